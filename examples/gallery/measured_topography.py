"""
A measured topography
=====================

Heights from a file are levelled, put on a sphere and pressed into copper. The pixels of
the file are larger than the spacing of the atoms.
"""

import matplotlib.pyplot as plt
import numpy as np

from ase_roughcontact import (
    HeightMap,
    NewtonKrylov,
    RoughContact,
    RoughSphere,
    SelfAffine,
    snapshot,
    substrate,
)
from ase_roughcontact.plot import plot_contact, style

SIZE = 64  # atoms along a side of the window

# %%
# A file to work with
# -------------------
# For this example the "measurement" is written first: a known surface, tilted, sampled
# at twice the spacing of the atoms and rounded to 0.01 Å.

a0 = 2.55  # Å
pixel = 2 * a0
known = SelfAffine(0.1, 0.8, 8 * a0, SIZE * a0, seed=3)
count = SIZE // 2 + 4
heights = known.heights((count, count), pixel, (-(count // 2) * pixel,) * 2)
np.savetxt("heights.txt", heights + 0.2 * np.arange(count), "%.2f")

# %%
# Level it
# --------
# The best plane is subtracted. An array of heights from the package SurfaceTopography
# can be used in the same way.

heights = np.loadtxt("heights.txt")
plane = np.array([*np.indices(heights.shape), np.ones(heights.shape)]).reshape(3, -1).T
tilt, *_ = np.linalg.lstsq(plane, heights.ravel(), rcond=None)
heights -= (plane @ tilt).reshape(heights.shape)

# %%
# Press it in
# -----------
# ``HeightMap`` interpolates between the pixels. ``snapshot`` makes a frame with contact
# and pressure, which can be drawn or written to a file.


def pressed(rough):
    """Return a frame of the relaxed contact of a sphere with this roughness."""
    sphere = RoughSphere(3 * SIZE * a0, rough)
    atoms = substrate("Cu", (SIZE, SIZE), sphere, spacing=a0, height=0.0)
    atoms.calc = RoughContact(sphere, contact_modulus=0.9)  # eV/Å^3
    if not NewtonKrylov(atoms, logfile=None).run(fmax=1e-5):
        raise RuntimeError("the contact did not converge")
    return snapshot(atoms)


frame = pressed(HeightMap(heights, pixel))
force = frame.info["normal_force"]
error = force / pressed(known).info["normal_force"] - 1
print(f"force {force:.2f} eV/Å, relative error {100 * error:.1f} %")

with style():
    figure, axes = plt.subplots()
    figure.colorbar(plot_contact(axes, frame), label="pressure (GPa)")
    figure.savefig("measured_topography.png", dpi=200)
