"""Load paths: results, files, resuming, and errors."""

import os
from dataclasses import asdict, fields
from functools import partial

import numpy as np
import pytest
from ase import Atoms
from ase.constraints import FixAtoms
from ase.io import read
from ase.optimize import FIRE, LBFGS
from built import atoms_under
from written_path import written_path

import ase_roughcontact as rc
from ase_roughcontact._util.files import table_rows
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.paths.restart import read_steps, restart_file

SPHERE = rc.RoughSphere(radius=10.0)
DEPTHS = [0.2, 0.4, 0.6]
FMAX = 1e-5


def make_atoms(modulus=1.0, **options):
    options = {"shape": (12, 10), "height": 1.0, "spacing": 1.0, **options}
    atoms = rc.substrate("Cu", indenter=SPHERE, **options)
    atoms.calc = rc.RoughContact(SPHERE, modulus)
    return atoms


def rows_of(path):
    with open(path, newline="") as file:
        return list(table_rows(file))


def same(records, others, tolerance):
    """Whether results agree, except time and cost."""
    names = ("step", "height", "normal_force", "contact_area", "energy", "converged")
    return len(records) == len(others) and all(
        getattr(a, name) == pytest.approx(getattr(b, name), abs=tolerance)
        for a, b in zip(records, others, strict=True)
        for name in names
    )


# Paths


def test_path_of_loads_may_start_out_of_contact():
    atoms = make_atoms(fixed=False, height=1.5)
    record = next(written_path(atoms, loads=[0.5], fmax=FMAX, max_steps=500))
    assert record.converged
    assert record.normal_force == pytest.approx(0.5, abs=FMAX)


@pytest.mark.parametrize("optimizer", [FIRE, LBFGS, partial(LBFGS, memory=5)])
def test_all_optimizers_lead_to_the_same_states(optimizer):
    records = list(written_path(make_atoms(), DEPTHS, optimizer=optimizer, fmax=FMAX))
    assert all(record.converged and not record.message for record in records)
    assert same(records, list(written_path(make_atoms(), DEPTHS, fmax=FMAX)), 1e-3)


def test_optimizers_of_ase_keep_constraints_on_surface_atoms():
    atoms = make_atoms()
    center = int(
        np.argmin(np.hypot(*(atoms.positions - atoms.positions[-1])[:-1, :2].T))
    )
    atoms.set_constraint([*atoms.constraints, FixAtoms([center])])
    record = next(written_path(atoms, [0.3], optimizer=LBFGS, fmax=FMAX))
    assert atoms.positions[center, 2] == 0.0
    assert record.converged
    assert record.max_force <= FMAX


def test_step_starts_from_the_last_state():
    atoms = make_atoms()
    again = list(written_path(atoms, [0.4, 0.4], fmax=FMAX))[1]
    assert again.iterations == 0


@pytest.mark.parametrize("penetration", [1e-12, 1e-8, 9e-7, 1.1e-6])
def test_small_penetration_of_a_hard_wall_is_due_to_one_atom(penetration):
    sphere = rc.RoughSphere(100.0)
    atoms = atoms_under(sphere, rc.HardWall(), (16, 16))
    (step,) = written_path(atoms, [penetration])
    halfspace = contact_of(atoms).halfspace
    stiffness = halfspace.cell_area / halfspace.self_compliance
    assert step.normal_force == pytest.approx(stiffness * penetration, rel=1e-3)
    assert step.repulsive_atoms == 1 and step.converged


# Files


def test_each_step_is_on_disk_before_the_next(tmp_path):
    table, movie = tmp_path / "curve.csv", tmp_path / "sweep.traj"
    path = written_path(make_atoms(), DEPTHS, fmax=FMAX, trajectory=movie, csv=table)
    for count, record in enumerate(path, start=1):
        rows = rows_of(table)
        assert len(rows) == len(read(movie, ":")) == count
        assert rows[-1] == {key: str(value) for key, value in asdict(record).items()}
    assert list(rows[0]) == [field.name for field in fields(rc.LoadStep)]


def test_frames_have_tags_and_the_result_of_the_step(tmp_path):
    movie = tmp_path / "sweep.traj"
    records = list(written_path(make_atoms(), DEPTHS, fmax=FMAX, trajectory=movie))
    for frame, record, depth in zip(read(movie, ":"), records, DEPTHS, strict=True):
        assert np.count_nonzero(frame.get_tags() == 1) == record.repulsive_atoms
        assert frame.positions[-1, 2] == record.height
        assert rc.LoadStep.from_columns(frame.info["load_step"]) == record
        assert frame.info["path"]["control"] == "penetration"
        assert frame.info["path"]["target"] == depth


