"""Cached results are never used for other parameters or other atoms."""

import numpy as np
import pytest
from ase.constraints import FixAtoms

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic

SPHERE = rc.RoughSphere(10.0)
WALL = rc.LennardJones93.repulsive(1.0, 1.0)
PER_ATOM = ("energies", "forces", "pressure", "gap", "contact")
NUMBERS = ("energy", "normal_force", "contact_area")

# Changes of every parameter of the calculator.
OTHERS = {
    "indenter": {"indenter": rc.RoughSphere(20.0)},
    "contact_modulus": {"contact_modulus": 2.0},
    "solid": {"solid": Isotropic(3.0), "contact_modulus": None},
    "wall": {"wall": rc.LennardJones93.adhesive(1.0, 1.0, 0.1)},
    "heterogeneity": {
        "heterogeneity": rc.Heterogeneity(lambda x, y: 0.5 * np.cos(x)),
        "wall": rc.LennardJones93.adhesive(1.0, 1.0, 0.1),
    },
    "load": {"load": 0.7},
    "fft": {"fft": {"dtype": "float32"}},
}


def make_atoms(*, periodic=False, margin=True):
    """Displaced atoms under a sphere, without calculator."""
    atoms = rc.substrate(
        "Cu", (8, 6), SPHERE, spacing=1.0, height=0.6, periodic=periodic, fixed=False
    )
    del atoms.info["indenter"]  # some tests exchange it
    atoms.set_tags(0)
    if not margin:
        i, j = atoms.positions[:-1, :2].T
        del atoms[np.flatnonzero((i > 7.5) | (j > 5.5))]
    x, y = atoms.positions[:-1, :2].T
    atoms.positions[:-1, 2] = 0.03 * np.sin(x + 2.0 * y)
    return atoms


def results(atoms, calc):
    return {name: calc.get_property(name, atoms) for name in (*NUMBERS, *PER_ATOM)}


def assert_fresh(atoms, calc, error=0.0):
    """Compare all results with a new calculator, and return them."""
    fresh = rc.RoughContact(**calc.parameters)
    expected, found = results(atoms.copy(), fresh), results(atoms, calc)
    for name, values in expected.items():
        np.testing.assert_allclose(
            found[name], values, 100 * error, error, err_msg=name
        )
    return found


def differ(some, others):
    """Return the names of the results that differ."""
    return {name for name in some if not np.array_equal(some[name], others[name])}


def test_every_parameter_of_the_calculator_is_in_the_table():
    assert OTHERS.keys() == rc.RoughContact.default_parameters.keys()


@pytest.mark.parametrize("wall", [None, WALL], ids=["default wall", "given wall"])
@pytest.mark.parametrize("name", OTHERS)
def test_results_follow_from_the_new_parameters(name, wall):
    atoms, calc = make_atoms(), rc.RoughContact(SPHERE, 1.0, wall)
    before = results(atoms, calc)
    calc.set(**OTHERS[name])
    changed = differ(assert_fresh(atoms, calc), before)
    assert {"energy", "energies", "forces"} <= changed
    usual = rc.RoughContact(SPHERE, 1.0, wall).parameters
    calc.set(**{key: usual[key] for key in OTHERS[name]})
    assert not differ(results(atoms, calc), before)


def move_surface(atoms):
    atoms.positions[5, 2] += 0.1


def move_indenter_down(atoms):
    atoms.positions[-1, 2] -= 0.2


def move_indenter_sideways(atoms):
    atoms.positions[-1, :2] += (1.0, -2.0)


def move_surface_sideways(atoms):
    atoms.positions[:-1, 0] += 1.0


def stretch(atoms):
    atoms.set_cell(1.5 * atoms.cell.array, scale_atoms=True)


def stretch_sideways(atoms):
    atoms.set_cell(atoms.cell.array * [1.5, 1.5, 1.5], scale_atoms=False)
    atoms.positions[:, :2] *= 1.5


def turn_into_periodic(atoms):
    atoms.pbc = (True, True, False)


def turn_into_free(atoms):
    atoms.pbc = False


def widen_the_window(atoms):
    sides = np.ptp(atoms.positions[:-1, :2], axis=0) + 1.0
    atoms.cell[:] = np.diag([*sides, sides.max()])


def fix_the_indenter(atoms):
    atoms.set_constraint(FixAtoms([len(atoms) - 1]))


CHANGES = [
    (move_surface, {}),
    (move_indenter_down, {}),
    (move_indenter_sideways, {}),
    (move_surface_sideways, {}),
    (stretch, {}),
    (stretch_sideways, {}),
    (turn_into_periodic, {"margin": False}),
    (turn_into_free, {"periodic": True}),
    (widen_the_window, {}),
    (fix_the_indenter, {}),
]


@pytest.mark.filterwarnings("ignore:the load of")
@pytest.mark.parametrize(
    "change, options", CHANGES, ids=[change.__name__ for change, _ in CHANGES]
)
def test_results_follow_from_the_changed_atoms(change, options):
    atoms, calc = make_atoms(**options), rc.RoughContact(SPHERE, 1.0, WALL, load=0.3)
    before, unchanged = results(atoms, calc), atoms.copy()
    change(atoms)
    assert "energy" in differ(assert_fresh(atoms, calc), before)
    assert not differ(results(unchanged, calc), before)


# Solvers pass the pressure that displaces the atoms on to the calculator.


def relaxed(options):
    atoms = make_atoms(**options)
    atoms.calc = rc.RoughContact(SPHERE, 1.0, WALL, load=0.3)
    assert rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
    return atoms


@pytest.mark.parametrize("name", OTHERS)
def test_the_pressure_of_a_solver_is_not_used_with_other_parameters(name):
    atoms = relaxed({})
    atoms.calc.set(**OTHERS[name])
    atoms.calc.set(fft={})
    assert_fresh(atoms, atoms.calc, 1e-9)


@pytest.mark.filterwarnings("ignore:the load of")
@pytest.mark.parametrize(
    "change, options", CHANGES, ids=[change.__name__ for change, _ in CHANGES]
)
def test_the_pressure_of_a_solver_is_not_used_for_other_atoms(change, options):
    atoms = relaxed(options)
    assert_fresh(atoms, atoms.calc, 1e-9)
    change(atoms)
    assert_fresh(atoms, atoms.calc, 1e-9)


def test_misplaced_indenters_are_refused_after_a_calculation_too():
    atoms, calc = make_atoms(), rc.RoughContact(SPHERE, 1.0, WALL)
    before = results(atoms, calc)
    for numbers in ({3: 0}, {-1: 29}):
        wrong = atoms.copy()
        for index, number in numbers.items():
            wrong.numbers[index] = number
        with pytest.raises(ValueError, match="indenter"):
            calc.get_property("energy", wrong)
    assert not differ(results(atoms, calc), before)
