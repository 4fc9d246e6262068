"""The entry point in ASE's plugin system."""

import importlib
import sys
from pathlib import Path

import pytest

from ase_roughcontact import RoughContact
from ase_roughcontact.atoms import plugin
from ase_roughcontact.loading.frame_file import MAGIC

if sys.version_info < (3, 11):
    import tomli as tomllib
else:
    import tomllib

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"


def test_plugin_is_the_calculator():
    pytest.importorskip("ase._4.plugins.plugin")
    (calculator,) = plugin.__ase_plugins__
    assert (calculator.name, calculator()) == ("roughcontact", RoughContact)


def test_project_registers_the_module_of_the_plugin():
    project = tomllib.loads(PYPROJECT.read_text())["project"]
    (name,) = project["entry-points"]["ase.plugins"].values()
    assert importlib.import_module(name) is plugin


def test_module_is_empty_where_ase_has_no_such_plugins(monkeypatch):
    monkeypatch.setitem(sys.modules, "ase._4.plugins.plugin", None)
    try:
        assert importlib.reload(plugin).__ase_plugins__ == set()
    finally:
        monkeypatch.undo()
        importlib.reload(plugin)


def test_project_registers_the_format_of_frames():
    project = tomllib.loads(PYPROJECT.read_text("utf-8"))["project"]
    (name,) = project["entry-points"]["ase.ioformats"].values()
    module, _, attribute = name.partition(":")
    frames = getattr(importlib.import_module(module), attribute)
    assert MAGIC.startswith(frames.magic)
    assert importlib.import_module(frames.module).read_roughcontact