def test_step_that_does_not_converge_is_written_and_marked(tmp_path):
    table, movie = tmp_path / "curve.csv", tmp_path / "sweep.traj"
    path = written_path(
        make_atoms(), DEPTHS, fmax=1e-9, max_steps=1, trajectory=movie, csv=table
    )
    records = list(path)
    assert [record.converged for record in records] == [False] * 3
    assert all(record.max_force > 1e-9 for record in records)
    assert [row["converged"] for row in rows_of(table)] == ["False"] * 3
    assert not read(movie, -1).info["load_step"]["converged"]


# Resuming


@pytest.mark.parametrize("done", [0, 1, 2, 3])
def test_interrupted_path_resumes_to_the_same_results(tmp_path, periodic, done):
    table, movie = tmp_path / "curve.csv", tmp_path / "sweep.traj"
    options = {"fmax": FMAX, "trajectory": movie, "csv": table}
    whole = list(written_path(make_atoms(periodic=periodic), DEPTHS, fmax=FMAX))
    path = written_path(make_atoms(periodic=periodic), DEPTHS, **options)
    before = [next(path) for _ in range(done)]
    path.close()

    resumed = list(
        written_path(make_atoms(periodic=periodic), DEPTHS, resume=True, **options)
    )
    assert resumed[:done] == before
    assert same(resumed, whole, 0.0)
    assert len(read(movie, ":")) == len(rows_of(table)) == 3


@pytest.mark.parametrize("keep", ["thinned", "all", "last"])
def test_files_without_a_finished_step_are_started_again(tmp_path, keep):
    movie = tmp_path / "sweep.traj"
    movie.touch()
    options = {"fmax": FMAX, "trajectory": movie, "keep": keep}
    steps = list(written_path(make_atoms(), DEPTHS, resume=True, **options))
    assert len(steps) == 3
    assert len(read(movie, ":")) == (1 if keep == "last" else 3)


@pytest.mark.parametrize(
    "other, message",
    [
        (
            {"penetrations": [0.2, 0.5, 0.6]},
            r"penetrations\[1\] was 0\.4, is 0\.5 \(eV, Å\): .*delete the file",
        ),
        ({"penetrations": [0.2]}, "2 steps or more"),
        ({"heights": [0.8, 0.6]}, "penetration.* height"),
        ({"atoms": make_atoms(modulus=2.0)}, r"contact_modulus was 1\.0, is 2\.0"),
        (
            {"atoms": make_atoms(shape=(9, 6))},
            r"lattice\.window was \[12, 10\], is \[9",
        ),
        ({"atoms": make_atoms(periodic=True)}, r"lattice\.periodic was False, is True"),
        ({"fmax": 1e-6}, "fmax was 1e-05, is 1e-06"),
        ({"fmax": None}, "fmax was 1e-05, is None; accuracy was None, is 0.0001"),
    ],
)
def test_another_path_is_an_error_that_lists_what_differs(tmp_path, other, message):
    movie = tmp_path / "sweep.traj"
    list(written_path(make_atoms(), DEPTHS[:2], fmax=FMAX, trajectory=movie))
    written = {file: file.read_bytes() for file in tmp_path.iterdir()}
    path = {"atoms": make_atoms(), "fmax": FMAX, **other}
    if "heights" not in path:
        path.setdefault("penetrations", DEPTHS)
    with pytest.raises(
        ValueError, match=f"can't resume: .*sweep.restart.* .*: .*{message}"
    ):
        next(written_path(**path, trajectory=movie, resume=True))
    assert {file: file.read_bytes() for file in tmp_path.iterdir()} == written


@pytest.mark.parametrize("keep", ["all", "last"])
def test_finished_path_that_is_extended_resumes_from_its_last_state(tmp_path, keep):
    options = {"fmax": FMAX, "trajectory": tmp_path / "sweep.traj", "keep": keep}
    before = list(written_path(make_atoms(), DEPTHS, **options))
    longer = [*DEPTHS, 0.8, 1.0]
    records = list(written_path(make_atoms(), longer, resume=True, **options))
    assert records[:3] == before
    assert [record.penetration for record in records[-2:]] == pytest.approx([0.8, 1.0])
    whole = list(written_path(make_atoms(), longer, fmax=FMAX))
    assert same(records, whole, 0.0)
    assert len(read(tmp_path / "sweep.traj", ":")) == (5 if keep == "all" else 1)


