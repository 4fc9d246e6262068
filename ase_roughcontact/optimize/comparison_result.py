"""Results of compared optimizers, and their table."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from ase_roughcontact._util.printing import Printed, table
from ase_roughcontact._util.summary import Summarized


@dataclass(frozen=True)
class Progress:
    """Costs and error of an optimizer after a step.

    Attributes
    ----------
    steps : int
        Number of steps so far.
    evaluations : int
        Number of evaluations of energy and forces so far; for a solver of this package,
        the number of its states.
    pairs : float
        Number of FFT pairs so far.
    seconds : float
        Time so far (s).
    error : float
        Relative error of the state.
    """

    steps: int
    evaluations: int
    pairs: float
    seconds: float
    error: float


@dataclass(frozen=True)
class OptimizerResult(Summarized):
    """Result of an optimizer.

    Attributes
    ----------
    optimizer : str
        Name of the optimizer.
    converged : bool
        Whether the optimizer has converged.
    reason : str
        Reason why it has not converged, or the other state in which it ended; otherwise
        empty.
    steps, evaluations, pairs, seconds
        Costs at the end; see `Progress`.
    evaluations_to_accuracy, pairs_to_accuracy, seconds_to_accuracy : float
        Costs until the error stayed below the accuracy; NaN if it did not.
    error, force_error, area_error : float
        Relative errors at the end; NaN if the optimizer did not start.
    height_error : float
        Error of the height (Å).
    changed_atoms : int
        Number of atoms in contact in either the last or the relaxed state, but not in
        both; -1 if the optimizer did not start.
    energy_error : float
        Energy minus the energy of the relaxed state (eV).
    history : tuple of Progress
        Costs and errors after each step; not a column.
    """

    optimizer: str
    converged: bool = False
    reason: str = ""
    steps: int = 0
    evaluations: int = 0
    pairs: float = 0.0
    seconds: float = 0.0
    evaluations_to_accuracy: float = math.nan
    pairs_to_accuracy: float = math.nan
    seconds_to_accuracy: float = math.nan
    error: float = math.nan
    force_error: float = math.nan
    area_error: float = math.nan
    height_error: float = math.nan
    changed_atoms: int = -1
    energy_error: float = math.nan
    history: tuple[Progress, ...] = field(default=(), repr=False)

    def reached(self, error: float) -> Progress | None:
        """Return the progress after which the error stays within a limit.

        Parameters
        ----------
        error : float
            Largest relative error of the state.

        Returns
        -------
        Progress or None
            Progress; None if the error at the end is above the limit.
        """
        return reached(self.history, error)


@dataclass(frozen=True)
class OptimizerComparison(Summarized, Printed):
    """Results of several optimizers on the same atoms; printed as a table.

    Attributes
    ----------
    accuracy : float
        Wanted relative error of force and area.
    fmax : float
        Tolerance of forces for this error (eV/Å).
    energy, normal_force : float
        Energy and normal force of the relaxed state (eV, eV/Å).
    contact_atoms : int
        Number of atoms in contact in the relaxed state.
    results : tuple of OptimizerResult
        Result of each optimizer.
    """

    accuracy: float
    fmax: float
    energy: float
    normal_force: float
    contact_atoms: int
    results: tuple[OptimizerResult, ...]

    @property
    def parts(self) -> Sequence[Any]:
        """Texts and tables, from top to bottom."""
        percent = f"{100.0 * self.accuracy:.2g} %"
        about = (
            f"{self.contact_atoms} atoms in contact, {self.normal_force:.4g} eV/Å, "
            f"{self.energy:.8g} eV; forces to {self.fmax:.2g} eV/Å, for an error of "
            f"{percent}"
        )
        heads = (
            "optimizer",
            "steps",
            "force (calls)",
            "FFT (pairs)",
            "time (s)",
            f"to {percent} (pairs)",
            "error",
            "atoms",
            "energy (eV)",
        )
        rows = [
            (
                each.optimizer,
                each.steps,
                each.evaluations,
                f"{each.pairs:.0f}",
                f"{each.seconds:.2f}",
                _text(each.pairs_to_accuracy, ".0f"),
                _text(each.error, ".1e"),
                f"{each.changed_atoms}" if each.changed_atoms >= 0 else "-",
                _text(each.energy_error, "+.1e"),
            )
            for each in self.results
        ]
        failures = [f"{r.optimizer}: {r.reason}" for r in self.results if r.reason]
        return [about, table(heads, rows, 1), *failures]

    def write_csv(self, file: str | Path) -> None:
        """Write the results as CSV, a line for each optimizer.

        Parameters
        ----------
        file : str or Path
            File to write.
        """
        names = [each.name for each in fields(OptimizerResult)][:-1]
        with open(file, "w", newline="", encoding="utf-8") as opened:
            writer = csv.DictWriter(opened, names, extrasaction="ignore")
            writer.writeheader()
            writer.writerows(asdict(result) for result in self.results)

    def check(self, *, atoms: int = 0, energy: float = 1e-3) -> None:
        """Raise `AssertionError` if an optimizer has not found the relaxed state.

        This is for tests: all optimizers must have converged, with the same atoms in
        contact and the same energy.

        Parameters
        ----------
        atoms : int
            Largest number of atoms with changed contact.
        energy : float
            Largest difference of the energy (eV).
        """
        wrong = []
        for result in self.results:
            if not result.converged:
                wrong.append(f"{result.optimizer}: {result.reason}")
            elif result.changed_atoms > atoms or not abs(result.energy_error) <= energy:
                wrong.append(
                    f"{result.optimizer}: {result.changed_atoms} other atoms in "
                    f"contact, energy off by {result.energy_error:.2g} eV"
                )
        if wrong:
            limits = f"{atoms} atoms and {energy:g} eV"
            raise AssertionError(
                f"not the same state within {limits}: " + "; ".join(wrong)
            )


def reached(history: Sequence[Progress], error: float) -> Progress | None:
    """Return the progress after which the error stays within a limit."""
    found = None
    for progress in reversed(history):
        if not progress.error <= error:
            break
        found = progress
    return found


def _text(value: float, form: str) -> str:
    """Return a number as text; "-" if it is not known."""
    return "-" if math.isnan(value) else format(value, form)
