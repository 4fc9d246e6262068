r"""Energy balance of a time step: work put in = stored + dissipated + lost.

The work on indenter, load or base is integrated by the trapezoidal rule, the energy
that creep dissipates exactly for a pressure that is linear in time. What is missing is
an error of the time step, or was lost when the contact jumped, as in a quasi-static
path.
"""

from __future__ import annotations

from ase_roughcontact.contact.control import BASE
from ase_roughcontact.path_kinds.time.record import TimeStep
from ase_roughcontact.stepping.step import Stepper


def energy_balance(
    stepper: Stepper, before: tuple[float, TimeStep], after: tuple[float, TimeStep]
) -> tuple[float, float]:
    """Return the energy balance between two states.

    Parameters
    ----------
    stepper : Stepper
    before, after : (float, TimeStep)
        Targets and states.

    Returns
    -------
    missing : float
        Work that is neither stored nor dissipated (energy).
    uncertainty : float
        Uncertainty of the work, if the contact jumps at an unknown moment of the step
        (energy).
    """
    (last_target, last), (target, step) = before, after
    first, second = _conjugate(stepper, *before), _conjugate(stepper, *after)
    change = target - last_target
    work = 0.5 * (first + second) * change
    missing = work - (step.energy - last.energy) - step.dissipated_energy
    return missing, abs((second - first) * change)


def work_between(before: TimeStep, after: TimeStep) -> float:
    """Return the work on the indenter between two states, by the trapezoidal rule."""
    mean_force = 0.5 * (before.normal_force + after.normal_force)
    return mean_force * (before.height - after.height)


def _conjugate(stepper: Stepper, target: float, step: TimeStep) -> float:
    """Return the derivative of the energy to the target."""
    force = step.normal_force
    if stepper.control == BASE:  # of the cantilever
        force = stepper.options.cantilever * (step.height - target)
    return stepper.control.conjugate(force, step.height)
