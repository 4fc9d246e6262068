"""Sliding with friction."""
