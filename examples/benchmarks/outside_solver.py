"""Parts of the processor time of a run: the solver, and what is around it.

    OMP_NUM_THREADS=1 python outside_solver.py                # the built-in scene
    OMP_NUM_THREADS=1 python outside_solver.py my.toml ...    # other scenes

prints a table in Markdown, for the second of two runs of each scene; the first one
imports packages. Solutions of equations are the solver: the relaxation of the normal
and the lateral contact, the contact stiffness, conductances, and errors that the
relaxation leaves. What is left are windows, elastic kernels, and areas by the fields at
the edge of the contact ("other"), the columns of the table, and files.
"""

import argparse
import tempfile
from collections import defaultdict
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from functools import wraps
from pathlib import Path
from time import process_time
from typing import Any
from unittest.mock import patch

from markdown import table

from ase_roughcontact.loading import trajectory
from ase_roughcontact.loading.path_atoms import ProblemAtoms
from ase_roughcontact.path_kinds.sliding import steps as sliding
from ase_roughcontact.paths.restart import RestartWriter
from ase_roughcontact.results import record
from ase_roughcontact.scene import Scene
from ase_roughcontact.solvers.relaxation import SolverRelaxer
from ase_roughcontact.stepping import relaxed

# Owners and names of the functions that are timed, by the part of a run.
PARTS = {
    "solver": [
        (SolverRelaxer, "__call__"),
        (relaxed, "height_response"),
        (relaxed, "relaxation_errors"),
        (record, "region_conductance"),
        (sliding, "slip_at_bounds"),
        (sliding, "follow_slip"),
    ],
    "frames": [(ProblemAtoms, "frame"), (trajectory, "packed")],
    "restart file": [(RestartWriter, "add")],
    "area at the edge": [(relaxed, "edge_area")],
}


class Clock:
    """Processor time in functions, without functions within that are timed, too."""

    def __init__(self) -> None:
        self.spent: dict[str, float] = defaultdict(float)
        self._inner = [0.0]

    def timed(self, part: str, function: Callable[..., Any]) -> Callable[..., Any]:
        """Return a function that adds its time to a part."""

        @wraps(function)
        def measured(*arguments: Any, **options: Any) -> Any:
            begun = process_time()
            self._inner.append(0.0)
            try:
                return function(*arguments, **options)
            finally:
                time = process_time() - begun
                self.spent[part] += time - self._inner.pop()
                self._inner[-1] += time

        return measured


@contextmanager
def timed_parts() -> Iterator[Clock]:
    """Time the functions of all parts within a context."""
    clock = Clock()
    with ExitStack() as patches:
        for part, functions in PARTS.items():
            for owner, name in functions:
                function = clock.timed(part, getattr(owner, name))
                patches.enter_context(patch.object(owner, name, function))
        yield clock


def shares(scene: Scene) -> dict[str, float]:
    """Return the part of each kind of work in the processor time of a run."""
    with tempfile.TemporaryDirectory() as folder, timed_parts() as clock:
        begun = process_time()
        for _ in scene.run(Path(folder) / "run", validity="ignore"):
            pass
        whole = process_time() - begun
    found = {part: clock.spent[part] / whole for part in PARTS}
    return found | {"other": 1.0 - sum(found.values())}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("scenes", nargs="*", help="scene files")
    names = parser.parse_args().scenes or ["built-in"]
    rows = []
    for name in names:
        for _ in range(2):
            scene = Scene.default() if name == "built-in" else Scene.read(name)
            found = shares(scene)
        rows.append([Path(name).stem, *(f"{share:.2f}" for share in found.values())])
    table(" | ".join(["scene", *PARTS, "other"]), rows)


if __name__ == "__main__":
    main()
