"""Soft walls: heights as the unknowns of an energy."""
