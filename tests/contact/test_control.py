"""Controlled quantities: heights at targets, and what is conjugate to a target."""

import numpy as np
import pytest

import ase_roughcontact as rc
from ase_roughcontact.contact.control import (
    BASE,
    CONTROLS,
    HEIGHT,
    LOAD,
    PENETRATION,
    control_of,
)
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box

FIRST_CONTACT = 2.0
STIFFNESS = 5.0


def relaxed_at(control, target):
    """Contact of a smooth sphere at a target, and the energy of the whole system."""
    problem = rc.Problem(
        rc.RoughSphere(100.0), Isotropic(1.0), rc.HardWall(), spacing=1.0
    )
    options = rc.StepOptions(fmax=1e-9, cantilever=STIFFNESS)
    window = Box((-16, -16), (32, 32))
    stepper = rc.Stepper(problem, control, window, options)
    step = stepper.relax(stepper.start, target)
    energy = step.fields.energy
    if control == LOAD:
        energy += target * step.height
    if control == BASE:
        energy += 0.5 * STIFFNESS * (step.height - target) ** 2
    return step, energy


@pytest.mark.parametrize(
    ("control", "target"),
    [(PENETRATION, 0.5), (HEIGHT, -0.5), (LOAD, 6.0), (BASE, -2.0)],
)
def test_conjugate_quantity_is_the_derivative_of_the_energy(control, target):
    step, _ = relaxed_at(control, target)
    delta = 1e-3
    (_, above), (_, below) = (relaxed_at(control, target + d) for d in (delta, -delta))
    expected = (above - below) / (2.0 * delta)
    found = control.conjugate(step.fields.normal_force, step.height)
    assert found == pytest.approx(expected, rel=1e-4)


@pytest.mark.parametrize(("control", "height"), [(PENETRATION, 1.5), (HEIGHT, 0.5)])
def test_height_at_a_target(control, height):
    assert control.height(0.5, FIRST_CONTACT) == height
    assert control.target(height, FIRST_CONTACT) == 0.5


@pytest.mark.parametrize(
    ("control", "targets", "depths"),
    [(PENETRATION, [0.0, 2.0, 1.0], [0.0, 2.0, 1.0]), (HEIGHT, [3.0, 1.0], [0.0, 2.0])],
)
def test_depths_of_targets(control, targets, depths):
    assert control.depths(np.array(targets)).tolist() == depths


@pytest.mark.parametrize("control", CONTROLS.values(), ids=CONTROLS)
def test_a_deeper_target_presses_more(control):
    target = {PENETRATION: 0.5, HEIGHT: -0.5, LOAD: 6.0, BASE: -2.0}[control]
    step, _ = relaxed_at(control, target)
    further, _ = relaxed_at(control, target + 0.1 * control.deeper)
    assert further.fields.normal_force > step.fields.normal_force


@pytest.mark.parametrize("control", CONTROLS.values(), ids=CONTROLS)
def test_a_control_is_found_by_its_name_and_by_its_plural(control):
    assert control_of(control.name) is control_of(control.plural) is control


def test_an_unknown_control_is_refused_with_the_closest_name():
    with pytest.raises(ValueError, match="'load'"):
        control_of("laod")
