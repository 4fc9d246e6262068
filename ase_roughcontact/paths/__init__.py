"""Load paths: one relaxed state after another."""
