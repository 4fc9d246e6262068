"""Results of optimizers that were compared, and their table."""

from __future__ import annotations

import csv
import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from ase_roughcontact._util.printing import Printed, table


@dataclass(frozen=True)
class Progress:
    """State of an optimizer after a step.

    Attributes
    ----------
    steps : int
    evaluations : int
        Of energy and forces so far; of a solver of this package, its states.
    pairs : float
        FFT pairs so far.
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
class OptimizerResult:
    """What one optimizer did.

    Attributes
    ----------
    optimizer : str
        Its name.
    converged : bool
    reason : str
        Why it has not converged, or in which other state it ended; else empty.
    steps, evaluations, pairs, seconds
        At the end; see `Progress`.
    evaluations_to_accuracy, pairs_to_accuracy, seconds_to_accuracy : float
        Until the error stayed below the accuracy; NaN if it did not.
    error, force_error, area_error : float
        Relative errors at the end; NaN if it did not start.
    height_error : float
        Error of the height (Å).
    changed_atoms : int
        Atoms in contact in one state only, in the last or in the relaxed one; -1 if it
        did not start.
    energy_error : float
        Energy above that of the relaxed state (eV).
    history : tuple of Progress
        Not a column.
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
        """Return the moment after which the error stays within a limit.

        Parameters
        ----------
        error : float
            Relative error of the state.

        Returns
        -------
        Progress or None
            None if it does not.
        """
        return reached(self.history, error)


@dataclass(frozen=True)
class OptimizerComparison(Printed):
    """Results of several optimizers on the same atoms; printed as a table.

    Attributes
    ----------
    accuracy : float
        Relative error of force and area.
    fmax : float
        Tolerance of forces for it (eV/Å).
    energy, normal_force : float
        Of the relaxed state (eV, eV/Å).
    contact_atoms : int
        Of the relaxed state.
    results : tuple of OptimizerResult
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
        """Write a line for each optimizer.

        Parameters
        ----------
        file : str or Path
        """
        names = [each.name for each in fields(OptimizerResult)][:-1]
        with open(file, "w", newline="", encoding="utf-8") as opened:
            writer = csv.DictWriter(opened, names, extrasaction="ignore")
            writer.writeheader()
            writer.writerows(asdict(result) for result in self.results)

    def check(self, *, atoms: int = 0, energy: float = 1e-3) -> None:
        """Raise `AssertionError` unless all optimizers have found the relaxed state.

        For tests: all have converged, to the same atoms in contact and energy.

        Parameters
        ----------
        atoms : int
            Largest number of other atoms in contact.
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
    """Return the moment after which the error stays within a limit."""
    found = None
    for progress in reversed(history):
        if not progress.error <= error:
            break
        found = progress
    return found


def _text(value: float, form: str) -> str:
    """Return a number as text; "-" if it is not known."""
    return "-" if math.isnan(value) else format(value, form)
