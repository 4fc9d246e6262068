"""Commands, their output, files and exit status."""

import json
import os
import re
import subprocess
import sys
from contextlib import suppress

import numpy as np
import pytest
from ase.io import read
from small_scene import SMALL

from ase_roughcontact import __version__
from ase_roughcontact._util.files import table_rows
from ase_roughcontact.analysis.view import TAG_INDENTER
from ase_roughcontact.cli import ensembles, main
from ase_roughcontact.cli.parser import make_parser
from ase_roughcontact.ensemble import Progress
from ase_roughcontact.scene import Scene, default_text
from ase_roughcontact.scene.path_kind import PATHS

without_pictures = pytest.mark.usefixtures("no_pictures")


@pytest.fixture
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # of the default database
    file = tmp_path / "small.toml"
    file.write_text(SMALL)
    return file


def test_run_writes_table_trajectories_and_figures(scene, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["run", str(scene), "--out", str(out)]) == 0
    rows = list(table_rows((out / "curve.csv").read_text().splitlines()))
    assert [row["converged"] for row in rows] == ["True", "True"]
    assert len(read(out / "sweep.traj", ":")) == 2
    view = read(out / "view.traj", ":")
    assert [(frame.numbers == 0).sum() for frame in view] == [1, 1]
    surface = [frame.get_tags()[: 32 * 30] < TAG_INDENTER for frame in view]
    assert np.all(surface)
    for name in ("curve.png", "force.png", "contact.png"):
        assert (out / name).read_bytes().startswith(b"\x89PNG")
    text = capsys.readouterr().out
    assert "Eq. (4)" in text and "restored" not in text
    assert {file.name for file in out.iterdir()} <= set(text.split())
    assert f"ase gui -R=-60x {out / 'view.traj'}" in text


@without_pictures
def test_steps_that_do_not_converge_are_marked_and_set_the_exit_status(scene, capsys):
    scene.write_text(SMALL.replace("[solver]", "[solver]\nmax_steps = 1"))
    assert main(["run", str(scene)]) == 1
    assert capsys.readouterr().out.count("NOT CONVERGED") == 2


@without_pictures
def test_steps_that_are_calculated_again_are_not_called_restored(scene, capsys):
    text = scene.read_text()
    scene.write_text(text.replace("[solver]", "[solver]\nmax_steps = 1"))
    assert main(["run", str(scene)]) == 1
    scene.write_text(text)
    capsys.readouterr()
    assert main(["run", str(scene)]) == 0
    assert "restored" not in capsys.readouterr().out
    assert main(["run", str(scene)]) == 0
    assert "restored" in capsys.readouterr().out


def test_the_frame_of_a_step_that_is_not_finished_is_not_shown(scene, tmp_path):
    out, text = tmp_path / "out", scene.read_text()
    scene.write_text(text.replace("last = 0.6\nsteps = 2", "last = 0.2\nsteps = 1"))
    assert main(["run", str(scene), "--out", str(out)]) == 0
    restart = (out / "sweep.restart.npz").read_bytes()
    scene.write_text(text)
    assert main(["run", str(scene), "--out", str(out)]) == 0
    (out / "sweep.restart.npz").write_bytes(restart)  # as of a run that was killed
    assert len(read(out / "sweep.traj", ":")) == 2
    assert main(["maps", str(out)]) == 0
    assert main(["figure", str(out)]) == 0
    assert len(read(out / "view.traj", ":")) == 1


@without_pictures
def test_quiet_prints_nothing_and_json_a_line_per_step(scene, tmp_path, capsys):
    out = str(tmp_path / "out")
    assert main(["run", str(scene), "--out", out, "--quiet"]) == 0
    assert capsys.readouterr().out == ""
    assert main(["run", str(scene), "--out", out]) == 0
    assert capsys.readouterr().out.count("restored") == 2
    assert main(["run", str(scene), "--out", out, "--json"]) == 0
    records = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    assert [record["step"] for record in records] == [0, 1]


