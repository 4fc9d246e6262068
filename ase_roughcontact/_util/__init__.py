"""Checks of input and array operations that the other packages share."""
