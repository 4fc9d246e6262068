"""
The crystal below the surface
=============================

The solid can be the crystal that a calculator of ASE describes, by the lattice Green's
function of its surface. Long waves see a continuum with the elastic constants of the
same calculator; short ones a solid that is stiffer, and at the edge of the Brillouin
zone softer.
"""

import matplotlib.pyplot as plt
import numpy as np
from ase.build import bulk
from ase.calculators.emt import EMT
from ase.units import GPa
from matscipy.elasticity import fit_elastic_constants

from ase_roughcontact.elasticity import Crystal, Cubic
from ase_roughcontact.plot import BLUE, ORANGE, style

METALS = ("Cu", "Au", "Al")
SLAB = {"layers": 15, "size": 9}

# %%
# A slab is relaxed and its force constants are calculated, which takes some seconds for
# EMT. With ``crystal.write`` and ``Crystal.read`` an expensive potential is asked once.

crystals = [Crystal.from_calculator(EMT(), metal, **SLAB) for metal in METALS]
for crystal in crystals:
    a = np.sqrt(2) * crystal.spacing
    atoms = bulk(crystal.symbol, cubic=True, a=a)
    atoms.calc = EMT()
    fit, _ = fit_elastic_constants(atoms, "cubic", delta=1e-4, verbose=False)
    continuum = Cubic(fit[0, 0], fit[0, 1], fit[3, 3])
    error = float(crystal.contact_modulus / continuum.contact_modulus - 1)
    print(
        f"{crystal.symbol}: a = {a:.4f} Å, E* = {crystal.contact_modulus / GPa:.1f} GPa"
        f", difference from the continuum {100 * error:.2f} %"
    )

# %%
# The modulus of waves along the rows of neighbours and at 45 degrees to them, and that
# of all waves on the first crystal.

half = np.linspace(0.01, np.pi, 100)
qx, qy = np.meshgrid([*-half[::-1], *half], [*-half[::-1], *half], indexing="ij")
with style():
    figure, (lines, zone) = plt.subplots(1, 2, figsize=(6.8, 3.0))
    for colour, crystal in zip((BLUE, ORANGE, "k"), crystals, strict=False):
        for direction, line in (([1, 0], "-"), ([1, 1], "--")):
            wave = np.outer(direction, half / crystal.spacing)
            modulus = 2 / (np.hypot(*wave) * crystal.wave_compliance(*wave))
            label = crystal.symbol + (" rows" if line == "-" else " 45°")
            relative = modulus / crystal.contact_modulus
            lines.plot(half / np.pi, relative, line, color=colour, label=label)
    lines.set(xlabel=r"$q_x a_0/\pi$", ylabel=r"$E^*(q)/E^*$")
    lines.set_title("(a) along two directions")
    lines.legend(fontsize="small")
    a0 = crystals[0].spacing
    modulus = (
        2 * a0 / (np.hypot(qx, qy) * crystals[0].wave_compliance(qx / a0, qy / a0))
    )
    relative = modulus.T / crystals[0].contact_modulus
    image = zone.imshow(relative, origin="lower", extent=(-1, 1, -1, 1))
    figure.colorbar(image, ax=zone, label=rf"$E^*(q)/E^*$, {METALS[0]}")
    ticks = (-1, -0.5, 0, 0.5, 1)
    zone.set(xlabel=r"$q_x a_0/\pi$", ylabel=r"$q_y a_0/\pi$", xticks=ticks)
    zone.set_title(f"(b) all waves on {METALS[0]}")
    figure.savefig("crystals.png", dpi=115)
