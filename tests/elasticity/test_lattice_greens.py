"""Green's functions of crystal surfaces from force constants."""

import numpy as np
import pytest
from ase.build import fcc100
from ase.optimize import LBFGS
from matscipy.calculators.eam import EAM
from matscipy.calculators.pair_potential import LennardJonesCut, PairPotential
from matscipy.elasticity import coalesce_elastic_constants, rotate_elastic_constants
from scipy.interpolate import InterpolatedUnivariateSpline
from spring_crystal import Springs, fcc_springs

from ase_roughcontact.elasticity.crystals.cubic import surface_modulus
from ase_roughcontact.elasticity.crystals.force_constants import (
    force_constants,
    relaxed_slab,
)
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
def test_long_waves_are_those_of_the_continuum(surface, axes, cell_area, angle):
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


def pair_potential(kind=PairPotential):
    return kind({(29, 29): LennardJonesCut(0.4, A / 2**0.5 / 1.1, CUTOFF)})


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


class Drifting(PairPotential):
    """Forces along x on all atoms of large slabs, which their Hessian does not show."""

    def calculate(self, *args, **kwargs):
        super().calculate(*args, **kwargs)
        if len(self.atoms) > 50:
            self.results["forces"][:, 0] += 0.01


@pytest.mark.parametrize("displacement", [0.0, 1e-3])
def test_forces_of_the_slab_at_rest_are_an_error(displacement):
    figures = []
    for potential in map(pair_potential, (PairPotential, Drifting)):
        slab = relaxed_slab(potential, "Cu", "fcc100", A, 7)
        constants = force_constants(potential, slab, 5, displacement)
        figures.append(constants.figures["rest"])
    largest = abs(constants.matrix).max()
    assert figures[0] < 1e-5
    expected = 10.0 * 0.01 / (largest * constants.spacing)
    assert figures[1] == pytest.approx(expected, rel=1e-3)


def test_reciprocity_and_symmetry_of_the_surface():
    greens = greens_function(fcc_springs(A)[0])
    q = np.array([[0.3, 0.1], [0.3, -0.1], [0.1, 0.3], [-0.3, -0.1]])
    g = greens(q)
    np.testing.assert_allclose(g, g.conj().swapaxes(1, 2), atol=1e-12)
    np.testing.assert_allclose(g[:, 2, 2], g[0, 2, 2], rtol=1e-7)
    np.testing.assert_allclose(g[0], g[3].conj(), atol=1e-12)


@pytest.mark.slow
def test_point_force_on_a_slab_of_atoms():
    n, springs = 6, fcc_springs(A)[0]
    slab = relaxed_slab(springs, "Cu", "fcc100", A, 31).repeat((n, n, 1))
    top = np.arange(0, len(slab), 31)
    pushed = np.zeros((len(slab), 3))
    pushed[top, 2], pushed[top[0], 2] = 1.0, 1.0 - n * n  # balanced
    displacements = []
    for force in (1e-4, -1e-4):
        atoms = slab.copy()
        atoms.calc = Pushed(springs, force * pushed)
        assert LBFGS(atoms, memory=30, logfile=None).run(fmax=1e-10, steps=3000)
        displacements.append((atoms.positions - slab.positions)[top, 2] / force)
    measured = np.add(*displacements).reshape(n, n) / 2

    spacing = A / np.sqrt(2)
    waves = 2 * np.pi * np.fft.fftfreq(n, spacing)
    q = np.stack(np.meshgrid(waves, waves, indexing="ij"), -1).reshape(-1, 2)
    compliance = np.zeros(n * n)
    compliance[1:] = greens_function(springs)(q[1:])[:, 2, 2].real
    load = np.fft.fft2(pushed[top, 2].reshape(n, n))
    expected = np.fft.ifft2(compliance.reshape(n, n) * load).real
    measured -= measured.mean()
    np.testing.assert_allclose(measured, expected, atol=1e-5 * abs(expected).max())


class Pushed(Springs):
    """Springs and constant forces on the atoms."""

    def __init__(self, springs, forces):
        super().__init__(dict(springs.shells))
        self.forces = forces

    def calculate(self, *args, **kwargs):
        super().calculate(*args, **kwargs)
        self.results["forces"] += self.forces
        self.results["energy"] -= float(np.sum(self.forces * self.atoms.positions))


def test_a_surface_with_a_negative_mode_is_refused():
    slab = fcc100("Cu", (1, 1, 7), a=A, vacuum=8.0)[::-1]
    # springs between second neighbours that push once they are displaced
    unstable = Springs({A / np.sqrt(2): 1.0, A: -0.7})
    greens = LatticeGreensFunction(force_constants(unstable, slab, 5))
    with pytest.raises(ValueError, match="not stable"):
        greens(np.array([[0.5, 0.0], [1.0, 1.0]]))
