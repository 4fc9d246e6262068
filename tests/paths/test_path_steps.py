"""Steps of paths: nothing is kept between them but their state."""

from dataclasses import asdict
from itertools import islice

import numpy as np
import pytest
from built import atoms_under
from sliding_contacts import MU, stepper_of

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.path_kinds.loop.specification import LoopSpecification
from ase_roughcontact.path_kinds.loop.steps import LoopSteps
from ase_roughcontact.path_kinds.sliding.specification import SlidingSpecification
from ase_roughcontact.path_kinds.sliding.steps import SlidingSteps
from ase_roughcontact.path_kinds.time.specification import TimeSpecification
from ase_roughcontact.path_kinds.time.steps import TimeSteps
from ase_roughcontact.paths.follow import follow
from ase_roughcontact.paths.path_steps import NumberedSteps

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
WINDOW = Box((-8, -8), (16, 16))


def contact_of(wall, control, solid=None):
    sphere = rc.RoughSphere(100.0)
    problem = rc.Problem(sphere, solid or Isotropic(1.0), wall, 1.0, offset=(0.5, 0.5))
    return rc.Stepper(problem, control, WINDOW, rc.StepOptions(window="auto"))


def loads():
    return NumberedSteps(contact_of(rc.HardWall(), "loads"), np.array([0.5, 1.0, 1.5]))


def loop():
    wall = rc.DugdaleWall(0.02, attraction_range=0.8)
    stepper = contact_of(wall, "heights")
    return LoopSteps(stepper, LoopSpecification(0.1, 0.2, 0.01).on(stepper.problem))


def time():
    solid = rc.Viscoelastic(1.0, rc.Creep.standard_solid(relaxed=0.5, time=1.0))
    stepper = contact_of(rc.HardWall(), "penetrations", solid)
    return TimeSteps(
        stepper, TimeSpecification(rc.Schedule(0.0).ramp(0.2, time=1.0).hold(1.0), 0.05)
    )


def sliding():
    stepper = stepper_of(16, solid=Isotropic(1.0, 0.2))
    path = [0.0, 0.02, 0.05]
    return SlidingSteps(
        stepper, SlidingSpecification(0.3, rc.Coulomb(MU), path, coupling="solved")
    )


def columns(step):
    return {k: v for k, v in asdict(step).items() if k != "seconds"}


@pytest.mark.parametrize("path", [loads, loop, time, sliding])
@pytest.mark.parametrize("taken", [1, 2, None])
def test_a_path_that_is_followed_again_starts_again(path, taken):
    steps = path()
    first = [columns(step) for step in islice(follow(steps, validity="ignore"), taken)]
    again = [columns(step) for step in islice(follow(steps, validity="ignore"), taken)]
    assert len(first) >= (taken or 3)
    np.testing.assert_equal(again, first)


def test_a_step_of_a_resumed_path_has_the_tolerance_of_the_uninterrupted_one(tmp_path):
    loads, file = [1.0, 3.0, 30.0, 300.0], tmp_path / "sweep.traj"
    sphere = rc.RoughSphere(200.0, rc.SelfAffine(0.1, 0.8, 10.0, 40.0, seed=1))

    def steps(count, **output):
        atoms = atoms_under(sphere, None, (8, 8), spacing=2.5, fixed=False)
        files = {"output": rc.Output(**output)} if output else {}
        return list(rc.load_path(atoms, loads=loads[:count], window="auto", **files))

    whole = steps(4)
    steps(3, trajectory=file)
    resumed = steps(4, trajectory=file, resume=True)
    assert resumed[3].tolerance == whole[3].tolerance
    assert resumed[3].contact_area == whole[3].contact_area
