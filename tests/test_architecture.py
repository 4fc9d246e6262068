"""Imports of the package point downward, and extras stay optional."""

import ast
import os
import re
import subprocess
import sys
from collections import Counter
from functools import cache
from graphlib import CycleError, TopologicalSorter
from pathlib import Path

import pytest

import ase_roughcontact
from ase_roughcontact._util.parts import shown_by

PACKAGE = "ase_roughcontact"
ROOT = Path(ase_roughcontact.__file__).parent
# Packages and modules of the package by layer, from the bottom up.
LAYERS = [
    {"_util"},
    {"theory"},
    {"elasticity", "interactions", "topography"},
    {"contact"},
    {"solvers"},
    {"windows"},
    {"stepping"},
    {"results"},
    {"paths"},
    {"atoms"},
    {"optimize"},
    {"analysis", "loading"},
    {"plot"},
    {"scene"},
    {"path_kinds", "foundation"},
    {"fitting", "tradeoff"},
    {"ensemble"},
    {"cli"},
    {"api", "__main__"},
]
LAYER_OF = {name: layer for layer, names in enumerate(LAYERS) for name in names}
# Packages that show names of others above them, and import them for type checkers.
SHOWING = {"api": "api", "plot.__init__": "plot", "scene.__init__": "scene"}
# What may import a part, which can be deleted: the command line, and what builds on it.
IMPORTERS = {
    "fitting": {"cli"},
    "foundation": set(),
    "path_kinds.loop": {"fitting"},
    "path_kinds.sliding": set(),
    "path_kinds.time": {"fitting"},
    "tradeoff": {"cli"},
}
EXTRAS = ("dask", "ducc0")


def modules():
    """Dotted names within the package, its own front door left out."""
    for path in sorted(ROOT.rglob("*.py")):
        parts = path.relative_to(ROOT).with_suffix("").parts
        if parts != ("__init__",):
            yield ".".join(parts), path


FILES = dict(modules())


def is_module(name):
    return name in FILES or f"{name}.__init__" in FILES


@cache
def imports(module):
    """Modules of the package imported anywhere in `module`, also in functions.

    Of a module in `SHOWING` only what is imported at run time.
    """
    tree = ast.parse(FILES[module].read_text())
    left_out = for_type_checkers(tree) if module in SHOWING else []
    found = set()
    for node in ast.walk(tree):
        if node in left_out:
            continue
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            assert not node.level, f"{module} has a relative import"
            names = [f"{node.module}.{alias.name}" for alias in node.names]
        else:
            continue
        for name in names:
            first, _, inner = name.partition(".")
            if first == PACKAGE:
                found.add(inner if is_module(inner) else inner.rpartition(".")[0])
    return found


def for_type_checkers(tree):
    """Statements of a module under ``if TYPE_CHECKING``."""
    found = []
    for node in tree.body:
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING":
            found += node.body
    return found


@pytest.mark.parametrize("module", SHOWING)
def test_type_checkers_see_the_names_that_are_found_at_run_time(module):
    declared, exported = {}, []
    for node in for_type_checkers(ast.parse(FILES[module].read_text())):
        if isinstance(node, ast.ImportFrom):
            declared |= {alias.name: node.module for alias in node.names}
        else:  # __all__ += [...]
            exported += ast.literal_eval(node.value)
    assert declared == shown_by(SHOWING[module])
    assert sorted(exported) == sorted(declared)


def test_modules_import_only_from_their_own_layer_or_below():
    for module in FILES:
        for other in imports(module):
            assert other, f"{module} must import from a module, not from {PACKAGE}"
            above, below = (name.partition(".")[0] for name in (module, other))
            assert above == below or LAYER_OF[below] < LAYER_OF[above], (
                f"{module} imports {other}"
            )


# What may be transformed by a library itself: kernels of solids, once for each grid and
# in double precision, and heights of indenters.
OWN_TRANSFORMS = {
    "elasticity.crystals.kernel",
    "elasticity.fft",
    "elasticity.fft_backends",
    "elasticity.harmonics",
    "elasticity.spectra",
    "scene.random_fields",
    "topography.interpolation",
    "topography.random_waves",
    "topography.realisation",
    "topography.spectrum",
}


def test_contacts_are_transformed_by_the_engines_alone():
    libraries = re.compile(
        r"scipy(\.| import )fft|import (pyfftw|ducc0)|\.fft\.i?r?fft2"
    )
    found = {name for name, file in FILES.items() if libraries.search(file.read_text())}
    assert found == OWN_TRANSFORMS


def test_no_module_imports_itself_through_others():
    graph = {
        module: {
            other if other in FILES else f"{other}.__init__"
            for other in imports(module)
        }
        for module in FILES
    }
    try:
        order = list(TopologicalSorter(graph).static_order())
    except CycleError as error:
        pytest.fail(f"modules import each other in a circle: {error.args[1]}")
    names = ["_util.validation", "elasticity.halfspace", "contact.contact"]
    assert sorted(names, key=order.index) == names


def package_of(module):
    """Folder of a module as a dotted name; a module beside the packages is its own."""
    return module.rpartition(".")[0] or module


def test_no_package_imports_itself_through_others():
    graph = {}
    for module in FILES:
        uses = {package_of(other) for other in imports(module)}
        graph.setdefault(package_of(module), set()).update(uses)
    for package, uses in graph.items():  # a package and those within it are one
        uses -= {other for other in uses if nested(package, other)}
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        pytest.fail(f"packages import each other in a circle: {error.args[1]}")
    assert graph["contact"] >= {"elasticity", "interactions"}


def nested(package, other):
    """Whether one of two packages is in the other, or they are the same."""
    outer, inner = sorted((f"{package}.", f"{other}."), key=len)
    return inner.startswith(outer)


@pytest.mark.parametrize("part", IMPORTERS)
def test_a_part_is_imported_by_what_builds_on_it_alone(part):
    outside = {
        module.partition(".")[0]
        for module in FILES
        if not nested(package_of(module), part)
        and any(f"{other}.".startswith(f"{part}.") for other in imports(module))
    }
    assert outside == IMPORTERS[part]


def python(code):
    """Standard output of a fresh interpreter, which must end well."""
    done = subprocess.run(
        [sys.executable, "-c", code],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": str(ROOT.parent)},
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def test_no_two_test_files_have_the_same_name():
    names = Counter(path.name for path in Path(__file__).parent.rglob("test_*.py"))
    assert [name for name, count in names.items() if count > 1] == []


def test_importing_the_command_loads_neither_matplotlib_nor_a_scheduler():
    loaded = python(f"import sys, {PACKAGE}.cli; print(*sys.modules)").split()
    assert PACKAGE in loaded
    assert not {"matplotlib", "dask", "distributed", "pandas"} & set(loaded)


def test_every_module_imports_without_the_extras():
    names = [f"{PACKAGE}.{module}".removesuffix(".__init__") for module in FILES]
    code = (
        "import sys\n"
        "from importlib import import_module\n"
        f"sys.modules.update(dict.fromkeys({EXTRAS}))\n"
        f"for name in {names}: import_module(name)\n"
        f"print(*sorted(name for name in sys.modules if {PACKAGE!r} in name))"
    )
    assert set(names) <= set(python(code).split())
