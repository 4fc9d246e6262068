"""NewtonKrylov and ActiveSet as ASE optimizers."""

import numpy as np
import pytest
from ase.calculators.emt import EMT
from ase.optimize import LBFGS
from numpy.testing import assert_allclose
from pressed import SOFT, calculated_anew, largest_force, pressed_atoms

import ase_roughcontact as rc
from ase_roughcontact.solvers.options import ActiveSetOptions, NewtonKrylovOptions

WALLS = {rc.NewtonKrylov: SOFT, rc.ActiveSet: rc.HardWall()}


@pytest.fixture(params=WALLS, ids=lambda solver: solver.__name__)
def solver(request):
    return request.param


# The interface of ASE


@pytest.mark.parametrize("pressure", [3e3, 1e4, 1e5])
def test_forces_of_a_full_contact_are_those_that_the_solver_has_seen(pressure):
    flat = rc.SelfAffine(0.1, 0.8, 4.0, 64.0, domain=64.0)
    atoms = pressed_atoms(
        sphere=flat, n=64, periodic=True, fixed=False, load=pressure * 64**2
    )
    dynamics = rc.NewtonKrylov(atoms)
    assert dynamics.run(fmax=3e-12 * pressure)
    assert abs(atoms.get_forces()).max() <= 3e-12 * pressure


@pytest.mark.parametrize("load", [None, 2.0], ids=["height", "load"])
def test_relaxed_atoms_have_no_forces(solver, load, periodic):
    control = {} if load is None else {"fixed": False, "load": load}
    atoms = pressed_atoms(WALLS[solver], periodic=periodic, **control)
    dynamics = solver(atoms)
    assert dynamics.run(fmax=1e-8)
    assert dynamics.converged() and dynamics.message == ""
    assert dynamics.pairs > 0.0
    # forces of a hard wall are reactions: exact in contact, and zero outside
    assert largest_force(atoms) < 1.1e-8
    if load is not None:
        force = atoms.calc.state(atoms).normal_force
        assert force == pytest.approx(load, abs=1e-7)


def test_generator_yields_whether_it_has_converged(solver):
    dynamics = solver(pressed_atoms(WALLS[solver]))
    *before, last = dynamics.irun(fmax=1e-8)
    assert last and not any(before)
    assert len(before) == dynamics.nsteps > 0


def test_every_step_is_logged_and_observed(solver, tmp_path):
    log, seen = tmp_path / "relax.log", []
    with solver(pressed_atoms(WALLS[solver]), logfile=log) as dynamics:
        dynamics.attach(lambda: seen.append(dynamics.nsteps))
        dynamics.run(fmax=1e-8)
    assert seen == list(range(dynamics.nsteps + 1))
    header, *lines = log.read_text().splitlines()
    assert header.split() == ["Step", "Time", "Energy", "fmax"]
    assert len(lines) == len(seen)
    assert all(line.startswith(f"{solver.__name__}:") for line in lines)
    assert float(lines[-1].split()[-1]) == 0.0


def test_run_out_of_steps_has_a_message_and_can_be_continued(solver):
    atoms = pressed_atoms(WALLS[solver])
    dynamics = solver(atoms)
    assert not dynamics.run(fmax=1e-10, steps=1)
    assert dynamics.message == "not converged after 1 steps; allow more steps"
    assert dynamics.nsteps == 1 and not dynamics.converged()
    dynamics.step()  # no memory is held for steps that may never come
    assert dynamics.message == "the solver has ended"
    assert dynamics.run(fmax=1e-8)
    assert dynamics.message == ""


@pytest.mark.parametrize("fmax", [0.05, 10.0])
def test_load_below_the_tolerance_is_carried(solver, fmax):
    atoms = pressed_atoms(WALLS[solver], depth=-0.1, load=0.02, fixed=False)
    assert solver(atoms, logfile=None).run(fmax=fmax)
    assert_allclose(atoms.calc.state(atoms).normal_force, 0.02, rtol=0.01)


