"""Energy, forces and fields of a contact, as arrays."""

import numpy as np
import pytest

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.interactions import HardWall, LennardJones93

WALL = LennardJones93.repulsive(1.0, 1.0)
STEP = 1e-5


def half_space(periodic, shape=(6, 5), solid=1.0):
    return (PeriodicHalfSpace if periodic else FreeHalfSpace)(shape, 1.0, solid)


def random_displacement(contact, rng, size=0.2):
    return rng.normal(0.0, size, contact.halfspace.grid)


def numerical_forces(contact, u, height):
    forces = np.empty(u.shape)
    for index in np.ndindex(u.shape):
        moved = u.copy()
        moved[index] += STEP
        up = contact.evaluate(moved, height).energy
        moved[index] -= 2 * STEP
        forces[index] = (contact.evaluate(moved, height).energy - up) / (2 * STEP)
    return forces


# Energy and forces


# Heights of the indenter: light touch, and atoms pushed through the core.
@pytest.mark.parametrize("height", [0.9, -0.3], ids=["touching", "overlapping"])
def test_forces_are_minus_the_gradient_of_the_energy(scene, rng, height):
    u = random_displacement(scene, rng, 0.05)
    state = scene.evaluate(u, height)
    assert (state.gap.min() < 0.0) == (height < 0.0)
    error = np.abs(numerical_forces(scene, u, height) - state.forces).max()
    assert error < 1e-6 * max(1.0, np.abs(state.forces).max())
    up, down = (scene.evaluate(u, height + step).energy for step in (STEP, -STEP))
    assert (down - up) / (2 * STEP) == pytest.approx(state.normal_force, rel=1e-6)


def test_energies_of_the_atoms_sum_to_the_energy(scene, rng):
    displacement = random_displacement(scene, rng)
    state = scene.evaluate(displacement, 0.8)
    energies = scene.energies(displacement, state)
    assert energies.sum() == pytest.approx(state.energy, rel=1e-13)


def test_at_equilibrium_the_pressure_causes_the_displacement(scene, relax):
    u = relax(scene, 0.3, gtol=1e-9)
    pressure = scene.evaluate(u, 0.3).pressure
    u -= u.mean() if scene.halfspace.periodic else 0.0
    np.testing.assert_allclose(
        u, scene.halfspace.padded_displacement(pressure), atol=1e-7
    )


# Symmetries


@pytest.fixture
def periodic_contact(wall, rng, solid):
    heights = rng.uniform(0.0, 3.0, (6, 5))
    return Contact(half_space(True, solid=solid), heights, wall)


@pytest.mark.parametrize("name", ["forces", "gap", "pressure"])
def test_a_shift_of_the_whole_periodic_substrate_changes_nothing(
    periodic_contact, rng, name
):
    contact = periodic_contact
    u = random_displacement(contact, rng)
    there, here = (getattr(contact.evaluate(u + c, 0.8), name) for c in (0.7, 0.0))
    np.testing.assert_allclose(there, here, atol=1e-12 * np.abs(here).max())


def test_periodic_forces_sum_to_zero(periodic_contact, rng):
    u = random_displacement(periodic_contact, rng)
    forces = periodic_contact.evaluate(u, 0.5).forces
    assert abs(forces.sum()) < 1e-12 * np.abs(forces).sum()


# Contact


def test_distant_indenter_has_no_energy_force_or_contact(scene):
    state = scene.evaluate(np.zeros(scene.halfspace.grid), 50.0)
    assert (state.energy, state.normal_force, state.contact_area) == (0.0, 0.0, 0.0)


def test_atoms_closer_than_the_contact_distance_are_in_contact(scene, rng):
    state = scene.evaluate(random_displacement(scene, rng), 0.0)
    wall = scene.wall
    np.testing.assert_array_equal(state.contact, state.gap < wall.contact_distance)
    assert 0 < state.repulsive_atoms < state.gap.size
    assert state.contact_area == state.repulsive_atoms * scene.halfspace.cell_area


def test_attractive_walls_pull_between_contact_distance_and_cutoff(scene, rng):
    state = scene.evaluate(random_displacement(scene, rng), 0.0)
    wall = scene.wall
    pulled = (state.gap > wall.contact_distance) & (state.gap < wall.cutoff)
    assert state.attractive_atoms == np.count_nonzero(pulled)
    assert (state.attractive_atoms > 0) == wall.attractive


def test_first_contact_is_the_height_at_which_one_atom_begins_to_touch(scene):
    flat = np.zeros(scene.halfspace.grid)
    assert scene.evaluate(flat, scene.first_contact + 1e-9).repulsive_atoms == 0
    assert scene.evaluate(flat, scene.first_contact - 1e-9).repulsive_atoms == 1


# Hard wall


def test_hard_wall_carries_the_pressure_that_holds_its_atoms(periodic, rng, solid):
    half = half_space(periodic, solid=solid)
    pressure = np.maximum(rng.normal(size=half.shape), 0.0)
    u = half.padded_displacement(pressure)
    window = u[: half.shape[0], : half.shape[1]]
    heights = np.where(pressure > 0.0, window, window + 1.0)
    state = Contact(half, heights, HardWall()).evaluate(u, 0.0)
    np.testing.assert_allclose(state.pressure, pressure, atol=1e-12)
    assert state.normal_force == pytest.approx(pressure.sum())
    assert state.repulsive_atoms == np.count_nonzero(pressure)
    np.testing.assert_allclose(state.forces, 0.0, atol=1e-12)


def test_overlap_with_a_hard_wall_is_refused_with_advice(periodic):
    half = half_space(periodic)
    contact = Contact(half, np.zeros(half.shape), HardWall())
    with pytest.raises(ValueError, match=r"30 atoms overlap .* by up to 0\.1.*use"):
        contact.evaluate(np.zeros(half.grid), -0.1)


# Bad input


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_heights_that_are_not_finite_are_refused(bad):
    heights = np.zeros((6, 5))
    heights[2, 3] = bad
    with pytest.raises(ValueError, match="finite, got 1 values"):
        Contact(half_space(False), heights, WALL)


def test_arrays_of_another_shape_than_the_window_are_refused():
    half = half_space(False)
    with pytest.raises(ValueError, match=r"shape \(6, 5\)"):
        Contact(half, np.zeros((5, 6)), WALL)
    with pytest.raises(ValueError, match=r"shape \(12, 9\)"):
        Contact(half, np.zeros((6, 5)), WALL).evaluate(np.zeros((6, 5)), 2.0)
