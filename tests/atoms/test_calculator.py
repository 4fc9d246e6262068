"""The ASE calculator: forces, units, control, optimizers, cache, errors."""

import copy
import gc
import json
import pickle
import weakref
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest
from ase.calculators.calculator import all_properties
from ase.calculators.singlepoint import SinglePointCalculator
from ase.optimize import FIRE, FIRE2
from built import atoms_under, force_along, up

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import contact_of

SPHERE = rc.RoughSphere(radius=10.0)


make_atoms = partial(atoms_under, SPHERE, shape=(8, 6), height=0.6)


def convolutions(atoms):
    return contact_of(atoms).halfspace.grid_transform.pairs


# Energy and forces


def test_forces_are_minus_the_gradient_of_the_energy(periodic, wall, rng):
    atoms = make_atoms(wall, periodic=periodic, load=0.3, fixed=False)
    atoms.positions[:-1, 2] = rng.normal(0.0, 0.05, len(atoms) - 1)
    forces = atoms.get_forces()
    for index in (*range(0, len(atoms), 7), len(atoms) - 1):
        expected = force_along(atoms, up(atoms, index))
        assert forces[index, 2] == pytest.approx(expected, abs=1e-6)


def test_forces_act_along_z_only(wall):
    assert not make_atoms(wall).get_forces()[:, :2].any()


def test_energies_sum_to_the_energy_with_the_load_on_the_indenter(wall, periodic):
    atoms = make_atoms(wall, periodic=periodic, load=0.3, fixed=False)
    energies = atoms.get_potential_energies()
    assert energies.sum() == pytest.approx(atoms.get_potential_energy(), rel=1e-13)
    assert energies[-1] == pytest.approx(0.3 * 0.6)


def test_contact_quantities_are_properties_beside_the_results_of_ase():
    atoms = make_atoms(rc.LennardJones93.adhesive(1.0, 1.0, 0.02))
    atoms.get_potential_energy()
    calc, state = atoms.calc, atoms.calc.state(atoms)
    assert set(calc.results) == set(calc.implemented_properties) <= set(all_properties)
    assert calc.get_property("normal_force") == state.normal_force > 0.0
    assert calc.get_property("contact_area") == state.repulsive_atoms > 0
    for name in ("pressure", "gap", "contact"):
        assert calc.get_property(name).shape == (8, 6)
        np.testing.assert_array_equal(calc.get_property(name), getattr(state, name))


def test_results_make_a_calculator_of_a_single_point():
    atoms = make_atoms()
    forces = atoms.get_forces(apply_constraint=False)
    frozen = SinglePointCalculator(atoms.copy(), **atoms.calc.results)
    np.testing.assert_array_equal(frozen.get_forces(), forces)


def test_properties_of_the_contact_follow_the_atoms():
    atoms = make_atoms()
    before = atoms.calc.get_property("normal_force", atoms)
    atoms.positions[-1, 2] -= 0.1
    assert atoms.calc.get_property("gap", atoms, allow_calculation=False) is None
    assert atoms.calc.get_property("normal_force", atoms) > before


