"""Nearly full contacts of a periodic surface, solved for the gaps of open atoms."""

import numpy as np
import pytest
from numpy.testing import assert_allclose, assert_array_equal
from scipy.optimize import nnls

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity import Layer
from ase_roughcontact.elasticity.halfspace import PeriodicHalfSpace
from ase_roughcontact.interactions import HardWall
from ase_roughcontact.solvers.hard_wall import active_set
from ase_roughcontact.solvers.nearly_full import nearly_full_contact
from ase_roughcontact.solvers.options import ActiveSetOptions
from ase_roughcontact.topography import SelfAffine

TOLERANCE = 1e-9


def rough(n, seed=0):
    return SelfAffine(0.1, 0.8, 4.0, 16.0, seed=seed, domain=float(n)).heights(
        (n, n), 1.0
    )


def open_atoms(heights, mean, **options):
    halfspace = PeriodicHalfSpace(heights.shape, 1.0, 1.0)
    pressure, _ = nearly_full_contact(
        halfspace, heights, mean, TOLERANCE, ActiveSetOptions(**options)
    )
    return halfspace, pressure


def steps(heights, mean, solid=1.0, tolerance=1e-6, **options):
    halfspace = PeriodicHalfSpace(heights.shape, 1.0, solid)
    contact, load = Contact(halfspace, heights, HardWall()), mean * heights.size
    return list(
        active_set(
            contact,
            height=0.0,
            external=lambda z: (load * z, -load),
            start=None,
            tolerance=tolerance,
            options=ActiveSetOptions(**options),
        )
    )


@pytest.mark.parametrize("mean", [0.08, 0.1])
def test_open_atoms_are_those_of_a_dense_solution(mean):
    heights = rough(16)
    halfspace, pressure = open_atoms(heights, mean)
    full = halfspace.elastic_pressure(heights - heights.mean()).ravel()
    units = np.eye(heights.size).reshape(-1, *heights.shape)
    stiffness = np.array([-halfspace.elastic_pressure(unit).ravel() for unit in units])
    # g K g / 2 + p g as least squares; the last row stands for the mean, on which K
    # does not depend
    values, vectors = np.linalg.eigh(stiffness)
    values, vectors = values[1:], vectors[:, 1:].T
    last = np.full((1, heights.size), 1e-5)
    gap, _ = nnls(
        np.vstack((np.sqrt(values)[:, None] * vectors, last)),
        np.append(-vectors @ full / np.sqrt(values), -mean / 1e-5),
    )
    assert 0.8 < np.count_nonzero(pressure) / heights.size < 1.0
    assert_array_equal(pressure.ravel() > 0.0, gap == 0.0)
    expected = np.where(gap > 0.0, 0.0, mean + full + stiffness @ gap)
    assert_allclose(pressure.ravel(), expected, atol=1e-8)


@pytest.mark.parametrize("mean", [0.11, 0.2, 0.3])
def test_solution_is_that_of_the_active_set(mean):
    heights = rough(64)
    (near,) = steps(heights, mean)  # nothing is left to correct
    *_, far = steps(heights, mean, full_contact=2.0)
    assert near.converged and far.converged
    assert_array_equal(near.pressure > 0.0, far.pressure > 0.0)
    assert_allclose(near.pressure, far.pressure, atol=1e-6)


def test_contact_with_too_many_open_atoms_is_left_to_the_active_set():
    assert open_atoms(rough(16), 0.02)[1] is None


def test_full_contact_has_no_open_atoms():
    heights = rough(16)
    halfspace, pressure = open_atoms(heights, 1.0)
    elastic = halfspace.elastic_pressure(heights - heights.mean())
    assert_allclose(pressure, 1.0 + elastic, rtol=1e-12)


def test_steps_that_do_not_suffice_are_a_start():
    pressure = open_atoms(rough(64), 0.15, inner_steps=3)[1]
    assert pressure.min() >= 0.0
    *_, last = done = steps(rough(64), 0.15, inner_steps=3)
    assert last.converged and len(done) > 1


@pytest.mark.parametrize("solid", [1.0, Layer(0.5, 3.0, 2.0, 0.3, 0.2)])
def test_windows_need_not_be_square_nor_solids_uniform(solid):
    heights = rough(48)[:, :36]
    halfspace = PeriodicHalfSpace(heights.shape, 1.0, solid)
    full = halfspace.elastic_pressure(heights - heights.mean())
    problem = heights, -0.8 * full.min(), solid, 1e-8
    *_, near = steps(*problem)
    *_, far = steps(*problem, full_contact=2.0)
    assert near.converged and far.converged
    assert 0.8 < np.mean(near.pressure > 0.0) < 1.0
    assert_array_equal(near.pressure > 0.0, far.pressure > 0.0)
    assert_allclose(near.pressure, far.pressure, atol=1e-7)
