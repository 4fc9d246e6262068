"""
A rough sphere under rising loads
=================================

The contact of a rough sphere is followed over two decades of load, compared with the
theory of Pastewka and Robbins, and written to files for ``ase gui`` and OVITO.
"""

import matplotlib.pyplot as plt
import numpy as np
from ase.io import read, write
from ase.units import GPa, J, m

from ase_roughcontact import (
    Output,
    RoughContact,
    RoughSphere,
    SelfAffine,
    Validity,
    load_path,
    substrate,
    theory,
)
from ase_roughcontact.analysis import with_columns, with_indenter
from ase_roughcontact.plot import plot_contact, plot_curve, style

RADIUS = 1000.0  # of the sphere, in lattice spacings

# %%
# The indenter is a sphere with self-affine roughness. The window given here is only a
# start: with ``window="auto"`` each step uses the atoms that can touch at its load.

a0, modulus, nanonewton = 2.55, 145 * GPa, 1e-9 * J / m
slope, hurst, shortest, longest = 0.1, 0.8, 4 * a0, 512 * a0
rough = SelfAffine(slope, hurst, shortest, longest, seed=1)
sphere = RoughSphere(RADIUS * a0, rough)
atoms = substrate("Cu", (8, 8), sphere, spacing=a0)
atoms.calc = RoughContact(sphere, modulus)

loads = RADIUS * np.geomspace(0.01, 1.0, 7) * nanonewton
# copper would not bear these pressures: an infinite hardness makes it elastic by intent
elastic, output = Validity(hardness=np.inf), Output(trajectory="sweep-steps.traj")
path = load_path(atoms, loads=loads, window="auto", validity=elastic, output=output)
area = np.array([step.contact_area for step in path])

# %%
# Files
# -----
# The trajectory has one frame for each load. ``with_indenter`` shows the contact in
# purple below the sphere, which is cut open, with at most 48 rows of atoms along a
# side and heights enlarged: ``ase gui -R=-60x sweep.traj``. ``with_columns`` adds
# pressure and gap as columns, for OVITO.

frames = read("sweep-steps.traj", ":")
write("sweep.traj", [with_indenter(frame, sphere) for frame in frames])
write("sweep.extxyz", [with_columns(frame, sphere) for frame in frames])

# %%
# Theory
# ------
# Eq. (4) of the paper follows from the mean pressure in the contact. In the map, the
# solid circle is the contact of a smooth sphere, and the dashed one has the radius a'
# within which the first asperity is expected to touch, Eq. (3) as printed in the paper
# (by the heights of the surface it is smaller by the factor (2 pi)^(1/(2 - H))).

pressure = theory.mean_contact_pressure(slope, modulus, theory.KAPPA_REPULSIVE)
along = np.geomspace(loads[0], loads[-1], 50)
predicted = theory.predicted_area(along, sphere.radius, modulus, pressure)
hertz = theory.Hertz(sphere.radius, modulus).contact_area
ratio = float(area[-1] / predicted[-1])
print(f"area at {loads[-1] / nanonewton:g} nN: {ratio:.3f} of Eq. (4)")

with style():
    figure, (left, right) = plt.subplots(1, 2, figsize=(6.8, 3.3))
    eq4 = along / nanonewton, predicted / hertz(along)
    load = loads / nanonewton
    plot_curve(left, load, area, hertz(loads), {"Eq. (4), rough sphere": eq4})
    left.set_title("(a) contact area")
    hertz_radius = float(np.sqrt(hertz(loads[-1]) / np.pi))
    first = float(theory.first_contact_radius(sphere.radius, rough))
    title = f"(b) contact at {load[-1]:g} nN"
    plot_contact(right, frames[-1], hertz_radius, None, title, first)
    figure.colorbar(right.images[0], ax=right, label="pressure (GPa)")
    figure.legend(
        *right.get_legend_handles_labels(), loc="outside lower right", ncols=2
    )
    figure.savefig("load_sweep.png", dpi=150)
