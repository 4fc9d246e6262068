"""One relaxed step of a path.

``step`` has the `Stepper`, which relaxes a target from a state with its ``options``.
``relaxed`` is the outcome; ``convergence`` says why a step is not converged, and
``relaxation_errors`` has the errors that the tolerance leaves. ``accuracy`` has the
grid and tolerance for a wanted error, ``extrapolation`` the start of a step from
earlier ones, ``surface_history`` the history that the surface keeps of them, and
``retraction`` the parts of a step away from an adhesive contact.
"""
