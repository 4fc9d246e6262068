"""Paths of atoms in time, their files, and the cantilever."""

from dataclasses import dataclass

import numpy as np
import pytest
from ase.io import read, write
from ase.optimize import LBFGS
from built import atoms_under, force_along, up
from same_frames import assert_is_snapshot

from ase_roughcontact import (
    Creep,
    FourierModes,
    HardWall,
    LennardJones93,
    Output,
    RoughContact,
    RoughSphere,
    Schedule,
    TimeStep,
    Viscoelastic,
    column,
    time_path,
)
from ase_roughcontact.analysis.view import with_columns
from ase_roughcontact.atoms.snapshot import restore, snapshot
from ase_roughcontact.loading.trajectory import read_frames

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")

CREEP = Creep.standard_solid(relaxed=0.3, time=1.0)
PATH = Schedule(0.0).ramp(2.0, time=1.0).hold(1.0).ramp(-2.0, time=1.0)


def atoms_on(wall, shape=(32, 32), creep=CREEP, fixed=True):
    options = {"solid": Viscoelastic(0.8, creep), "spacing": 2.5, "fixed": fixed}
    return atoms_under(RoughSphere(radius=200.0), wall, shape, **options)


SOFT = LennardJones93.repulsive(0.8, 2.5)
ADHESIVE = LennardJones93.adhesive(0.8, 2.5, 0.02)
# Those between a resumed and an uninterrupted path, by the tolerance of forces.
ERRORS = {
    "normal_force": 1e-5,
    "dissipation": 1e-4,
    "dissipated_energy": 1e-5,
    "lost_energy": 1e-5,
}


@pytest.mark.parametrize("wall", [HardWall(), SOFT])
@pytest.mark.parametrize("window", ["fixed", "auto"])
def test_atoms_are_in_the_last_state(wall, window):
    atoms = atoms_on(wall)
    for step in time_path(atoms, penetrations=PATH.ramp(1.0, time=1.0), window=window):
        state = atoms.calc.state(atoms)
        assert state.normal_force == pytest.approx(step.normal_force, abs=1e-9)
        assert atoms.positions[-1, 2] == step.height
    assert step.time == 4.0
    assert abs(atoms.get_forces()[:-1]).max() < 2.0 * step.tolerance
    atoms.calc.reset()
    assert abs(atoms.get_forces()[:-1]).max() < 2.0 * step.tolerance + 1e-9


def test_forces_are_the_gradient_of_the_instantaneous_energy():
    atoms = atoms_on(SOFT)
    for step in time_path(atoms, penetrations=PATH):
        if step.time > 2.2:
            break
    index = 16 * 32 + 16
    force = atoms.get_forces()[index, 2]
    assert force == pytest.approx(force_along(atoms, up(atoms, index)), abs=1e-5)


@pytest.mark.parametrize(
    "optimizer", [None, lambda a, **k: LBFGS(FourierModes(a), alpha=1, **k)]
)
def test_optimizers_agree(optimizer):
    path = Schedule(0.0).ramp(2.0, time=1.0)
    expected = list(
        time_path(atoms_on(SOFT), penetrations=path, tolerance=1e-3, accuracy=1e-5)
    )[-1]
    steps = time_path(
        atoms_on(SOFT),
        penetrations=path,
        tolerance=1e-3,
        fmax=1e-5,
        optimizer=optimizer,
    )
    assert list(steps)[-1].normal_force == pytest.approx(
        expected.normal_force, rel=1e-3
    )


@pytest.mark.parametrize("keep", ["all", "last"])
@pytest.mark.parametrize("stop", [1, 20, pytest.param(33, marks=pytest.mark.slow)])
@pytest.mark.parametrize("wall", [HardWall(), ADHESIVE], ids=["hard", "adhesive"])
def test_a_path_is_resumed_with_its_history(tmp_path, wall, stop, keep):
    tight = {"accuracy": 1e-6}
    whole = list(time_path(atoms_on(wall), penetrations=PATH, **tight))
    files = {"trajectory": tmp_path / "p.traj", "csv": tmp_path / "p.csv", "keep": keep}
    steps = time_path(
        atoms_on(wall), penetrations=PATH, output=Output(**files), **tight
    )
    for _ in range(stop):
        next(steps)
    steps.close()
    output = Output(**files, resume=True)
    rest = list(time_path(atoms_on(wall), penetrations=PATH, output=output, **tight))
    rest = {s.step: s for s in rest}
    assert len(whole) == max(rest) + 1
    for step in whole[stop:]:
        assert rest[step.step].time == step.time
        for name, error in ERRORS.items():
            expected = pytest.approx(getattr(step, name), abs=error)
            assert getattr(rest[step.step], name) == expected


