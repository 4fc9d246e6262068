"""The state that a solver leaves in atoms and calculator belongs to these atoms."""

import numpy as np
import pytest
from ase.io import read
from ase.optimize import FIRE, LBFGS
from pressed import SOFT, calculated_anew, pressed_atoms

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import contact_of

WALLS = {
    "hard": rc.HardWall(),
    "repulsive": SOFT,
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.05),
}


@pytest.fixture(params=WALLS)
def wall(request):
    return WALLS[request.param]


def solver_of(atoms, **options):
    hard = atoms.calc.parameters["wall"].hard
    return (rc.ActiveSet if hard else rc.NewtonKrylov)(atoms, **options)


def relaxed_atoms(wall, periodic=False, **options):
    atoms = pressed_atoms(wall, periodic=periodic, **options)
    assert solver_of(atoms).run(fmax=1e-9)
    return atoms


@pytest.mark.parametrize("optimizer", [FIRE, LBFGS])
def test_other_optimizers_do_not_push_through_a_relaxed_hard_wall(optimizer):
    atoms = relaxed_atoms(WALLS["hard"], fixed=False, load=2.0)
    assert atoms.calc.get_property("normal_force", atoms) == pytest.approx(2.0)
    atoms.calc.set(load=3.0)
    assert atoms.get_forces()[-1, 2] == pytest.approx(-1.0)
    with pytest.raises(ValueError, match="overlap with the hard wall"):
        optimizer(atoms, logfile=None).run(fmax=1e-3, steps=50)


def test_atoms_follow_the_generator_at_every_step(wall):
    atoms = pressed_atoms(wall)
    optimizer = solver_of(atoms)
    for _ in optimizer.irun(fmax=1e-9):
        if optimizer.nsteps == 0:
            continue
        energy = atoms.get_potential_energy()
        assert optimizer.state.energy == pytest.approx(energy, rel=1e-9)
        gradient = optimizer.optimizable.get_gradient()
        np.testing.assert_array_equal(gradient, -atoms.get_forces().ravel())
        if not wall.hard:  # forces of a hard wall are reactions
            assert np.abs(gradient).max() == pytest.approx(
                optimizer.state.error, rel=1e-3, abs=1e-12
            )
    assert optimizer.nsteps > 1 and np.abs(gradient).max() < 1e-9


def test_a_calculator_changed_during_a_run_is_an_error(wall):
    atoms = pressed_atoms(wall)
    optimizer = solver_of(atoms)
    run = optimizer.irun(fmax=1e-9)
    next(run)
    atoms.calc.set(contact_modulus=2.0)
    with pytest.raises(RuntimeError, match="changed during the run"):
        list(run)


def test_forces_on_the_padding_are_not_lost_in_a_solver_that_has_not_moved_atoms(rng):
    atoms = pressed_atoms(WALLS["repulsive"])
    atoms.positions[:-1, 2] += 0.01 * rng.standard_normal(len(atoms) - 1)
    expected = atoms.get_forces()
    rc.NewtonKrylov(atoms).run(fmax=1e-9, steps=0)
    atoms.calc.reset()
    np.testing.assert_allclose(atoms.get_forces(), expected, atol=1e-12)


# The start


def test_observers_and_frames_have_the_energy_of_the_start(wall, periodic, tmp_path):
    atoms, file, seen = (
        pressed_atoms(wall, periodic=periodic),
        tmp_path / "run.traj",
        [],
    )
    if wall.hard:  # without overlap
        atoms.positions[-1, 2] = contact_of(atoms).first_contact + 0.5
    start = calculated_anew(atoms)
    with solver_of(atoms, trajectory=file) as solver:
        solver.attach(lambda: seen.append(dict(atoms.calc.results)))
        solver.run(fmax=1e-6)
    energy, forces = start.get_potential_energy(), start.get_forces()
    assert seen[0]["energy"] == pytest.approx(energy, abs=1e-12)
    frame = read(file, 0)
    assert frame.get_potential_energy() == pytest.approx(energy, abs=1e-12)
    np.testing.assert_allclose(frame.get_forces(), forces, atol=1e-12)


def test_the_first_frame_has_no_energy_where_atoms_overlap_with_a_hard_wall(
    tmp_path,
):
    atoms, file = pressed_atoms(WALLS["hard"]), tmp_path / "run.traj"
    with rc.ActiveSet(atoms, trajectory=file) as solver:
        assert solver.run(fmax=1e-6)
    first, second = read(file, "0:2")
    assert not first.calc.results and second.calc.results
