"""A rigid indenter with the walls of the package on explicit atoms."""

import warnings

import numpy as np
import pytest
from ase import units
from ase.build import bulk
from ase.calculators.emt import EMT
from ase.constraints import FixAtoms
from ase.io import read, write
from ase.md.verlet import VelocityVerlet
from ase.optimize import FIRE, LBFGS
from ase.optimize.precon import PreconLBFGS
from built import atoms_under, force_along
from pair_crystal import A, pair_potential
from pair_crystal import slab as slab_of

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Crystal, StressField
from ase_roughcontact.foundation import (
    CrystalSurface,
    ElasticFoundation,
    FoundationPrecon,
    add_indenter,
    crystal_slab,
)


def slab(surface, size=(6, 6), layers=2, **options):
    return slab_of(surface, layers, size, **options)


def rough_sphere(surface):
    a0 = surface.constants.spacing
    return rc.RoughSphere(40.0, rc.SelfAffine(0.2, 0.8, 4 * a0, 8 * a0, seed=1))


@pytest.mark.filterwarnings("ignore:nothing holds")
@pytest.mark.parametrize("name", ["surface", "hexagonal_surface"])
def test_forces_are_minus_the_gradient(request, name):
    surface = request.getfixturevalue(name)
    atoms = slab(surface, layers=1, held=False)
    indenter = add_indenter(atoms, rough_sphere(surface), load=0.3)
    atoms.positions += np.random.default_rng(1).normal(size=(len(atoms), 3)) * 0.05
    atoms.positions[-1] -= [1.3, 0.4, 0.9]
    atoms.set_constraint()
    forces = atoms.get_forces()
    assert indenter.get_property("contact").any()
    direction = np.random.default_rng(2).normal(size=forces.shape)
    expected = force_along(atoms, direction)
    assert np.sum(forces * direction) == pytest.approx(expected, rel=1e-6)
    assert abs(forces[-1, :2]).min() > 1e-3  # slopes of the roughness


def test_a_free_indenter_carries_its_load(surface):
    atoms = slab(surface)
    indenter = add_indenter(atoms, rough_sphere(surface), load=0.8)
    position = atoms.positions[-1].copy()
    assert LBFGS(atoms, logfile=None).run(fmax=1e-4, steps=300)
    assert indenter.get_property("normal_force") == pytest.approx(0.8, abs=2e-4)
    np.testing.assert_array_equal(atoms.positions[-1, :2], position[:2])
    assert atoms.positions[-1, 2] < position[2] - 0.05
    # the load is balanced by the constraint on the lowest layer
    unconstrained = atoms.get_forces(apply_constraint=False)
    assert unconstrained[:36, 2].sum() == pytest.approx(-0.8, abs=1e-3)


def test_the_wall_begins_at_the_default_height(surface):
    atoms = slab(surface)
    indenter = add_indenter(atoms, rc.RoughSphere(15.0), position=(0.0, 0.0))
    assert atoms.get_forces()[-1] == pytest.approx(0.0, abs=1e-12)
    assert indenter.get_property("gap", atoms).min() == pytest.approx(
        surface.constants.spacing
    )
    atoms.positions[-1, 2] -= 0.1
    assert indenter.get_property("contact", atoms).sum() == 1
    assert indenter.get_property("normal_force", atoms) > 0.01


@pytest.fixture(scope="module")
def crystal():
    return Crystal.from_calculator(
        pair_potential(), bulk("Cu", a=A), layers=9, size=7, displacement=0.0
    )


def test_a_small_load_agrees_with_the_half_space_of_the_same_crystal(surface, crystal):
    # relaxed with all their explicit layers, and as a Green's function of the surface
    sphere, load, n = rc.RoughSphere(200.0), 0.02, 6
    gold = rc.substrate("Au", (n, n), sphere, spacing=crystal.spacing, periodic=True)
    gold.calc = rc.RoughContact(sphere, solid=crystal)
    with pytest.raises(ValueError, match=r"Cu, got .* Au"):
        gold.get_potential_energy()
    assert surface.contact_modulus == pytest.approx(crystal.contact_modulus, rel=1e-6)
    wall = rc.LennardJones93.repulsive(crystal.contact_modulus, crystal.spacing)
    options = {"load": load, "spacing": crystal.spacing, "periodic": True}
    half_space = atoms_under(
        sphere, wall, (n, n), solid=crystal, fixed=False, **options
    )
    assert rc.NewtonKrylov(half_space, logfile=None).run(fmax=1e-7)
    atoms = slab(surface, (n, n))
    position = half_space.positions[-1, :2]
    indenter = add_indenter(atoms, sphere, wall, position=position, load=load)
    assert LBFGS(atoms, logfile=None).run(fmax=1e-6, steps=300)
    gap = indenter.get_property("gap")[n * n : -1].reshape(n, n).T
    np.testing.assert_allclose(
        gap, half_space.calc.get_property("gap", half_space), atol=2e-5
    )


