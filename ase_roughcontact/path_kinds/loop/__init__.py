"""Adhesion loops: approach and retraction with all instabilities."""
