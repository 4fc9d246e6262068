"""Damaged files: the same numbers or an error that names file and frame, no third."""

import csv
import os
import random
import shutil
from dataclasses import asdict, replace

import pytest
from ase.cli.main import main as ase
from ase.constraints import FixAtoms, Hookean
from ase.io import Trajectory, read
from small_scene import PERIODIC

import ase_roughcontact as rc
from ase_roughcontact.cli import main
from ase_roughcontact.loading import trajectory
from ase_roughcontact.loading.trajectory import read_frames
from ase_roughcontact.paths.restart import read_restart, read_steps, restart_file
from ase_roughcontact.scene import Scene

SCENE = Scene.parse(PERIODIC).with_values({"path.values": [0.05, 0.1, 0.2, 0.3]})


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Folder and results of an undisturbed run."""
    folder = tmp_path_factory.mktemp("whole")
    return folder, list(SCENE.run(folder))


@pytest.fixture
def folder(whole, tmp_path):
    """A copy of the folder of the run."""
    return shutil.copytree(whole[0], tmp_path / "out")


def rewrite(movie, number, change):
    """Change a frame of a trajectory as a user would, with ASE."""
    frames = read(movie, ":")
    change(frames[number])
    with Trajectory(movie, "w") as trajectory:
        for frame in frames:
            trajectory.write(frame)


def change_force(frame):
    frame.info["load_step"]["normal_force"] *= 1.01


CHANGES = {
    "force": change_force,
    "position": lambda frame: frame.translate([0.0, 0.0, 1e-9]),
    "cell": lambda frame: frame.set_cell(frame.cell * (1.0 + 1e-9)),
    "energy": lambda frame: frame.calc.results.update(energy=1e-9),
    "constraint": lambda frame: frame.set_constraint(),
    "no checksum": lambda frame: frame.info.pop("checksum"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_a_changed_frame_is_named_and_nothing_is_written(folder, change, capsys):
    movie = folder / "sweep.traj"
    rewrite(movie, 2, CHANGES[change])
    before = {file: file.read_bytes() for file in folder.iterdir()}
    longer = SCENE.with_values({"path.values": (*SCENE.path.values, 0.4)})
    for scene in (SCENE, longer):
        with pytest.raises(ValueError, match=rf"frame 2 of {movie} is damaged"):
            next(scene.run(folder))
    assert main(["figure", str(folder)]) == 2
    assert f"frame 2 of {movie} is damaged" in capsys.readouterr().err
    assert {file: file.read_bytes() for file in folder.iterdir()} == before


def test_frames_before_a_damaged_one_are_kept_as_the_message_says(folder, whole):
    movie, new = folder / "sweep.traj", folder / "new.traj"
    rewrite(movie, 2, change_force)
    with pytest.raises(ValueError, match="is damaged") as error:
        next(SCENE.run(folder))
    command = f"convert -n :2 {movie} new.traj"
    assert f"'ase {command}'" in str(error.value)
    ase(args=command.replace("new.traj", str(new)).split())
    os.replace(new, movie)
    steps = list(SCENE.run(folder))
    assert steps[:2] == whole[1][:2] and len(steps) == 4


def test_a_frame_that_cannot_be_read_before_others_is_named(folder, monkeypatch):
    def torn(frame):
        if frame.info["load_step"]["step"] == 1:
            raise ValueError("it ends too early")
        return checksum(frame)

    checksum, movie = trajectory.checksum, folder / "sweep.traj"
    monkeypatch.setattr(trajectory, "checksum", torn)
    with pytest.raises(ValueError, match=rf"frame 1 of {movie} is damaged"):
        list(read_frames(movie))


def test_a_damaged_version_field_changes_nothing(folder, whole):
    movie = folder / "sweep.traj"
    data = bytearray(movie.read_bytes())
    data[24] ^= 4
    movie.write_bytes(data)
    assert list(SCENE.run(folder)) == whole[1]


@pytest.mark.filterwarnings("default")
def test_figures_without_the_frames_that_are_cut_off_say_so(folder, capsys):
    movie = folder / "sweep.traj"
    os.truncate(movie, movie.stat().st_size - 400)
    assert len(read_restart(restart_file(movie)).steps) == 3
    assert main(["figure", str(folder)]) == 0
    assert "warning: the last 1 of the 4 frames" in capsys.readouterr().err


def test_a_changed_table_is_written_again_from_the_trajectory(folder, whole):
    table = folder / "curve.csv"
    before = table.read_text()
    table.write_text(before.replace("1", "2"))
    assert list(SCENE.run(folder)) == whole[1]
    assert table.read_text() == before


@pytest.mark.parametrize("control", ["penetrations", "loads"])
def test_frames_with_constraints_are_intact(tmp_path, control):
    sphere, movie = rc.RoughSphere(10.0), tmp_path / "sweep.traj"
    atoms = rc.substrate("Cu", (8, 8), sphere, spacing=1.0, fixed=False)
    last, point = len(atoms) - 1, (*atoms.positions[-1, :2], -1.0)
    spring = Hookean(last, point, 1.0, rt=0.5)
    constraint = spring if control == "loads" else FixAtoms([last])
    atoms.set_constraint(constraint)
    atoms.calc = rc.RoughContact(sphere, 1.0)
    path = rc.load_path(atoms, **{control: [0.1]}, output=rc.Output(trajectory=movie))
    steps = list(path)
    assert read_steps(restart_file(movie)) == steps
    (found,) = [c for frame in read_frames(movie) for c in frame.constraints]
    assert type(found) is type(constraint)


# Lines of a table of which the trajectory keeps only the last frame


def resume(folder, count=4):
    scene = replace(SCENE, path=replace(SCENE.path, values=SCENE.path.values[:count]))
    files = {"trajectory": folder / "last.traj", "csv": folder / "all.csv"}
    return list(scene.relax(keep="last", resume=True, **files))


def test_lines_of_a_table_that_are_of_other_steps_are_an_error(tmp_path):
    resume(tmp_path, 2)
    table = tmp_path / "all.csv"
    changed = table.read_bytes().replace(b"\n0,", b"\n3,", 1)
    table.write_bytes(changed)
    with pytest.raises(ValueError, match=r"first 1 lines of .*all\.csv are not"):
        resume(tmp_path)
    assert table.read_bytes() == changed


def test_lines_of_a_table_that_are_kept_may_be_followed_by_others(tmp_path):
    resume(tmp_path, 2)
    with open(tmp_path / "all.csv", "a") as table:
        table.write("half a li")
    assert [step.step for step in resume(tmp_path)] == [1, 2, 3]
    with open(tmp_path / "all.csv", newline="") as table:
        assert [row["step"] for row in csv.DictReader(table)] == list("0123")


# Random damage


def damaged(data, rng):
    """Return bytes with one change: a bit, a byte, some zeros, a cut, an insertion."""
    place = rng.randrange(len(data) if rng.random() < 0.7 else 60)
    before, after = data[:place], data[place:]
    return rng.choice(
        [
            before + bytes([after[0] ^ (1 << rng.randrange(8))]) + after[1:],
            before + bytes([rng.randrange(256)]) + after[1:],
            before + bytes(min(64, len(after))) + after[64:],
            before,
            before + b"7" + after,
        ]
    )


def numbers(steps):
    return [asdict(replace(step, seconds=0.0)) for step in steps]


@pytest.mark.filterwarnings("ignore:the last .* frames of:RuntimeWarning")
@pytest.mark.parametrize(
    "seed, count", [(1, 60), pytest.param(2, 1000, marks=pytest.mark.slow)]
)
def test_random_damage_is_named_or_changes_nothing(whole, tmp_path, seed, count):
    origin, steps = whole
    rng = random.Random(seed)
    for _ in range(count):
        folder = shutil.copytree(origin, tmp_path / "out", dirs_exist_ok=True)
        file = folder / rng.choice(["sweep.traj"] * 9 + ["curve.csv"])
        data = damaged(file.read_bytes(), rng)
        file.write_bytes(data)
        try:
            kept = len(read_steps(restart_file(folder / "sweep.traj")))
            found = list(SCENE.run(folder))
        except ValueError as error:
            assert str(file) in str(error)
            assert file.read_bytes() == data
        else:  # frames that are cut off are calculated again
            assert numbers(found[:kept]) == numbers(steps[:kept])
            for one, other in zip(found, steps, strict=True):
                assert one.normal_force == pytest.approx(other.normal_force, rel=1e-3)
        shutil.rmtree(folder)
