"""Linear elasticity of the substrate: Green's functions and half spaces."""
