"""Solvers of the contact problem on arrays, without ASE."""
