"""Comparison of optimizers, all of ASE on small scenes, and a check for tests."""

import csv
from dataclasses import fields

import numpy as np
import pytest
from ase.constraints import FixAtoms
from ase.optimize import LBFGS
from ase.optimize.optimize import Optimizer
from built import atoms_under
from matplotlib import pyplot

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.optimize.comparison_result import OptimizerResult
from ase_roughcontact.optimize.names import optimizer_names
from ase_roughcontact.plot import plot_optimizers

SPACING, MODULUS = 2.5, 0.9
WALLS = {
    "repulsive": rc.LennardJones93.repulsive(MODULUS, SPACING),
    "adhesive": rc.LennardJones93.adhesive(MODULUS, SPACING, 0.01 * MODULUS * SPACING),
    "hard": rc.HardWall(),
}
# Those that can't relax a surface; the preconditioned ones need atoms.
REFUSED = {
    *("CellAwareBFGS", "GPMin", "SciPyFmin", "SciPyFminPowell"),
    *(f"Precon{name} on modes" for name in ("FIRE", "LBFGS", "ODE12r")),
    *(
        f"{name} on modes"
        for name in ("CellAwareBFGS", "GPMin", "SciPyFmin", "SciPyFminPowell")
    ),
}
WORKING = [name for name in optimizer_names() if name not in {*REFUSED, "ActiveSet"}]


def atoms_of(wall="repulsive", fixed=True, n=6, periodic=True, depth=0.1):
    rough = rc.SelfAffine(0.05, 0.8, 4 * SPACING, 6 * SPACING, seed=1)
    options = {"spacing": SPACING, "modulus": MODULUS, "fixed": fixed}
    sphere = rc.RoughSphere(150.0, rough)
    atoms = atoms_under(sphere, WALLS[wall], (n, n), periodic=periodic, **options)
    atoms.positions[-1, 2] = contact_of(atoms).first_contact
    if fixed:
        atoms.positions[-1, 2] -= depth
    else:
        atoms.calc.set(load=2.0)
    return atoms


@pytest.fixture(scope="module")
def compared():
    names = ["NewtonKrylov", "LBFGS", "FIRE2 on modes"]
    return rc.compare_optimizers(atoms_of(n=10, periodic=False, depth=0.5), names)


# All optimizers


@pytest.mark.filterwarnings("ignore:Armijo linesearch failed")
@pytest.mark.parametrize(
    "wall, fixed",
    [
        ("repulsive", False),
        *(
            pytest.param(wall, fixed, marks=pytest.mark.slow)
            for wall, fixed in (
                ("repulsive", True),
                ("adhesive", True),
                ("adhesive", False),
            )
        ),
    ],
)
@pytest.mark.parametrize("name", WORKING)
def test_all_optimizers_of_ase_find_the_same_contact(name, wall, fixed):
    # attraction pulls the surface of the cell up to the indenter
    depth = 0.4 if wall == "adhesive" else 0.1
    compared = rc.compare_optimizers(atoms_of(wall, fixed, depth=depth), [name])
    compared.check(atoms=0, energy=1e-3)
    (result,) = compared.results
    assert result.error <= 0.01 and result.reached(0.01) is not None


@pytest.mark.parametrize("name", sorted(REFUSED))
def test_optimizers_that_cannot_work_say_what_to_use(name):
    (result,) = rc.compare_optimizers(atoms_of(), [name]).results
    assert not result.converged and result.steps == 0
    assert "use " in result.reason or "HalfSpacePrecon" in result.reason
    assert np.isnan(result.energy_error) and result.changed_atoms == -1


@pytest.mark.parametrize("fixed", [True, False])
def test_a_hard_wall_has_its_own_solver(fixed):
    compared = rc.compare_optimizers(atoms_of("hard", fixed), accuracy=1e-4)
    assert [result.optimizer for result in compared.results] == ["ActiveSet"]
    compared.check(energy=1e-6)


# Numbers


def test_errors_are_differences_to_the_relaxed_state():
    atoms = atoms_of(n=10, periodic=False, depth=0.5)
    before, followed = atoms.positions.copy(), []

    def loose_lbfgs(atoms, logfile=None):
        followed.append(atoms)
        return LBFGS(atoms, logfile=logfile)

    compared = rc.compare_optimizers(atoms, {"LBFGS": loose_lbfgs}, accuracy=0.3)
    assert np.array_equal(atoms.positions, before)
    (left,), (result,) = followed, compared.results
    loose = left.calc.state(left)
    modes = rc.FourierModes(atoms)
    assert LBFGS(modes, alpha=1.0, logfile=None).run(fmax=1e-9)
    exact = atoms.calc.state(atoms)
    energy = atoms.get_potential_energy()
    assert compared.energy == pytest.approx(energy, abs=1e-9)
    assert compared.normal_force == pytest.approx(exact.normal_force, rel=1e-7)
    assert compared.contact_atoms == exact.repulsive_atoms
    above = left.get_potential_energy() - energy
    assert result.energy_error == pytest.approx(above, rel=1e-4) and above > 0.0
    atoms_more = abs(loose.repulsive_atoms - exact.repulsive_atoms)
    assert result.area_error == atoms_more / exact.repulsive_atoms
    assert result.changed_atoms == (loose.contact ^ exact.contact).sum()
    force = abs(loose.normal_force - exact.normal_force)
    scale = np.abs(exact.pressure).sum() * exact.cell_area
    assert result.force_error == pytest.approx(force / scale, rel=1e-4)
    last = result.history[-1]
    assert last.error == result.error >= result.force_error > 0.0


