"""Type checkers and completion see what functions take and return."""

import inspect
import subprocess
import sys
from collections.abc import Generator
from importlib import import_module
from pathlib import Path
from typing import get_args, get_type_hints

import pytest
import typed_script

import ase_roughcontact as rc

ROOT = Path(__file__).resolve().parents[1]
SCRIPT = ROOT / "tests" / "typed_script.py"
PATHS = [rc.sliding_path, rc.time_path, rc.adhesion_loop]
SHARED = "optimizer", "fmax", "accuracy", "max_steps", "window", "validity", "output"
# Functions with any keyword: options of ASE, and values that a user names.
WITH_ANY_KEYWORD = {
    "ActiveSet",
    "NewtonKrylov",
    "on_modes",
    "read_ensemble",
    "snapshot",
    "write_csv",
}


def parameters(function):
    return inspect.signature(function).parameters


def takes_any_value(parameter):
    """Whether it stands for keywords that are not named, and not for an error."""
    return (
        parameter.kind is parameter.VAR_KEYWORD and parameter.annotation != "NoReturn"
    )


@pytest.mark.parametrize("path", PATHS)
@pytest.mark.parametrize("name", SHARED)
def test_options_of_steps_have_the_type_and_default_of_load_path(path, name):
    mine, other = parameters(path)[name], parameters(rc.load_path)[name]
    assert (mine.annotation, mine.default) == (other.annotation, other.default)


@pytest.mark.parametrize(
    "path, step",
    [
        (rc.load_path, rc.LoadStep),
        (rc.sliding_path, rc.SlidingStep),
        (rc.time_path, rc.TimeStep),
    ],
)
def test_paths_return_steps_of_their_own_class(path, step):
    assert get_type_hints(path)["return"] == Generator[step, None, None]


@pytest.mark.parametrize(
    "function, name, words",
    [
        (rc.load_path, "window", {"fixed", "unchecked", "auto"}),
        (rc.load_path, "accuracy", {"fast", "normal", "high"}),
        (rc.load_path, "validity", {"warn", "raise", "ignore"}),
        (rc.sliding_path, "coupling", {"neglected", "solved"}),
        (rc.Output, "keep", {"thinned", "all", "last"}),
    ],
)
def test_words_are_types(function, name, words):
    hint = get_type_hints(function)[name]
    members = [hint, *get_args(hint)]
    assert words in [set(get_args(each)) for each in members]


def test_parameters_of_the_calculator_are_keywords():
    names = {*parameters(rc.RoughContact)}
    assert names == {*rc.RoughContact.default_parameters, "atoms", "unknown"}


@pytest.mark.parametrize(
    "package", ["", ".analysis", ".ensemble", ".plot", ".scene", ".theory"]
)
def test_public_functions_take_no_keyword_that_they_do_not_name(package):
    module = import_module(f"ase_roughcontact{package}")
    public = {name: getattr(module, name) for name in module.__all__}
    open_ended = {
        name
        for name, each in public.items()
        if callable(each)
        and not (isinstance(each, type) and issubclass(each, Warning))
        and not getattr(each, "_is_protocol", False)
        and any(takes_any_value(p) for p in parameters(each).values())
    }
    assert open_ended <= WITH_ANY_KEYWORD


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_the_typed_script_runs():
    assert typed_script.press()[0] > 0.0
    assert typed_script.slide() > 0.0
    assert typed_script.wait() > 0.0


@pytest.mark.slow  # reads the whole package
def test_mypy_accepts_correct_code_and_finds_each_mistake(tmp_path, monkeypatch):
    api = pytest.importorskip("mypy.api")
    monkeypatch.setenv("MYPYPATH", str(ROOT))
    options = ["--strict", "--config-file=", "--follow-imports=silent"]
    found, errors, status = api.run([*options, f"--cache-dir={tmp_path}", str(SCRIPT)])
    assert not status, found + errors


@pytest.mark.slow
def test_pyright_accepts_correct_code_and_finds_each_mistake(tmp_path):
    pytest.importorskip("basedpyright", reason="needs the extra pyright")
    (tmp_path / "pyrightconfig.json").write_text(
        f"""{{
            "include": ["{SCRIPT.as_posix()}"],
            "extraPaths": ["{ROOT.as_posix()}"],
            "typeCheckingMode": "standard",
            "reportUnnecessaryTypeIgnoreComment": "error"
        }}"""
    )
    command = [sys.executable, "-m", "basedpyright", "-p", str(tmp_path)]
    options = ["--pythonpath", sys.executable]
    found = subprocess.run([*command, *options], capture_output=True, text=True)
    assert not found.returncode, found.stdout
