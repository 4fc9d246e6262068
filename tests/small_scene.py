"""Scene files that run in a fraction of a second."""

from ase_roughcontact.scene import Scene

SMALL = """
[substrate]
model = "atoms"
shape = [32, 30]
contact_modulus = 100.0
[sphere]
unit = "a0"
radius = 60.0
[roughness]
unit = "a0"
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

# Approach and retraction of a smooth sphere, and of a rough one.
SMOOTH = """
[substrate]
model = "atoms"
contact_modulus = 100.0
hardness = inf
[sphere]
unit = "a0"
radius = 60.0
[path]
control = "penetration"
values = [-4.0, 0.0, 2.0, 0.0, -4.0]
"""
ROUGH = SMOOTH + "[roughness]\nunit = 'a0'\nlong_wavelength = 16.0\n"

# A periodic cell of few atoms.
PERIODIC = """
[substrate]
model = "atoms"
shape = [12, 12]
contact_modulus = 100.0
periodic = true
[sphere]
unit = "a0"
radius = 60.0
[path]
control = "penetration"
values = [0.05, 0.1, 0.2]
"""


def adhesive(text, work, kind="adhesive"):
    """Scene of a text with a wall that attracts."""
    return Scene.parse(
        f'{text}[interaction]\nkind = "{kind}"\nwork_of_adhesion = {work}\n'
    )
