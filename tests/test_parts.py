"""Parts of the package are found by their folders; each can be deleted."""

import os
import re
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from ase_roughcontact._util.parts import found_parts, shown_by

ROOT = Path(__file__).parents[1]
PACKAGE = "ase_roughcontact"
# What is deleted with a part: its commands, and parts that build on it with theirs.
FITS = ("fitting", "cli/fit.py", "cli/curve.py", "cli/curves.py", "cli/curves_page.py")
DELETED_WITH = {
    "fitting": FITS,
    "foundation": ("foundation",),
    "path_kinds/loop": ("path_kinds/loop", *FITS),
    "path_kinds/sliding": ("path_kinds/sliding",),
    "path_kinds/time": ("path_kinds/time", *FITS),
    "tradeoff": ("tradeoff", "cli/tradeoff.py"),
}
# How tests call a part, beside its folder and the names of its ``SHOWN``.
WORDS = {
    "fitting": ['"fit"', '"curve"', '"curves"'],
    "path_kinds/sliding": ["sliding_contacts"],
}
# Tests of the pages and examples, which show all parts, and of the layout.
OF_ALL = (
    "test_architecture",
    "test_documentation",
    "test_examples",
    "test_gallery",
    "test_parts",
    "test_published",
)
# Imports all modules of the folder in which it runs, and then runs a test file. An
# editable installation of the package would stand in for modules that are missing.
CHECK = f"""
import sys
from importlib import import_module
from pkgutil import walk_packages

sys.meta_path[:] = [each for each in sys.meta_path if "ditable" not in repr(each)]
import {PACKAGE}
import pytest


def check():
    assert {PACKAGE}.__file__.startswith(sys.path[0])
    for module in walk_packages({PACKAGE}.__path__, "{PACKAGE}."):
        import_module(module.name)
    for name in import_module("{PACKAGE}.api").__all__:
        getattr({PACKAGE}, name)
    return pytest.main([*sys.argv[1:], "-q", "-p", "no:cacheprovider"])


if __name__ == "__main__":  # and not in workers of ensembles
    sys.exit(check())
"""


# A kind of path in a folder of its own.
KIND = """
from dataclasses import dataclass
import numpy as np
from ase_roughcontact.scene.path_kind import PathKind

@dataclass(frozen=True)
class Twice(PathKind):
    kind = "twice"
    control = "penetration"
    depth: float = 0.0

    def targets(self, bodies):
        return np.array([self.depth, self.depth])
"""
# What a scene file knows of it.
USE = """
from ase_roughcontact.scene import Scene, Twice

text = 'substrate = { material = "Cu" }\\npath = { kind = "twice", depth = 0.2 }'
scene = Scene.parse(text)
assert isinstance(scene.path, Twice)
print(*scene.targets)
"""


def test_a_folder_of_a_kind_of_path_is_found_by_scenes(tmp_path):
    unused = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / PACKAGE, tmp_path / PACKAGE, ignore=unused)
    folder = tmp_path / PACKAGE / "path_kinds" / "twice"
    folder.mkdir()
    (folder / "__init__.py").write_text('SHOWN = {"scene": {"Twice": "scene"}}\n')
    (folder / "scene.py").write_text(KIND)
    (tmp_path / "use.py").write_text(USE)
    done = run(tmp_path, "use.py")
    assert (done.returncode, done.stdout) == (0, "0.2 0.2\n"), done.stderr


def copied(folder, part):
    """Copy the package and its tests without a part."""
    unused = shutil.ignore_patterns("__pycache__")
    for name in (PACKAGE, "tests", "examples", ".ci"):
        shutil.copytree(ROOT / name, folder / name, ignore=unused)
    for file in ROOT.glob("*.*"):
        if file.is_file():
            shutil.copy(file, folder)
    for deleted in DELETED_WITH[part]:
        path = folder / PACKAGE / deleted
        shutil.rmtree(path) if path.is_dir() else path.unlink()
        shutil.rmtree(folder / "tests" / deleted, ignore_errors=True)


def run(folder, script, *arguments):
    """Run a script in a folder with the package in it."""
    return subprocess.run(
        [sys.executable, script, *arguments],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(folder)},
        capture_output=True,
        text=True,
    )


def passes(folder, *tests):
    """Whether all modules in a folder can be imported, and some tests pass."""
    (folder / "check.py").write_text(CHECK)
    done = run(folder, "check.py", *tests)
    return done.returncode == 0, done.stdout[-5000:] + done.stderr[-5000:]


@pytest.mark.parametrize("part", DELETED_WITH)
def test_the_package_is_imported_and_used_without_a_part(tmp_path, part):
    copied(tmp_path, part)
    ok, output = passes(tmp_path, "tests/scene/test_scene_messages.py")
    assert ok, output


@pytest.mark.slow  # minutes each
@pytest.mark.parametrize("part", DELETED_WITH)
def test_tests_of_the_rest_pass_without_a_part(tmp_path, part):
    copied(tmp_path, part)
    for file in (tmp_path / "tests").rglob("*.py"):
        if file.stem in OF_ALL or uses(file, DELETED_WITH[part]):
            file.unlink()
    ok, output = passes(tmp_path, "tests", PACKAGE)
    assert ok, output


def uses(file, deleted):
    """Whether a test file names one of the parts that are deleted, or a command."""
    words = []
    for each in deleted:
        if each.endswith(".py"):
            continue
        dotted = each.replace("/", ".")
        kind = dotted.rpartition(".")[2]
        shown = import_module(f"{PACKAGE}.{dotted}").SHOWN
        words += [dotted, f'kind = "{kind}"', f'"{kind}"', *WORDS.get(each, ())]
        words += [rf"\b{name}\b" for names in shown.values() for name in names]
        words.append(f"{kind}_scene")
    return re.search("|".join(words), file.read_text()) is not None


def test_the_parts_that_are_found_are_those_that_can_be_deleted():
    assert {part.replace(".", "/") for part in found_parts()} == set(DELETED_WITH)


@pytest.mark.parametrize("package", ["plot", "scene"])
def test_names_of_parts_are_names_of_the_package_that_shows_them(package):
    module = import_module(f"{PACKAGE}.{package}")
    shown = shown_by(package)
    assert shown and set(shown) < set(module.__all__)
    for name, origin in shown.items():
        assert getattr(module, name).__module__ == origin
    with pytest.raises(AttributeError, match="no_such_name"):
        module.no_such_name  # noqa: B018
