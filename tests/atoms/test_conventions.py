"""Conventions of ASE: dictionaries, changed parameters, moved and freed atoms."""

import json
import warnings

import numpy as np
import pytest
from ase.calculators.fd import calculate_numerical_forces
from ase.constraints import FixAtoms, Hookean, dict2constraint
from ase.io import read, write
from ase.optimize import LBFGS
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.elasticity import Cubic, Isotropic, Layer

SPHERE = rc.RoughSphere(30.0)
ROUGH = rc.SelfAffine(0.1, 0.8, 4.0, 16.0, seed=1)


def pressed(indenter=SPHERE, wall=None, **options):
    """Atoms under an indenter in contact, which are not relaxed."""
    atoms = atoms_under(indenter, wall, **options)
    atoms.positions[-1, 2] -= 0.3
    return atoms


# Dictionaries

PARTS = {
    "rough sphere": {"indenter": rc.RoughSphere(30.0, ROUGH)},
    "rough flat": {"indenter": ROUGH},
    "solid": {"solid": Isotropic(1.0, poisson=0.3)},
    "cubic": {"solid": Cubic(1.1, 0.77, 0.47)},
    "layer": {"solid": Layer(0.8, 20.0, 0.05)},
    "viscoelastic": {"solid": rc.Viscoelastic(1.0, rc.Creep((0.5,), (2.0,)))},
    "repulsive": {"wall": rc.LennardJones93.repulsive(2.0, 1.0)},
    "adhesive": {"wall": rc.LennardJones93.adhesive(1.0, 1.0, 0.02)},
    "full": {
        "wall": rc.LennardJones93.full(distance=1.0, work_of_adhesion=0.04, cutoff=3.0)
    },
    "heterogeneity": {
        "wall": rc.LennardJones93.adhesive(1.0, 1.0, 0.02),
        "heterogeneity": rc.Heterogeneity(ROUGH, rms=0.3),
    },
}


@pytest.mark.parametrize("parts", PARTS.values(), ids=PARTS)
def test_a_calculator_made_from_its_dictionary_gives_the_same(parts):
    atoms = pressed(**parts, load=0.2)
    text = json.dumps(atoms.calc.todict())
    again = rc.RoughContact.fromdict(json.loads(text))
    assert again.todict() == atoms.calc.todict()
    copy = atoms.copy()
    copy.calc = again
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # the load does not act
        assert copy.get_potential_energy() == atoms.get_potential_energy() != 0.0
        np.testing.assert_array_equal(copy.get_forces(), atoms.get_forces())


@pytest.mark.parametrize(
    "wall", [rc.HardWall(), rc.PlasticWall(0.1, permanent=True),
             rc.DugdaleWall(0.1, 1.0), rc.ExponentialWall(0.1, 1.0)], ids=repr
)  # fmt: skip
def test_hard_walls_are_made_from_their_dictionaries(wall):
    calc = rc.RoughContact(SPHERE, 1.0, wall)
    assert rc.RoughContact(**calc.todict()).parameters["wall"] == wall


def test_parameters_in_a_trajectory_make_the_calculator(tmp_path):
    atoms = pressed()
    energy = atoms.get_potential_energy()
    write(tmp_path / "a.traj", atoms)
    frame = read(tmp_path / "a.traj")
    frame.calc = rc.RoughContact(**frame.calc.parameters)
    assert frame.get_potential_energy() == energy


def test_what_does_not_describe_itself_completely_says_so():
    heights = rc.HeightMap(np.zeros((8, 8)), 1.0)
    calc = rc.RoughContact(heights, 1.0)
    with pytest.raises(ValueError, match="give the HeightMap itself"):
        rc.RoughContact(**calc.todict())
    with pytest.raises(ValueError, match="unknown indenter 'Unheard'"):
        rc.RoughContact({"name": "Unheard"}, 1.0)


# Parameters that are changed without `set`


@pytest.mark.parametrize("reset", [True, False])
@pytest.mark.parametrize(
    "name, value",
    [
        ("contact_modulus", 2.0),
        ("wall", rc.LennardJones93.repulsive(3.0, 1.0)),
        ("solid", None),
    ],
)
def test_parameters_take_effect_however_they_are_set(name, value, reset):
    atoms = pressed()
    before = atoms.get_potential_energy()
    changes = {name: value}
    if name == "solid":
        changes = {"solid": Isotropic(2.0), "contact_modulus": None}
    atoms.calc.parameters.update(changes)
    if reset:
        atoms.calc.reset()
    expected = pressed()
    expected.calc.set(**changes)
    energy = atoms.get_potential_energy()
    assert energy == expected.get_potential_energy() != before


def test_wrong_parameters_are_refused_however_they_are_set():
    atoms = pressed()
    energy = atoms.get_potential_energy()
    atoms.calc.parameters["contact_modulus"] = -1.0
    with pytest.raises(ValueError, match=r"contact_modulus must be .* got -1"):
        atoms.get_potential_energy()
    assert atoms.get_potential_energy() == energy
    atoms.calc.parameters["modulus"] = 2.0
    with pytest.raises(TypeError, match="unknown parameter 'modulus'"):
        atoms.get_forces()


