"""A time step is an elastic contact of a softer solid under a lowered surface."""

from dataclasses import replace

import numpy as np
import pytest
from contacts import ROUGH, spring

import ase_roughcontact as rc
from ase_roughcontact.contact import Contact, State
from ase_roughcontact.contact.creep import before_step, past_of, with_depths
from ase_roughcontact.contact.support import Support
from ase_roughcontact.elasticity import Isotropic, Layer
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions import ExponentialWall
from ase_roughcontact.solvers.soft.newton import default_relaxer

CREEP = rc.Creep([0.5, 2.0], [0.3, 4.0], flow=0.1)
WALLS = {
    "hard": rc.HardWall(),
    "plastic": rc.PlasticWall(0.05),
    "soft": rc.LennardJones93.repulsive(1.0, 1.0),
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.005),
    "hard adhesive": ExponentialWall(0.02, 0.5),
}
HOLDS = {
    "height": lambda height: Support(True),
    "load": lambda height: Support(False, 15.0),
    "spring": lambda height: Support(False, 0.0, spring(3.0, height - 5.0)),
}


@pytest.mark.parametrize("solid", [Isotropic(1.0), Layer(1.0, 3.0, poisson=0.3)])
@pytest.mark.parametrize("periodic", [False, True])
@pytest.mark.parametrize("hold", HOLDS)
@pytest.mark.parametrize("wall", WALLS)
def test_a_step_is_the_elastic_contact_of_the_effective_solid(
    wall, hold, periodic, solid
):
    n, elapsed = 32, 0.7
    indenter, box = rc.RoughSphere(200.0, ROUGH), Box((-16, -16), (n, n))
    problem = rc.Problem(
        indenter, rc.Viscoelastic(solid, CREEP), WALLS[wall], 1.0, periodic=periodic
    )
    height = WALLS[wall].contact_distance - float(problem.heights(box).min()) - 0.2
    # the past of a random pressure
    past = 0.02 * np.random.default_rng(1).random((n, n))
    halfspace, step = problem.halfspace((n, n)), CREEP.over(elapsed)
    displacement = halfspace.displacement(past)
    before = before_step(State(box, height, past, displacement), step)
    before = with_depths(before, halfspace)
    contact = problem.contact(box).changed(
        halfspace.softened(step.compliance), None, *past_of(before)
    )
    relaxer, support = default_relaxer(WALLS[wall]), HOLDS[hold](height)
    options = {"support": support, "tolerance": 1e-10, "max_steps": 1000}
    flat = State.flat(box, height)
    run = relaxer(contact, replace(flat, history=before.history), **options)
    assert run.converged, run.message

    # with the solid and the shape written out
    soft = 1.0 + float(step.new.sum())
    effective = Isotropic(1.0 / soft)
    if isinstance(solid, Layer):
        effective = Layer(1.0 / soft, 3.0, poisson=0.3)
    lowered = problem.heights(box) - halfspace.displacement(step.old.sum() * past)
    elastic = rc.Problem(indenter, effective, WALLS[wall], 1.0, periodic=periodic)
    same = Contact(elastic.halfspace((n, n)), lowered, WALLS[wall])
    expected = relaxer(same, flat, **options)
    assert expected.converged, expected.message
    scale = abs(expected.fields.pressure).max()
    assert run.fields.pressure == pytest.approx(
        expected.fields.pressure, abs=1e-6 * scale
    )
    assert run.state.height == pytest.approx(expected.state.height, abs=1e-8)
    assert run.fields.normal_force == pytest.approx(
        expected.fields.normal_force, rel=1e-9
    )
    assert run.energy == pytest.approx(expected.energy, rel=1e-9)
