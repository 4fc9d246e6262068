"""Results of load steps agree with the atoms and with the path."""

import numpy as np
import pytest
from ase.constraints import Hookean
from ase.optimize import LBFGS
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.optimize import default_optimizer
from ase_roughcontact.solvers.soft.newton import default_relaxer
from ase_roughcontact.stepping.accuracy import GridModel

SPHERE = rc.RoughSphere(20.0)
SPACING, MODULUS = 2.0, 0.5
AREA = SPACING**2
WALLS = {
    "hard": rc.HardWall(),
    "repulsive": rc.LennardJones93.repulsive(MODULUS, SPACING),
    "adhesive": rc.LennardJones93.adhesive(MODULUS, SPACING, 0.05),
    "full": rc.LennardJones93.full(
        distance=SPACING, work_of_adhesion=0.05, cutoff=4.0 * SPACING
    ),
}
OTHERS = {"plastic": rc.PlasticWall(0.1), "exponential": rc.ExponentialWall(0.02, 1.0)}
SOFT = [name for name in WALLS if name != "hard"]


def make_atoms(wall, periodic=False, shape=(20, 16), **options):
    options |= {"modulus": MODULUS, "spacing": SPACING, "periodic": periodic}
    return atoms_under(SPHERE, (WALLS | OTHERS)[wall], shape, **options)


def tie(atoms, stiffness, end):
    """Attach the indenter to a spring along z; return the energy of the spring."""
    point = (*atoms.positions[-1, :2], end)
    atoms.set_constraint(Hookean(len(atoms) - 1, point, stiffness, rt=0.0))
    return lambda height: 0.5 * stiffness * (height - end) ** 2


def relaxed(atoms, optimizer=None, **options):
    """Return the result of the first step of a path."""
    return next(rc.load_path(atoms, optimizer=optimizer, window="unchecked", **options))


def stopped_or_relaxed(atoms, stopped, **options):
    """Return the result of a step, stopped after one iteration or relaxed."""
    how = {"optimizer": LBFGS, "max_steps": 1} if stopped else {}
    record = relaxed(atoms, fmax=1e-5, **how, **options)
    assert record.converged == (not stopped)
    return record


def fresh(atoms):
    """Return a copy of the atoms with a new calculator."""
    again = atoms.copy()
    again.calc = rc.RoughContact(**atoms.calc.parameters)
    return again


def assert_describes(record, atoms, unit=1e-6):
    """Compare a result with properties from a new calculator."""
    again, load = fresh(atoms), atoms.calc.parameters["load"]
    calc = again.calc
    pressure = calc.get_property("pressure", again)
    height = atoms.positions[-1, 2]
    force = AREA * pressure.sum()
    assert record.height == height
    assert record.normal_force == pytest.approx(force, rel=1e-6, abs=unit)
    assert record.repulsive_atoms == np.count_nonzero(pressure > 0.0)
    assert record.attractive_atoms == np.count_nonzero(pressure < 0.0)
    assert record.contact_area == pytest.approx(AREA * record.repulsive_atoms)
    energy = again.get_potential_energy()
    assert record.energy == pytest.approx(energy, rel=1e-6, abs=unit)
    largest = np.linalg.norm(again.get_forces(), axis=1).max()
    assert record.max_force == pytest.approx(largest, rel=1e-3, abs=unit)
    without = energy - load * height - calc.get_property("energies", again)[:-1].sum()
    springs = again.constraints and isinstance(again.constraints[0], Hookean)
    assert (abs(without) > unit) == bool(springs)


@pytest.mark.parametrize("stopped", [True, False], ids=["stopped", "relaxed"])
@pytest.mark.parametrize("wall", SOFT)
def test_results_at_a_given_height_agree_with_the_atoms(wall, stopped, periodic):
    atoms = make_atoms(wall, periodic)
    record = stopped_or_relaxed(atoms, stopped, heights=[0.6 * SPACING])
    assert record.contact_area > 0.0
    assert_describes(record, atoms)


@pytest.mark.parametrize("stopped", [True, False], ids=["stopped", "relaxed"])
@pytest.mark.parametrize("wall", SOFT)
def test_results_under_a_load_agree_with_the_atoms(wall, stopped, periodic):
    atoms = make_atoms(wall, periodic, fixed=False)
    record = stopped_or_relaxed(atoms, stopped, loads=[3.0])
    assert_describes(record, atoms)
    if stopped:  # the indenter has the largest force
        assert record.max_force == pytest.approx(3.0 - record.normal_force)
    else:
        assert record.normal_force == pytest.approx(3.0, abs=1e-5)


@pytest.mark.parametrize("stopped", [True, False], ids=["stopped", "relaxed"])
def test_results_on_a_spring_include_its_force_and_energy(stopped):
    atoms = make_atoms("repulsive", fixed=False, height=SPACING)
    stored = tie(atoms, 0.7, -2.0)
    record = stopped_or_relaxed(atoms, stopped, loads=[1.5])
    assert_describes(record, atoms)
    again = fresh(atoms)
    own = again.get_potential_energy(apply_constraint=False)
    assert record.energy - own == pytest.approx(stored(record.height))
    missing = record.normal_force - 0.7 * (record.height + 2.0) - 1.5
    assert abs(missing) == pytest.approx(record.max_force if stopped else 0, abs=1e-5)


