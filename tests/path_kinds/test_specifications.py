"""One specification for each kind of path: defaults, checks and targets."""

from inspect import signature

import numpy as np
import pytest

from ase_roughcontact import Schedule, Tresca, adhesion_loop, sliding_path, time_path
from ase_roughcontact.contact.control import BASE, LOAD, PENETRATION
from ase_roughcontact.path_kinds.loop.specification import LoopSpecification
from ase_roughcontact.path_kinds.sliding.specification import (
    LATERAL_FORCE,
    SlidingSpecification,
)
from ase_roughcontact.path_kinds.time.specification import (
    TimeSpecification,
    check_cantilever,
)
from ase_roughcontact.scene import Loop, Timed
from ase_roughcontact.scene.config import FrictionConfig

LAW = Tresca(0.01)


@pytest.mark.parametrize(
    "section, function, specification, name, value",
    [
        (Loop, adhesion_loop, LoopSpecification, "tolerance", 1e-3),
        (Timed, time_path, TimeSpecification, "tolerance", 1e-3),
        (FrictionConfig, sliding_path, SlidingSpecification, "coupling", "neglected"),
    ],
)
def test_defaults_in_scenes_and_of_functions_agree_with_the_specification(
    section, function, specification, name, value
):
    assert getattr(section, name) == getattr(specification, name) == value
    assert signature(function).parameters[name].default == value


@pytest.mark.parametrize(
    "given", [{"deepest": np.inf}, {"step": 0.0}, {"smallest_step": -1.0}]
)
def test_numbers_of_a_loop_are_checked_without_a_contact(given):
    (name,) = given
    with pytest.raises(ValueError, match=name):
        LoopSpecification(**given)


def test_lateral_targets_along_x_are_pairs_and_one_normal_target_is_of_all_steps():
    given = SlidingSpecification(2.0, LAW, [0.0, 1.0, 2.0])
    np.testing.assert_array_equal(given.lateral, [[0, 0], [1, 0], [2, 0]])
    np.testing.assert_array_equal(given.normal(LOAD), [2.0, 2.0, 2.0])
    with pytest.raises(ValueError, match="all 3 displacements"):
        SlidingSpecification([1.0, 2.0], LAW, given.lateral).normal(PENETRATION)


def test_a_lateral_control_is_given_by_its_name():
    assert SlidingSpecification(1.0, LAW, [0.0], "forces").control is LATERAL_FORCE
    with pytest.raises(ValueError, match=r"'force'.*displacements, forces.*bases"):
        SlidingSpecification(1.0, LAW, [0.0], "force")


@pytest.mark.parametrize("control, spring", [("bases", None), ("forces", 1.0)])
def test_a_base_and_only_a_base_has_a_spring(control, spring):
    with pytest.raises(ValueError, match="give"):
        SlidingSpecification(1.0, LAW, [0.0, 1.0], control, spring)
    with pytest.raises(ValueError, match="leave out its stiffness"):
        check_cantilever(LOAD, 1.0)
    with pytest.raises(ValueError, match="give its stiffness"):
        check_cantilever(BASE, None)


def test_a_path_in_time_is_a_schedule():
    assert TimeSpecification(Schedule(0.0).hold(1.0), 0.1).tolerance == 0.1
    with pytest.raises(TypeError, match="Schedule"):
        TimeSpecification([0.0, 1.0])
