"""Output that is closed or not read, escape codes, and systems other than POSIX."""

import io
import json
import logging
import os
import subprocess
import sys
import warnings
from contextlib import redirect_stdout
from pathlib import Path

import pytest
from terminal import screen_of

from ase_roughcontact._util.extras import silenced
from ase_roughcontact.cli import main
from ase_roughcontact.scene import Scene

SCENE = """
[substrate]
spacing = "1 nm"
contact_modulus = 100.0
hardness = 3.0
[sphere]
radius = "30 nm"
[interaction]
kind = "hard"
[path]
first = 5.0
last = 500.0
steps = 16
"""
COMMAND = [sys.executable, "-m", "ase_roughcontact"]


@pytest.fixture(autouse=True)
def scene(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "scene.toml").write_text(SCENE)


def number_of_steps():
    with open("roughcontact-out/curve.csv") as file:
        return len(file.readlines()) - 1


def test_a_run_with_a_closed_output_goes_on_and_says_so():
    command = " ".join([*COMMAND, "run scene.toml >&-"])
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True)
    assert done.returncode == 0 and number_of_steps() == 16
    assert len(done.stderr.splitlines()) == 1
    assert "closed" in done.stderr


def test_errors_of_a_closed_error_output_do_not_enter_the_output():
    command = " ".join([*COMMAND, "plan nothere.toml 2>&-"])
    done = subprocess.run(["sh", "-c", command], capture_output=True, text=True)
    assert (done.returncode, done.stdout) == (2, "")


def run_with_closed_pipe(words, **options):
    """Run a command with an output that nobody reads."""
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run([*COMMAND, *words], stdout=writer, text=True, **options)
    os.close(writer)
    return done


def test_a_run_with_an_output_that_nobody_reads_calculates_all_steps():
    done = run_with_closed_pipe(["run", "scene.toml"], stderr=subprocess.PIPE)
    assert done.returncode == 0 and number_of_steps() == 16
    assert len(done.stderr.splitlines()) == 1


def test_help_that_nobody_reads_is_no_error():
    done = run_with_closed_pipe(["run", "--help"], stderr=subprocess.PIPE)
    assert done.returncode == 0 and "Traceback" not in done.stderr


def test_there_are_no_escape_codes_but_on_terminals(monkeypatch):
    monkeypatch.setenv("FORCE_COLOR", "1")
    with redirect_stdout(io.StringIO()) as piped:
        assert main(["run", "scene.toml"]) == 0
        assert main(["run", "scene.toml", "--json"]) == 0
        assert main(["report", "roughcontact-out"]) == 0
    assert "LIMITS" in piped.getvalue()  # in colour on terminals
    texts = [piped.getvalue()]
    for name in ("curve.csv", "report.html", "scene.toml"):
        with open(f"roughcontact-out/{name}", encoding="utf-8") as file:
            texts.append(file.read())
    assert not any("\x1b" in text for text in texts)


def test_json_on_a_terminal_is_not_wrapped_by_the_program(monkeypatch):
    status, lines = screen_of(["run", "scene.toml", "--json"], 60, monkeypatch)
    text = "".join(line.ljust(60) for line in lines)
    first, _ = json.JSONDecoder().raw_decode(text)
    assert status == 0 and first["step"] == 0


def test_a_scene_of_a_windows_editor_is_read(tmp_path):
    file = tmp_path / "windows.toml"
    file.write_bytes(b"\xef\xbb\xbf" + SCENE.replace("\n", "\r\n").encode())
    assert Scene.read(file) == Scene.read("scene.toml")


ON_WINDOWS = """
from windows_system import pretend

pretend()
from concurrent.futures import ThreadPoolExecutor
from ase_roughcontact._util.locks import lock
from ase_roughcontact.ensemble import run_ensemble
from ase_roughcontact.scene import Scene

scene = Scene.read("scene.toml").with_values({"output.keep": "last"})
path = scene.run("out")
next(path)
with lock("out/sweep.traj.lock") as free:
    assert not free
path.close()
list(scene.run("out"))
list(run_ensemble([scene], "cases.db", ThreadPoolExecutor(1)))
"""


@pytest.mark.skipif(not Path("/proc/self/fd").exists(), reason="needs Linux's /proc")
def test_runs_and_ensembles_work_without_what_windows_lacks():
    command = [sys.executable, "-X", "warn_default_encoding", "-c", ON_WINDOWS]
    folders = os.pathsep.join([str(Path(__file__).parents[1]), *sys.path])
    done = subprocess.run(
        command,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": folders},
    )
    assert done.returncode == 0, done.stderr
    assert len(Path("out/curve.csv").read_text("utf-8").splitlines()) == 1 + 16
    assert Path("cases.db").exists() and not list(Path().rglob("*.lock"))


def test_what_a_library_warns_of_and_logs_is_silenced_but_its_errors(capfd):
    with pytest.raises(OSError, match="damaged"), silenced():
        warnings.warn("tzname EST identified but not understood", stacklevel=1)
        logging.getLogger("library").error("Loader failed. Traceback follows.")
        raise OSError("damaged")
    assert capfd.readouterr().err == ""
    with pytest.warns(UserWarning, match="ours"):
        warnings.warn("ours", stacklevel=1)


def test_the_warning_of_a_library_has_its_name(monkeypatch, capsys):
    namespace = {"__name__": "dateutil.parser"}
    exec("import warnings\ndef warn(): warnings.warn('no time zone')", namespace)

    def text_of(options):
        warnings.simplefilter("always")
        namespace["warn"]()
        return "", "default.toml"

    monkeypatch.setattr("ase_roughcontact.cli.common.scene_text", text_of)
    main(["plan", "scene.toml"])
    assert "dateutil: no time zone" in capsys.readouterr().err


@pytest.mark.parametrize("command", ["figure", "report", "maps"])
def test_a_folder_without_a_run_is_named(command, capsys):
    assert main([command, "nothere"]) == 2
    assert "nothere" in capsys.readouterr().err


def test_a_number_of_steps_in_quotes_should_be_a_whole_number(capsys):
    text = SCENE.replace("steps = 16", 'steps = "13"')
    with pytest.raises(ValueError, match=r"steps .*'13'"):
        _ = Scene.parse(text).targets
