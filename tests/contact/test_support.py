"""Supports of the indenter: energies and forces of loads and springs."""

import numpy as np
import pytest

from ase_roughcontact.contact.support import LateralSupport, Spring, Support


@pytest.mark.parametrize(
    "support",
    [
        Support(False, 2.0),
        Support(False, 0.0, Spring(3.0, 1.5)),
        Support(False, 2.0, Spring(3.0, 1.5)),
        Support(True, 0.0, Spring(3.0, 1.5)),
    ],
    ids=["load", "spring", "load and spring", "spring at a height"],
)
def test_force_is_the_negative_derivative_of_the_energy(support):
    height, delta = 0.7, 1e-5
    above, below = (support.external(height + d)[0] for d in (delta, -delta))
    expected = -(above - below) / (2.0 * delta)
    assert support.external(height)[1] == pytest.approx(expected, rel=1e-8)


def test_a_given_height_needs_no_load():
    assert Support(True, 2.0).external(0.7) == (0.0, 0.0)


def test_a_solver_without_external_forces_has_a_fixed_indenter():
    assert Support.of(None) == Support(True)
    assert not Support.of(Spring(3.0, 1.5)).fixed


@pytest.mark.parametrize(
    ("force", "stiffness", "excess"),
    [((3.0, 4.0), 0.0, 0.2), ((0.0, 2.0), 0.0, -1.0), ((3.0, 4.0), 1.0, -np.inf)],
)
def test_part_of_a_lateral_force_that_friction_does_not_carry(force, stiffness, excess):
    bound = np.full((2, 2), 1.0)
    found = LateralSupport(force, stiffness).excess(bound)
    assert found == pytest.approx(excess, rel=1e-12)
