"""What an elastic foundation refuses."""

from dataclasses import replace

import numpy as np
import pytest
from ase.build import bcc100, bulk, fcc100
from ase.calculators.calculator import PropertyNotImplementedError
from ase.calculators.emt import EMT
from ase.constraints import FixAtoms
from ase.io import read, write
from matscipy.calculators.pair_potential import LennardJonesCut, PairPotential
from pair_crystal import A, pair_potential, slab
from spring_crystal import Softer, fcc_springs

from ase_roughcontact.foundation import (
    CrystalSurface,
    ElasticFoundation,
    FoundationPrecon,
    crystal_slab,
)

LAYERS = 4
SPACING = A / 2**0.5


@pytest.fixture
def atoms(surface):
    return slab(surface, LAYERS, held=False)


def foundation(atoms, surface):
    return ElasticFoundation(pair_potential(), surface, atoms, LAYERS)


def test_a_slab_that_is_not_held_any_more_warns_once(surface):
    atoms = slab(surface, LAYERS)
    held = atoms.constraints
    atoms.set_constraint([*held, FixAtoms([len(atoms) - 1])])
    atoms.get_forces()
    atoms.set_constraint(FixAtoms(range(12)))  # another one of the lowest layer
    atoms.get_forces()
    atoms.set_constraint(FixAtoms([len(atoms) - 1]))
    atoms.rattle(1e-3)
    with pytest.warns(UserWarning, match="set_constraint"):
        atoms.get_forces()
    atoms.rattle(1e-3)
    atoms.get_forces()
    atoms.calc.hold(atoms)
    atoms.rattle(1e-3)
    atoms.get_forces()


def test_a_slab_without_its_hold_after_a_file_warns(surface, tmp_path):
    write(tmp_path / "slab.extxyz", slab(surface, LAYERS))
    again = read(tmp_path / "slab.extxyz")
    again.calc = foundation(again, surface)
    with pytest.warns(UserWarning, match=r"foundation\.hold"):
        again.get_forces()


@pytest.mark.parametrize(
    "calculator",
    [
        EMT(),
        PairPotential({(29, 29): LennardJonesCut(0.45, A / 2**0.5 / 1.1, 1.3 * A)}),
    ],
    ids=["other forces", "other stiffness"],
)
def test_a_calculator_that_differs_from_the_surface(atoms, surface, calculator):
    surface = replace(surface, displacement=1e-3)
    with pytest.raises(ValueError, match="Give the same calculator"):
        ElasticFoundation(calculator, surface, atoms, LAYERS)


def test_differences_of_forces_are_near_enough_to_the_hessian(atoms, surface):
    ElasticFoundation(pair_potential(), replace(surface, displacement=1e-3), atoms)


def test_another_lattice_constant_or_structure(surface):
    atoms = fcc100("Cu", (3, 4, LAYERS), a=3.61, vacuum=5.0)
    with pytest.raises(ValueError, match=r"3\.60226"):
        foundation(atoms, surface)
    atoms = bcc100("Cu", (3, 4, LAYERS), a=surface.constants.spacing, vacuum=5.0)
    with pytest.raises(ValueError, match="layer 2 from below"):
        ElasticFoundation(pair_potential(), surface, atoms, 2)


def test_a_slab_of_ase_with_the_lattice_constant_is_accepted(surface):
    a = surface.lattice_constant
    atoms = fcc100("Cu", (3, 4, LAYERS), a=a, vacuum=5.0)
    atoms.calc = foundation(atoms, surface)
    # the surface is not relaxed yet
    assert 0.1 < abs(atoms.get_forces()[-1, 2]) < 1.0
    assert atoms.calc.layers == LAYERS


def test_sites_follow_from_the_mean_positions_of_the_lowest_layer(atoms, surface):
    forces = atoms.get_forces()
    spacing = surface.constants.spacing
    atoms.positions[5] += [0.2 * spacing, 0.1 * spacing, -0.1]
    atoms.positions += [5.3, -2.1, 0.7]
    atoms.calc = foundation(atoms, surface)
    atoms.positions[5] -= [0.2 * spacing, 0.1 * spacing, -0.1]
    np.testing.assert_allclose(atoms.get_forces(), forces, atol=1e-9)


