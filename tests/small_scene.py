"""A scene file that runs in a fraction of a second."""

SMALL = """
[substrate]
shape = [32, 30]
contact_modulus = 100.0
[sphere]
radius = 60.0
[roughness]
long_wavelength = 16.0
[path]
control = "penetration"
first = 0.2
last = 0.6
steps = 2
scale = "linear"
[solver]
optimizer = "LBFGS"
fmax = 1e-4
"""