def test_steps_before_an_error_are_drawn(scene, tmp_path, capsys):
    out = tmp_path / "out"
    text = SMALL.replace("last = 0.6", "last = 9.0")
    scene.write_text(text.replace('optimizer = "LBFGS"\nfmax = 1e-4', ""))
    assert main(["run", str(scene), "--out", str(out)]) == 2
    printed = capsys.readouterr()
    assert "edge" in printed.err and "contact.png" in printed.out
    assert len(read(out / "view.traj", ":")) == 1
    for name in ("curve.png", "force.png", "contact.png"):
        assert (out / name).exists()


def test_a_run_that_is_interrupted_in_its_first_step_says_that_nothing_is_saved(
    scene, tmp_path, capsys, monkeypatch
):
    def interrupted(*_, **__):
        raise KeyboardInterrupt

    monkeypatch.setattr("ase_roughcontact.RoughContact.calculate", interrupted)
    assert main(["run", str(scene), "--out", str(tmp_path / "out")]) == 130
    assert capsys.readouterr().err == "\ninterrupted; no step was finished\n"


def test_plan_prints_every_step_and_the_memory(scene, capsys):
    assert main(["plan", str(scene)]) == 0
    text = capsys.readouterr().out
    assert text.count("32x30") == 2 and "GB" in text and "Left out" in text
    assert main(["plan", str(scene), "--json"]) == 0
    *steps, totals = map(json.loads, capsys.readouterr().out.splitlines())
    assert (len(steps), totals["steps"], totals["at_least"]) == (2, 2, False)
    assert steps[0]["memory"] <= totals["memory"] < totals["available"]
    assert totals["units"]["files"] == "bytes"


def test_plan_marks_steps_that_can_not_run(scene, capsys):
    scene.write_text(SMALL.replace("last = 0.6", "last = 60.0"))
    assert main(["plan", str(scene)]) == 2
    text = capsys.readouterr().out
    assert text.count("CAN'T RUN") == 1
    assert "1 of 2 steps can't run:\nthe contact is about" in text


def test_plan_and_run_of_a_load_for_which_memory_is_missing_have_one_status(
    scene, capsys
):
    scene.write_text("[substrate]\nmaterial = 'Cu'\n[path]\nvalues = [1e12]\n")
    assert main(["plan", str(scene)]) == 2
    planned = capsys.readouterr().out
    assert "NOT ENOUGH" in planned
    assert main(["run", str(scene)]) == 2
    (least,) = re.findall(r"at least (\d+) x", capsys.readouterr().err)
    assert int(least) < int(re.findall(r"(\d+)x\d+", planned)[0])


def test_a_value_out_of_range_is_an_error_with_file_section_and_key(
    scene, tmp_path, capsys
):
    scene.write_text(SMALL.replace("radius = 60.0", "radius = -1"))
    for command in ("run", "plan", "tradeoff"):
        assert main([command, str(scene)]) == 2
        expected = f"{scene}: [sphere] radius must be a finite number > 0, got -1"
        assert expected in capsys.readouterr().err


