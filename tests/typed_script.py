"""A user's script with types, which type checkers accept without an error but these.

Each ``type: ignore`` marks a mistake that a type checker must find.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import numpy.typing as npt
from ase import Atoms
from ase.units import GPa

import ase_roughcontact as rc
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.contact import ContactState
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.theory import Hertz

Numbers = npt.NDArray[np.float64]
SPHERE = rc.RoughSphere(500.0, profile="paraboloid")


def build(solid: Isotropic | rc.Viscoelastic, fixed: bool = True) -> Atoms:
    """Atoms under a sphere."""
    atoms = rc.substrate("Si", (16, 16), SPHERE, fixed=fixed)
    atoms.calc = rc.RoughContact(SPHERE, solid=solid, wall=rc.HardWall())
    return atoms


def areas(steps: Iterable[rc.LoadStep]) -> Numbers:
    """Contact areas of steps (Å^2)."""
    return np.array([step.contact_area for step in steps])


def press() -> Numbers:
    """Penetrations as an array, a list and a tuple."""
    atoms = build(Isotropic(171 * GPa, poisson=0.3))
    found = areas(rc.load_path(atoms, penetrations=np.linspace(0.1, 0.3, 2)))
    areas(
        rc.load_path(atoms, penetrations=[0.1, 0.2], accuracy="high", validity="ignore")
    )
    areas(rc.load_path(atoms, penetrations=(0.1,), window="fixed", accuracy=1e-3))
    return found


def slide() -> float:
    """Columns of sliding steps."""
    atoms = build(Isotropic(171 * GPa, poisson=0.3))
    slid: list[rc.SlidingStep] = list(
        rc.sliding_path(
            atoms,
            rc.Coulomb(0.3),
            penetrations=0.2,
            displacements=[0.0, 0.1],
            max_steps=100,
        )
    )
    return slid[-1].lateral_force_x


def wait() -> float:
    """Columns of steps in time."""
    creep = rc.Creep.standard_solid(relaxed=0.5, time=1.0)
    atoms = build(rc.Viscoelastic(1.0, creep))
    schedule = rc.Schedule(0.0).step(0.2).hold(1.0)
    timed: list[rc.TimeStep] = list(
        rc.time_path(atoms, penetrations=schedule, tolerance=0.1)
    )
    return timed[-1].time


def look() -> tuple[Numbers, Numbers]:
    """Fields of the atoms, and the area by theory."""
    atoms = build(Isotropic(171 * GPa))
    state: ContactState = rc.calculator_of(atoms).state(atoms)
    pressure: Numbers = ContactMap.from_atoms(atoms).pressure
    return pressure, Hertz(500.0, 1.0).contact_area(state.normal_force)


def mistakes(atoms: Atoms) -> None:
    """Typing errors, which are never executed."""
    rc.adhesion_loop(atoms, deepest=1.0, acuracy="high")  # type: ignore[call-arg]
    rc.load_path(atoms, penetrations=[1.0], window="atuo")  # type: ignore[arg-type]
    rc.load_path(atoms, penetrations=[1.0], accuracy="hihg")  # type: ignore[arg-type]
    rc.sliding_path(atoms, rc.Tresca(1.0), coupling="solvd")  # type: ignore[arg-type]
    rc.time_path(atoms, validity="wran")  # type: ignore[arg-type]
    rc.RoughContact(SPHERE, 1.0, lood=3.0)  # type: ignore[arg-type]
    rc.Output(keep="al")  # type: ignore[arg-type]


if __name__ == "__main__":
    print(press(), slide(), wait(), look())
