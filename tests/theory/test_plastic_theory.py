"""Closed forms of plastic contact: limits, load and simulated areas."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact import theory
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import PeriodicHalfSpace
from ase_roughcontact.interactions import PlasticWall
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.topography import SelfAffine

PRESSURES = np.array([0.0, 1e-4, 0.01, 0.03, 0.09])


def test_fully_plastic_area():
    assert_allclose(theory.plastic_area([0.0, 3.0], 0.5), [0.0, 6.0])


def test_loads_of_a_sphere_follow_from_hertz():
    radius, modulus, hardness = 300.0, 2.0, 0.03
    sphere = theory.Hertz(radius, modulus)
    first = theory.yield_load(radius, modulus, hardness)
    a = float(sphere.contact_radius(first))
    assert_allclose(sphere.pressure(0.0, a), hardness)
    full = theory.plastic_crossover_load(radius, modulus, hardness)
    assert_allclose(full / sphere.contact_area(full), hardness)


def test_without_a_limit_the_fraction_is_the_elastic_one():
    contact, plastic = theory.plastic_contact_fraction(PRESSURES, 0.05, 1e3)
    assert_allclose(contact, theory.contact_fraction(PRESSURES, 0.05), rtol=1e-10)
    assert_allclose(plastic, 0.0, atol=1e-12)


def test_soft_solids_are_fully_plastic():
    contact, plastic = theory.plastic_contact_fraction(0.3 * PRESSURES, 10.0, 0.1)
    assert_allclose(contact, 3.0 * PRESSURES)
    assert_allclose(plastic, 3.0 * PRESSURES)


@pytest.mark.parametrize("rough", [0.02, 0.05, 0.2])
def test_fraction_agrees_with_the_series(rough):
    """The same distribution as a sum over standing waves between the bounds."""
    p, hardness = PRESSURES[1:], 0.1
    n = np.arange(1, 3000)[:, None]
    decay = np.exp(-(n**2) * np.pi * (rough / hardness) ** 2)
    waves = np.sin(n * np.pi * p / hardness) * decay / (n * np.pi)
    elastic = (2.0 * (1.0 - (-1.0) ** n) * waves).sum(axis=0)
    carried = (-2.0 * hardness * (-1.0) ** n * waves).sum(axis=0)
    contact, plastic = theory.plastic_contact_fraction(p, rough, hardness)
    assert_allclose(plastic, (p - carried) / hardness, atol=1e-12)
    assert_allclose(contact, elastic + plastic, rtol=1e-9)


def test_fraction_is_continuous_at_the_hardness():
    contact, plastic = theory.plastic_contact_fraction(
        [0.1 - 1e-9, 0.1, 0.2], 0.05, 0.1
    )
    assert_allclose(contact, [1.0, 1.0, 2.0], rtol=1e-6)
    assert_allclose(plastic, contact, rtol=1e-6)


@pytest.mark.parametrize("part", [0.1, 0.5])
@pytest.mark.parametrize("hardness", [0.02, 0.05, 0.1])
def test_fraction_of_rough_flats(part, hardness):
    n, load = 128, part * hardness * 128**2
    heights = SelfAffine(0.1, 0.8, 8.0, n, seed=3).heights((n, n), 1.0)
    halfspace = PeriodicHalfSpace((n, n), 1.0, 1.0)
    contact = Contact(halfspace, heights, PlasticWall(hardness))
    *_, state = active_set(
        contact,
        height=0.0,
        external=lambda z: (load * z, -load),
        start=None,
        tolerance=1e-5,
    )
    expected, plastic = theory.plastic_contact_fraction(part * hardness, 0.05, hardness)
    assert_allclose((state.pressure > 0.0).mean(), expected, rtol=0.2)
    assert_allclose((state.pressure == hardness).mean(), plastic, atol=0.06)
