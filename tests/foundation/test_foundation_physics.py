"""Physics of atoms on a semi-infinite crystal, with EMT copper where it takes time."""

import numpy as np
import pytest
from ase.calculators.calculator import Calculator, all_changes
from ase.calculators.emt import EMT
from ase.calculators.mixing import SumCalculator
from ase.optimize import LBFGS
from ase.optimize.precon import PreconLBFGS
from pair_crystal import pair_potential
from scipy.optimize import brentq
from spring_crystal import Springs, fcc_springs

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Crystal
from ase_roughcontact.elasticity.crystals.lattice_greens import LatticeGreensFunction
from ase_roughcontact.foundation import (
    CrystalSurface,
    FoundationPrecon,
    add_indenter,
    crystal_slab,
)


def rayleigh_velocity(c11, c12, c44, density):
    """Velocity along [100] on a (001) surface, from its secular equation."""

    def secular(x):
        left = c11 * c44 * (c11 - x) * x**2
        return left - (c44 - x) * (c11 * (c11 - x) - c12**2) ** 2

    return np.sqrt(brentq(secular, 1e-6 * c44, (1 - 1e-9) * c44) / density)


def test_long_surface_waves_have_the_velocity_of_rayleigh():
    a, layers = 3.6, 100
    springs, constants = fcc_springs(a)
    surface = CrystalSurface.from_calculator(
        springs, "Cu", lattice_constant=a, layers=9, size=5
    )
    greens = LatticeGreensFunction(surface.constants, layers)
    velocity = []
    for wavelength in (20.0, 40.0):
        q = 2 * np.pi / (wavelength * surface.constants.spacing)
        wave = q * np.array([[1.0, 1.0]]) / np.sqrt(2)  # [100] of the crystal
        stiffness = greens.stiffness(wave, layers)[0]
        velocity.append(np.sqrt(np.linalg.eigvalsh(stiffness)[0]) / q)
    expected = rayleigh_velocity(*constants, density=4 / a**3)
    assert velocity[1] == pytest.approx(expected, rel=1e-2)
    # without the correction of the lattice, which is proportional to the wave number
    assert 2 * velocity[1] - velocity[0] == pytest.approx(expected, rel=1.5e-3)


@pytest.fixture(scope="module")
def copper():
    return CrystalSurface.from_calculator(EMT(), "Cu")


class PointForce(Calculator):
    """Force on one atom of the surface, balanced by the others."""

    implemented_properties = ["energy", "forces"]

    def __init__(self, top, atom, force):
        super().__init__()
        self.top, self.atom, self.force = top, atom, force

    def calculate(self, atoms=None, properties=("energy",), system_changes=all_changes):
        super().calculate(atoms, properties, system_changes)
        forces = np.zeros((len(self.atoms), 3))
        forces[self.top, 2] = -self.force / len(self.top)
        forces[self.atom, 2] += self.force
        energy = -float(np.sum(forces * self.atoms.positions))
        self.results = {"energy": energy, "forces": forces}


def displacement(atoms, calculator, precon, force):
    """Displacement of an atom under a force, relative to the mean of the surface."""
    atoms = atoms.copy()
    top = np.flatnonzero(atoms.get_tags() == 1)
    atoms.calc = SumCalculator([calculator, PointForce(top, top[0], force)])
    for _ in range(60):
        forces = atoms.get_forces()
        if abs(forces).max() < 1e-6:
            moved = atoms.positions[top, 2]
            return moved[0] - moved.mean()
        atoms.positions += precon.solve(forces.ravel()).reshape(-1, 3)
    raise AssertionError("the atoms did not relax")


def thick_slab(surface, n):
    """Slab of 40 layers with two free surfaces, and the preconditioner of one."""
    atoms, foundation = crystal_slab("Cu", (n, n), 40, EMT(), surface)
    distances = -np.diff(surface.column(40).positions[:, 2])
    number = len(surface.heights) - 1
    distances[-number:] = distances[:number][::-1]
    heights = -np.append(0.0, np.cumsum(distances))
    atoms.positions[:, 2] = np.repeat(heights[::-1], n * n)
    return atoms, FoundationPrecon(atoms, foundation)


@pytest.mark.parametrize("layers", [1, 2, 3])
def test_a_body_centred_crystal(layers):
    a = 2.87
    springs = Springs({a * 3**0.5 / 2: 1.0, a: 0.5})
    surface = CrystalSurface.from_calculator(
        springs, "Fe", "bcc100", lattice_constant=a, layers=9, size=5
    )
    found = []
    for number in (layers, 20):
        atoms, foundation = crystal_slab("Fe", (3, 3), number, springs, surface)
        precon = FoundationPrecon(atoms, foundation)
        # twenty layers of springs are at rest without a foundation, too
        calculator = springs if number == 20 else foundation
        found.append(displacement(atoms, calculator, precon, 1e-3))
    assert found[0] == pytest.approx(found[1], rel=1e-6)


