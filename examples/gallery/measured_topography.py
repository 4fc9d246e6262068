"""
A measured topography
=====================

A scan of a rough substrate, with tilt and missing points, is read from a file; a smooth
tip is pressed on it at its highest point and at a grid of places.
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

SIZE = 32  # atoms along a side of the window
PLACES = 8  # places along a side of the scan

a0 = 2.55  # Å, distance of the atoms
edge = (SIZE // 2 + 1) * a0  # places closer to the edge have atoms beyond the scan

# %%
# A file to work with
# -------------------
# For this example the "measurement" is written first, as Gwyddion exports it: a known
# surface with pixels twice as large as the distance of the atoms, tilted, rounded, and
# with two missing lines.

count, pixel = 96, 2 * a0
known = SelfAffine(0.15, 0.8, 8 * a0, 128 * a0, seed=3).heights((count, count), pixel)
scan = known + 0.2 * np.arange(count)[:, None]
scan[:, 40:42] = np.nan
size = f"{count * pixel / 10:.3f} nm"
header = f"Channel: Height\nWidth: {size}\nHeight: {size}\nValue units: nm"
np.savetxt("scan.txt", scan.T / 10, "%.4f", header=header)

# %%
# Read it
# -------
# Sizes and units come from the file, missing points are filled, and the best plane is
# subtracted. The scan is that of the substrate: its high points stick out, and the tip
# touches them first.

surface = HeightMap.from_topography(
    "scan.txt", role="substrate", center="highest", margin=edge / 10
)
print(surface, surface.statistics())
print(surface.self_affine)

# %%
# Press a tip on it
# -----------------
# ``HeightMap`` interpolates between the pixels. The tip is a sphere, to which the scan
# is added as roughness. It is lowered by 3 Å below the height of the first contact. The
# force differs little from that on the known surface, without tilt and complete.


def pressed(rough):
    """Return a frame of the relaxed contact at the center of a map."""
    tip = RoughSphere(200.0, rough)
    atoms = substrate("Cu", (SIZE, SIZE), tip, spacing=a0)
    atoms.positions[-1, 2] -= 3.0
    atoms.calc = RoughContact(tip, contact_modulus=0.9)  # eV/Å^3
    if not NewtonKrylov(atoms, logfile=None).run(fmax=1e-4):
        raise RuntimeError("the contact did not converge")
    return snapshot(atoms)


frame = pressed(surface)
exact = HeightMap.from_topography(known, "substrate", spacing=pixel)
exact_frame = pressed(exact.centered(surface.center))
error = frame.info["normal_force"] / exact_frame.info["normal_force"] - 1
print(f"force {frame.info['normal_force']:.2f} eV/Å, error {100 * error:.1f} %")

# %%
# At a grid of places, away from the edges, this gives a map of the area over the scan.

x, y = surface.places(PLACES, PLACES, margin=edge)
frames = [[pressed(surface.centered((i, j))) for j in y] for i in x]
areas = np.array([[each.info["contact_area"] for each in row] for row in frames])

with style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(6.8, 2.8))
    figure.colorbar(plot_contact(left, frame).images[0], label="pressure (GPa)")
    left.set_title("(a) contact at the highest point")
    cell = 0.5 * (x[1] - x[0])
    extent = np.array([x[0] - cell, x[-1] + cell, y[0] - cell, y[-1] + cell]) / 10
    image = right.imshow(areas.T / 100, origin="lower", extent=extent)
    figure.colorbar(image, label="contact area (nm²)")
    right.set(xlabel="$x$ (nm)", ylabel="$y$ (nm)", title="(b) contact area by place")
    figure.savefig("measured_topography.png", dpi=150)
