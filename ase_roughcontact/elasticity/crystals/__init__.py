"""Surfaces of cubic crystals: as a continuum, and of atoms with any ASE calculator."""
