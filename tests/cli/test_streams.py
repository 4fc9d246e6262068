"""Output that is closed or not read, escape codes, and systems other than POSIX."""

import io
import json
import logging
import os
import subprocess
import sys
import warnings
from contextlib import redirect_stdout

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


WITHOUT_POSIX = """
import builtins, os, random, signal, sys
import_module = builtins.__import__

def imported(name, globals=None, locals=None, fromlist=(), level=0):
    importer = (globals or {}).get("__name__", "")
    if name in ("fcntl", "resource") and importer.startswith("ase_roughcontact"):
        raise ImportError(name)
    return import_module(name, globals, locals, fromlist, level)

builtins.__import__ = imported
del os.register_at_fork, os.sched_getaffinity, signal.pthread_sigmask
from ase_roughcontact.cli import main
sys.exit(main(sys.argv[1:]))
"""


def test_without_posix_a_run_says_that_there_are_no_locks():
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_POSIX, "run", "scene.toml"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0 and number_of_steps() == 16
    assert "no locks" in done.stderr and "Traceback" not in done.stderr


def test_without_posix_an_ensemble_says_in_a_line_that_it_needs_locks():
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT_POSIX, "ensemble", "scene.toml"],
        capture_output=True,
        text=True,
    )
    assert done.returncode == 2 and "locks" in done.stderr
    assert "Traceback" not in done.stderr


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
        Scene.parse(text)
