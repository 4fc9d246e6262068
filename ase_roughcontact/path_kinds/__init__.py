"""Kinds of path, a folder each, which scenes find here.

Each has its ``specification`` (what a user gives, with defaults and checks), ``steps``
(how it is relaxed), ``scene`` (its section of a scene file), ``atoms`` (its function on
ASE atoms) and ``figures``; some have columns of their own in ``record``.
"""