@pytest.mark.parametrize(
    "options, message",
    [
        (["--set", "roughness.seed"], "SECTION.KEY=VALUE"),
        (["--set", "roughness.seed="], "SECTION.KEY=VALUE"),
        (["--set", "seed=1"], "unknown section 'seed'"),
        (["--set", "roughness=1"], "[roughness] must be a section, got 1"),
        (["--set", "substrate.periodic=False"], "must be true or false, got 'False'"),
        (["--set", "path.steps=true"], "steps must be an integer >= 1"),
        (["--set", "path.steps=1", "--set", "path.steps=2"], "steps is given twice"),
        (["--database", "mysql://me:secret@host"], "mysql://me:***@host"),
        (["--table", __file__], "was not written by this version of ase-roughcontact"),
    ],
)
def test_invalid_options_of_an_ensemble_are_one_line_on_stderr(
    options, message, scene, capsys
):
    assert main(["ensemble", str(scene), *options]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert message in line and "secret" not in line


@pytest.mark.parametrize(
    "option, key, values",
    [
        ("interaction.kind=hard,repulsive", "kind", ["hard", "repulsive"]),
        ('interaction.kind="hard"', "kind", ["hard"]),
        ("roughness.seed=1,2,3", "seed", [1, 2, 3]),
        ("sphere.radius=50,60.5", "radius", [50.0, 60.5]),
        ("sphere.radius=50,20 nm,'3 nm'", "radius", [50, "20 nm", "3 nm"]),
        ("solver.relative_error=1e-2, 1e-3", "relative_error", [1e-2, 1e-3]),
        ("substrate.shape=auto,[24, 20]", "shape", ["auto", (24, 20)]),
        ("substrate.hardness=inf,2", "hardness", [float("inf"), 2]),
        ("roughness.random_amplitudes=true,false", "random_amplitudes", [True, False]),
    ],
)
def test_values_of_an_ensemble_are_numbers_strings_or_truth_values(
    option, key, values, scene, monkeypatch
):
    given = []

    def run(scenes, *_, **__):
        given.extend(scenes)
        yield Progress(2, 2)

    monkeypatch.setattr(ensembles, "run_ensemble", run)
    assert main(["ensemble", str(scene), "--set", option]) == 0
    title = option.partition(".")[0]
    assert [getattr(getattr(each, title), key) for each in given] == values


@pytest.mark.parametrize(
    "address, shown",
    [
        ("postgresql://me:se/cr@et@host:5432/db", "postgresql://me:***@host:5432/db"),
        ("postgresql://host/db?password=secret&x=1", "//host/db?password=***&x=1"),
        ("postgresql://me@host/db", "postgresql://me@host/db"),
        ("/some:where/a@b.db", "/some:where/a@b.db"),
    ],
)
def test_the_password_of_a_database_is_not_shown(
    address, shown, scene, capsys, monkeypatch
):
    monkeypatch.setattr(ensembles, "run_ensemble", lambda *_, **__: [Progress(2, 2)])
    assert main(["ensemble", str(scene), "--database", address]) == 0
    text = capsys.readouterr().out
    assert text.count(shown) == 2 and "secret" not in text and "se/cr" not in text


def test_progress_in_json_has_null_if_the_time_left_is_unknown(
    scene, capsys, monkeypatch
):
    progress = [Progress(0, 2, 0.5), Progress(2, 2, 1.0, 0.0)]
    monkeypatch.setattr(ensembles, "run_ensemble", lambda *_, **__: progress)
    assert main(["ensemble", str(scene), "--json"]) == 0

    def refuse(word):
        raise ValueError(f"{word} is not JSON")

    lines = capsys.readouterr().out.splitlines()
    first, last = (json.loads(line, parse_constant=refuse) for line in lines)
    assert (first["steps"], first["left"]) == (0, None)
    assert (last["steps"], last["left"]) == (2, 0.0)
    assert first["units"] == last["units"] == {"elapsed": "s", "left": "s"}


@pytest.mark.parametrize(
    "words, first",
    [
        (["--version", "-v"], f"ase-roughcontact {__version__}"),
        (["scene"], default_text().partition("\n")[0]),
        (["run", "--help"], "usage: ase-roughcontact run "),
    ],
    ids=" ".join,
)
def test_texts_are_printed_without_importing_the_dependencies(words, first):
    code = """if True:
        import atexit, sys
        from ase_roughcontact.cli import main
        slow = {"ase", "numpy", "rich", "matplotlib"}
        atexit.register(lambda: print(slow & sys.modules.keys()))
        main(sys.argv[1:])"""
    done = subprocess.run(
        [sys.executable, "-c", code, *words], capture_output=True, text=True
    )
    printed = done.stdout.splitlines()
    assert printed[0].startswith(first) and printed[-1] == "set()"
    if words[0] == "--version":
        names = [line.split()[0].strip(":") for line in printed[1:]]
        assert names[:4] == ["Python", "ase", "numpy", "scipy"]


def test_version_and_commands_are_printed(capsys):
    assert main(["--version"]) == 0 == main([])
    assert "\nusage: ase-roughcontact " in capsys.readouterr().out


@pytest.mark.parametrize(
    "words, hint",
    [
        (["rnu"], "did you mean 'run'?"),
        (["run", "--jsn"], "did you mean '--json'?"),
        (["maps", "out", "--format", "np"], "did you mean 'npz'?"),
        (["ensemble", "--schedular=a"], "did you mean '--scheduler'?"),
        (["places", "my.toml", "--grid", "4"], "must be NxM, such as 4x4, got '4'"),
    ],
)
def test_similar_commands_and_options_are_suggested(words, hint, capsys):
    with pytest.raises(SystemExit) as status:
        main(words)
    assert status.value.code == 2 and hint in capsys.readouterr().err


def test_rows_are_in_colour_and_progress_is_a_bar_on_a_terminal_only(
    scene, tmp_path, capsys
):
    assert main(["run", str(scene), "--out", str(tmp_path / "a")]) == 0
    piped = capsys.readouterr().out
    command = [sys.executable, "-m", "ase_roughcontact", "run", str(scene)]
    options = {"env": os.environ | {"TERM": "xterm-256color", "COLUMNS": "100"}}
    master, slave = os.openpty()
    with subprocess.Popen(
        [*command, "--out", str(tmp_path / "b")], stdout=slave, **options
    ) as process:
        os.close(slave)
        shown = b""
        with suppress(OSError):  # the end of the output
            while part := os.read(master, 65536):
                shown += part
    os.close(master)
    assert process.returncode == 0
    assert "\x1b" not in piped and "━" not in piped
    assert b"\x1b[" in shown and "2/2 steps" in shown.decode()
    lines = piped.splitlines()
    assert max(len(line) for line in lines if str(tmp_path) not in line) <= 80


def test_characters_that_a_terminal_lacks_are_replaced(scene):
    command = [sys.executable, "-m", "ase_roughcontact", "plan", str(scene)]
    ascii_only = os.environ | {"PYTHONIOENCODING": "ascii"}
    done = subprocess.run(command, capture_output=True, env=ascii_only)
    assert (done.returncode, done.stderr) == (0, b"")
    assert b"spacing" in done.stdout and b"?" in done.stdout


def test_scene_prints_the_built_in_scene(capsys):
    assert main(["scene"]) == 0
    assert Scene.parse(capsys.readouterr().out) == Scene.default()
    assert Scene.parse(default_text()) == Scene.default()


def test_a_file_in_place_of_the_folder_is_an_error_that_asks_for_a_folder(
    scene, capsys
):
    assert main(["run", str(scene), "--out", str(scene)]) == 2
    message = f"ase-roughcontact: {scene} is a file, give a folder for the results\n"
    assert capsys.readouterr().err == message


def test_help_fits_80_columns(monkeypatch):
    monkeypatch.setenv("COLUMNS", "80")
    parser = make_parser()
    (commands,) = (action.choices for action in parser._actions if action.choices)
    for command in (parser, *commands.values()):
        assert max(map(len, command.format_help().splitlines())) <= 80, command.prog


def test_the_help_of_run_names_every_kind_of_path(capsys):
    with pytest.raises(SystemExit):
        main(["run", "--help"])
    text = capsys.readouterr().out
    ours = [k for k, v in PATHS.items() if v.__module__.startswith("ase_roughcontact")]
    assert [kind for kind in ours if f'"{kind}"' not in text] == []


INTERRUPTED = """
import os, runpy, signal, sys

class Interrupt:
    def find_spec(self, name, path=None, target=None):
        if name == "numpy":
            os.kill(os.getpid(), signal.SIGINT)

sys.argv = ["ase-roughcontact", "plan"]
signal.signal(signal.SIGINT, signal.default_int_handler)  # as in a terminal
sys.meta_path.insert(0, Interrupt())
runpy.run_module("ase_roughcontact", run_name="__main__")
"""


def test_an_interrupt_while_modules_are_imported_is_a_line():
    done = subprocess.run(
        [sys.executable, "-c", INTERRUPTED], capture_output=True, text=True
    )
    assert (done.returncode, done.stderr) == (130, "\ninterrupted\n")