def force_at(surface, depth, layers, held):
    """Force on a fixed indenter at a depth, relaxed."""
    atoms = slab(surface, layers=layers, held=held)
    precon = FoundationPrecon(atoms, atoms.calc)
    indenter = add_indenter(atoms, rc.RoughSphere(20.0))
    atoms.positions[-1, 2] -= depth
    relax = PreconLBFGS(atoms, precon=precon, use_armijo=False, logfile=None)
    assert relax.run(fmax=1e-5, steps=100)
    return indenter.get_property("normal_force")


def test_depths_relative_to_the_surface_do_not_depend_on_the_layers(surface):
    few, many = (force_at(surface, 0.3, layers, "surface") for layers in (4, 7))
    assert few == pytest.approx(many, rel=1e-3)
    # a load compresses the slab above the lowest layer
    few, many = (force_at(surface, 0.3, layers, "lowest") for layers in (3, 7))
    assert few > 1.1 * many


def test_depths_relative_to_the_surface_agree_with_the_half_space(surface, crystal):
    sphere, depth = rc.RoughSphere(20.0), 0.02
    wall = rc.LennardJones93.repulsive(crystal.contact_modulus, crystal.spacing)
    options = {"spacing": crystal.spacing, "periodic": True}
    half_space = atoms_under(sphere, wall, (6, 6), solid=crystal, **options)
    (step,) = rc.load_path(
        half_space, penetrations=[depth], validity="ignore", fmax=1e-6
    )
    found = force_at(surface, depth, 2, "surface")
    assert found == pytest.approx(step.normal_force, rel=0.01)


def seam_error(atoms, crystal, load=2.0):
    """Error of zz at the seam relative to the stress of the continuum, and its mean."""
    foundation = atoms.calc
    precon = FoundationPrecon(atoms, foundation)
    indenter = add_indenter(atoms, rc.RoughSphere(100.0), load=load)
    relax = PreconLBFGS(atoms, precon=precon, use_armijo=False, logfile=None)
    assert relax.run(fmax=1e-4, steps=200)
    sites, a0 = foundation.all_sites(), crystal.spacing
    wall = -indenter.results["forces"][sites.indices, 2].sum(axis=0)
    field = StressField(crystal, a0, wall / a0**2, periodic=True)
    found = foundation.seam_stress(atoms)
    x, y = np.moveaxis((found.positions - sites.positions[0, 0, 0, :2]) / a0, -1, 0)
    expected = field.stress_at(x[:, 0], y[0], found.depth)[2]
    scale = abs(expected).max()
    area = found.stress[2].size * a0**2
    assert found.stress[2].mean() * area == pytest.approx(-load, rel=1e-3)
    return abs(found.stress[2] - expected).max() / scale


def test_stress_at_the_seam_becomes_the_stress_of_the_continuum(surface, crystal):
    # measured: 0.22 at a depth of 1.1 spacings, 0.11 at 3.9
    thin, thick = (
        seam_error(slab(surface, (12, 12), layers=layers), crystal) for layers in (2, 6)
    )
    assert thick < 0.15 and thick < 0.6 * thin


def test_mean_stress_at_the_seam_is_zero_if_the_surface_is_held(surface):
    atoms = slab(surface, held="surface")
    foundation = atoms.calc
    add_indenter(atoms, rc.RoughSphere(20.0))
    atoms.positions[-1, 2] -= 0.3
    assert LBFGS(atoms, logfile=None).run(fmax=1e-3, steps=200)
    stress = foundation.seam_stress(atoms).stress
    np.testing.assert_allclose(stress.mean(axis=(1, 2)), 0.0, atol=1e-9)
    assert stress[2].min() < -1e-3


