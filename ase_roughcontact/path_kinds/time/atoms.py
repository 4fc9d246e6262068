"""Paths in time of atoms."""

from __future__ import annotations

from collections.abc import Callable, Generator
from typing import Any

from ase import Atoms

from ase_roughcontact._util.keywords import suggesting
from ase_roughcontact._util.lazy import lazy
from ase_roughcontact.contact.control import control_of
from ase_roughcontact.loading.load_path import AtomsPath, single_path
from ase_roughcontact.path_kinds.time.record import TimeStep
from ase_roughcontact.path_kinds.time.specification import (
    TimeSpecification,
    check_cantilever,
)
from ase_roughcontact.path_kinds.time.steps import TimeSteps
from ase_roughcontact.paths.output import OutputLike
from ase_roughcontact.paths.schedule import Schedule
from ase_roughcontact.results.validity import Reaction, Validity
from ase_roughcontact.stepping.accuracy import Accuracy
from ase_roughcontact.stepping.options import Window


@lazy
@suggesting
def time_path(
    atoms: Atoms,
    *,
    penetrations: Schedule | None = None,
    heights: Schedule | None = None,
    loads: Schedule | None = None,
    bases: Schedule | None = None,
    cantilever: float | None = None,
    tolerance: float = TimeSpecification.tolerance,
    optimizer: Callable[..., Any] | None = None,
    fmax: float | None = None,
    accuracy: Accuracy = "normal",
    max_steps: int = 10_000,
    window: Window = "fixed",
    validity: Reaction | Validity = "warn",
    output: OutputLike | None = None,
) -> Generator[TimeStep, None, None]:
    r"""Move or load the indenter on a viscoelastic solid, as a function of time.

    Parameters
    ----------
    atoms : Atoms
        Atoms from `substrate`, with a `RoughContact` calculator of a `Viscoelastic`
        solid. They are moved, and in a free half space they lose their padding.
    penetrations, heights, loads, bases : Schedule
        Exactly one of: distances that the indenter has moved down since it first repels
        the flat substrate (Å), heights of the indenter (Å), loads on it (eV/Å), or
        heights of the base of a cantilever that holds it (Å), as functions of time in
        the unit of the creep times, seconds. The first two need a fixed indenter, the
        others a free one.
    cantilever : float, optional
        Stiffness of the cantilever (eV/Å^2), for `bases`.
    tolerance : float
        Largest error of a time step, relative to the largest force of the path so far,
        and of its energy balance, relative to the largest work or dissipated energy.
        The steps follow from it, and the solver leaves a tenth of it; errors of steps
        that add up count as one. At the start of the path these scales are taken from
        one step to the largest target.
    optimizer, fmax, accuracy, max_steps, window, validity, output
        See `load_path`. Results are of the class `TimeStep`, with the time, and the
        energies that are stored, dissipated and lost.

    Yields
    ------
    TimeStep
        The first state, of a surface that was at rest unless the atoms have a history,
        and the states at the end of each time step.

    Raises
    ------
    ValueError
        If not exactly one schedule is given, the solid is not viscoelastic, the
        cantilever is missing, or as `load_path` does.
    RuntimeError
        If a load is a tension that the contact does not hold.
    TypeError
        If the path is no `Schedule`, or `output.record` not derived from `TimeStep`.

    Notes
    -----
    The pressure is taken as linear in time during a step, which is then solved exactly,
    see `Creep.over`. An instability of the quasi-static contact is a fast motion here,
    which the steps resolve; one that remains at the instantaneous modulus is a jump at
    a time, with the energy in the column ``lost_energy``.

    The z of the atoms is the displacement by the pressure of the moment, from which
    forces follow. In frames it is the surface, lower by the depth that the past adds,
    the field ``past_depth`` of their `info`. A calculation that starts from a frame
    takes both into account.

    Examples
    --------
    >>> from ase_roughcontact import Creep, HardWall, RoughContact, RoughSphere
    >>> from ase_roughcontact import Schedule, Viscoelastic, substrate, time_path
    >>> sphere = RoughSphere(radius=500.0)
    >>> creep = Creep.standard_solid(relaxed=0.5, time=1.0)
    >>> solid = Viscoelastic(1.0, creep)
    >>> atoms = substrate("Cu", (32, 32), sphere, spacing=2.5)
    >>> atoms.calc = RoughContact(sphere, solid=solid, wall=HardWall())
    >>> dwell = Schedule(0.0).step(2.0).hold(20.0)
    >>> steps = list(time_path(atoms, penetrations=dwell))
    >>> round(steps[-1].normal_force / steps[1].normal_force, 3)
    0.5
    """
    name, schedule = single_path(
        penetrations=penetrations, heights=heights, loads=loads, bases=bases
    )
    specification = TimeSpecification(schedule, tolerance)
    control = control_of(name)
    check_cantilever(control, cantilever)
    path = AtomsPath(
        atoms,
        control,
        optimizer=optimizer,
        fmax=fmax,
        accuracy=accuracy,
        max_steps=max_steps,
        window=window,
        validity=validity,
        output=output,
        cantilever=cantilever or 0.0,
    )
    steps = TimeSteps(path.stepper, specification)
    return path.follow(steps, cantilever=cantilever or 0.0)
