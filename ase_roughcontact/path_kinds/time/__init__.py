"""Paths in time, of viscoelastic solids."""