def test_rounding_of_the_targets_does_not_make_another_path(tmp_path):
    options = {"fmax": FMAX, "trajectory": tmp_path / "sweep.traj"}
    short, long = np.geomspace(0.1, 0.4, 3), np.geomspace(0.1, 1.6, 5)[:4]
    long[:3] *= 1.0 + 2e-16
    assert (long[:3] != short).any()
    before = list(written_path(make_atoms(), short, **options))
    assert list(written_path(make_atoms(), long, resume=True, **options))[:3] == before


# Bad input


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"atoms": Atoms("X"), "penetrations": [0.2]}, "RoughContact"),
        ({"atoms": make_atoms(fixed=False), "heights": [0.2]}, "is free.*FixAtoms"),
        ({"penetrations": [0.1], "optimizer": LBFGS(Atoms())}, "must be a class"),
        ({}, "exactly one of .* got none"),
        ({"penetrations": [0.2], "loads": [0.1]}, "exactly one of .*penetrations, lo"),
        ({"penetrations": []}, "penetrations must be"),
        ({"heights": [0.9, np.nan]}, "heights must be"),
        ({"heights": [[0.9]]}, "heights must be"),
        ({"heights": [10**400]}, "heights must be"),
        ({"heights": ["high"]}, "heights must be"),
        ({"loads": [0.1], "atoms": make_atoms(fixed=True)}, "free to move.*fixed=T"),
        ({"penetrations": [0.2], "fmax": 0.0}, "fmax must be a finite number > 0"),
        ({"penetrations": [0.2], "max_steps": 0}, "max_steps"),
        ({"penetrations": [0.2], "max_steps": 2.5}, "max_steps"),
    ],
)
def test_invalid_arguments_are_errors_before_anything_happens(
    tmp_path, arguments, message
):
    movie, arguments = tmp_path / "sweep.traj", {"atoms": make_atoms()} | arguments
    positions = arguments["atoms"].positions.copy()
    with pytest.raises(ValueError, match=message):
        written_path(**arguments, trajectory=movie)
    np.testing.assert_array_equal(arguments["atoms"].positions, positions)
    assert not movie.exists()


def test_table_that_cannot_be_written_does_not_delete_the_trajectory(tmp_path):
    movie = tmp_path / "sweep.traj"
    list(written_path(make_atoms(), DEPTHS[:1], fmax=FMAX, trajectory=movie))
    table = tmp_path / "nowhere" / "curve.csv"
    with pytest.raises(OSError, match="nowhere"):
        next(written_path(make_atoms(), DEPTHS, trajectory=movie, csv=table))
    assert len(read(movie, ":")) == 1


def test_the_name_of_a_file_in_place_of_an_output_is_an_error():
    with pytest.raises(ValueError, match=r"a folder, got 'a.csv'.*Output\(csv="):
        rc.load_path(make_atoms(), penetrations=DEPTHS, output="a.csv")


# The edge of the window


def test_contact_at_the_edge_of_a_fixed_window_is_an_error_with_advice(tmp_path):
    table = tmp_path / "curve.csv"
    edge = r"depth of 1.5 Å .* edge of the window of \(6, 6\).* larger shape"
    for depths in [1.5], [0.1, 1.5]:
        assert not table.exists()  # without a step
        path = written_path(make_atoms(shape=(6, 6)), depths, fmax=FMAX, csv=table)
        with pytest.raises(RuntimeError, match=edge):
            list(path)
    assert len(rows_of(table)) == 1


# Indenters without a description


class Dome:
    """A surface without `todict`."""

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        x, y = (o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True))
        return (x[:, None] ** 2 + y**2) / 20.0


def below_a_dome():
    atoms = make_atoms()
    atoms.calc.set(indenter=Dome())
    return atoms


def test_indenter_without_todict_runs_without_a_trajectory(tmp_path):
    records = list(written_path(below_a_dome(), DEPTHS, csv=tmp_path / "curve.csv"))
    assert same(records, list(written_path(make_atoms(), DEPTHS)), 1e-9)


def test_trajectory_with_an_indenter_without_todict_is_an_error_at_once(tmp_path):
    movie = tmp_path / "sweep.traj"
    with pytest.raises(ValueError, match=r"Dome has none: give it .* todict"):
        written_path(below_a_dome(), DEPTHS, trajectory=movie)
    assert not movie.exists()


