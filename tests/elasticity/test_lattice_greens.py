"""Green's functions of crystal surfaces from force constants."""

import numpy as np
import pytest
from ase.build import fcc100
from matscipy.calculators.eam import EAM
from matscipy.calculators.pair_potential import LennardJonesCut, PairPotential
from matscipy.elasticity import coalesce_elastic_constants, rotate_elastic_constants
from scipy.interpolate import InterpolatedUnivariateSpline
from spring_crystal import Springs, fcc_springs

from ase_roughcontact.elasticity.crystals.force_constants import (
    force_constants,
    relaxed_slab,
)
from ase_roughcontact.elasticity.crystals.impedance import surface_modulus
from ase_roughcontact.elasticity.crystals.lattice_greens import LatticeGreensFunction

A = 3.6
CUTOFF = 1.2 * A


def greens_function(calculator, surface="fcc100", layers=7, size=5, displacement=1e-3):
    slab = relaxed_slab(calculator, "Cu", surface, A, layers)
    return LatticeGreensFunction(force_constants(calculator, slab, size, displacement))


def modulus(greens, q, angle, cell_area):
    vectors = np.outer(q, [np.cos(angle), np.sin(angle)])
    return 2 / (q * cell_area * greens(vectors)[:, 2, 2].real)


@pytest.mark.parametrize(
    "surface, axes, cell_area",
    [
        ("fcc100", [[1, 1, 0], [-1, 1, 0], [0, 0, 1]], A**2 / 2),
        ("fcc111", [[-1, 1, 0], [-1, -1, 2], [1, 1, 1]], A**2 * 3**0.5 / 4),
    ],
)
@pytest.mark.parametrize("angle", [0.0, 0.5])
def test_long_waves_agree_with_the_continuum(surface, axes, cell_area, angle):
    springs, constants = fcc_springs(A)
    rotation = np.array(axes, float)
    rotation /= np.linalg.norm(rotation, axis=1)[:, None]
    stiffness = coalesce_elastic_constants(*constants, convention="Cij")
    stiffness = rotate_elastic_constants(stiffness, rotation)
    expected = surface_modulus(stiffness, np.array([angle]))
    q = 2 * np.pi / np.array([400.0, 800.0]) / (A / np.sqrt(2))
    at_400, at_800 = modulus(greens_function(springs, surface), q, angle, cell_area)
    assert at_400 == pytest.approx(expected, rel=1e-2)
    assert 2 * at_800 - at_400 == pytest.approx(expected, rel=2e-5)


def pair_potential():
    return PairPotential({(29, 29): LennardJonesCut(0.4, A / 2**0.5 / 1.1, CUTOFF)})


def embedded_atoms():
    """Return a potential of Sutton and Chen to second neighbours, without stress."""
    r, rho = np.linspace(1.5, CUTOFF, 400), np.linspace(0.1, 60.0, 400)
    smooth = (1 - (r / CUTOFF) ** 2) ** 3
    density = InterpolatedUnivariateSpline(r, (A / r) ** 6 * smooth)
    embedding = InterpolatedUnivariateSpline(rho, -0.1927 * np.sqrt(rho))
    pair = InterpolatedUnivariateSpline(r, 0.01 * r * (A / r) ** 9 * smooth)
    return EAM(None, np.array([29]), [embedding], [density], [[pair]], CUTOFF)


@pytest.mark.parametrize("potential", [pair_potential, embedded_atoms])
def test_hessian_and_differences_agree(potential):
    q = np.array([[0.3, 0.1], [0.9, 0.9], [1.2, 0.0]])
    analytic, differences = (
        greens_function(potential(), layers=9, size=7, displacement=displacement)(q)
        for displacement in (0.0, 1e-3)
    )
    np.testing.assert_allclose(differences, analytic, atol=1e-5 * abs(analytic).max())


def test_reciprocity_and_symmetry_of_the_surface():
    greens = greens_function(fcc_springs(A)[0])
    q = np.array([[0.3, 0.1], [0.3, -0.1], [0.1, 0.3], [-0.3, -0.1]])
    g = greens(q)
    np.testing.assert_allclose(g, g.conj().swapaxes(1, 2), atol=1e-12)
    np.testing.assert_allclose(g[:, 2, 2], g[0, 2, 2], rtol=1e-7)
    np.testing.assert_allclose(g[0], g[3].conj(), atol=1e-12)


def test_a_surface_with_a_negative_mode_is_refused():
    slab = fcc100("Cu", (1, 1, 7), a=A, vacuum=8.0)[::-1]
    # springs between second neighbours that push once they are displaced
    unstable = Springs({A / np.sqrt(2): 1.0, A: -0.7})
    greens = LatticeGreensFunction(force_constants(unstable, slab, 5))
    with pytest.raises(ValueError, match="not stable"):
        greens(np.array([[0.5, 0.0], [1.0, 1.0]]))
