"""Adhesion: approach and retraction, the jumps between, and the energy they cost.

The indenter is moved in small steps and held; each state is relaxed from the last one,
so that the surface stays in its minimum of energy until that minimum is gone. While it
is there, the work done on the indenter is all stored: ::

    dE = -N dZ

What a step takes in and does not store was lost in a jump from one minimum to another.
A step whose balance does not close is taken back and halved.
"""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from dataclasses import asdict
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact._util.validation import positive
from ase_roughcontact.atoms.build import snapshot
from ase_roughcontact.paths.instabilities import (
    AdhesionLoop,
    Jump,
    force_error,
    jumped,
    lost_energy,
)
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.step import Stepper
from ase_roughcontact.paths.trajectory import Frames, Keep, PathName, keeper

# A balance is judged by the force on the indenter, but not below this, in units of
# E* a0^2: about that on one atom in contact.
_LEAST_FORCE = 0.05
# Part of a smallest step that is rounding, and no step.
_REST = 1e-3
# Smallest step relative to the largest.
_SMALLEST = 1 / 256


def adhesion_loop(
    atoms: Atoms,
    deepest: float,
    step: float,
    *,
    smallest_step: float | None = None,
    tolerance: float = 1e-3,
    optimizer: Callable[..., Any] | None = None,
    fmax: float | None = None,
    accuracy: str | float = "normal",
    max_steps: int = 10_000,
    window: str = "fixed",
    edge: str = "raise",
    trajectory: PathName | None = None,
    csv: PathName | None = None,
) -> AdhesionLoop:
    r"""Press the indenter in from out of reach and pull it off again, quasi-statically.

    The indenter is held at every height. A step between heights :math:`Z_1` and
    :math:`Z_2` takes in the work :math:`W = (N_1 + N_2)(Z_1 - Z_2)/2` and stores the
    energy :math:`E_2 - E_1`. It is taken back and halved while

    .. math:: |W - (E_2 - E_1)| >
              (\epsilon \max(|N_1|, |N_2|) + \delta N)\, |Z_1 - Z_2|

    or while it does not converge, and steps grow again afterwards; :math:`\delta N` is
    what the relaxation leaves uncertain of the forces. The smallest step is kept in any
    case, and is a `Jump` if it lost more energy than any force between :math:`N_1` and
    :math:`N_2` explains,
    :math:`W - (E_2 - E_1) > (|N_1 - N_2|/2 + \delta N)\, |Z_1 - Z_2|`.

    Parameters
    ----------
    atoms : Atoms
        From `substrate`, with a `RoughContact` calculator without load, the indenter
        fixed. They are moved.
    deepest : float
        Penetration at which to turn, counted from where the indenter first repels the
        flat substrate (Å). Below zero only the attraction is felt.
    step : float
        Largest step (Å).
    smallest_step : float, optional
        A step as small as this is not halved any more (Å): jumps are bracketed as
        closely. By default 1/256 of `step`.
    tolerance : float
        :math:`\epsilon`, dimensionless. A smooth curve is followed so closely that its
        largest tension is found to about 1.5 times this, relative.
    optimizer, fmax, accuracy, max_steps, window, edge
        See `load_path`.
    trajectory : path, optional
        File of an ASE trajectory of snapshots, one per state, written as they come,
        each whole or not at all.
    csv : path, optional
        File of a table of the records, one line per state, written as they come.

    Returns
    -------
    AdhesionLoop

    Raises
    ------
    ValueError
        If a step or the tolerance is not a finite number above zero, the smallest step
        is larger than the largest, `deepest` is out of reach, the wall has no end, the
        calculator has a load, or the indenter is not fixed.
    RuntimeError
        If the contact has come to the edge of a fixed window, or another run is writing
        `trajectory`.
    MemoryError
        If an automatic window does not fit into the memory that is free.
    OSError
        If a file can't be written.

    Notes
    -----
    Of a curve :math:`N(Z)` without jumps the balance of a step misses
    :math:`|N''| |Z_1 - Z_2|^3/12`, the error of the trapezoid, while the energy lost in
    a jump does not fall with the step: halving tells them apart.

    *Smooth spheres.* `LennardJones93.adhesive` pulls off as Maugis-Dugdale does with
    the same work and the same range, :math:`\sigma_0 = w/D`: for Maugis parameters from
    0.05 to 2 (:math:`R` from 50 to 1000 spacings) between 0 and 1.3 % less. With
    the same largest tension, :math:`\sigma_0 = 4kD/27`, Maugis-Dugdale gives 3 to 5 %
    too little for parameters from 0.35 to 1.8. The contact area at zero load is that
    under pressure in theory, without the rim of its contact that is under tension: to
    1 % where its radius is 25 or more times :math:`E^*/k`, to 3 % at 10 times.

    *Resolution.* The spacing has to resolve the length :math:`E^*/k` over which the
    wall gives way, whatever the work. On the sphere of :math:`R = 50\,E^*/k`,
    :math:`w = 0.05\,E^{*2}/k`, the pull-off force is off by less than 0.1 % with a
    spacing of :math:`E^*/k`, the bulk-matched wall, by 1 % at 1.25, 2 % at 1.4, 4 % at
    1.7, 8 % at 2, and 13 % at 2.5 times that; from 1.7 on it parts in several jumps.
    """
    positive(step=step, tolerance=tolerance)
    smallest = _SMALLEST * step if smallest_step is None else smallest_step
    positive(smallest_step=smallest)
    if smallest > step:
        raise ValueError(
            f"smallest_step must not be larger than step {step}, got {smallest}"
        )
    stepper = Stepper(
        atoms,
        "heights",
        optimizer,
        fmax=fmax,
        accuracy=accuracy,
        max_steps=max_steps,
        window=window,
        edge=edge,
    )
    top, bottom = _ends(stepper, deepest)
    with ExitStack() as files:
        keep = keeper(files, Frames(trajectory), csv)
        walk = _Walk(stepper, step, smallest, tolerance, keep)
        return walk.there_and_back(top + 0.5 * smallest, bottom)