@pytest.mark.slow
def test_stress_at_the_seam_of_emt_copper_is_the_stress_of_the_continuum():
    copper = CrystalSurface.from_calculator(EMT(), "Cu")
    crystal = Crystal.from_calculator(EMT(), "Cu")
    # measured: 0.12 at a depth of 1.8 spacings, 0.06 at 5.3
    for size, layers, largest in ((12, 3, 0.18), (16, 8, 0.09)):
        atoms, _ = crystal_slab("Cu", (size, size), layers, EMT(), copper)
        assert seam_error(atoms, crystal) < largest


@pytest.mark.parametrize("load", [None, 0.5])
def test_an_indenter_that_a_new_constraint_frees_is_noticed(surface, load):
    atoms = slab(surface)
    add_indenter(atoms, rc.RoughSphere(20.0), load=load)
    atoms.positions[-1, 2] -= 0.3
    atoms.set_constraint([*atoms.constraints, FixAtoms([0])])
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        atoms.get_forces()
    atoms.set_constraint(FixAtoms(range(36)))
    atoms.positions[-1, 2] -= 0.01
    with pytest.warns(UserWarning, match="nothing holds the indenter"):
        atoms.get_forces()


def drift(surface, mass):
    """Change of the energy in 200 fs under a load, with a time step of 4 fs."""
    atoms = slab(surface, (4, 4))
    add_indenter(atoms, rc.RoughSphere(20.0), load=1.0, mass=mass)
    assert LBFGS(atoms, logfile=None).run(fmax=1e-3, steps=300)
    atoms.positions[-1, 2] += 0.05
    energies, dynamics = [], VelocityVerlet(atoms, 4.0 * units.fs)
    for _ in range(25):
        dynamics.run(2)
        energies.append(atoms.get_total_energy())
    return np.ptp(energies)


def test_dynamics_under_a_load_conserve_the_energy(surface):
    assert drift(surface, None) < 2e-4  # of about 0.05 eV
    assert drift(surface, 50.0) > 3.0 * drift(surface, None)


def test_an_indenter_has_the_mass_of_a_layer_unless_one_is_given(surface):
    atoms = slab(surface, (4, 4))
    add_indenter(atoms, rc.RoughSphere(20.0))
    assert atoms.get_masses()[-1] == pytest.approx(16 * atoms.get_masses()[0])
    other = slab(surface, (4, 4))
    add_indenter(other, rc.RoughSphere(20.0), mass=7.0)
    assert other.get_masses()[-1] == 7.0
    for wrong in (0.0, -1.0, "heavy"):
        with pytest.raises(ValueError, match="mass"):
            add_indenter(slab(surface, (4, 4)), rc.RoughSphere(20.0), mass=wrong)


def test_a_held_surface_that_is_released_is_noticed(surface):
    atoms = slab(surface, held="surface")
    add_indenter(atoms, rc.RoughSphere(20.0))
    held = atoms.constraints
    atoms.set_constraint([*held[1:], FixAtoms(range(36))])  # another layer
    with pytest.warns(UserWarning, match="nothing holds the slab"):
        atoms.get_forces()


def test_a_surface_that_is_not_complete_can_not_be_held(surface):
    atoms = slab(surface, held=False)
    foundation = atoms.calc
    del atoms[-1]
    with pytest.raises(ValueError, match="72 atoms"):
        foundation.hold(atoms, "surface")
    foundation.hold(atoms)
    with pytest.raises(ValueError, match="'lowest' or 'surface'"):
        foundation.hold(atoms, "middle")


@pytest.mark.parametrize("optimizer", [FIRE, LBFGS, PreconLBFGS])
def test_optimizers_find_the_same_state(surface, optimizer):
    atoms, options = slab(surface), {"logfile": None}
    foundation = atoms.calc
    indenter = add_indenter(atoms, rc.RoughSphere(15.0))
    atoms.positions[-1, 2] -= 0.3
    if optimizer is PreconLBFGS:
        precon = FoundationPrecon(atoms, foundation)
        options |= {"precon": precon, "use_armijo": False}
    assert optimizer(atoms, **options).run(fmax=1e-4, steps=500)
    assert indenter.get_property("normal_force") == pytest.approx(2.2437, abs=1e-3)


