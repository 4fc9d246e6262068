"""Accuracy of a calculation against its time."""