def free(atoms):
    atoms.pbc = False


def another_element(atoms):
    atoms.symbols[5] = "Ni"


def vacancy(atoms):
    del atoms[5]
    atoms.append("Cu")
    atoms.positions[-1, 2] = 3.0


def shift_the_lowest_layer(atoms):
    atoms.positions[atoms.get_tags() == LAYERS - 1, 0] += SPACING / 2


@pytest.mark.parametrize(
    "spoil, message",
    [
        (free, r"pbc to \(True, True, False\)"),
        (another_element, "Ni"),
        (vacancy, "from below"),
        (shift_the_lowest_layer, "layer 2 from below"),
        (lambda atoms: atoms.pop(), r"48 atoms, got 47"),
    ],
)
def test_atoms_that_differ_from_the_surface(atoms, surface, spoil, message):
    spoil(atoms)
    with pytest.raises(ValueError, match=message):
        foundation(atoms, surface)


def leave_the_site(atoms):
    atoms.positions[14, 0] += 0.4 * SPACING


def reverse(atoms):
    atoms.positions = atoms.positions[::-1]


def remove(atoms):
    del atoms[12:]


def stretch(atoms):
    atoms.set_cell(atoms.cell * 1.01, scale_atoms=True)


@pytest.mark.parametrize(
    "spoil, message",
    [
        (free, "Free boundaries"),
        (another_element, "Ni"),
        (leave_the_site, "atom 14"),
        (reverse, "make a new foundation"),
        (remove, "make a new foundation"),
        (stretch, "cell"),
    ],
)
def test_atoms_that_have_changed(atoms, spoil, message):
    spoil(atoms)
    with pytest.raises(ValueError, match=message):
        atoms.get_forces()


def test_a_calculator_that_describes_slabs_in_another_way_is_found_out():
    softer = Softer(dict(fcc_springs(3.6)[0].shells))
    with pytest.raises(ValueError, match="'long_waves'"):
        CrystalSurface.from_calculator(softer, "Cu", "fcc111", layers=9, size=7)


def test_a_slab_of_a_crystal_given_as_atoms_or_of_another_element(surface):
    size = 3, 3
    atoms, _ = crystal_slab(bulk("Cu"), size, 2, pair_potential(), surface)
    assert len(atoms) == 18
    for other in ("Ni", bulk("Ni")):
        with pytest.raises(ValueError, match=r"Cu.* got Ni"):
            crystal_slab(other, size, 2, pair_potential(), surface)


def test_preconditioner_of_another_calculator_or_of_other_atoms(atoms):
    with pytest.raises(TypeError, match="ElasticFoundation"):
        FoundationPrecon(atoms, pair_potential())
    with pytest.raises(ValueError, match="48 atoms"):
        FoundationPrecon(atoms[:40], atoms.calc)


def test_atoms_above_the_coupled_layers_may_go_anywhere(atoms):
    forces = atoms.get_forces()
    del atoms[[-1, -2]]
    atoms.positions[-1, 2] += 8.0
    assert abs(atoms.get_forces()[:12] - forces[:12]).max() < 1e-6


def test_a_slab_bends_by_more_than_a_spacing_and_has_no_stress(surface):
    atoms = slab(surface, 2, (16, 2))
    x = 2 * np.pi * atoms.positions[:, 0] / atoms.cell[0, 0]
    atoms.positions[:, 2] += surface.constants.spacing * np.cos(x) * 0.7
    assert np.isfinite(atoms.get_potential_energy())
    with pytest.raises(PropertyNotImplementedError, match="stress"):
        atoms.get_stress()


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"format": "another"}'])
def test_another_file(tmp_path, text):
    file = tmp_path / "copper.json"
    file.write_text(text)
    with pytest.raises(ValueError, match=r"copper\.json"):
        CrystalSurface.read(file)
