"""Derivatives of relaxed contacts agree with central differences and closed forms."""

import numpy as np
import pytest
from built import atoms_under
from contacts import contact_of, rough_sphere, solve

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import contact_of as contact_of_atoms
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.solvers.response import force_derivative, height_response
from ase_roughcontact.theory import Hertz

ISOTROPIC = Isotropic(1.0)
ROUGH = rc.SelfAffine(0.1, 0.8, 4.0, 16.0, seed=1)
# Longer steps cross kinks of the force, where atoms change their range of the wall.
STEP = 3e-6
WALLS = {
    "hard": rc.HardWall(),
    "repulsive": rc.LennardJones93.repulsive(1.0, 1.0),
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.02),
    "full": rc.LennardJones93.full(distance=1.0, work_of_adhesion=0.05),
    "exponential": rc.ExponentialWall(0.02, 0.5),
}


def relaxed(contact, height):
    """Fields of the relaxed contact at a height."""
    pressure = solve(contact, height=height, tolerance=1e-12).pressure
    displacement = contact.halfspace.padded_displacement(pressure)
    return contact.evaluate(displacement, height, pressure, pressure)


@pytest.mark.parametrize("wall", WALLS.values(), ids=WALLS)
def test_derivative_of_the_force_to_the_height_agrees_with_differences(
    wall, periodic, solid
):
    heights = rough_sphere((40, 40), np.inf if periodic else 100.0, ROUGH)
    adhesion = np.linspace(0.5, 1.5, 1600).reshape(40, 40) if wall.attractive else None
    contact = contact_of(
        heights, wall, periodic=periodic, solid=solid, adhesion=adhesion
    )
    height = contact.first_contact - (0.3 if periodic else 0.6)
    low, high, state = (relaxed(contact, height + d) for d in (-STEP, STEP, 0.0))
    expected = (high.normal_force - low.normal_force) / (2 * STEP)
    for tolerance, error in ((1e-3, 1e-4), (1e-6, 1e-6)):
        response = height_response(contact, state, tolerance)
        assert response.force == pytest.approx(expected, rel=error)
    gap = (high.gap - low.gap) / (2 * STEP)
    np.testing.assert_allclose(response.gap, gap, rtol=0, atol=1e-4)


def test_few_steps_under_a_hard_wall_leave_a_small_error_of_the_force():
    """What further steps would add is estimated: 2e-5 remains, without it 4e-4."""
    rough = rc.SelfAffine(0.1, 0.8, 4.0, 32.0, seed=1, domain=256.0)
    heights = rc.RoughSphere(np.inf, rough).heights((256, 256), 1.0, (0.0, 0.0))
    contact = contact_of(heights, rc.HardWall(), periodic=True)
    last = solve(contact, 0.01 * heights.size)
    displacement = contact.halfspace.displacement(last.pressure)
    state = contact.evaluate(displacement, last.height, last.pressure, last.pressure)
    rough_force, force = (
        height_response(contact, state, t).force for t in (0.01, 1e-6)
    )
    assert rough_force == pytest.approx(force, rel=1e-4)


def test_nothing_responds_out_of_range(solid):
    contact = contact_of(rough_sphere((40, 40)), WALLS["repulsive"], solid=solid)
    state = relaxed(contact, contact.first_contact + 1.0)
    response = height_response(contact, state)
    assert response.force == 0.0
    assert (response.gap == 1.0).all()


def test_a_full_contact_of_a_periodic_hard_wall_is_rigid():
    contact = contact_of(np.zeros((8, 8)), rc.HardWall(), periodic=True)
    pressure = solve(contact, 3.0, tolerance=1e-9).pressure
    state = contact.evaluate(np.zeros((8, 8)), 0.0, pressure, pressure)
    assert height_response(contact, state).force == -np.inf


def test_a_state_that_is_no_minimum_has_no_stiffness():
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.1)
    heights = rc.RoughSphere(30.0).heights((24, 24), 1.0, (-12.0, -12.0))
    contact, largest, known = contact_of(heights, wall, solid=0.3), [], []
    flat = np.zeros(contact.halfspace.dof_shape)
    for height in np.linspace(wall.cutoff, wall.contact_distance, 25)[1:]:
        state = contact.evaluate(flat, height)  # above a surface that is kept flat
        largest.append(contact.halfspace.cell_area * wall.evaluate(state.gap)[2].sum())
        known.append(-height_response(contact, state).force)
    known, largest = np.array(known), np.array(largest)
    assert np.isfinite(known[0]) and np.isnan(known).any()
    assert (known <= largest + 0.01 * abs(largest))[np.isfinite(known)].all()