def test_load_below_the_tolerance_is_carried_by_the_optimizers_of_ase():
    atoms = pressed_atoms(depth=1e-3, load=0.02, fixed=False)
    assert LBFGS(rc.FourierModes(atoms), alpha=1.0, logfile=None).run()
    assert_allclose(atoms.calc.state(atoms).normal_force, 0.02, rtol=0.01)


@pytest.mark.parametrize("depth", [1e-9, 1e-7, 9e-7, 1e-5, 0.01])
def test_contact_below_the_tolerance_is_relaxed(solver, depth):
    forces = []
    for fmax in (0.05, 1e-6 * depth):
        atoms = pressed_atoms(WALLS[solver], depth=depth)
        assert solver(atoms, logfile=None).run(fmax=fmax)
        forces.append(atoms.calc.state(atoms).normal_force)
    assert_allclose(forces[0], forces[1], rtol=0.04)


def test_second_run_uses_a_new_load(solver):
    atoms = pressed_atoms(WALLS[solver], fixed=False, load=1.0)
    dynamics = solver(atoms)
    dynamics.run(fmax=1e-8)
    atoms.calc.set(load=2.0)
    assert dynamics.run(fmax=1e-8)
    assert atoms.calc.state(atoms).normal_force == pytest.approx(2.0, abs=1e-7)


# Errors


def test_restart_file_is_refused(solver, tmp_path):
    with pytest.raises(ValueError, match="restart must be None"):
        solver(pressed_atoms(WALLS[solver]), restart=tmp_path / "restart.json")


FACES = rc.NewtonKrylov, rc.ActiveSet, rc.FourierModes, rc.HalfSpacePrecon


@pytest.mark.parametrize("face", FACES)
@pytest.mark.parametrize("calculator", [None, EMT()], ids=["none", "EMT"])
def test_other_calculators_are_refused(face, calculator):
    atoms = pressed_atoms()
    atoms.calc = calculator
    with pytest.raises(ValueError, match="RoughContact"):
        face(atoms)


@pytest.mark.parametrize("face", [rc.FourierModes, rc.HalfSpacePrecon])
def test_a_hard_wall_is_refused_with_the_optimizer_to_use(face):
    with pytest.raises(ValueError, match="ActiveSet"):
        face(pressed_atoms(rc.HardWall()))


# Observers, records and messages


def test_results_of_a_run_agree_with_a_new_calculator(solver, periodic):
    atoms = pressed_atoms(WALLS[solver], periodic=periodic, fixed=False, load=3.0)
    solver(atoms).run(fmax=1e-9)
    fresh = calculated_anew(atoms)
    fresh.get_potential_energy()
    assert atoms.calc.calculation_required(atoms, ["forces"]) is False
    calc = fresh.calc
    for name in calc.implemented_properties + calc.own_properties:
        found, expected = (
            each.calc.get_property(name, each) for each in (atoms, fresh)
        )
        assert_allclose(found, expected, atol=1e-7, err_msg=name)


def test_optimality_residuals_of_a_solution_are_small():
    atoms = pressed_atoms(rc.HardWall(), fixed=False, load=2.0)
    optimizer = rc.ActiveSet(atoms)
    with pytest.raises(RuntimeError, match="before the first step"):
        _ = optimizer.optimality_residuals
    optimizer.run(fmax=1e-9)
    found = optimizer.optimality_residuals
    assert max(found.gap_in_contact, found.penetration, found.tension) <= 1e-6
    assert found.load_error < 1e-12


@pytest.mark.parametrize(
    "solver, options",
    [
        (rc.NewtonKrylov, NewtonKrylovOptions(forcing=0.5)),
        (rc.ActiveSet, ActiveSetOptions(coarsest=16)),
    ],
    ids=["NewtonKrylov", "ActiveSet"],
)
def test_options_are_passed_to_the_solver(solver, options):
    changed, usual = (pressed_atoms(WALLS[solver], n=48) for _ in range(2))
    dynamics, reference = solver(changed, options=options), solver(usual)
    assert dynamics.run(fmax=1e-8) and reference.run(fmax=1e-8)
    assert (dynamics.nsteps, dynamics.pairs) != (reference.nsteps, reference.pairs)
    np.testing.assert_allclose(changed.positions, usual.positions, atol=1e-6)
