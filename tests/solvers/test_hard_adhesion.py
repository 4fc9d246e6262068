"""Hard walls with attraction, relaxed by the Newton-Krylov solver."""

import numpy as np
import pytest
from contacts import contact_of as contact_with
from contacts import solve
from scipy.optimize import minimize

import ase_roughcontact as rc
from ase_roughcontact.solvers.soft.energy import ContactEnergy

WALLS = {
    "exponential": rc.ExponentialWall(0.02, 0.5),
    "power-law": rc.PowerLawWall(0.02, 0.5),
    "dugdale": rc.DugdaleWall(0.02, 0.5),
}
every_wall = pytest.mark.parametrize("wall", WALLS.values(), ids=WALLS.keys())
ROUGH = rc.SelfAffine(0.1, 0.8, short_wavelength=4.0, long_wavelength=16.0, seed=2)


def contact_of(wall, n=32, radius=60.0, **options):
    origin = (-(n - 1) / 2, -(n - 1) / 2)
    heights = rc.RoughSphere(radius, ROUGH).heights((n, n), 1.0, origin)
    return contact_with(heights, wall, **options)


def relax(contact, height=0.0, load=None, start=None, tolerance=1e-7):
    return solve(contact, load, height, start, tolerance)


def gap_and_reaction(contact, state):
    gap = contact.heights + state.height
    gap -= contact.halfspace.displacement(state.pressure)
    return gap, state.pressure - contact.evaluate_wall(np.maximum(gap, 0.0))[1]


def check_conditions(contact, state, tolerance=1e-6, overlap=2e-6):
    """Check gaps and reactions; return the mask of the atoms that touch."""
    gap, reaction = gap_and_reaction(contact, state)
    assert gap.min() > -overlap
    assert reaction.min() > -tolerance
    touching = reaction > 10 * tolerance
    assert abs(gap[touching]).max(initial=0.0) < overlap
    return touching


@every_wall
@pytest.mark.parametrize("load", [None, -0.2, 3.0])
def test_optimality_conditions_are_satisfied(wall, periodic, load):
    contact = contact_of(wall, periodic=periodic)
    state = relax(contact, height=-0.5, load=load)
    touching = check_conditions(contact, state, 1e-7, 2e-7)
    assert 10 < touching.sum() < touching.size
    if load is not None:
        assert state.pressure.sum() == pytest.approx(load, abs=1e-6)


@every_wall
@pytest.mark.parametrize("load", [2e-7, 1.0])
@pytest.mark.parametrize("level", [0.0, 1e-3, -7.0])
def test_a_flat_indenter_carries_a_load_at_a_gap_of_zero(wall, load, level):
    contact = contact_with(np.full((10, 10), level), wall, periodic=True)
    state = relax(contact, load=load)
    assert state.height == pytest.approx(-level, abs=1e-6)
    assert state.pressure == pytest.approx(0.01 * load, abs=1e-8)


@every_wall
def test_energy_is_the_constrained_minimum_that_scipy_finds(wall):
    """In the displacements of a periodic surface, which bounds keep below the wall."""
    contact = contact_of(wall, n=8, periodic=True)
    half, heights = contact.halfspace, contact.heights

    def energy_and_gradient(u):
        state = contact.evaluate(u.reshape(heights.shape), 20.0)
        gap = heights - u.reshape(heights.shape)
        energy, pressure = contact.evaluate_wall(gap)
        elastic = state.energy - contact.evaluate_wall(state.gap)[0].sum()
        force = state.forces - state.forces.mean()
        return elastic + energy.sum(), -(force - pressure).ravel()

    state = relax(contact, height=0.0)
    start = half.displacement(state.pressure) * 0.9
    # a mean displacement is a change of height: the bound is the relaxed bound
    start -= start.mean()
    bounds = [(None, float(h)) for h in heights.ravel()]
    mean = {"type": "eq", "fun": lambda u: u.sum(), "jac": np.ones_like}
    result = minimize(
        energy_and_gradient,
        np.minimum(start, heights).ravel(),
        jac=True,
        method="SLSQP",
        bounds=bounds,
        constraints=[mean],
        options={"ftol": 1e-14, "maxiter": 2000},
    )
    assert state.energy == pytest.approx(result.fun, rel=1e-5)


def test_weak_attraction_gives_the_hard_wall_of_the_active_set():
    adhesive = contact_of(rc.ExponentialWall(1e-9, 0.5))
    hard = relax(contact_of(rc.HardWall()), height=-1.0, tolerance=1e-8)
    soft = relax(adhesive, height=-1.0, tolerance=1e-8)
    np.testing.assert_allclose(soft.pressure, hard.pressure, atol=2e-7)


@every_wall
def test_adhesion_of_patches_agrees_with_each_patch(wall):
    """Where the local work of adhesion is zero, the wall is a hard one."""
    n = 32
    none, half = np.zeros((n, n)), np.ones((n, n))
    half[:, : n // 2] = 0.0
    expected = relax(contact_of(rc.HardWall()), height=-1.0, tolerance=1e-8)
    state = relax(contact_of(wall, adhesion=none), height=-1.0, tolerance=1e-8)
    np.testing.assert_allclose(state.pressure, expected.pressure, atol=2e-7)
    contact = contact_of(wall, adhesion=half)
    gap, reaction = gap_and_reaction(contact, relax(contact, height=-1.0))
    pressure = contact.evaluate_wall(np.maximum(gap, 0.0))[1]
    assert (pressure[:, : n // 2] == 0.0).all() and pressure.min() < -0.01
    assert reaction.min() > -1e-6


def test_stiffness_of_the_augmented_lagrangian_follows_the_strongest_attraction():
    """It has to exceed the negative stiffness of the attraction everywhere."""
    factors = np.ones((32, 32))
    factors[3, 4] = 4.0
    short = rc.ExponentialWall(0.05, 0.05)
    stiffness = ContactEnergy.of(contact_of(short, adhesion=factors), None).stiffness
    assert stiffness > 4.0 * 0.05 / 0.05**2


# Extremes


@pytest.mark.parametrize("kind", [rc.ExponentialWall, rc.PowerLawWall, rc.DugdaleWall])
@pytest.mark.parametrize("work", [1e-8, 0.3])
@pytest.mark.parametrize("reach", [0.2, 30.0])
def test_any_work_and_range_relax(kind, work, reach):
    contact = contact_of(kind(work, reach), n=24)
    check_conditions(contact, relax(contact, height=-0.5))


@every_wall
def test_full_contact_of_a_periodic_surface_relaxes(wall):
    contact = contact_of(wall, n=24, periodic=True, radius=1e6)
    state = relax(contact, load=500.0)
    gap, _ = gap_and_reaction(contact, state)
    assert abs(gap).max() < 2e-7


@every_wall
def test_out_of_range_the_surface_stays_flat(wall):
    state = relax(contact_of(wall), height=100.0)
    assert not state.pressure.any()
    assert state.energy == 0.0


@every_wall
def test_deep_overlap_is_removed(wall):
    contact = contact_of(wall)
    check_conditions(contact, relax(contact, height=-30.0, tolerance=1e-6), 1e-4)
