"""Kinds of path, a folder each."""
