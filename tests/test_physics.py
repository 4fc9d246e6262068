"""Known solutions of contact mechanics, reached as the atoms get finer.

The spacing and the contact modulus are 1. A finer grid under the same sphere is then a
larger sphere; the wall, as stiff as the bulk, is thinner and stiffer in proportion.
"""

from functools import cache

import numpy as np
import pytest
from scipy.special import erf

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.interactions import LennardJones93
from ase_roughcontact.topography import RoughSphere, SelfAffine

WALL = LennardJones93.repulsive(1.0, 1.0)
WINDOWS = (16, 32, 64)
SLOPE = 0.1


@pytest.fixture(scope="module")
def hertz(relax):
    """Quantities over their Hertzian values, for a sphere that fills 70 % of a side."""

    @cache
    def ratios(n):
        radius, contact_radius = 1.6 * n, 0.35 * n
        depth = contact_radius**2 / radius
        origin = (0.5 - n / 2, 0.5 - n / 2)
        heights = RoughSphere(radius).heights((n, n), 1.0, origin)
        contact = Contact(FreeHalfSpace((n, n), 1.0, 1.0), heights, WALL)
        height = WALL.contact_distance - depth
        state = contact.evaluate(relax(contact, height), height)
        force = state.normal_force
        return {
            "force": force / (4 / 3 * radius**0.5 * depth**1.5),
            "area": state.contact_area / (np.pi * (0.75 * force * radius) ** (2 / 3)),
            "depth": depth / (0.75 * force / radius**0.5) ** (2 / 3),
            "peak": state.pressure.max() * np.pi * radius / (2 * contact_radius),
        }

    return ratios


def punch_force(relax, n):
    """Force over 2 E* b depth of a flat circular punch of radius b."""
    radius, depth = 0.4375 * n, 0.00625 * n
    x = np.arange(n) + 0.5 - n / 2
    heights = np.where(np.hypot(x[:, None], x) < radius, 0.0, 10.0 * n)
    contact = Contact(FreeHalfSpace((n, n), 1.0, 1.0), heights, WALL)
    height = WALL.contact_distance - depth
    state = contact.evaluate(relax(contact, height), height)
    return state.normal_force / (2 * radius * depth)


# Errors of first order in the spacing: halved by every refinement, and gone if the two
# finest are extrapolated. The area counts whole atoms and is the coarsest.
@pytest.mark.parametrize(
    "name, finest, extrapolated",
    [
        ("force", 0.015, 0.003),
        ("depth", 0.010, 0.002),
        ("peak", 0.020, 0.001),
        ("area", 0.070, 0.020),
    ],
)
def test_hertz(hertz, name, finest, extrapolated):
    error = np.array([hertz(n)[name] - 1.0 for n in WINDOWS])
    assert (np.abs(error[1:]) < 0.75 * np.abs(error[:-1])).all()
    assert abs(error[-1]) < finest
    assert abs(2 * error[-1] - error[-2]) < extrapolated


def test_flat_circular_punch(relax):
    error = np.array([punch_force(relax, n) - 1.0 for n in WINDOWS])
    assert (np.abs(error[1:]) < 0.65 * np.abs(error[:-1])).all()
    assert abs(error[-1]) < 0.035
    assert abs(2 * error[-1] - error[-2]) < 0.005


def rough_contacts(relax, n, long_wavelength, depths):
    """Contact fractions and mean pressures of a periodic, nominally flat surface."""
    surface = SelfAffine(SLOPE, 0.8, 4.0, long_wavelength, seed=1, domain=float(n))
    half = PeriodicHalfSpace((n, n), 1.0, 1.0)
    contact = Contact(half, surface.heights((n, n), 1.0), WALL)
    u = np.zeros(half.grid)
    for depth in depths:
        height = contact.first_contact - depth * surface.statistics().rms_height
        u = relax(contact, height, start=u, gtol=1e-5)
        state = contact.evaluate(u, height)
        yield state.repulsive_atoms / n**2, state.normal_force / n**2


def test_kappa_of_the_repulsive_wall_agrees_with_the_paper(relax):
    for area, pressure in rough_contacts(relax, 256, 256.0, (0.9, 1.2)):
        assert 0.02 < area < 0.10
        assert 2.6 < SLOPE * area / pressure < 3.2


@pytest.mark.slow  # 512 x 512 atoms
def test_contact_fraction_of_a_flat_surface_is_an_error_function(relax):
    path = rough_contacts(relax, 512, 256.0, (1.2, 1.5, 1.8, 2.4, 3.0))
    area, pressure = np.array(list(path)).T
    assert area[0] < 0.03 and area[-1] > 0.3
    kappa = SLOPE * area / pressure
    assert ((kappa > 2.6) & (kappa < 3.2))[(area > 0.02) & (area < 0.1)].all()
    rough_pressure = SLOPE / 2.9
    predicted = erf(np.sqrt(np.pi) * pressure / (2 * rough_pressure))
    np.testing.assert_allclose(area, predicted, rtol=0.15)
