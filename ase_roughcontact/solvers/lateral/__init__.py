"""Friction: tractions below their bounds."""
