"""The command, as a user types it."""

import csv
import subprocess
import sys

import pytest
from ase.io import read
from test_scene import SMALL

from ase_roughcontact.cli import main
from ase_roughcontact.scene import Scene, default_text


@pytest.fixture
def scene(tmp_path):
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    return file


def test_run_leaves_table_trajectory_and_pictures(scene, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["run", str(scene), "--out", str(out)]) == 0
    with open(out / "curve.csv", newline="") as file:
        rows = list(csv.DictReader(file))
    assert [row["converged"] for row in rows] == ["True", "True"]
    assert len(read(out / "sweep.traj", ":")) == 2
    for name in ("curve.png", "contact.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG")
    text = capsys.readouterr().out
    assert "Eq. (4)" in text
    assert f"ase gui {out / 'sweep.traj'}" in text


def test_steps_that_do_not_converge_are_marked_and_tell_in_the_exit_status(
    tmp_path, capsys
):
    file = tmp_path / "short.toml"
    file.write_text(SMALL.replace("[solver]", "[solver]\nmax_steps = 1"))
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 1
    assert capsys.readouterr().out.count("NOT CONVERGED") == 2


def test_scene_prints_a_template_that_can_be_run(capsys):
    assert main(["scene"]) == 0
    assert Scene.parse(capsys.readouterr().out) == Scene.default()
    assert Scene.parse(default_text()) == Scene.default()


def test_a_wrong_scene_is_one_line_on_stderr(tmp_path, capsys):
    file = tmp_path / "wrong.toml"
    file.write_text("[substrat]\n")
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 2
    errors = capsys.readouterr().err
    assert "did you mean 'substrate'" in errors
    assert len(errors.splitlines()) == 1
    assert not (tmp_path / "out").exists()


def test_a_folder_that_can_not_be_made_is_one_line_on_stderr(scene, tmp_path, capsys):
    (tmp_path / "file").touch()
    assert main(["run", str(scene), "--out", str(tmp_path / "file" / "out")]) == 2
    assert "file" in capsys.readouterr().err


@pytest.mark.parametrize("arguments", [["--help"], ["run", "--help"]])
def test_help_tells_of_commands_and_files(arguments, capsys):
    with pytest.raises(SystemExit) as status:
        main(arguments)
    assert status.value.code == 0
    text = capsys.readouterr().out
    wanted = ("run", "scene") if arguments == ["--help"] else ("curve.csv", "--out")
    assert all(word in text for word in wanted)


def test_command_starts_without_matplotlib_being_loaded():
    code = (
        "import sys, ase_roughcontact.cli as cli; cli.main(['scene']); "
        "sys.exit('matplotlib' in sys.modules)"
    )
    assert (
        subprocess.run([sys.executable, "-c", code], capture_output=True).returncode
        == 0
    )
