"""Adhesion loops of atoms."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from ase import Atoms

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.keywords import suggesting
from ase_roughcontact._util.validation import function
from ase_roughcontact.contact.control import HEIGHT
from ase_roughcontact.loading.load_path import AtomsPath
from ase_roughcontact.path_kinds.loop.instabilities import AdhesionLoop
from ase_roughcontact.path_kinds.loop.specification import LoopSpecification
from ase_roughcontact.path_kinds.loop.steps import LoopSteps
from ase_roughcontact.paths.output import OutputLike
from ase_roughcontact.results.record import LoadStep
from ase_roughcontact.results.validity import Reaction, Validity
from ase_roughcontact.stepping.accuracy import Accuracy
from ase_roughcontact.stepping.options import Window


@suggesting
def adhesion_loop(
    atoms: Atoms,
    *,
    deepest: float | None = None,
    step: float | None = None,
    smallest_step: float | None = None,
    tolerance: float = LoopSpecification.tolerance,
    optimizer: Callable[..., Any] | None = None,
    fmax: float | None = None,
    accuracy: Accuracy = "normal",
    max_steps: int = 10_000,
    window: Window = "fixed",
    validity: Reaction | Validity = "warn",
    output: OutputLike | None = None,
    callback: Callable[[LoadStep], Any] | None = None,
) -> AdhesionLoop:
    r"""Press the indenter in from beyond the range of the wall, and pull it off again.

    The indenter is held at every height. In a step between heights :math:`Z_1` and
    :math:`Z_2` the work W is done on it, calculated from the forces and the contact
    stiffnesses of both states, and the energy :math:`E_2 - E_1` is stored. The step is
    undone and halved while

    .. math:: |W - (E_2 - E_1)| >
              (\epsilon \max(|N_1|, |N_2|) + \delta N)\, |Z_1 - Z_2|

    or while it does not converge; steps grow again afterwards. :math:`\delta N` is the
    error of the forces that the relaxation leaves. The balance does not depend on the
    antisymmetric part of the force between the states; a step is also halved while
    this part is above :math:`\epsilon^{3/4} \max(|N_1|, |N_2|) + \delta N`. During
    retraction a state is inserted where the tension may exceed all others by more than
    :math:`\epsilon`: where the tangents at both states intersect.

    The smallest step is always accepted. It is a `Jump` if the energy lost is more than
    any force between :math:`N_1` and :math:`N_2` explains, :math:`(N_1 + N_2)(Z_1 -
    Z_2)/2 - (E_2 - E_1) > (|N_1 - N_2|/2 + \delta N)\, |Z_1 - Z_2|`.

    Parameters
    ----------
    atoms : Atoms
        Atoms from `substrate`, with a `RoughContact` calculator without load and a
        fixed indenter. They are moved.
    deepest : float, optional
        Penetration at which to turn, counted from where the indenter first repels the
        flat substrate (Å). If negative, the indenter stays in the attractive range. By
        default the loop goes on until the force is compressive by at least the largest
        tension on approach. If the indenter is still pulled at the turn, the pull-off
        force is a lower bound; a warning names it.
    step : float, optional
        Largest step (Å), by default about a tenth of the way down. A loop begins and
        ends at the cutoff of the wall, so that a long tail takes a number of states
        that is the cutoff over the step.
    smallest_step : float, optional
        Size below which steps are not halved (Å), and jumps are bracketed. By default
        1/256 of `step`.
    tolerance : float
        :math:`\epsilon`, dimensionless. The relative error of the pull-off force is at
        most about 1.5 times this.
    optimizer, fmax, accuracy, max_steps, window, validity, output
        See `load_path`.
    callback : callable, optional
        Function called with each state after it is written.

    Returns
    -------
    AdhesionLoop

    Raises
    ------
    ValueError
        If a step or the tolerance is not a finite number above zero, the smallest step
        is larger than the largest, `deepest` is beyond the range of the wall, that
        range is infinite, the wall does not attract and no `deepest` is given, the
        calculator has a load, or the indenter is not fixed.
    RuntimeError
        If a loop without `deepest` finds no compressive force, the contact reaches the
        edge of a fixed window, or another run is writing the trajectory.
    MemoryError
        If an automatic window does not fit into the available memory.
    OSError
        If a file can't be written.

    Notes
    -----
    On a curve :math:`N(Z)` without jumps, :math:`W - (E_2 - E_1)` is the error of the
    integral of a cubic polynomial, :math:`|N''''| |Z_1 - Z_2|^5/720`, while the energy
    lost in a jump does not decrease with the step: halving distinguishes them. Between
    the states the curve is this polynomial, see `interpolated`.

    *Smooth spheres.* With `LennardJones93.adhesive`, the pull-off force agrees with
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

    Examples
    --------
    >>> from ase_roughcontact import DugdaleWall, RoughContact, RoughSphere
    >>> from ase_roughcontact import adhesion_loop, substrate
    >>> sphere = RoughSphere(radius=100.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, spacing=1.0)
    >>> atoms.calc = RoughContact(sphere, 1.0, DugdaleWall(0.02, attraction_range=0.8))
    >>> loop = adhesion_loop(atoms, step=0.1, window='auto')
    >>> round(loop.pull_off_force / (3.14159 * 0.02 * 100.0), 1)  # between JKR and DMT
    1.7
    """
    path = AtomsPath(
        atoms,
        HEIGHT,
        optimizer=optimizer,
        fmax=fmax,
        accuracy=accuracy,
        max_steps=max_steps,
        window=window,
        validity=validity,
        output=output,
    )
    load = atoms.calc.parameters["load"]
    if load:
        raise ValueError(
            "the indenter is held at heights: the calculator must have load=0, got "
            f"{load}"
        )

    if callback is not None:
        function(callback=callback)
    specification = LoopSpecification(deepest, step, smallest_step, tolerance)
    loop = specification.on(path.stepper.problem)
    states = list[LoadStep]()
    for state in path.follow(LoopSteps(path.stepper, loop)):
        states.append(state)
        if callback is not None:
            callback(state)
    found = AdhesionLoop.of(states, loop.smallest_step)
    for message in found.warnings:
        warn(message)
    return found
