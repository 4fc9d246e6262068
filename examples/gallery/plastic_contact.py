"""
Elastic and plastic contact of copper
=====================================

A rough sphere is pressed on copper and lifted again: without a limit of the pressure,
and with the hardness of annealed copper. The area is the load over the hardness then,
and the surface keeps the dents.
"""

import matplotlib.pyplot as plt
import numpy as np
from ase.units import GPa, nm

from ase_roughcontact import (
    HardWall,
    PlasticWall,
    RoughContact,
    RoughSphere,
    SelfAffine,
    fcc_spacing,
    load_path,
    substrate,
)
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.elasticity import HARDNESS, crystal_modulus
from ase_roughcontact.plot import style

LOADS = (1.0, 2.0, 5.0, 10.0, 20.0, 40.0, 60.0, 80.0)

# %%
# The roughness has a slope of 0.01. Without a limit, its asperities would bear 0.5 % of
# the contact modulus, twice the hardness.

modulus, hardness = crystal_modulus("Cu") * GPa, HARDNESS["Cu"] * GPa
a0, nanonewton = fcc_spacing("Cu"), GPa * nm**2
sphere = RoughSphere(4000 * a0, SelfAffine(0.01, 0.8, 4 * a0, 64 * a0, seed=2))


def press(wall):
    """Return loads and areas, and the maps at the largest load and after unloading."""
    atoms = substrate("Cu", (16, 16), sphere)
    atoms.calc = RoughContact(sphere, modulus, wall)
    loads = np.array([*LOADS, *LOADS[-2::-1], 0.0]) * nanonewton
    areas, maps = [], []
    for step in load_path(atoms, loads=loads, window="auto", validity="ignore"):
        areas.append(step.contact_area)
        maps.append(ContactMap.from_atoms(atoms))
    return loads / nanonewton, np.array(areas) / nm**2, maps[len(LOADS) - 1], maps[-1]


def show(ax, contact, values, title, **options):
    """Draw a map with lengths in nm."""
    extent = np.array([*contact.x[[0, -1]], *contact.y[[0, -1]]]) / nm
    image = ax.imshow(values.T, extent=extent, origin="lower", **options)
    ax.set(title=title, xlabel="$x$ (nm)", ylabel="$y$ (nm)")
    ax.set(xlim=(-15, 15), ylim=(-15, 15))
    return image


# %%
# Above: pressures at the largest load. Below: areas along the path, dashed while the
# load falls, and the dents that are left after it.

with style():
    figure, axes = plt.subplots(2, 2, figsize=(6.8, 6.0))
    curve, top = axes[1, 0], len(LOADS)
    walls = {"elastic": HardWall(), "plastic": PlasticWall(hardness, permanent=True)}
    for ax, letter, (name, wall) in zip(axes[0], "ab", walls.items(), strict=True):
        loads, areas, pressed, lifted = press(wall)  # nN, nm²
        pressure = np.where(pressed.contact, pressed.pressure / hardness, np.nan)
        image = show(ax, pressed, pressure, f"({letter}) {name}", vmin=0, vmax=3)
        (line,) = curve.plot(loads[:top], areas[:top], "o-", label=name)
        curve.plot(loads[top - 1 :], areas[top - 1 :], "--", color=line.get_color())
    full = LOADS[-1] * nanonewton / hardness / nm**2
    curve.plot([0, LOADS[-1]], [0, full], "k:", label="load over hardness")
    curve.set(xlabel="load (nN)", ylabel="contact area (nm²)", title="(c) contact area")
    curve.legend()
    figure.colorbar(image, ax=axes[0], label="pressure / hardness", extend="max")
    depth = lifted.plastic_depth / nm
    image = show(axes[1, 1], lifted, depth, "(d) after unloading", cmap="magma_r")
    figure.colorbar(image, ax=axes[1, 1], label="plastic depth (nm)")
    figure.savefig("plastic_contact.png", dpi=150)

ratio = areas[top - 1] / full
print(f"area at {LOADS[-1]:g} nN over N/H: {ratio:.3f}")