@pytest.mark.parametrize("wall", WALLS)
def test_penetrations_count_from_the_first_contact(wall, periodic):
    atoms = make_atoms(wall, periodic)
    touch = WALLS[wall].contact_distance  # the lowest point is above an atom
    record = relaxed(atoms, penetrations=[1.5])
    assert (record.penetration, record.height) == pytest.approx((1.5, touch - 1.5))
    record = relaxed(make_atoms(wall, periodic), heights=[touch - 1.0])
    assert (record.penetration, record.height) == pytest.approx((1.0, touch - 1.0))


@pytest.mark.parametrize("steps, larger", [(1, "overlap"), (500, "gap")])
def test_the_gap_error_of_a_hard_wall_is_the_largest_gap_or_overlap(steps, larger):
    atoms = make_atoms("hard")
    record = relaxed(atoms, heights=[-1.0], max_steps=steps)
    gap, touching = (atoms.calc.get_property(n, atoms) for n in ("gap", "contact"))
    most = abs(gap[touching]).max(initial=0.0)
    errors = {"overlap": -gap[~touching].min(), "gap": most}
    assert record.converged == (steps > 1)
    assert max(errors.values()) == errors[larger] > 0.0
    # the atoms have padding, the path has none: they differ by rounding
    assert record.gap_error == pytest.approx(errors[larger], rel=1e-6)


@pytest.mark.parametrize("wall", [*WALLS, "plastic", "exponential"])
@pytest.mark.parametrize("relaxes", [True, False])
def test_a_step_has_converged_only_if_its_forces_are_small(wall, relaxes):
    class Claimed(default_optimizer((WALLS | OTHERS)[wall])):
        def run(self, fmax, steps):
            return super().run(fmax, steps) if relaxes else True

    atoms = make_atoms(wall, fixed=False, height=SPACING)
    record = relaxed(atoms, optimizer=Claimed, loads=[0.3])
    assert record.converged == (record.max_force <= record.tolerance) == relaxes
    assert bool(record.message) != relaxes


def test_a_step_of_a_hard_wall_has_converged_only_if_its_gaps_are_small():
    class Loose(rc.ActiveSet):
        def run(self, fmax, steps):
            return super().run(fmax, steps=1) or True

    record = relaxed(make_atoms("hard"), optimizer=Loose, heights=[-1.0])
    assert record.gap_error > 1e-3 and not record.converged


def test_the_gap_error_of_a_soft_wall_is_not_known(periodic):
    record = relaxed(make_atoms("repulsive", periodic), heights=[-1.0])
    assert "gap_error" in record.not_known


@pytest.mark.parametrize("path", [{"loads": [0.3]}, {"penetrations": [2.0]}])
@pytest.mark.parametrize("error", ["fast", "normal", 1e-3, 1e-6])
@pytest.mark.parametrize("wall", ["hard", "repulsive"])
def test_the_relative_tolerance_is_a_quarter_of_the_relative_error(wall, error, path):
    atoms = make_atoms(wall, fixed="loads" not in path)
    record = relaxed(atoms, accuracy=error, **path)
    mean = record.normal_force / record.repulsive_atoms
    allowed = GridModel("atoms", error).error
    assert record.converged
    assert 0.02 * allowed < record.tolerance / mean <= 0.2501 * allowed


@pytest.mark.parametrize("wall", [rc.HardWall(), rc.LennardJones93.repulsive(1.0, 1.0)])
def test_cost_of_a_step_agrees_with_all_its_runs(wall):
    relaxer, runs = default_relaxer(wall), []

    def counted(*arguments):
        runs.append(relaxer(*arguments))
        return runs[-1]

    problem = rc.Problem(rc.RoughSphere(200.0), Isotropic(1.0), wall, 1.0)
    options = rc.StepOptions(window="auto", relaxer=counted)
    stepper = rc.Stepper(problem, "loads", Box((-8, -8), (16, 16)), options)
    step = rc.LoadStep.of(stepper.relax(stepper.start, 0.1))
    assert len(runs) > 1  # the tolerance of the first run does not suffice
    assert step.pairs == sum(run.pairs for run in runs)
    assert step.iterations == sum(run.iterations for run in runs)


@pytest.mark.parametrize(
    "error, of_atoms, of_continuum",
    [
        ("fast", 1e-4, 0.05),
        ("normal", 1e-4, 0.01),
        ("high", 1e-4, 2e-3),
        (0.1, 0.1, 0.1),
    ],
)
def test_errors_of_the_levels_of_accuracy(error, of_atoms, of_continuum):
    assert GridModel("atoms", error).error == of_atoms
    assert GridModel("atoms", error).tolerance == pytest.approx(of_atoms / 4.0)
    assert GridModel("continuum", error).error == of_continuum
    tolerance = GridModel("continuum", error).tolerance
    assert tolerance == pytest.approx(of_continuum / 40.0)
    assert rc.StepOptions().accuracy == "normal"