@pytest.mark.parametrize("keep", ["all", "last"])
def test_second_writer_gets_an_error_and_the_first_one_continues(tmp_path, keep):
    options = {"trajectory": tmp_path / "sweep.traj", "keep": keep}
    first = written_path(make_atoms(), DEPTHS, **options)
    record = next(first)
    for resume in (False, True):
        with pytest.raises(RuntimeError, match=r"another run is writing .*sweep\.traj"):
            next(written_path(make_atoms(), DEPTHS, resume=resume, **options))
    assert read_steps(restart_file(options["trajectory"])) == [record]
    assert len(list(first)) == 2
    assert read(options["trajectory"]).info["load_step"]["step"] == 2


@pytest.mark.parametrize(
    "other",
    [{"restart": "a.restart.npz"}, {"trajectory": "a.traj", "restart": "b.npz"}],
)
def test_a_run_that_shares_one_file_with_another_one_is_refused(tmp_path, other):
    first = written_path(make_atoms(), DEPTHS, trajectory=tmp_path / "a.traj")
    record = next(first)
    files = {name: tmp_path / file for name, file in other.items()}
    for resume in (False, True):
        with pytest.raises(RuntimeError, match=r"another run is writing .*a\."):
            next(written_path(make_atoms(), DEPTHS, resume=resume, **files))
    assert read_steps(tmp_path / "a.restart.npz") == [record]
    assert len(list(first)) == 2


def test_a_restart_file_may_be_in_a_folder_that_is_not_there_yet(tmp_path):
    file = tmp_path / "new" / "a.npz"
    files = {"trajectory": tmp_path / "a.traj", "restart": file}
    steps = list(written_path(make_atoms(), DEPTHS, **files))
    assert read_steps(file) == steps


def test_lock_removed_by_its_owner_is_not_held(tmp_path, monkeypatch):
    fcntl = pytest.importorskip("fcntl")
    options = {"trajectory": tmp_path / "a.traj", "keep": "last"}
    lock, held = fcntl.flock, tmp_path / "a.traj.lock"

    def late(*arguments):
        held.unlink()  # after it was opened
        lock(*arguments)

    monkeypatch.setattr(fcntl, "flock", late)
    with pytest.raises(RuntimeError, match="another run is writing"):
        next(written_path(make_atoms(), DEPTHS, **options))


@pytest.mark.parametrize("keep", ["all", "last"])
def test_path_resumes_from_steps_finished_meanwhile(tmp_path, keep):
    options = {"trajectory": tmp_path / "a.traj", "keep": keep, "resume": True}
    next(written_path(make_atoms(), DEPTHS, **options))
    late = written_path(make_atoms(), DEPTHS, **options)
    steps = list(written_path(make_atoms(), DEPTHS, **options))
    assert list(late) == steps


@pytest.mark.parametrize("lost", [0, 1, 500], ids=["whole", "torn", "no row"])
def test_the_table_of_a_resumed_path_has_all_steps(tmp_path, lost):
    table = tmp_path / "curve.csv"
    options = {"trajectory": tmp_path / "last.traj", "csv": table, "keep": "last"}
    list(written_path(make_atoms(), DEPTHS, **options))
    rows = rows_of(table)
    last = len(table.read_bytes().splitlines(True)[-1])
    os.truncate(table, table.stat().st_size - min(lost, last))
    list(written_path(make_atoms(), [*DEPTHS, 0.8], resume=True, **options))
    assert rows_of(table)[:3] == rows
    assert [int(row["step"]) for row in rows_of(table)] == [0, 1, 2, 3]


def test_result_describes_how_it_was_obtained():
    atoms = make_atoms()
    record = next(written_path(atoms, DEPTHS[:1], fmax=FMAX))
    shapes = contact_of(atoms).halfspace
    assert record.window == "x".join(map(str, shapes.shape))
    assert record.grid == "x".join(map(str, shapes.grid))
    assert (record.precision, record.tolerance) == ("float64", FMAX)
    assert record.pairs >= record.iterations > 0


def test_adhesive_contact_without_load_converges():
    atoms = make_atoms(fixed=False)
    atoms.calc.set(wall=rc.LennardJones93.adhesive(1.0, 1.0, 0.02))
    (record,) = written_path(atoms, loads=[0.0], window="auto")
    assert record.converged and record.repulsive_atoms > 0