class Pusher(Optimizer):
    """Moves the surface up by 1 Å and calls it done."""

    def run(self, fmax, steps):
        self.atoms.positions[:-1, 2] += 1.0
        return True


class Failing(Optimizer):
    """Fails without a word."""

    def run(self, fmax, steps):
        raise ValueError


@pytest.mark.parametrize(
    "optimizer, reason", [(Pusher, "inside the hard wall"), (Failing, "ValueError")]
)
def test_optimizers_that_end_without_a_state_say_why(optimizer, reason):
    atoms = atoms_of("hard")
    (result,) = rc.compare_optimizers(atoms, {"own": optimizer}).results
    assert not result.converged and reason in result.reason
    assert result.changed_atoms == -1 and np.isnan(result.error)


def test_atoms_that_are_relaxed_already_are_named():
    atoms = atoms_of()
    rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
    with pytest.warns(UserWarning, match="relaxed"):
        rc.compare_optimizers(atoms, ["LBFGS"])


def test_costs_are_of_the_optimizer_alone(compared):
    newton, lbfgs, fire = compared.results
    assert newton.pairs < lbfgs.pairs and newton.pairs < fire.pairs
    # ASE evaluates the first atoms, and those after each step
    assert lbfgs.steps <= lbfgs.evaluations <= lbfgs.steps + 2
    assert abs(lbfgs.pairs - lbfgs.evaluations) <= 2
    assert fire.steps < fire.evaluations < 1.2 * fire.steps
    for result in compared.results:
        assert 0.0 < result.seconds_to_accuracy <= result.seconds
        assert 0.0 < result.pairs_to_accuracy <= result.pairs


def test_the_moment_of_an_error_is_the_first_from_which_it_stays_below(compared):
    for result in compared.results:
        reached = result.reached(0.01)
        after = [each for each in result.history if each.steps >= reached.steps]
        before = [each for each in result.history if each.steps < reached.steps]
        assert max(each.error for each in after) <= 0.01 < before[-1].error
        assert result.reached(1e-15) is None


def test_a_state_with_other_atoms_in_contact_fails_the_check(compared):
    compared.check(atoms=1, energy=1e-2)
    with pytest.raises(AssertionError, match="FIRE2 on modes"):
        compared.check(energy=1e-14)
    unfinished = rc.compare_optimizers(atoms_of(), ["LBFGS"], max_steps=2)
    with pytest.raises(AssertionError, match="2 steps"):
        unfinished.check(atoms=100, energy=100.0)


def test_what_an_optimizer_does_wrong_is_its_result():
    def failing(atoms, **options):
        raise KeyError("mine")

    own = {"failing": failing, "modes": rc.on_modes(LBFGS)}
    failed, works = rc.compare_optimizers(atoms_of(), own).results
    assert "mine" in failed.reason and not failed.converged
    assert works.converged and not works.reason


def test_another_state_of_an_adhesive_contact_is_named():
    """A contact that was larger before keeps another edge on the lattice."""

    def pressed_before(atoms, **options):
        atoms.positions[-1, 2] -= 1.7
        rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-8)
        atoms.positions[-1, 2] += 1.7
        return rc.NewtonKrylov(atoms, **options)

    wall = rc.ExponentialWall(0.2, 0.3)
    atoms = atoms_under(rc.RoughSphere(20.0), wall, (20, 20))
    atoms.positions[-1, 2] = contact_of(atoms).first_contact + 0.7
    given = {"flat": rc.NewtonKrylov, "pressed before": pressed_before}
    flat, pressed = rc.compare_optimizers(atoms, given).results
    assert flat.reason == "" and flat.changed_atoms == 0
    assert "another state" in pressed.reason and pressed.changed_atoms == 8


# Files and arguments


def test_table_and_csv_have_a_line_for_each_optimizer(compared, tmp_path):
    text = str(compared)
    assert all(result.optimizer in text for result in compared.results)
    compared.write_csv(tmp_path / "compared.csv")
    with open(tmp_path / "compared.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [*rows[0]] == [each.name for each in fields(OptimizerResult)][:-1]
    for row, result in zip(rows, compared.results, strict=True):
        assert row["optimizer"] == result.optimizer
        assert float(row["energy_error"]) == result.energy_error


def test_figure_has_a_line_for_each_optimizer(compared):
    _, axes = pyplot.subplots()
    plot_optimizers(axes, compared)
    lines = {line.get_label(): line for line in axes.lines}
    for result in compared.results:
        line = lines[result.optimizer]
        assert line.get_ydata()[-1] == result.error
        assert line.get_xdata()[-1] == result.pairs
    pyplot.close()


def test_arguments_are_checked():
    with pytest.raises(ValueError, match="FIRE2"):
        rc.compare_optimizers(atoms_of(), ["FIRE3"])
    with pytest.raises(ValueError, match="accuracy"):
        rc.compare_optimizers(atoms_of(), accuracy=0.0)
    with pytest.raises(ValueError, match="lower the"):
        rc.compare_optimizers(atoms_of(depth=-3.0))
    held = atoms_of()
    held.set_constraint([*held.constraints, FixAtoms([3])])
    with pytest.raises(ValueError, match="constraints"):
        rc.compare_optimizers(held)