@pytest.mark.parametrize("load", [None, 0.8])
@pytest.mark.parametrize("name", ["slab.traj", "slab.extxyz"])
def test_a_slab_with_an_indenter_is_restarted_from_its_file(
    surface, name, load, tmp_path
):
    sphere = rough_sphere(surface)
    atoms = slab(surface)
    add_indenter(atoms, sphere, load=load)
    atoms.positions[-1, 2] -= 0.3
    assert LBFGS(atoms, logfile=None).run(fmax=1e-2, steps=300)
    write(tmp_path / name, atoms)
    again = read(tmp_path / name)
    foundation = ElasticFoundation(pair_potential(), surface, again, 2)
    again.calc = foundation
    if name.endswith(".extxyz"):
        foundation.hold(again)
    add_indenter(again, sphere, load=load)
    assert len(again) == len(atoms)
    energies = [each.get_potential_energy() for each in (again, atoms)]
    assert energies[0] == pytest.approx(energies[1], abs=1e-6)
    np.testing.assert_allclose(again.get_forces(), atoms.get_forces(), atol=1e-6)
    indenter = again.positions[-1].copy()
    assert LBFGS(again, logfile=None).run(fmax=1e-4, steps=300)
    assert (again.positions[-1] == indenter).all() == (load is None)


def test_a_slab_under_an_indenter_that_was_never_held_warns_once(surface):
    atoms = slab(surface, held=False)
    add_indenter(atoms, rc.RoughSphere(15.0), load=0.1)
    with pytest.warns(UserWarning, match=r"foundation\.hold"):
        atoms.get_forces()
    atoms.positions[-1, 2] -= 0.1
    atoms.get_forces()


def test_what_is_refused(surface):
    atoms = slab(surface)
    with pytest.raises(ValueError, match="soft wall"):
        add_indenter(atoms, rc.RoughSphere(15.0), rc.HardWall())
    foundation = atoms.calc
    add_indenter(atoms, rc.RoughSphere(15.0))
    with pytest.raises(ValueError, match=r"atoms\.calc = foundation"):
        add_indenter(atoms, rc.RoughSphere(15.0))
    atoms.calc = foundation
    with pytest.raises(ValueError, match="an indenter already"):
        add_indenter(atoms, rc.RoughSphere(15.0), height=3.0)
    atoms = slab(surface)
    atoms.calc = None
    with pytest.raises(ValueError, match="ElasticFoundation"):
        add_indenter(atoms, rc.RoughSphere(15.0))


def test_an_indenter_at_the_border_of_the_cell(surface):
    atoms = slab(surface)
    add_indenter(atoms, rc.RoughSphere(15.0))
    atoms.positions[-1, 2] -= 3.0
    with pytest.raises(ValueError, match="use a larger cell"):
        atoms.get_potential_energy()


def test_a_roughness_with_the_period_of_the_cell_has_no_border(surface):
    side = 6 * surface.constants.spacing
    rough = rc.SelfAffine(0.02, 0.8, side / 2, side, seed=1, domain=side)
    heights = rough.heights((24, 24), side / 24, (-side / 2, -side / 2))
    energies = []
    for shape in (
        rough,
        rc.RoughSphere(np.inf, rough),
        rc.HeightMap(heights, side / 24, periodic=True),
    ):
        atoms = slab(surface)
        indenter = add_indenter(atoms, shape)
        atoms.positions[-1, 2] -= 0.6
        energies.append(atoms.get_potential_energy())
        assert indenter.get_property("contact").sum() == 36
    assert energies == pytest.approx(3 * energies[:1])


def test_a_map_with_the_periods_of_a_rectangular_cell_has_no_border(surface):
    atoms, spacing = slab(surface, (6, 4)), surface.constants.spacing
    x, y = np.arange(24) / 24, np.arange(16) / 16
    waves = 0.1 * np.cos(2 * np.pi * x)[:, None] * np.cos(2 * np.pi * y)
    indenter = add_indenter(atoms, rc.HeightMap(waves, spacing / 4, periodic=True))
    atoms.positions[-1, 2] -= 0.6
    assert np.isfinite(atoms.get_potential_energy())
    assert indenter.get_property("contact").sum() == 24
