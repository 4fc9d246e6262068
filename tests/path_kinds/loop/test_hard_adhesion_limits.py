"""Hard adhesive walls against DMT, Maugis-Dugdale, JKR and the plain hard wall."""

import numpy as np
import pytest
from built import atoms_under
from loop_areas import zero_load_area

import ase_roughcontact as rc
from ase_roughcontact.theory import MaugisDugdale


def loop_of(radius, wall, deepest, step, **options):
    sphere = rc.RoughSphere(radius)
    atoms = atoms_under(sphere, wall, (16, 16))
    options = {"window": "auto", "tolerance": 3e-3, "validity": "ignore", **options}
    return rc.adhesion_loop(
        atoms, deepest=deepest, step=step, smallest_step=step / 64, **options
    )


def forces_of(radius, wall, penetrations):
    """Return the forces on a path, in units of pi w R."""
    sphere = rc.RoughSphere(radius)
    atoms = atoms_under(sphere, wall, (16, 16))
    options = {"window": "auto", "validity": "ignore"}
    steps = rc.load_path(atoms, penetrations=penetrations, **options)
    unit = np.pi * wall.work_of_adhesion * radius
    return [step.normal_force / unit for step in steps]


@pytest.mark.slow  # loops of up to 100 x 100 atoms
@pytest.mark.parametrize(
    "radius, work, reach, deepest, step",
    [
        (100.0, 5e-4, 0.5, 0.5, 0.1),  # Maugis parameter 0.07
        (200.0, 5e-3, 0.5, 1.0, 0.25),  # 0.39
        (200.0, 5e-2, 0.8, 3.0, 0.25),  # 1.1
    ],
)
def test_dugdale_wall_has_the_pull_off_of_maugis_and_dugdale(
    radius, work, reach, deepest, step
):
    loop = loop_of(radius, rc.DugdaleWall(work, reach), deepest, step)
    theory = MaugisDugdale(radius, 1.0, work, reach)
    assert loop.pull_off_force == pytest.approx(theory.pull_off_force, rel=0.01)
    expected = np.pi * float(theory.contact_radius(0.0)) ** 2
    if theory.parameter > 0.3:  # else the contact has a few tens of atoms
        assert zero_load_area(loop.retraction) == pytest.approx(expected, rel=0.01)


def test_rigid_sphere_has_the_pull_off_of_dmt():
    """The range is long, and the deformation far smaller than it."""
    for wall in (rc.DugdaleWall(2e-5, 2.0), rc.PowerLawWall(2e-5, 3.0)):
        forces = forces_of(40.0, wall, [0.005, 0.0, -0.005])
        assert min(forces) == pytest.approx(-2.0, rel=0.01)
        assert forces[0] > forces[1] + 0.1  # the largest tension is at first touch


def pull_off(radius, work, reach):
    """Return the largest tension of a path to both sides of the theoretical one."""
    theory = MaugisDugdale(radius, 1.0, work, reach)
    *_, depth = theory.state(theory.stability_limit("load"))
    unit = np.cbrt(work**2 * radius)
    offsets = np.array([1.0, 0.6, 0.4, 0.25, 0.15, 0.07, 0.0, -0.07])
    forces = forces_of(radius, rc.DugdaleWall(work, reach), depth + unit * offsets)
    assert forces[-1] > forces[-2]  # beyond the largest tension
    expected = -theory.pull_off_force / (np.pi * work * radius)
    assert min(forces) == pytest.approx(expected, rel=0.005)
    return min(forces)


def test_a_large_contact_under_attraction_takes_few_transforms():
    """Newton's steps with the exact Green's function, without which it takes 318."""
    atoms = atoms_under(rc.RoughSphere(1000.0), rc.DugdaleWall(0.1, 1.0), (16, 16))
    options = {"window": "auto", "validity": "ignore"}
    (step,) = rc.load_path(atoms, penetrations=[0.445], **options)
    assert step.converged and step.pairs < 250  # 125


@pytest.mark.slow  # up to 188 x 188 atoms
def test_dugdale_wall_tends_to_the_pull_off_of_jkr():
    """Ranges that the atoms resolve; theory deviates from JKR by the square of them."""
    radius, work = 1000.0, 0.1
    ranges = np.array([2.0, 1.4, 1.0])  # zones of tension from 31 to 7.9 a0
    found = [pull_off(radius, work, reach) for reach in ranges]
    assert (np.diff(found) > 0.0).all() and found[-1] > -1.53
    limit = np.polynomial.Polynomial.fit(ranges**2, found, 2)(0.0)
    assert limit == pytest.approx(-1.5, rel=0.005)


@pytest.mark.slow  # 30 s: up to 540 x 540 atoms
def test_pull_off_is_within_a_percent_of_jkr_at_a_resolved_range():
    """The zone of tension has 7.9 a0, Maugis' parameter is 3.7."""
    assert pull_off(3500.0, 0.1, 1.0) == pytest.approx(-1.5, rel=0.01)


def steps_of_a_flat(slope, part, tension, seed, n=32, **options):
    """Return steps of a flat under a constant tension, and without, at one height.

    In a periodic cell a constant tension changes only the mean pressure.
    """
    flat = rc.SelfAffine(slope, 0.8, 4.0, n, domain=n, seed=seed)
    heights = flat.heights((n, n), 1.0)
    reach = max(1.0, 5.0 * slope * n)  # beyond all gaps
    steps = []
    for wall in (rc.DugdaleWall(tension * reach, reach), rc.HardWall()):
        atoms = atoms_under(flat, wall, (n, n), periodic=True)
        options |= {"validity": "ignore"}
        steps += rc.load_path(
            atoms, penetrations=[part * (heights.mean() - heights.min())], **options
        )
        options = {"accuracy": 1e-9}
    return steps


@pytest.mark.parametrize("slope", [1e-6, 1e-5, 1e-4, 1e-2, 0.5])
def test_contact_on_small_slopes_agrees_with_the_hard_wall(slope):
    attracted, hard = steps_of_a_flat(slope, 0.6, 0.02, seed=1)
    assert attracted.converged
    difference = abs(attracted.repulsive_atoms - hard.repulsive_atoms)
    assert difference <= 2.0 * attracted.area_error
    assert attracted.area_error < 1e-3 or slope < 1e-5


@pytest.mark.slow  # six hundred pairs of states
@pytest.mark.filterwarnings("ignore:work_of_adhesion")  # of a long range
def test_contact_on_any_slope_agrees_with_the_hard_wall():
    known, decided = [], []
    for seed in range(600):
        rng = np.random.default_rng(seed)
        slope, tension = 10 ** rng.uniform(-6, 0), 10 ** rng.uniform(-3, -1)
        n, part = int(rng.choice([16, 32])), rng.uniform(0.1, 0.95)
        attracted, hard = steps_of_a_flat(slope, part, tension, seed, n)
        assert attracted.converged
        difference = abs(attracted.repulsive_atoms - hard.repulsive_atoms)
        assert difference <= 2.0 * attracted.area_error
        force = attracted.normal_force + tension * n * n
        error = abs(force - hard.normal_force) - 1e-12 * tension * n * n
        known.append(error <= 2.0 * attracted.force_error)
        decided.append(attracted.area_error < 0.5 or slope < 1e-4)
    assert np.mean(known) >= 0.9 and np.mean(decided) >= 0.95
