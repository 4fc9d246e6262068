"""A path is resumed only if everything that its states depend on is unchanged."""

from dataclasses import replace

import numpy as np
import pytest
from ase.constraints import FixAtoms, Hookean

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic

ROUGH = rc.SelfAffine(0.1, 0.8, 4.0, 16.0, seed=1, domain=64.0)
SPHERE = rc.RoughSphere(10.0, ROUGH)
BUMPS = np.random.default_rng(1).uniform(0.0, 1.0, (14, 14))
ADHESIVE = rc.LennardJones93.adhesive(1.0, 1.0, 0.02)


def make_atoms(sphere=SPHERE, spring=None, spacing=1.0, wall=None, **options):
    """Return atoms with calculator; springs are (stiffness, rest, end), or ()."""
    lattice = {"shape": (12, 10), "periodic": True} | {
        key: options.pop(key) for key in ("shape", "periodic") if key in options
    }
    atoms = rc.substrate(
        "Cu", indenter=sphere, spacing=spacing, height=2.0, fixed=False, **lattice
    )
    atoms.calc = rc.RoughContact(
        sphere, **{"contact_modulus": 1.0} | options, wall=wall
    )
    if spring is None:
        atoms.set_constraint(FixAtoms([len(atoms) - 1]))
    elif spring:
        stiffness, rest, end = spring
        point = (*atoms.positions[-1, :2], end)
        atoms.set_constraint(Hookean(len(atoms) - 1, point, stiffness, rt=rest))
    return atoms


def rough(**changes):
    return rc.RoughSphere(10.0, replace(ROUGH, **changes))


SPRING = {"spring": (1.0, 0.5, -3.0)}
# Parameters before, and changes of them.
OTHERS = {
    "radius": ({}, {"sphere": rc.RoughSphere(11.0, ROUGH)}),
    "profile": ({}, {"sphere": rc.RoughSphere(10.0, ROUGH, "sphere")}),
    "smooth": ({}, {"sphere": rc.RoughSphere(10.0)}),
    "slope": ({}, {"sphere": rough(rms_slope=0.11)}),
    "hurst": ({}, {"sphere": rough(hurst=0.7)}),
    "shortest wave": ({}, {"sphere": rough(short_wavelength=5.0)}),
    "longest wave": ({}, {"sphere": rough(longest_wavelength=20.0)}),
    "seed": ({}, {"sphere": rough(seed=2)}),
    "amplitudes": ({}, {"sphere": rough(random_amplitudes=True)}),
    "domain": ({}, {"sphere": rough(domain=80.0)}),
    "one height of a map": (
        {"sphere": rc.HeightMap(BUMPS, 1.0)},
        {"sphere": rc.HeightMap(BUMPS + 1e-12 * np.eye(14), 1.0)},
    ),
    "modulus": ({}, {"contact_modulus": 1.1}),
    "solid": ({}, {"contact_modulus": None, "solid": Isotropic(1.1)}),
    "Poisson's ratio": (
        {"contact_modulus": None, "solid": Isotropic(1.0, 0.2)},
        {"contact_modulus": None, "solid": Isotropic(1.0, 0.3)},
    ),
    "wall": ({}, {"wall": ADHESIVE}),
    "default wall": ({}, {"wall": rc.LennardJones93.repulsive(1.2, 1.0)}),
    "work of adhesion": (
        {"wall": ADHESIVE},
        {"wall": rc.LennardJones93.adhesive(1.0, 1.0, 0.021)},
    ),
    "precision": ({}, {"fft": {"dtype": "float32"}}),
    "spacing": ({"sphere": rc.RoughSphere(10.0)}, {"spacing": 1.01}),
    "window": ({}, {"shape": (10, 12)}),
    "boundary": ({}, {"periodic": False}),
    "stiffness of a spring": (SPRING, {"spring": (1.1, 0.5, -3.0)}),
    "rest length": (SPRING, {"spring": (1.0, 0.6, -3.0)}),
    "end of a spring": (SPRING, {"spring": (1.0, 0.5, -3.1)}),
    "no spring": (SPRING, {"spring": ()}),
}
SAME = {
    "all": ({}, {}),
    "spring": (SPRING, SPRING),
    "Poisson's ratio without friction": (
        {"contact_modulus": None, "solid": Isotropic(1.0)},
        {"contact_modulus": None, "solid": Isotropic(1.0, 0.3)},
    ),
    "threads": ({}, {"fft": {"threads": 2}}),
    "named precision": ({}, {"fft": {"dtype": "float64"}}),
    "the default wall by name": ({}, {"wall": rc.LennardJones93.repulsive(1.0, 1.0)}),
}


def steps_of(file, resume=False, path=None, **atoms):
    """Steps of a path of loads on a spring, of penetrations without."""
    path = path or {"loads" if "spring" in atoms else "penetrations": [0.1, 0.2]}
    output = rc.Output(trajectory=file, resume=resume)
    return rc.load_path(make_atoms(**atoms), **path, window="unchecked", output=output)


def first_step(file, **options):
    steps = steps_of(file, **options)
    next(steps)
    steps.close()


@pytest.mark.parametrize("name", OTHERS)
def test_a_path_of_another_system_is_not_resumed(name, tmp_path):
    file, (before, after) = tmp_path / "sweep.traj", OTHERS[name]
    first_step(file, **before)
    with pytest.raises(ValueError, match="can't resume"):
        next(steps_of(file, resume=True, **before | after))


@pytest.mark.parametrize("name", SAME)
def test_a_path_of_the_same_system_is_resumed(name, tmp_path):
    file, (before, after) = tmp_path / "sweep.traj", SAME[name]
    first_step(file, **before)
    assert [step.step for step in steps_of(file, resume=True, **after)] == [0, 1]


PATH = {"penetrations": [0.1, 0.2, 0.3], "accuracy": 1e-4}


@pytest.mark.parametrize(
    "other",
    [{"penetrations": [0.1, 0.25]}, {"max_steps": 99}, {"accuracy": "normal"}],
    ids=str,
)
def test_the_remaining_steps_and_the_number_of_iterations_may_change(other, tmp_path):
    file, path = tmp_path / "sweep.traj", PATH | other
    first_step(file, path=PATH)
    steps = list(steps_of(file, resume=True, path=path))
    assert len(steps) == len(path["penetrations"])


def test_table_and_trajectory_are_two_files(tmp_path):
    same = {"csv": tmp_path / "a", "trajectory": tmp_path / "b" / ".." / "a"}
    with pytest.raises(ValueError, match="csv and trajectory"):
        rc.Output(**same)
