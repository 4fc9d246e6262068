"""The scenes of Pastewka and Robbins, Appl. Phys. Lett. 108, 221601 (2016).

Lengths are in units of the spacing a0, pressures in units of the contact modulus E*: a
scene with a spacing of 1 Å and a modulus of 1 eV/Å^3.
"""

import csv
from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise, product
from pathlib import Path

import numpy as np
from ase.units import GPa, J, m

from ase_roughcontact import LennardJones93, nN
from ase_roughcontact.ensemble.columns import step_types
from ase_roughcontact.ensemble.database import EnsembleDatabase
from ase_roughcontact.scene import (
    InteractionConfig,
    RoughnessConfig,
    Scene,
    SphereConfig,
    Steps,
    SubstrateConfig,
)
from ase_roughcontact.theory import (
    ASPERITY_FACTOR_REPULSIVE,
    KAPPA_HARD,
    KAPPA_REPULSIVE,
    Hertz,
    RoughSphereTheory,
)

RADII = (1e3, 1e5, 1e4, 1e2)
ADHESIVE_RADII = (1e3, 1e5)
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
    if len(ends) > 2:
        bands += [adhesive(ends[0], ends[-1], seeds, (r,)) for r in ADHESIVE_RADII]
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


def adhesive(
    first: float, last: float, seeds: range, radii: tuple[float, ...] = ADHESIVE_RADII
) -> list[Scene]:
    """Walls that attract: one path from the first touch to the last load."""
    return [
        scene(radius, 0.1, seed, "adhesive", contact_radii(first, last), work)
        for radius, work, seed in product(radii, WORKS, seeds)
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
    adhesion = {} if work is None else {"work_of_adhesion": work / (J / m**2)}
    return Scene(
        substrate=SubstrateConfig(
            model="atoms", spacing=1.0, contact_modulus=1.0 / GPa, hardness=np.inf
        ),
        sphere=SphereConfig(radius=radius, unit="a0"),
        roughness=RoughnessConfig(rms_slope=slope, seed=seed, domain=DOMAIN, unit="a0"),
        interaction=InteractionConfig(kind, adhesion),
        path=Steps(loads=tuple(loads / nN)),
    )


def theory(
    radius: float, slope: float, kind: str, work: float = 0.0
) -> RoughSphereTheory:
    """Numbers of the paper's formulas for a sphere, in units of a0 and E*."""
    hard = kind == "hard"
    reach = LennardJones93.adhesive(1.0, 1.0, work).attraction_range if work else None
    return RoughSphereTheory(
        radius,
        1.0,
        RoughnessConfig(rms_slope=slope).surface(1.0),
        work,
        reach,
        KAPPA_HARD if hard else KAPPA_REPULSIVE,
        1.0 if hard else ASPERITY_FACTOR_REPULSIVE,
    )


@dataclass(frozen=True, eq=False)
class Curve:
    """Contact area against load, of all realisations of a sphere.

    Attributes
    ----------
    kind : str
        Of the wall.
    radius, slope, work : float
        R/a0, h'rms, and w/(E* a0), zero without attraction.
    loads : ndarray, shape (k,)
        N/(E* a0^2), rising.
    areas : ndarray, shape (k, seeds)
        A/a0^2, the number of atoms in contact, NaN where a realisation is missing.
    corrected : ndarray, shape (k, seeds)
        Under a hard wall the area of the continuum, corrected for the grid, in a0^2.
    """

    kind: str
    radius: float
    slope: float
    work: float
    loads: np.ndarray
    areas: np.ndarray
    corrected: np.ndarray

    @property
    def hertz(self) -> np.ndarray:
        """Contact areas of the smooth sphere, shape (k,)."""
        return Hertz(self.radius, 1.0).contact_area(self.loads)

    @property
    def theory(self) -> RoughSphereTheory:
        """The sphere without attraction: N_c is that of the repulsive wall."""
        return theory(self.radius, self.slope, self.kind)


def read_table(file: Path) -> dict[str, np.ndarray]:
    """Columns of a file of `write_csv`."""
    with open(file, encoding="utf-8", newline="") as stream:
        header, *rows = csv.reader(stream)
    header = [head.partition(" (")[0] for head in header]  # without units
    columns = dict(zip(header, map(np.array, zip(*rows, strict=True)), strict=True))
    types = step_types()
    return {
        name: texts == "True" if types[name] is bool else texts.astype(types[name])
        for name, texts in columns.items()
    }


def fill_database(database: Path, file: Path) -> int:
    """Add the steps of a file of `write_csv`, so that a run continues there."""
    table = read_table(file)
    values = zip(*(column.tolist() for column in table.values()), strict=True)
    stored = EnsembleDatabase(str(database.absolute()))
    stored.create()
    return stored.add_steps([dict(zip(table, row, strict=True)) for row in values], {})


def curves(table: Mapping[str, np.ndarray]) -> list[Curve]:
    """Sort the steps of a table into curves."""
    works = np.nan_to_num(table["work_of_adhesion"]) * (J / m**2)
    works = np.round(works, 9)  # undo the change of units
    columns = table["kind"], table["radius"], table["rms_slope"], works
    keys = list(zip(*(column.tolist() for column in columns), strict=True))
    found = []
    for key in sorted(set(keys)):
        used = np.array([other == key for other in keys])
        loads, row = np.unique(table["target"][used], return_inverse=True)
        seeds, column = np.unique(table["seed"][used], return_inverse=True)
        areas, corrected = np.full((2, len(loads), len(seeds)), np.nan)
        areas[row, column] = table["contact_area"][used]
        kind, radius, slope, work = key
        if kind == "hard":
            corrected[row, column] = table["continuum_area"][used]
        found.append(Curve(kind, radius, slope, work, loads, areas, corrected))
    return found
