"""Windows: the surface atoms that a step of a load path needs."""
