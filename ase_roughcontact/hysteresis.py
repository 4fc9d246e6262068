"""Adhesion: approach and retraction, the jumps between, and the energy they cost.

The indenter is moved in small steps and held; each state is relaxed from the last one,
so that the surface stays in its minimum of energy until that minimum is gone. While it
is there, the work done on the indenter is all stored: ::

    dE = -N dZ

What a step takes in and does not store was lost in a jump from one minimum to another.
A step whose balance does not close is taken back and halved.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import ExitStack
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from ase import Atoms
from ase.io import Trajectory
from ase.parallel import DummyMPI

from ase_roughcontact.checks import positive
from ase_roughcontact.record import LoadStep, Table
from ase_roughcontact.stepping import Stepper
from ase_roughcontact.substrate import snapshot

PathName = str | os.PathLike

# A balance is judged by the force on the indenter, but not below this, in units of
# E* a0^2: about that on one atom in contact.
_LEAST_FORCE = 0.05
# Part of a smallest step that is rounding, and no step.
_REST = 1e-3
# Smallest step relative to the largest.
_SMALLEST = 1 / 256


@dataclass(frozen=True)
class Jump:
    """An instability, between two states at neighbouring heights.

    Attributes
    ----------
    before, after : LoadStep
        The last state on this side of the jump, and the first one beyond.
    """

    before: LoadStep
    after: LoadStep

    @property
    def height(self) -> float:
        """Height of the indenter, the middle of the bracket (Å)."""
        return 0.5 * (self.before.height + self.after.height)

    @property
    def dissipated_energy(self) -> float:
        """Energy that was lost (eV).

        Where in the bracket the force changed is not known: the error is at most half
        of that change times the width of the bracket.
        """
        return _lost(self.before, self.after)


@dataclass(frozen=True)
class AdhesionLoop:
    """A contact made and parted.

    Attributes
    ----------
    approach, retraction : tuple of LoadStep
        The states on the way down, from out of reach to the deepest one, and on the way
        up, until nothing acts on the indenter any more.
    approach_jumps, retraction_jumps : tuple of Jump
        The instabilities found on either way.
    """

    approach: tuple[LoadStep, ...]
    retraction: tuple[LoadStep, ...]
    approach_jumps: tuple[Jump, ...]
    retraction_jumps: tuple[Jump, ...]

    @property
    def pull_off_force(self) -> float:
        """Largest tension on the way up, zero without any (eV/Å)."""
        return max(0.0, -min(record.normal_force for record in self.retraction))

    @property
    def jump_in(self) -> float | None:
        """Height of the first jump on the way down, None without one (Å)."""
        return self.approach_jumps[0].height if self.approach_jumps else None

    @property
    def jump_out(self) -> float | None:
        """Height of the last jump on the way up, None without one (Å)."""
        return self.retraction_jumps[-1].height if self.retraction_jumps else None

    @property
    def dissipated_energy(self) -> float:
        r"""Area of the loop of force against height, :math:`-\oint N\,dZ` (eV)."""
        records = (*self.approach, *self.retraction)
        return sum(map(_work, records, records[1:]))

    @property
    def energy_lost_in_jumps(self) -> float:
        """Energy lost in the jumps, which is all of it if none was overlooked (eV)."""
        jumps = (*self.approach_jumps, *self.retraction_jumps)
        return sum(jump.dissipated_energy for jump in jumps)


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
        File of an ASE trajectory of snapshots, one per state, written as they come.
    csv : path, optional
        File of a table of the records, one line per state, written as they come.

    Returns
    -------
    AdhesionLoop

    Raises
    ------
    ValueError
        If a step or the tolerance is not a finite number above zero, the smallest step
        is larger than the largest, `deepest` is out of reach, the calculator has a
        load, or the indenter is not fixed.
    RuntimeError
        If the contact has come to the edge of a fixed window.

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
        write = _writer(files, trajectory, csv)
        walk = _Walk(stepper, step, smallest, tolerance, write)
        walk.begin(top + 0.5 * smallest)
        while walk.last.height - bottom > _REST * smallest:
            walk.move(max(walk.last.height - walk.size, bottom))
        turn, jumps = len(walk.records), len(walk.jumps)
        while walk.last.repulsive_atoms + walk.last.attractive_atoms:
            walk.move(walk.last.height + walk.size)
    return AdhesionLoop(
        approach=tuple(walk.records[:turn]),
        retraction=tuple(walk.records[turn - 1 :]),
        approach_jumps=tuple(walk.jumps[:jumps]),
        retraction_jumps=tuple(walk.jumps[jumps:]),
    )


def zero_load_area(records: Sequence[LoadStep]) -> float:
    """Contact area at zero force, between the states of an approach or a retraction.

    Parameters
    ----------
    records : sequence of LoadStep
        Of one way down or up, in any order.

    Returns
    -------
    float
        Area, interpolated linearly in the force where it falls to zero on the way up
        from the deepest state (Å^2).

    Raises
    ------
    ValueError
        If the force does not change its sign, or does not come down to zero.
    """
    upward = sorted(records, key=lambda record: record.height)
    forces = [record.normal_force for record in upward]
    first = next((i for i, force in enumerate(forces) if force <= 0.0), None)
    if not first:
        raise ValueError(
            "the area at zero force needs states on both sides of it, got forces "
            f"from {min(forces, default=np.nan):g} to {max(forces, default=np.nan):g} "
            f"and {forces[0] if forces else np.nan:g} at the lowest height"
        )
    below, above = upward[first - 1], upward[first]
    share = below.normal_force / (below.normal_force - above.normal_force)
    return below.contact_area + share * (above.contact_area - below.contact_area)


def low_load_area(records: Iterable[LoadStep], largest_load: float) -> float:
    """Area A_adh that an adhesive first asperity keeps while the load is low.

    Parameters
    ----------
    records : iterable of LoadStep
        Of one realisation of the roughness, on one way.
    largest_load : float
        End of the low loads (eV/Å).

    Returns
    -------
    float
        Constant nearest, by least squares of the logarithm, to the areas at forces
        above zero and up to `largest_load` (Å^2).

    Raises
    ------
    ValueError
        If `largest_load` is not above zero, or no atom touches at such a force.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016): A_adh, Fig. 2(c).
    """
    positive(largest_load=largest_load)
    areas = [
        record.contact_area
        for record in records
        if 0.0 < record.normal_force <= largest_load and record.contact_area > 0.0
    ]
    if not areas:
        raise ValueError(f"no state in contact has a force from 0 to {largest_load:g}")
    return float(np.exp(np.mean(np.log(areas))))


class _Walk:
    """A way of small steps, some of them taken back."""

    def __init__(
        self,
        stepper: Stepper,
        largest: float,
        smallest: float,
        tolerance: float,
        write: Callable[[LoadStep, Atoms], None],
    ) -> None:
        self._stepper, self._write = stepper, write
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

    def begin(self, height: float) -> None:
        """Relax the first state."""
        self._keep(self._stepper.step(0, height))

    def move(self, height: float) -> None:
        """Go to a height, or as far towards it as there is no jump."""
        new, halved = self._stepper.step(len(self.records), height), False
        while not self._closes(new):
            self.size = abs(height - self.last.height)
            if self.size <= self._smallest:
                if _jumped(self.last, new):
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
        allowed = self._tolerance * force + _noise(self.last, new)
        path = abs(new.height - self.last.height)
        return new.converged and abs(_lost(self.last, new)) <= allowed * path

    def _keep(self, record: LoadStep) -> None:
        self._frame = snapshot(self._stepper.atoms, load_step=asdict(record))
        self.records.append(record)
        self._write(record, self._frame)


def _ends(stepper: Stepper, deepest: float) -> tuple[float, float]:
    """Heights where the wall begins to act on the flat substrate, and of the turn."""
    calc, first_contact = stepper.atoms.calc, stepper.windows.first_contact
    wall = calc.contact(stepper.atoms).interaction
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


def _work(before: LoadStep, after: LoadStep) -> float:
    """Work done on the indenter between two states, by the trapezoid."""
    mean_force = 0.5 * (before.normal_force + after.normal_force)
    return mean_force * (before.height - after.height)


def _lost(before: LoadStep, after: LoadStep) -> float:
    """Work that was not stored."""
    return _work(before, after) - (after.energy - before.energy)


def _jumped(before: LoadStep, after: LoadStep) -> bool:
    """Whether more was lost than any force between the two states explains."""
    change = abs(after.normal_force - before.normal_force)
    explained = 0.5 * change + _noise(before, after)
    return _lost(before, after) > explained * abs(after.height - before.height)


def _noise(*records: LoadStep) -> float:
    """Error of a normal force while every acting atom may miss its equilibrium."""
    return max(r.max_force * (r.repulsive_atoms + r.attractive_atoms) for r in records)


def _writer(
    files: ExitStack, trajectory: PathName | None, csv: PathName | None
) -> Callable[[LoadStep, Atoms], None]:
    """Return what writes a state to the files that are asked for."""
    # the table first: a trajectory that is there is lost once it is opened to write
    table = None if csv is None else files.enter_context(Table(csv))
    frames = None
    if trajectory is not None:
        writer = Trajectory(os.fspath(trajectory), "w", comm=DummyMPI())
        frames = files.enter_context(writer)

    def write(record: LoadStep, frame: Atoms) -> None:
        if frames is not None:
            frames.write(frame)
        if table is not None:
            table.write(record)

    return write
