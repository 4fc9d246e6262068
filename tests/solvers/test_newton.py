"""The Newton-Krylov solver against dense linear algebra and scipy."""

import numpy as np
import pytest
from contacts import constant, contact_of, green, pairs, rough_sphere, spring, steps
from scipy.optimize import minimize

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.interactions import RepulsiveLennardJones93
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.soft import newton
from ase_roughcontact.solvers.soft.newton import newton_krylov

REPULSIVE = rc.LennardJones93.repulsive(1.0, 1.0)
ADHESIVE = rc.LennardJones93.adhesive(1.0, 1.0, 0.005)
TIGHT = 1e-10


def sphere(n, seed=1):
    """Heights of a sphere of radius 10 n with short waves on it."""
    rough = rc.SelfAffine(0.1, 0.8, 4.0, 64.0, seed=seed)
    return rough_sphere((n, n), 10.0 * n, rough)


def scene(n=16, wall=REPULSIVE, *, heights=None, **options):
    return contact_of(sphere(n) if heights is None else heights, wall, **options)


def relax(contact, height=0.0, external=None, start=None, tolerance=TIGHT, **options):
    """All states; the last one must have converged."""
    done = steps(contact, external, height, start, tolerance, **options)
    assert done[-1].converged, done[-1].message
    return done


def wall_pressure(contact, state):
    gap = state.height + contact.heights
    gap -= contact.halfspace.displacement(state.pressure)
    return contact.wall.evaluate(gap)[1]


def normal_force(contact, state):
    return contact.halfspace.cell_area * wall_pressure(contact, state).sum()


def minimum(contact, height):
    """Energy by scipy in variables that make the elastic part the identity."""
    G = green(contact)
    values, modes = np.linalg.eigh((G + G.T) / 2.0)
    root = modes * np.sqrt(np.maximum(values, 0.0))

    def energy(x):
        gap = height + contact.heights.ravel() + root @ x
        energies, pressure, _ = contact.wall.evaluate(gap)
        return 0.5 * x @ x + energies.sum(), x - root.T @ pressure

    options = {"ftol": 1e-16, "gtol": 1e-10, "maxiter": 10000, "maxfun": 10000}
    start = np.zeros(len(G))
    return minimize(energy, start, jac=True, method="L-BFGS-B", options=options).fun


def test_energy_agrees_with_a_generic_minimiser(periodic, wall, solid):
    contact = scene(12, wall, periodic=periodic, solid=solid)
    height = contact.first_contact - 0.7
    state = relax(contact, height)[-1]
    assert state.energy == pytest.approx(minimum(contact, height), rel=1e-9)


def test_a_slack_spring_does_not_pull(solid):
    def hook(height):  # pulls down only above a height of 5
        stretch = max(height - 5.0, 0.0)
        return 0.5 * stretch**2 + 2.0 * height, -stretch - 2.0

    contact = scene(32, solid=solid)
    state = relax(contact, 20.0, hook)[-1]
    assert state.height < 5.0
    assert normal_force(contact, state) == pytest.approx(2.0, rel=1e-9)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_cold_start_finds_the_state_of_a_slow_approach(seed, solid):
    # under a stronger wall, soft solids, the isotropic one too, have several states
    compliance = solid.self_compliance(1.0) / Isotropic(1.0).self_compliance(1.0)
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.005 / max(compliance, 1.0))
    contact = scene(heights=sphere(64, seed), wall=wall, solid=solid)
    load = 10.0
    height = contact.wall.cutoff - contact.heights.min()
    state = relax(contact, height, start=np.zeros((64, 64)), tolerance=1e-3)[-1]
    while normal_force(contact, state) < load:
        height -= 0.05
        state = relax(contact, height, start=state.pressure, tolerance=1e-3)[-1]
    slow = relax(contact, height, constant(load), state.pressure)[-1]
    cold = relax(contact, height, constant(load))[-1]
    assert cold.energy == pytest.approx(slow.energy, rel=1e-11)


@pytest.mark.parametrize("load", [0.05, 2.0, 60.0])
@pytest.mark.parametrize("control", ["load", "height", "spring"])
def test_steps_with_and_without_the_inverse_of_a_wall_agree(
    periodic, load, control, solid
):
    class OnlyGaps(RepulsiveLennardJones93):
        kind = ""
        invertible = False

    states = []
    for wall in (REPULSIVE, OnlyGaps(**vars(REPULSIVE))):
        contact = scene(24, wall, periodic=periodic, solid=solid)
        height = contact.first_contact - 0.1 * load**0.5
        external = {"load": constant(load), "spring": spring(load, height - 1.0)}
        states.append(relax(contact, height, external.get(control))[-1])
    inverse, gaps = states
    assert inverse.energy == pytest.approx(gaps.energy, rel=1e-11, abs=1e-14)
    assert inverse.height == pytest.approx(gaps.height, rel=1e-9)


def test_a_wall_with_a_wrong_inverse_relaxes_without_it(solid):
    class Wrong(RepulsiveLennardJones93):
        kind = ""

        def inverse(self, pressure):
            gap, exact, stiffness = super().inverse(pressure)
            return gap, exact + 0.01, stiffness

    contact = scene(24, Wrong(**vars(REPULSIVE)), solid=solid)
    wrong = relax(contact, 0.0, constant(9.0))[-1]
    right = relax(scene(24, solid=solid), 0.0, constant(9.0))[-1]
    assert wrong.energy == pytest.approx(right.energy, rel=1e-11)


