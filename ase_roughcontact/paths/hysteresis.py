"""Adhesion loops: approach and retraction in small steps, with their instabilities.

The indenter is moved in small steps and held; each state is relaxed from the last one,
so that the surface stays in its minimum of energy until that minimum disappears. As
long as it does, the work done on the indenter is stored, ``dE = -N dZ``. A step whose
energy balance does not close is undone and repeated at half its size.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact._util.files import PathName
from ase_roughcontact._util.validation import finite, positive
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.atoms.snapshot import snapshot
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.paths.instabilities import (
    AdhesionLoop,
    Jump,
    balanced,
    jumped,
)
from ase_roughcontact.paths.output import Write, open_output
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.validity import ValidityReport

# Normal force below which the error of the balance does not decrease further, in units
# of E* a0^2: about that on one atom in contact.
_SMALLEST_FORCE = 0.05
# Part of the smallest step by which the deepest height may be missed.
_ROUNDING = 1e-3
#: Default of the smallest step, relative to the largest.
SMALLEST_STEP = 1 / 256
# Number of the largest steps of an approach by default.
_STEPS_DOWN = 10


def adhesion_loop(
    atoms: Atoms,
    deepest: float,
    step: float,
    *,
    smallest_step: float | None = None,
    tolerance: float = 1e-3,
    trajectory: PathName | None = None,
    csv: PathName | None = None,
    record: type[LoadStep] = LoadStep,
    validity: str = "warn",
    callback: Callable[[LoadStep], Any] | None = None,
    **options: Any,
) -> AdhesionLoop:
    r"""Press the indenter in from beyond the range of the wall, and pull it off again.

    The indenter is held at every height. In a step between heights :math:`Z_1` and
    :math:`Z_2` the work W is done on it, calculated from the forces and the contact
    stiffnesses of both states, and the energy :math:`E_2 - E_1` is stored. The step is
    undone and halved while

    .. math:: |W - (E_2 - E_1)| >
              (\epsilon \max(|N_1|, |N_2|) + \delta N)\, |Z_1 - Z_2|

    or while it does not converge; steps grow again afterwards. :math:`\delta N` is the
    error of the forces that the relaxation leaves. The smallest step is always
    accepted. It is a `Jump` if the energy lost is more than any force between
    :math:`N_1` and :math:`N_2` explains, :math:`(N_1 + N_2)(Z_1 - Z_2)/2 - (E_2 - E_1)
    > (|N_1 - N_2|/2 + \delta N)\, |Z_1 - Z_2|`.

    Parameters
    ----------
    atoms : Atoms
        From `substrate`, with a `RoughContact` calculator without load, the indenter
        fixed. They are moved.
    deepest : float
        Penetration at which to turn, counted from where the indenter first repels the
        flat substrate (Å). If negative, the indenter stays in the attractive range.
    step : float
        Largest step (Å). A loop begins and ends at the cutoff of the wall, so that a
        long tail takes a number of states that is the cutoff over the step.
    smallest_step : float, optional
        Size below which steps are not halved (Å), and jumps are bracketed. By default
        1/256 of `step`.
    tolerance : float
        :math:`\epsilon`, dimensionless. The relative error of the pull-off force is
        about 1.5 times this on a path without jumps.
    trajectory : path, optional
        ASE trajectory of snapshots, one per state.
    csv : path, optional
        CSV file of the results, one line per state.
    record, validity
        See `load_path`.
    callback : callable, optional
        Called with each state after it is written.
    **options
        Options of the `Stepper`: `optimizer`, `fmax`, `accuracy`, `max_steps`,
        `window`, `edge` and `hardness`.

    Returns
    -------
    AdhesionLoop

    Raises
    ------
    ValueError
        If a step or the tolerance is not a finite number above zero, the smallest step
        is larger than the largest, `deepest` is beyond the range of the wall, that
        range is infinite, the calculator has a load, or the indenter is not fixed.
    RuntimeError
        If the contact reaches the edge of a fixed window, or another run is writing
        `trajectory`.
    MemoryError
        If an automatic window does not fit into the available memory.
    OSError
        If a file can't be written.

    Notes
    -----
    On a curve :math:`N(Z)` without jumps, :math:`W - (E_2 - E_1)` is the error of the
    integral of a cubic polynomial, :math:`|N''''| |Z_1 - Z_2|^5/720`, while the energy
    lost in a jump does not decrease with the step: halving distinguishes them. Between
    the states the curve is that polynomial, see `interpolated`.

    *Smooth spheres.* With `LennardJones93.adhesive`, the pull-off force is that of
    Maugis-Dugdale theory for the same work and range, :math:`\sigma_0 = w/D`: smaller
    by 0 to 1.3 % for Maugis parameters from 0.05 to 2 (:math:`R` from 50 to 1000
    spacings). For the same largest tension, :math:`\sigma_0 = 4kD/27`, Maugis-Dugdale
    theory is 3 to 5 % too small for parameters from 0.35 to 1.8. The contact area at
    zero load corresponds to the part under pressure in theory, without the rim under
    tension: to 1 % if its radius is at least 25 times :math:`E^*/k`, to 3 % at 10
    times.

    *Resolution.* The spacing has to resolve the length :math:`E^*/k`, :math:`k` being
    the stiffness of the wall, at any work of adhesion. For :math:`R = 50\,E^*/k` and
    :math:`w = 0.05\,E^{*2}/k` the error of the pull-off force is below 0.1 % with a
    spacing of :math:`E^*/k`, 1 % with 1.25, 2 % with 1.4, 4 % with 1.7, 8 % with 2, and
    13 % with 2.5 times that; from 1.7 on the contact separates in several jumps.
    """
    positive(step=step, tolerance=tolerance)
    smallest = SMALLEST_STEP * step if smallest_step is None else smallest_step
    positive(smallest_step=smallest)
    if smallest > step:
        raise ValueError(
            f"smallest_step must not be larger than step {step}, got {smallest}"
        )
    stepper = Stepper(atoms, "heights", record=record, **options)
    report = ValidityReport(validity)
    top, bottom = _end_heights(stepper, deepest)
    with open_output(trajectory, csv, record) as write:
        path = _AdaptivePath(
            stepper, write, step, smallest, tolerance, report, callback
        )
        return path.loop(top + 0.5 * smallest, bottom)


def default_step(wall: Interaction, deepest: float) -> float:
    """Return a largest step for `adhesion_loop`: a tenth of the way down.

    Parameters
    ----------
    wall : Interaction
    deepest : float
        Penetration at which to turn (Å).

    Returns
    -------
    float
        Å.
    """
    return (wall.cutoff - wall.contact_distance + deepest) / _STEPS_DOWN


@dataclass
class _AdaptivePath:
    """Path of heights whose steps are halved until their energy balance closes."""

    stepper: Stepper
    write: Write
    largest: float
    smallest: float
    tolerance: float
    report: ValidityReport
    callback: Callable[[LoadStep], Any] | None

    def __post_init__(self) -> None:
        halfspace = contact_of(self.stepper.atoms).halfspace
        unit = halfspace.contact_modulus * halfspace.cell_area
        self._smallest_force = _SMALLEST_FORCE * unit
        self._size = self.largest
        self._states: list[LoadStep] = []
        self._jumps: list[Jump] = []

    def loop(self, top: float, bottom: float) -> AdhesionLoop:
        """Approach from one height to another, and retract until nothing interacts."""
        self._accept(self.stepper.step(0, top))
        while self._last.height - bottom > _ROUNDING * self.smallest:
            self._move_towards(max(self._last.height - self._size, bottom))
        states, jumps = len(self._states), len(self._jumps)
        while self._last.repulsive_atoms + self._last.attractive_atoms:
            self._move_towards(self._last.height + self._size)
        return AdhesionLoop(
            approach=tuple(self._states[:states]),
            retraction=tuple(self._states[states - 1 :]),
            approach_jumps=tuple(self._jumps[:jumps]),
            retraction_jumps=tuple(self._jumps[jumps:]),
        )

    @property
    def _last(self) -> LoadStep:
        return self._states[-1]

    def _move_towards(self, height: float) -> None:
        """Move to a height, or to one on the way to which the balance closes."""
        new, halved = self._relax(height), False
        while not balanced(self._last, new, self.tolerance, self._smallest_force):
            self._size = abs(height - self._last.height)
            if self._size <= self.smallest:
                if jumped(self._last, new):
                    self._jumps.append(Jump(self._last, new))
                    self._size, halved = self.largest, True  # on the new branch
                break
            self._size, halved = 0.5 * self._size, True
            height = 0.5 * (self._last.height + height)
            self.stepper.restart_from(self._frame)
            new = self._relax(height)
        self._accept(new)
        if not halved:  # else what is left of the step is tried first
            self._size = min(2.0 * self._size, self.largest)

    def _relax(self, height: float) -> LoadStep:
        return self.stepper.step(len(self._states), height)

    def _accept(self, state: LoadStep) -> None:
        self._frame = snapshot(self.stepper.atoms, load_step=asdict(state))
        self._states.append(state)
        self.write(state, lambda: self._frame)
        self.report(state.step, state.validity)
        if self.callback is not None:
            self.callback(state)


def _end_heights(stepper: Stepper, deepest: float) -> tuple[float, float]:
    """Return the heights where the range of the wall begins, and where to turn."""
    calc, first_contact = stepper.atoms.calc, stepper.windows.first_contact
    wall = contact_of(stepper.atoms).interaction
    if not np.isfinite(wall.cutoff):
        raise ValueError(
            "a loop begins and ends beyond the range of the wall: the wall must have a "
            f"finite cutoff, got {wall.cutoff}"
        )
    attraction = wall.cutoff - wall.contact_distance
    finite(deepest=deepest)
    if deepest <= -attraction:
        raise ValueError(
            f"deepest must be a finite penetration above {-attraction:g}, where the "
            f"wall begins to act, got {deepest}"
        )
    if calc.parameters["load"]:
        raise ValueError(
            "the indenter is held at heights: the calculator must have load=0, got "
            f"{calc.parameters['load']}"
        )
    return first_contact + attraction, first_contact - deepest
