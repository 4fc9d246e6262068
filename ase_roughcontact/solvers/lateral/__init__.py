"""Friction: lateral tractions within their bounds, at a given pressure."""
