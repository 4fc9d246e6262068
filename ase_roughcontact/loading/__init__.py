"""Load paths on ASE `Atoms`."""
