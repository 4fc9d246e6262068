"""The scenes of Pastewka and Robbins, Appl. Phys. Lett. 108, 221601 (2016).

Lengths are in units of the spacing a0, pressures in units of the contact modulus E*: a
scene with a spacing of 1 Å and a modulus of 1 eV/Å^3.
"""

from itertools import pairwise, product

import numpy as np
from ase.units import GPa, J, m

from ase_roughcontact.scene import (
    NANONEWTON,
    InteractionTable,
    PathTable,
    RoughnessTable,
    Scene,
    SphereTable,
    SubstrateTable,
)

RADII = (1e3, 1e5, 1e4, 1e2)
SLOPES = (0.1, 0.01)
WORKS = (0.0005, 0.005)
SEEDS = range(5)
# Contact radii of a smooth sphere under the loads, in a0: the first is less than one
# atom. Bands of them are calculated one after the other, the cheap ones first.
SMALLEST = 0.5
BANDS = {"quick": (64.0,), "paper": (256.0, 512.0, 1024.0)}
# Side of the square that a realisation fills before it repeats.
DOMAIN = 4096.0


def scenes(scale: str) -> list[list[Scene]]:
    """Scenes of Fig. 2, band by band, the cheap ones first."""
    ends = (SMALLEST / 2**0.5, *BANDS[scale])
    seeds = SEEDS if scale == "paper" else SEEDS[:3]
    bands = [repulsive(*band, seeds) for band in pairwise(ends)]
    bands.insert(1, adhesive(ends[0], ends[1], seeds))
    return bands


def repulsive(first: float, last: float, seeds: range) -> list[Scene]:
    """Walls that only repel: the state does not depend on the path before."""
    return [
        scene(radius, slope, seed, kind, radii)
        for kind, radius, slope, seed in product(
            ("hard", "repulsive"), RADII, SLOPES, seeds
        )
        if len(radii := contact_radii(first, min(last, radius)))
    ]


def adhesive(first: float, last: float, seeds: range) -> list[Scene]:
    """Walls that attract: one path from the first touch to the last load."""
    return [
        scene(radius, 0.1, seed, "adhesive", contact_radii(first, last), work)
        for radius, work, seed in product((1e3, 1e5), WORKS, seeds)
    ]


def contact_radii(first: float, last: float) -> np.ndarray:
    """Contact radii above the first, up to the last, two per octave."""
    octaves = np.arange(np.log2(SMALLEST), np.log2(last) + 1e-9, 0.5)
    radii = 2.0**octaves
    return radii[radii > first * (1 + 1e-9)]


def scene(
    radius: float,
    slope: float,
    seed: int,
    kind: str,
    radii: np.ndarray,
    work: float | None = None,
) -> Scene:
    """Press a rough sphere under the loads of some contact radii."""
    loads = 4.0 * radii**3 / (3.0 * radius)
    joule = None if work is None else work / (J / m**2)
    return Scene(
        substrate=SubstrateTable(spacing=1.0, contact_modulus=1.0 / GPa),
        sphere=SphereTable(radius=radius),
        roughness=RoughnessTable(rms_slope=slope, seed=seed, domain=DOMAIN),
        interaction=InteractionTable(kind=kind, work_of_adhesion=joule),
        path=PathTable(values=tuple(loads / NANONEWTON)),
    )