def test_the_state_can_not_be_written_to():
    atoms = make_atoms()
    state, force = atoms.calc.state(atoms), atoms.calc.state(atoms).normal_force
    for name in ("pressure", "gap", "forces", "contact", "plastic"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(state, name)[:] = 1
    pressure = atoms.calc.get_property("pressure", atoms)
    pressure *= 2.0  # a copy
    assert rc.pressure_of(rc.snapshot(atoms)).sum() == pytest.approx(force)


# Optimizers and control


@pytest.mark.parametrize("optimizer", [FIRE, FIRE2])
def test_unconstrained_optimizer_with_a_hard_wall_is_an_error_with_advice(
    periodic, optimizer
):
    atoms = make_atoms(
        rc.HardWall(), periodic=periodic, fixed=False, load=1.0, height=0.1
    )
    with pytest.raises(ValueError, match=r"ActiveSet.*LennardJones93\.repulsive"):
        optimizer(atoms, logfile=None).run(fmax=1e-4, steps=100)


# Cache, parameters and copies


def test_nothing_is_calculated_twice():
    atoms = make_atoms()
    atoms.get_potential_energy()
    before = convolutions(atoms)
    atoms.get_forces()
    atoms.get_potential_energies()
    atoms.calc.state(atoms)
    assert convolutions(atoms) == before
    atoms.positions[3, 2] += 0.1
    atoms.get_forces()
    assert convolutions(atoms) == before + 1


def test_new_load_discards_the_results_and_keeps_the_half_space():
    atoms = make_atoms(fixed=False)
    before = atoms.get_forces(apply_constraint=False)[-1, 2]
    contact = contact_of(atoms)
    assert atoms.calc.set(load=2.0) == {"load": 2.0}
    assert atoms.calc.results == {}
    after = atoms.get_forces(apply_constraint=False)[-1, 2]
    assert after == pytest.approx(before - 2.0)
    assert contact_of(atoms) is contact


def test_properties_that_are_not_calculated_are_none_on_request():
    atoms = make_atoms()
    assert atoms.calc.get_property("pressure", atoms, allow_calculation=False) is None
    force = atoms.calc.get_property("normal_force", atoms)
    for known in (atoms, None):
        again = atoms.calc.get_property("normal_force", known, allow_calculation=False)
        assert again == force > 0.0


def test_state_needs_atoms_or_a_calculation():
    atoms = make_atoms()
    atoms.get_potential_energy()
    atoms.calc.set(load=1.0)
    with pytest.raises((ValueError, RuntimeError), match="atoms"):
        atoms.calc.state()


@pytest.mark.filterwarnings("ignore:the load of")
@pytest.mark.parametrize(
    "copied", [copy.deepcopy, lambda calc: pickle.loads(pickle.dumps(calc))]
)
@pytest.mark.parametrize("used", [False, True])
def test_copies_of_the_calculator_give_the_same_forces(copied, used):
    atoms = make_atoms(load=0.1)
    if used:
        atoms.get_forces()
    twin = atoms.copy()
    twin.calc = copied(atoms.calc)
    np.testing.assert_array_equal(twin.get_forces(), atoms.get_forces())
    assert twin.calc.parameters == atoms.calc.parameters


def test_parameters_can_be_stored_as_json(wall):
    calculator = rc.RoughContact(SPHERE, 1.0, wall, load=0.5)
    stored = json.loads(json.dumps(calculator.todict()))
    assert stored["indenter"] == SPHERE.todict()
    assert stored["wall"] == wall.todict()
    assert (stored["contact_modulus"], stored["load"]) == (1.0, 0.5)


# Bad input


def test_unknown_keyword_is_an_error_with_the_nearest_name():
    with pytest.raises(TypeError, match=r"'contact_modlus'.*did you mean 'contact_mod"):
        rc.RoughContact(SPHERE, contact_modlus=1.0)


BAD_PARAMETERS = [
    ("contact_modulus", 0.0),
    ("contact_modulus", -1.0),
    ("contact_modulus", np.nan),
    ("contact_modulus", "soft"),
    ("load", np.inf),
    ("load", [1.0, 2.0]),
    ("indenter", np.zeros((8, 6))),
    ("indenter", rc.RoughSphere),
    ("wall", "hard"),
    ("fft", {"engine": "abacus"}),
    ("fft", {"thread": 1}),
    ("fft", None),
]


@pytest.mark.filterwarnings("ignore:the load of")
@pytest.mark.parametrize("name, value", BAD_PARAMETERS)
def test_bad_parameters_are_refused_and_change_nothing(name, value):
    atoms = make_atoms(load=0.5)
    forces = atoms.get_forces()
    with pytest.raises((TypeError, ValueError), match=name):
        atoms.calc.set(**{"load": 0.7, name: value})
    assert atoms.calc.parameters["load"] == 0.5
    np.testing.assert_array_equal(atoms.get_forces(), forces)


@pytest.mark.parametrize("parameters", [{"indenter": SPHERE}, {"contact_modulus": 1.0}])
def test_missing_parameters_are_an_error(parameters):
    atoms = make_atoms()
    atoms.calc = rc.RoughContact(**parameters)
    with pytest.raises(ValueError, match="an indenter, and a contact_modulus"):
        atoms.get_forces()


@pytest.mark.parametrize("index", [3, -1])
@pytest.mark.parametrize("bad", [np.nan, np.inf])
def test_non_finite_positions_are_refused(index, bad):
    atoms = make_atoms()
    atoms.get_forces()
    atoms.positions[index, 2] = bad
    with pytest.raises(ValueError, match="finite"):
        atoms.get_forces()


@pytest.mark.parametrize(
    "heights, message",
    [(np.full((8, 6), np.nan), "finite"), (np.zeros((6, 8)), r"shape \(8, 6\)")],
)
def test_surface_with_bad_heights_is_refused(heights, message):
    atoms = make_atoms()
    surface = SimpleNamespace(heights=lambda *_: heights, todict=dict)
    atoms.calc = rc.RoughContact(surface, 1.0)
    with pytest.raises(ValueError, match=message):
        atoms.get_forces()


def test_calculator_has_no_reference_cycle():
    atoms = make_atoms()
    atoms.get_potential_energy()
    calculator = weakref.ref(atoms.calc)
    gc.disable()
    try:
        del atoms
        assert calculator() is None
    finally:
        gc.enable()


# Representation


@pytest.mark.parametrize(
    "calc, expected",
    [
        (rc.RoughContact(), "RoughContact()"),
        (
            rc.RoughContact(SPHERE, 1, rc.HardWall(), load=2),
            f"RoughContact(indenter={SPHERE!r}, contact_modulus=1.0, "
            "wall=HardWall(), load=2.0)",
        ),
    ],
    ids=["empty", "hard"],
)
def test_representation_lists_parameters_that_are_not_defaults(calc, expected):
    assert repr(calc) == expected


@pytest.mark.parametrize(
    "modulus, work, message",
    [
        (171.0, 0.02, r"GPa.* multiply .* ase\.units\.GPa"),
        (1.0, 50.0, r"801 J/m\^2.* multiply"),  # given in J/m^2
    ],
)
def test_values_above_all_solids_are_warned_of(modulus, work, message):
    wall = rc.LennardJones93.adhesive(1.0, 4.0, work)
    with pytest.warns(UserWarning, match=message) as found:
        rc.RoughContact(SPHERE, modulus, wall)
    assert found[0].filename == __file__
