"""Load paths: one relaxed state after another.

``follow`` is the loop over the steps of a path. A kind of path is a `PathSteps` of
``path_steps``: from a `PathStep`, the end of the last step, it relaxes and yields the
next one. ``path_files`` opens the files of a path and adds each step to them:
``restart`` is the file from which a path is resumed, ``kept_frames`` says which steps
have a frame, and ``output`` is what a user asks for. ``schedule`` has targets as
functions of time; ``plan`` and ``planned_steps`` estimate windows, memory and time.
"""