def test_a_longer_path_is_resumed_and_another_one_refused(tmp_path):
    files = {"trajectory": tmp_path / "p.traj"}
    list(time_path(atoms_on(HardWall()), penetrations=PATH, output=Output(**files)))
    output = Output(**files, resume=True)
    longer = list(
        time_path(atoms_on(HardWall()), penetrations=PATH.hold(1.0), output=output)
    )
    assert longer[-1].time == 4.0
    other = Schedule(0.0).ramp(1.9, time=1.0)
    with pytest.raises(ValueError, match=r"another path .*parts"):
        list(time_path(atoms_on(HardWall()), penetrations=other, output=output))
    with pytest.raises(ValueError, match="creep"):
        slower = atoms_on(HardWall(), creep=Creep.standard_solid(0.3, 2.0))
        list(time_path(slower, penetrations=PATH, output=output))


def test_frames_have_the_gap_of_the_crept_surface(tmp_path):
    atoms = atoms_on(HardWall())
    file = tmp_path / "p.traj"
    list(time_path(atoms, penetrations=PATH, output=Output(trajectory=file)))
    state = atoms.calc.state(atoms)
    frame = read(file)
    gap = with_columns(frame, atoms.calc.parameters["indenter"]).arrays["gap"][:-1]
    assert gap == pytest.approx(state.gap.ravel(), abs=1e-6)  # in single precision
    frame.calc = RoughContact(**atoms.calc.parameters)
    with pytest.raises(ValueError, match="creep_pressure_1, pressure_rate"):
        frame.get_potential_energy()  # frames for looking do not have them


@pytest.mark.parametrize("rebuilt", [False, True])
def test_a_snapshot_is_a_calculation_again(tmp_path, rebuilt):
    atoms, file = atoms_on(SOFT), tmp_path / "p.traj"
    path = Schedule(0.0).ramp(2.0, time=1.0)
    list(time_path(atoms, penetrations=path, accuracy=1e-6))
    write(file, snapshot(atoms))
    frame = read(file)
    again = restore(frame, 0.8) if rebuilt else frame
    energy = frame.get_potential_energy()
    again.calc = RoughContact(**atoms.calc.parameters)
    assert again.get_potential_energy() == pytest.approx(energy, rel=1e-9)
    assert abs(again.get_forces()[:-1]).max() < 1e-4
    hold = Schedule(2.0).hold(0.5)
    expected = list(time_path(atoms, penetrations=hold, accuracy=1e-6))[-1]
    found = list(time_path(again, penetrations=hold, accuracy=1e-6))[-1]
    assert found.normal_force == pytest.approx(expected.normal_force, rel=1e-6)


def test_atoms_with_the_past_of_another_solid_are_refused(tmp_path):
    file = tmp_path / "p.traj"
    atoms = atoms_on(HardWall())
    list(time_path(atoms, penetrations=Schedule(0.0).ramp(2.0, time=1.0)))
    write(file, snapshot(atoms))
    other = Creep.standard_solid(relaxed=0.3, time=2.0)
    for crept in (atoms, read(file)):
        slower = Viscoelastic(0.8, other)
        crept.calc = RoughContact(RoughSphere(200.0), wall=SOFT, solid=slower)
        with pytest.raises(
            ValueError, match=r"has crept in .*3\.33.* but this .*6\.66"
        ):
            list(time_path(crept, penetrations=Schedule(2.0).hold(1.0)))
        with pytest.raises(ValueError, match="crept"):
            crept.get_potential_energy()


def test_base_of_a_cantilever_balances_the_force():
    atoms = atoms_on(ADHESIVE, fixed=False)
    start = 6.0
    path = Schedule(start).ramp(-3.0, time=1.0).hold(0.5).ramp(40.0, time=3.0)
    k, last = 5.0, None
    for last in time_path(atoms, bases=path, cantilever=k):
        deflection = path.at(last.time) - last.height
        assert last.normal_force == pytest.approx(-k * deflection, abs=1e-4)
    assert last.time == 4.5
    assert last.normal_force == pytest.approx(0.0, abs=1e-6)


def test_columns_of_a_path_in_time_are_derived_from_its_class():
    @dataclass(frozen=True)
    class Right(TimeStep):
        largest_gap: float = column(lambda s: s.fields.gap.max(), "largest gap", "Å")

    step = next(
        time_path(atoms_on(HardWall()), penetrations=PATH, output=Output(record=Right))
    )
    assert np.isfinite(step.largest_gap)


def test_errors_say_what_a_path_in_time_needs():
    with pytest.raises(ValueError, match="exactly one of"):
        time_path(atoms_on(HardWall()), penetrations=PATH, loads=PATH)
    with pytest.raises(ValueError, match="give its stiffness"):
        time_path(atoms_on(HardWall(), fixed=False), bases=PATH)


def test_frames_of_a_path_in_time_are_snapshots_of_its_atoms(tmp_path):
    atoms, output = atoms_on(HardWall(), (8, 8)), Output(trajectory=tmp_path / "a.traj")
    path = Schedule(0.0).ramp(0.5, time=1.0).ramp(0.2, time=1.0)
    path = time_path(
        atoms, penetrations=path, window="auto", tolerance=0.1, output=output
    )
    snapshots = [snapshot(atoms) for _ in path]
    frames = list(read_frames(output.trajectory))
    assert len(frames) == len(snapshots) > 2
    for frame, expected in zip(frames, snapshots, strict=True):
        assert_is_snapshot(frame, expected)
