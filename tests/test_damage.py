"""Damaged files: the same numbers or an error that names file and frame, no third."""

import os
import random
import shutil
from dataclasses import asdict, replace

import pytest
from ase.constraints import FixAtoms, Hookean
from ase.io import read
from small_scene import PERIODIC

import ase_roughcontact as rc
from ase_roughcontact.cli import main
from ase_roughcontact.loading.trajectory import read_frames
from ase_roughcontact.paths.restart import read_steps, restart_file
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


def change(file, place):
    """Change a bit of a file, at a part of its length."""
    data = bytearray(file.read_bytes())
    data[int(place * len(data))] ^= 4
    file.write_bytes(data)


@pytest.mark.parametrize("name", ["sweep.traj", "sweep.restart.npz"])
def test_a_changed_file_is_named_and_nothing_is_written(folder, name, capsys):
    file = folder / name
    change(file, 0.6)
    before = {each: each.read_bytes() for each in folder.iterdir()}
    longer = SCENE.with_values({"path.values": (*SCENE.path.values, 0.4)})
    for scene in (SCENE, longer):
        with pytest.raises(ValueError, match=rf"{file} is damaged"):
            next(scene.run(folder))
    assert main(["figure", str(folder)]) == 2
    assert f"{file} is damaged" in capsys.readouterr().err
    assert {each: each.read_bytes() for each in folder.iterdir()} == before


def test_a_damaged_frame_has_a_number(folder):
    change(folder / "sweep.traj", 0.6)
    with pytest.raises(ValueError, match="frame 2 of"):
        list(read_frames(folder / "sweep.traj"))


@pytest.mark.parametrize("name", ["sweep.traj", "curve.csv"])
def test_a_run_without_its_frames_or_table_goes_on(folder, whole, name):
    (folder / name).unlink()
    longer = SCENE.with_values({"path.values": (*SCENE.path.values, 0.4)})
    steps = list(longer.run(folder))
    assert steps[:4] == whole[1] and len(steps) == 5
    assert len(read(folder / "sweep.traj", ":")) == (1 if name == "sweep.traj" else 5)


def test_frames_without_their_restart_file_are_not_written_over(folder):
    (folder / "sweep.restart.npz").unlink()
    before = (folder / "sweep.traj").read_bytes()
    with pytest.raises(ValueError, match="restore the restart file"):
        next(SCENE.run(folder))
    assert (folder / "sweep.traj").read_bytes() == before


@pytest.mark.filterwarnings("default")
def test_figures_without_the_frame_that_is_cut_off_say_so(folder, capsys):
    movie = folder / "sweep.traj"
    os.truncate(movie, movie.stat().st_size - 400)
    assert main(["figure", str(folder)]) == 0
    assert f"warning: frame 3 of {movie} is cut off" in capsys.readouterr().err


def test_a_changed_table_is_written_again(folder, whole):
    table = folder / "curve.csv"
    before = table.read_text()
    table.write_text(before.replace("1", "2"))
    assert list(SCENE.run(folder)) == whole[1]
    assert table.read_text() == before


REMOVED = ["sweep.traj", "curve.csv", "."]


@pytest.mark.parametrize("name", REMOVED)
def test_files_that_are_removed_are_missed_at_the_next_step(tmp_path, whole, name):
    """All that was calculated is in the restart file, which may be a new one."""
    folder = tmp_path / "out"
    steps = SCENE.run(folder)
    found = [next(steps), next(steps)]
    if name == ".":
        shutil.rmtree(folder)
    else:
        (folder / name).unlink()
    with pytest.raises(OSError, match="removed or replaced"):
        next(steps)
    kept = read_steps(folder / "sweep.restart.npz")
    assert kept[:2] == found and len(kept) == 3
    assert numbers(SCENE.run(folder)) == numbers(whole[1])


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


@pytest.mark.filterwarnings("ignore:frame .* is cut off:RuntimeWarning")
@pytest.mark.parametrize(
    "seed, count", [(1, 60), pytest.param(2, 1000, marks=pytest.mark.slow)]
)
def test_random_damage_is_named_or_changes_nothing(whole, tmp_path, seed, count):
    origin, steps = whole
    rng = random.Random(seed)
    for _ in range(count):
        folder = shutil.copytree(origin, tmp_path / "out", dirs_exist_ok=True)
        names = ["sweep.traj"] * 5 + ["sweep.restart.npz"] * 5 + ["curve.csv"]
        file = folder / rng.choice(names)
        data = damaged(file.read_bytes(), rng)
        file.write_bytes(data)
        try:
            found = list(SCENE.run(folder))
        except ValueError as error:
            assert str(file) in str(error)
            assert file.read_bytes() == data
        else:
            assert numbers(found) == numbers(steps)
        shutil.rmtree(folder)
