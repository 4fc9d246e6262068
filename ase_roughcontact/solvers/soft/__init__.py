"""Soft walls: pressure and height at the minimum of an energy."""
