"""Steps outside of the validity of the model, and the hardness to compare with."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, TypeAlias, get_args

import numpy as np

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.units import UNITS
from ase_roughcontact._util.validation import instance_of, one_of, positive
from ase_roughcontact.contact import Problem
from ase_roughcontact.elasticity.material import HARDNESS, fcc_spacing
from ase_roughcontact.elasticity.named_materials import hardness_bound
from ase_roughcontact.results.limits import failed_checks
from ase_roughcontact.windows.regrid import GridChange, lost_text

# Largest relative difference of a spacing from the spacing of an element's crystal.
_MAX_SPACING_DIFFERENCE = 0.02
#: Reaction to a step that exceeds a limit of the model; see `Validity`.
Reaction: TypeAlias = Literal["warn", "raise", "ignore"]


class ValidityWarning(UserWarning):
    """A result is outside of the validity of the model."""


@dataclass(frozen=True)
class Validity:
    """What to do if a step exceeds a limit of the model.

    In any case the column `validity` lists the limits.

    Attributes
    ----------
    action : {"warn", "raise", "ignore"}
        The reaction: a `ValidityWarning`, once for each limit, an error after the step
        is written, or nothing.
    hardness : float, optional
        Hardness of the substrate, with which pressures are compared (eV/Å^3): infinity
        for a solid that is elastic by intent, NaN if it is not known. The default is
        the element's hardness in `HARDNESS`, if the spacing fits its crystal and the
        solid is not layered, and else none. If the spacing fits, but the hardness is
        not known, pressures are compared with `hardness_bound_for`.

    yield_strength : float
        Yield strength with which the largest von Mises stress below the surface is
        compared, at the cost of some FFTs in each step (eV/Å^3); NaN for none. For
        metals it is about a third of the hardness. The solid needs Poisson's ratio or
        elastic constants.

    Raises
    ------
    ValueError
        If the action is unknown, or the yield strength is not positive.
    TypeError
        If the hardness is no number.

    Examples
    --------
    >>> from ase_roughcontact import RoughContact, RoughSphere, Validity
    >>> from ase_roughcontact import load_path, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (8, 8), sphere, fixed=False)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.9)
    >>> soft = Validity('ignore', hardness=0.01)  # eV/Å^3
    >>> (step,) = load_path(atoms, loads=[2.0], window='auto', validity=soft)
    >>> step.validity
    'largest pressure/hardness = 1.73 > 1'
    """

    action: Reaction = "warn"
    hardness: float | None = None
    yield_strength: float = math.nan

    def __post_init__(self) -> None:
        """Check the action."""
        one_of(get_args(Reaction), validity=self.action)
        if self.hardness is not None:
            instance_of((int, float, np.number), hardness=self.hardness)
        if not math.isnan(self.yield_strength):
            positive(yield_strength=self.yield_strength)


class ValidityReport:
    """Reports the limits that the steps of a path exceed, each of them once.

    Parameters
    ----------
    action : {"warn", "raise", "ignore"}
        The reaction to a limit that is exceeded; see `Validity`.

    Raises
    ------
    ValueError
        If the action is unknown.
    """

    def __init__(self, action: Reaction) -> None:
        self._action = Validity(action).action
        self._reported: set[str] = set()

    def __call__(self, number: int, validity: str) -> None:
        """Report a step.

        Parameters
        ----------
        number : int
            Number of the step, from zero.
        validity : str
            Column `validity` of the step.

        Raises
        ------
        RuntimeError
            If it exceeds a limit and the action is "raise".
        """
        new = {
            entry: check
            for entry, check in failed_checks(validity).items()
            if check.name not in self._reported
        }
        if not new or self._action == "ignore":
            return
        self._reported |= {check.name for check in new.values()}
        text = f"step {number} is outside of the validity of the model: " + "; ".join(
            f"{entry} ({check.reason})" for entry, check in new.items()
        )
        if self._action == "raise":
            raise RuntimeError(text)
        warn(text, ValidityWarning)


def warn_of_lost_slope(
    lost: float, change: GridChange | None, action: Reaction
) -> None:
    """Warn of the part of the slope that a coarser grid loses, unless ignored."""
    if change and lost and action != "ignore":
        warn(lost_text(change, lost))


def hardness_for(problem: Problem, symbol: str, hardness: float | None = None) -> float:
    """Return the hardness with which the pressures of a problem are compared (eV/Å^3).

    It is the wall's hardness, if it has one, or the given hardness; else the element's,
    unless the solid is layered.

    Raises
    ------
    ValueError
        If the hardness is not positive.
    """
    if problem.wall.plastic:  # what is plastic is within the model
        return problem.wall.hardness
    if hardness is None:
        layered = problem.solid.layered
        return math.nan if layered else _hardness_of(symbol, problem.spacing)
    if hardness != math.inf and not math.isnan(hardness):
        positive(hardness=hardness)
    return hardness


def hardness_bound_for(
    problem: Problem, symbol: str, hardness: float | None = None
) -> float:
    """Return the pressure that a solid of unknown hardness can hardly bear.

    It is the bound by `named_materials.hardness_bound` (eV/Å^3); NaN if a hardness is
    known or given, for the symbol "X", and if the spacing differs from the element's
    crystal, as in other units.
    """
    if hardness is not None or symbol == "X":
        return math.nan
    if not math.isnan(hardness_for(problem, symbol)):
        return math.nan
    if not _is_spacing_of(symbol, problem.spacing):
        return math.nan
    solid = problem.solid
    modulus = solid.modulus_at_surface(problem.spacing) / UNITS["GPa"]
    return UNITS["GPa"] * hardness_bound(modulus, solid.creep)


def _hardness_of(symbol: str, spacing: float) -> float:
    """Return the hardness of an element in `HARDNESS` (eV/Å^3).

    NaN if it is not known, or if the spacing differs from the element's crystal, as in
    other units.
    """
    if not _is_spacing_of(symbol, spacing):
        return math.nan
    return HARDNESS.get(symbol, math.nan) * UNITS["GPa"]


def _is_spacing_of(symbol: str, spacing: float) -> bool:
    """Return whether a spacing (Å) may belong to the surface of an element."""
    try:
        crystal = fcc_spacing(symbol)
    except ValueError:  # neither fcc nor diamond: any spacing may be meant
        return True
    return math.isclose(spacing, crystal, rel_tol=_MAX_SPACING_DIFFERENCE)