def test_a_tolerance_below_rounding_is_reported_and_the_best_state_kept(solid):
    *_, last = steps(scene(24, solid=solid), 9.0, tolerance=1e-18)
    assert not last.converged
    assert last.status.kind == newton.ROUNDING
    assert last.error < 1e-12


@pytest.mark.parametrize("solver", [newton_krylov, active_set])
def test_the_contact_may_be_a_keyword(solver):
    wall = rc.HardWall() if solver is active_set else REPULSIVE
    options = {"external": constant(9.0), "start": None, "tolerance": 1e-6}
    states = list(solver(contact=scene(wall=wall), height=0.0, **options))
    assert states[-1].converged
    assert pairs(states) > 1.0


def test_a_gap_that_is_not_finite_is_reported():
    contact = scene(16)
    displacement = contact.halfspace.displacement
    contact.halfspace.displacement = lambda pressure: displacement(pressure) * np.nan
    *_, last = steps(contact, height=-3.0)
    assert not last.converged
    assert last.status.kind == newton.NOT_FINITE


def test_an_indenter_that_nothing_holds_is_reported(solid):
    *_, last = steps(scene(16, solid=solid), -1.0, 9.0)
    assert not last.converged
    assert last.status.kind == newton.NOT_HELD


@pytest.mark.parametrize("height", [60.0, -15.0])
def test_a_load_is_carried_from_any_height(height, wall, solid):
    contact = scene(24, wall, solid=solid)
    start = np.zeros((24, 24))
    state = relax(contact, height, constant(10.0), start)[-1]
    assert normal_force(contact, state) == pytest.approx(10.0, rel=1e-10)


def test_one_atom_is_a_wall_and_its_own_compliance_in_series(solid):
    heights = np.full((33, 33), 9.0)
    heights[16, 16] = 0.0
    contact = scene(heights=heights, solid=solid)
    state = relax(contact, 0.0, constant(0.05))[-1]
    depth = 0.05 * contact.halfspace.self_compliance
    gap = np.array([state.height + depth])
    assert REPULSIVE.evaluate(gap)[1] == pytest.approx(0.05, rel=1e-8)


@pytest.mark.parametrize(
    ("wall", "most"), [(REPULSIVE, 40.0), (ADHESIVE, 150.0)], ids=["rep", "adh"]
)
def test_a_cold_start_costs_few_transforms(wall, most, solid):
    contact = scene(128, wall, solid=solid)
    states = relax(contact, 0.0, constant(60.0), tolerance=1e-6)
    assert pairs(states) < most
    assert contact.halfspace.window_transform.pairs <= most / 2.0


def test_a_stiff_wall_costs_few_transforms():
    # 129 pairs if steps are combined after a step that has increased the residual
    wall = rc.LennardJones93.repulsive(1.0, 1.0, stiffness=1e4)
    rough = rc.SelfAffine(0.1, 0.8, 4.0, 96.0, seed=1)
    heights = rough_sphere((96, 96), 960.0, rough)
    contact = scene(heights=heights, wall=wall, solid=Isotropic(1.0))
    states = relax(contact, 0.0, constant(33.0), tolerance=1e-6)
    assert pairs(states) <= 76.0


def test_a_large_contact_costs_few_steps():
    # steps with the model alone are 30, as each leaves most of the longest waves
    rough = rc.SelfAffine(0.01, 0.8, 4.0, 512.0, seed=2)
    heights = rough_sphere((576, 576), 300.0, rough)
    contact = scene(heights=heights, solid=Isotropic(1.0))
    load = float(rc.theory.Hertz(300.0, 1.0).force(260.0))
    states = relax(contact, 0.0, constant(load), tolerance=1e-6)
    assert len(states) <= 20
    assert pairs(states) <= 48.0


def test_a_start_far_from_the_load_costs_less_than_twice_a_cold_one(solid):
    contact = scene(96, solid=solid)
    light = relax(contact, 0.0, constant(20.0))[-1]
    heavy = relax(contact, light.height, constant(60.0), light.pressure)
    cold = relax(contact, 0.0, constant(60.0))
    assert pairs(heavy) < 2 * pairs(cold)
    assert heavy[-1].energy == pytest.approx(cold[-1].energy, rel=1e-12)


def test_a_threefold_load_converges_from_a_warm_start(solid):
    rough = rc.SelfAffine(0.1, 0.8, 4.0, 512.0, seed=1)
    heights = rc.RoughSphere(1000.0, rough).heights((480, 480), 1.0, (-240.0, -240.0))
    contact = scene(480, heights=heights, solid=solid)
    light = relax(contact, 0.0, constant(1067.0))[-1]
    heavy = relax(
        contact,
        light.height,
        constant(3373.0),
        light.pressure,
        max_load_change=np.inf,
    )
    cold = relax(contact, 0.0, constant(3373.0))[-1]
    assert heavy[-1].energy == pytest.approx(cold.energy, rel=1e-12)
    assert len(heavy) < 60


@pytest.mark.parametrize("work", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("seed", [0, 1, 4])
def test_atoms_deep_in_the_core_do_not_stall_those_that_are_attracted(
    seed, work, solid
):
    rough = rc.SelfAffine(0.1, 0.8, 4.0, 64.0, seed=seed, domain=512.0)
    heights = rc.RoughSphere(1000.0, rough).heights((64, 64), 1.0, (-32.0, -32.0))
    wall = rc.LennardJones93.adhesive(1.0, 1.0, work)
    contact = scene(heights=heights, wall=wall, solid=solid)
    states = relax(contact, contact.first_contact - 0.5, tolerance=1e-6)
    assert abs(wall_pressure(contact, states[-1]) - states[-1].pressure).max() < 1e-6
    assert len(states) < 50