@pytest.mark.slow
@pytest.mark.parametrize(
    "n, force, errors",
    [
        (7, 0.02, {2: 1.6e-4, 4: 8e-5, 8: 3e-6}),
        (7, -0.3, {2: 1.3e-3, 4: 8e-5, 8: 1e-5}),
        (7, 0.3, {2: 2.5e-3, 4: 8e-5, 8: 1e-5}),
        (7, -1.0, {2: 2e-2, 4: 3e-4, 8: 1e-5}),
        (24, -0.3, {2: 7e-4, 4: 1.6e-4, 8: 1e-5}),
    ],
)
def test_displacement_under_a_point_force_agrees_with_a_thick_slab(
    copper, n, force, errors
):
    thick, precon = thick_slab(copper, n)
    expected = displacement(thick, EMT(), precon, force)
    for layers, error in errors.items():
        atoms, foundation = crystal_slab("Cu", (n, n), layers, EMT(), copper)
        precon = FoundationPrecon(atoms, foundation)
        found = displacement(atoms, foundation, precon, force)
        assert found == pytest.approx(expected, rel=error)


@pytest.mark.slow
def test_a_hard_indenter_deforms_the_top_layers_plastically(surface):
    size, layers = (12, 12), 8
    atoms, foundation = crystal_slab("Cu", size, layers, pair_potential(), surface)
    spacing, rest = surface.constants.spacing, atoms.positions.copy()
    # beside the symmetric place, where no direction of slip is preferred
    position = 6 * spacing + np.array([0.4, 0.25])
    indenter = add_indenter(atoms, rc.RoughSphere(6.0), position=position)
    height, forces = atoms.positions[-1, 2], []
    for depth in np.arange(0.5, 3.5, 0.25):
        atoms.positions[-1, 2] = height - depth
        assert LBFGS(atoms, logfile=None).run(fmax=0.02, steps=600)
        forces.append(indenter.get_property("normal_force"))
    drops = np.diff(forces) < -0.2 * max(forces)
    assert drops.sum() == 1
    assert np.argmax(drops) > 5  # elastic before
    # without the indenter, the atoms under it do not return
    atoms.positions[-1, 2] = height + 5.0
    assert LBFGS(atoms, logfile=None).run(fmax=0.02, steps=600)
    moved = np.linalg.norm(atoms.positions[:-1] - rest, axis=1)
    by_layer = moved.reshape(layers, -1).max(axis=1)[::-1]
    assert by_layer[0] > spacing / 2
    assert by_layer[-foundation.coupled_layers :].max() < 0.1 * spacing


@pytest.mark.slow
def test_a_rough_sphere_on_copper_has_the_load_and_gaps_of_the_elastic_crystal(copper):
    crystal = Crystal.from_calculator(EMT(), "Cu", layers=11, size=7)
    n, a0 = 8, crystal.spacing
    sphere = rc.RoughSphere(40.0, rc.SelfAffine(0.1, 0.8, 3 * a0, 8 * a0, seed=1))
    atoms, foundation = crystal_slab("Cu", (n, n), 4, EMT(), copper)
    indenter = add_indenter(atoms, sphere)
    touching, axis = atoms.positions[-1, 2], atoms.positions[-1, :2].copy()
    elastic = rc.substrate("Cu", (n, n), sphere, spacing=a0, periodic=True)
    elastic.positions[-1, :2] = axis
    wall = indenter.wall
    elastic.calc = rc.RoughContact(sphere, solid=crystal, wall=wall)
    top = np.flatnonzero(atoms.get_tags() == 1)
    for depth, error in ((0.1, 0.005), (0.4, 0.015)):
        atoms.positions[-1, 2] = touching - depth
        precon = FoundationPrecon(atoms, foundation)
        relax = PreconLBFGS(atoms, precon=precon, use_armijo=False, logfile=None)
        assert relax.run(fmax=1e-3, steps=50)
        height = atoms.positions[-1, 2] - atoms.positions[top, 2].mean()
        elastic.positions[-1, 2] = height
        assert rc.NewtonKrylov(elastic, logfile=None).run(fmax=1e-5)
        expected = elastic.calc.state(elastic)
        force = indenter.get_property("normal_force")
        assert force == pytest.approx(expected.normal_force, rel=error)
        # at the border of the cell the two take different images of the sphere
        found = indenter.get_property("gap")[top].reshape(n, n)
        gaps = found, expected.gap
        inner = slice(1, None)
        gap, expected_gap = (each[inner, inner] for each in gaps)
        np.testing.assert_allclose(gap, expected_gap, atol=0.01)