class _Walk:
    """A way of small steps, some of them taken back."""

    def __init__(
        self,
        stepper: Stepper,
        largest: float,
        smallest: float,
        tolerance: float,
        keep: Keep,
    ) -> None:
        self._stepper, self._to_files = stepper, keep
        self._largest, self._smallest = largest, smallest
        self._tolerance = tolerance
        halfspace = stepper.atoms.calc.contact(stepper.atoms).halfspace
        self._least = _LEAST_FORCE * halfspace.contact_modulus * halfspace.cell_area
        self.size = largest
        self.records: list[LoadStep] = []
        self.jumps: list[Jump] = []

    @property
    def last(self) -> LoadStep:
        """Record of where the atoms are."""
        return self.records[-1]

    def there_and_back(self, top: float, bottom: float) -> AdhesionLoop:
        """Go down from one height to another, and up until nothing acts any more."""
        self._keep(self._stepper.step(0, top))
        while self.last.height - bottom > _REST * self._smallest:
            self.move(max(self.last.height - self.size, bottom))
        turn, jumps = len(self.records), len(self.jumps)
        while self.last.repulsive_atoms + self.last.attractive_atoms:
            self.move(self.last.height + self.size)
        return AdhesionLoop(
            approach=tuple(self.records[:turn]),
            retraction=tuple(self.records[turn - 1 :]),
            approach_jumps=tuple(self.jumps[:jumps]),
            retraction_jumps=tuple(self.jumps[jumps:]),
        )

    def move(self, height: float) -> None:
        """Go to a height, or as far towards it as there is no jump."""
        new, halved = self._stepper.step(len(self.records), height), False
        while not self._closes(new):
            self.size = abs(height - self.last.height)
            if self.size <= self._smallest:
                if jumped(self.last, new):
                    self.jumps.append(Jump(self.last, new))
                break
            self.size, halved = 0.5 * self.size, True
            height = 0.5 * (self.last.height + height)
            self._stepper.proceed_from(self._frame)
            new = self._stepper.step(len(self.records), height)
        self._keep(new)
        # what is left of a step that was halved is tried at once, and not more
        self.size = self.size if halved else min(2.0 * self.size, self._largest)

    def _closes(self, new: LoadStep) -> bool:
        """Whether a step stored its work, but for the trapezoid's error."""
        force = max(abs(self.last.normal_force), abs(new.normal_force), self._least)
        allowed = self._tolerance * force + force_error(self.last, new)
        path = abs(new.height - self.last.height)
        return new.converged and abs(lost_energy(self.last, new)) <= allowed * path

    def _keep(self, record: LoadStep) -> None:
        self._frame = snapshot(self._stepper.atoms, load_step=asdict(record))
        self.records.append(record)
        self._to_files(record, lambda: self._frame)


def _ends(stepper: Stepper, deepest: float) -> tuple[float, float]:
    """Heights where the wall begins to act on the flat substrate, and of the turn."""
    calc, first_contact = stepper.atoms.calc, stepper.windows.first_contact
    wall = calc.contact(stepper.atoms).interaction
    if not np.isfinite(wall.cutoff):
        raise ValueError(
            "a loop begins and ends where the wall does not act: the wall must have a "
            f"finite cutoff, got {wall.cutoff}"
        )
    reach = wall.cutoff - wall.contact_distance
    if not (np.isfinite(deepest) and deepest > -reach):
        raise ValueError(
            f"deepest must be a finite penetration above {-reach:g}, where the wall "
            f"begins to act, got {deepest!r}"
        )
    if calc.parameters["load"]:
        raise ValueError(
            "the indenter is held at heights: the calculator must have load=0, got "
            f"{calc.parameters['load']}"
        )
    return first_contact + reach, first_contact - deepest