def test_contact_stiffness_and_pressure_of_a_smooth_sphere_agree_with_hertz():
    sphere = rc.RoughSphere(400.0)
    atoms = atoms_under(sphere, rc.HardWall(), (96, 96))
    (step,) = rc.load_path(atoms, penetrations=[3.0])
    radius = float(Hertz(400.0, 1.0).contact_radius(step.normal_force))
    assert step.contact_stiffness == pytest.approx(2 * radius, rel=0.01)
    peak = 1.5 * step.normal_force / (np.pi * radius**2)
    assert step.largest_pressure == pytest.approx(peak, rel=0.02)
    mean = step.normal_force / step.contact_area
    assert step.mean_pressure == pytest.approx(mean, rel=1e-9)


def force_of(work=0.02, radius=100.0, kind="adhesive", solid=ISOTROPIC):
    """Force, contact, state and response of a rough sphere at a fixed height."""
    wall = (
        rc.LennardJones93.adhesive(1.0, 1.0, work)
        if kind == "adhesive"
        else rc.HardWall()
    )
    contact = contact_of(rough_sphere((40, 40), radius, ROUGH), wall, solid=solid)
    lowest = rough_sphere((40, 40), 100.0, ROUGH).min()
    state = relaxed(contact, (0.4 if kind == "adhesive" else -0.6) - lowest)
    assert state.repulsive_atoms > 20
    return state.normal_force, contact, state


def difference(force, value, step=STEP):
    low, high = (force(end)[0] for end in (value - step, value + step))
    return (high - low) / (2 * step)


@pytest.mark.parametrize("kind", ["adhesive", "hard"])
def test_derivative_to_the_radius_agrees_with_differences(kind, solid):
    _, contact, state = force_of(kind=kind, solid=solid)
    response = height_response(contact, state, 1e-9)
    x = np.arange(40) - 20.0
    slope = -(x[:, None] ** 2 + x**2) / (2 * 100.0**2)
    by_radius = force_derivative(contact, state, response, heights=slope)
    step = STEP if kind == "adhesive" else 10 * STEP  # no atom changes contact
    expected = difference(
        lambda r: force_of(radius=r, kind=kind, solid=solid), 100.0, step
    )
    assert by_radius == pytest.approx(expected, rel=1e-5, abs=1e-8)


@pytest.mark.parametrize("kind", ["adhesive", "hard"])
def test_derivative_to_the_modulus_agrees_with_differences(kind):
    _, contact, state = force_of(kind=kind)
    response = height_response(contact, state, 1e-9)
    by_modulus = force_derivative(contact, state, response, compliance=-1.0)
    expected = difference(lambda e: force_of(kind=kind, solid=Isotropic(e)), 1.0)
    assert by_modulus == pytest.approx(expected, rel=1e-6)


def test_derivative_to_the_work_of_adhesion_agrees_with_differences(solid):
    _, contact, state = force_of(solid=solid)
    response = height_response(contact, state, 1e-9)
    low, high = (
        rc.LennardJones93.adhesive(1.0, 1.0, 0.02 + change).evaluate(state.gap)[1]
        for change in (-1e-6, 1e-6)
    )
    by_work = force_derivative(
        contact, state, response, wall_pressure=(high - low) / 2e-6
    )
    expected = difference(lambda work: force_of(work, solid=solid), 0.02, 2e-6)
    assert by_work == pytest.approx(expected, rel=1e-6)


def test_derivative_to_the_height_agrees_with_raised_heights(solid):
    _, contact, state = force_of(solid=solid)
    response = height_response(contact, state, 1e-9)
    raised = force_derivative(contact, state, response, heights=1.0)
    assert raised == pytest.approx(response.force, rel=1e-8)


def test_a_saddle_has_no_stiffness():
    """An atom at the end of the attraction: the energy falls if it moves up or down."""
    rough = rc.SelfAffine(0.3, 0.8, 4.0, 8.0, domain=16.0, seed=34)
    atoms = atoms_under(rough, rc.DugdaleWall(0.063, 0.203), (16, 16), periodic=True)
    options = {"validity": "ignore", "window": "unchecked"}
    (step,) = rc.load_path(atoms, penetrations=[0.2], **options)
    contact, state = contact_of_atoms(atoms), atoms.calc.state(atoms)
    stiffness = contact.wall.evaluate(state.gap)[2]
    move = -1.0 * (~state.contact & (stiffness == 0.0))
    move /= abs(move.sum())
    move.flat[stiffness.argmin()] = 1.0  # the mean stays
    displacement = contact.heights + step.height - state.gap
    low, middle, high = (
        contact.evaluate(displacement + k * move, step.height).energy
        for k in (-1e-4, 0.0, 1e-4)
    )
    assert step.converged and low + high < 2.0 * middle - 1e-8
    assert np.isnan(step.contact_stiffness)