# Numerical forces


def test_numerical_forces_along_z_are_the_forces(periodic):
    atoms = pressed(shape=(4, 4), periodic=periodic, load=0.2, fixed=False)
    atoms.positions[:-1, 2] = np.linspace(-0.1, 0.1, len(atoms) - 1)
    before = atoms.positions.copy()
    numerical = calculate_numerical_forces(atoms, eps=1e-5, icarts=[2])
    np.testing.assert_array_equal(atoms.positions, before)
    np.testing.assert_allclose(numerical[:, 0], atoms.get_forces()[:, 2], atol=1e-6)


def test_lateral_numerical_forces_are_refused_with_advice():
    atoms = pressed()
    with pytest.raises(ValueError, match=r"icarts=\[2\]"):
        calculate_numerical_forces(atoms, eps=1e-2)


# Moved and freed atoms


@pytest.mark.parametrize(
    "move", [lambda a: a.center(), lambda a: a.translate([0, 0, 1])]
)
def test_a_translation_along_z_is_noticed(move, periodic):
    atoms = pressed(periodic=periodic)
    energy = atoms.get_potential_energy()
    move(atoms)
    with pytest.warns(UserWarning, match="move them back"):
        assert atoms.get_potential_energy() != energy
    with warnings.catch_warnings():
        warnings.simplefilter("error")  # once
        atoms.get_forces()


def test_a_translation_before_the_first_calculation_is_noticed():
    atoms = pressed()
    atoms.center()
    with pytest.warns(UserWarning, match="moved along z"):
        atoms.get_potential_energy()


def test_moves_that_change_nothing_or_deform_the_surface_pass():
    atoms = pressed()
    energy = atoms.get_potential_energy()
    atoms.center(axis=(0, 1))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert atoms.get_potential_energy() == pytest.approx(energy)
        atoms.positions[-1, 2] += 0.1
        atoms.get_potential_energy()
        assert LBFGS(atoms, logfile=None).run(fmax=1e-3)


def without_constraints(atoms):
    atoms.set_constraint()
    return atoms


def bare(atoms):
    """What is left of atoms in files that keep nothing else, such as NetCDF."""
    kept = {"positions": atoms.positions, "cell": atoms.cell, "pbc": atoms.pbc}
    return type(atoms)(atoms.numbers, **kept)


@pytest.mark.parametrize("change", [without_constraints, bare])
def test_an_indenter_that_has_lost_its_constraint_is_noticed(change):
    atoms = change(pressed())
    last = len(atoms) - 1
    atoms.calc = rc.RoughContact(SPHERE, 1.0)
    with pytest.warns(UserWarning, match="FixAtoms"):
        atoms.get_potential_energy()
    for held in ([FixAtoms([last])], [Hookean(last, (0.0, 0.0, 1.0), k=1.0, rt=0.0)]):
        atoms.set_constraint(held)
        atoms.calc = rc.RoughContact(SPHERE, 1.0)
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            atoms.get_potential_energy()


def test_constraints_from_a_bundle_are_refused_with_advice(tmp_path):
    atoms, file = pressed(), tmp_path / "a.bundle"
    write(file, atoms, format="bundletrajectory")
    frame = read(file, format="bundletrajectory")
    frame.calc = atoms.calc
    with pytest.raises(ValueError, match="dict2constraint"):
        frame.get_potential_energy()
    frame.set_constraint([dict2constraint(each) for each in frame.constraints])
    assert frame.get_potential_energy() == atoms.get_potential_energy()


def test_an_indenter_that_was_free_may_be_free():
    free = pressed(fixed=False)
    loaded = pressed(load=1.0)
    loaded.set_constraint()
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for atoms in (free, loaded):
            atoms.get_potential_energy()


@pytest.mark.filterwarnings("ignore::RuntimeWarning")
@pytest.mark.parametrize("wall", [rc.HardWall(), rc.PlasticWall(0.1)])
def test_an_optimizer_that_fails_at_a_hard_wall_names_the_one_to_use(wall):
    atoms = atoms_under(SPHERE, wall, load=1.0, fixed=False)
    with pytest.raises(ValueError, match="ActiveSet"):
        LBFGS(atoms, logfile=None).run(fmax=0.01, steps=200)


# Columns


def test_extxyz_files_of_frames_have_columns_of_the_contact(tmp_path):
    atoms = pressed()
    state, file = atoms.calc.state(atoms), tmp_path / "a.extxyz"
    write(file, rc.snapshot(atoms))
    head = file.read_text().splitlines()[1]
    assert "contact:I:1:pressure:R:1:gap:R:1" in head
    frame = read(file)
    shape = state.gap.shape
    for name in ("contact", "gap"):
        column = frame.arrays[name][:-1].reshape(shape)
        np.testing.assert_allclose(column, getattr(state, name), atol=1e-7)
    np.testing.assert_array_equal(ContactMap.from_frame(frame).pressure, state.pressure)
