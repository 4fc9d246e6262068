"""Which surface atoms a step of a load path needs."""
