"""Where loops turn, and when their pull-off force is a lower bound."""

from functools import cache

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.theory import JKR, MaugisDugdale

WORK = 0.005
NEWTON = 0.6241509  # 1 nN in eV/Å
ROUGH = rc.SelfAffine(0.3, 0.8, short_wavelength=4.0, long_wavelength=16.0, seed=1)


def tip(roughness=None, wall=None, radius=60.0):
    sphere = rc.RoughSphere(radius=radius, roughness=roughness)
    wall = wall or rc.LennardJones93.adhesive(1.0, 1.0, WORK)
    return atoms_under(sphere, wall, (20, 20))


def loop_of(atoms, deepest=None, **options):
    options = {"tolerance": 0.01, "validity": "ignore", "window": "auto", **options}
    return rc.adhesion_loop(atoms, deepest=deepest, **options)


@cache
def rough():
    """Loop of a rough tip that turns by itself."""
    return loop_of(tip(ROUGH))


def largest_tension(states):
    return -min(state.normal_force for state in states)


def test_a_loop_turns_where_it_is_pressed_as_much_as_it_was_pulled_before():
    *before, turn = rough().approach
    assert turn is rough().turn is rough().retraction[0]
    for number, state in enumerate(before, 1):
        assert state.normal_force < max(largest_tension(before[:number]), 1e-9)
    assert turn.normal_force >= largest_tension(before) > 0.0


def test_a_loop_deeper_than_its_roughness_is_wide_has_no_step(tmp_path):
    narrow = rc.SelfAffine(0.3, 0.8, 4.0, 16.0, seed=1, domain=40.0)
    table = rc.Output(csv=tmp_path / "loop.csv")
    with pytest.raises(ValueError, match="a domain of 60 grid spacings"):
        loop_of(tip(narrow), 4.0, output=table)
    assert not (tmp_path / "loop.csv").exists()


def test_the_pull_off_force_of_a_rough_tip_agrees_with_a_deep_loop():
    deep = loop_of(tip(ROUGH), 2.0 * rough().turn.penetration)
    assert rough().pull_off_force == pytest.approx(deep.pull_off_force, rel=0.015)
    assert not rough().turns_in_tension and not rough().warnings


def test_a_loop_that_turns_in_tension_is_warned_of_with_the_numbers():
    with pytest.warns(UserWarning, match="lower bound") as caught:
        shallow = loop_of(tip(ROUGH), 0.02)
    assert shallow.pull_off_force < 0.6 * rough().pull_off_force
    assert shallow.turns_in_tension
    (message,) = {str(each.message) for each in caught}
    forces = np.array([shallow.pull_off_force, -shallow.turn.normal_force])
    for number in (*forces / NEWTON, 0.02):
        assert f"{number:.4g} " in message
    assert f"at least {shallow.pull_off_force:.4g} eV/Å" in str(shallow)


def test_a_smooth_sphere_turns_by_itself_and_has_the_pull_off_force_of_theory():
    wall = rc.DugdaleWall(0.02, attraction_range=0.8)
    loop = loop_of(tip(wall=wall, radius=100.0))
    theory = MaugisDugdale(100.0, 1.0, 0.02, 0.8)
    assert loop.pull_off_force == pytest.approx(theory.pull_off_force, rel=0.01)
    jkr = JKR(100.0, 1.0, 0.02)
    under_load = jkr.penetration(jkr.contact_radius(jkr.pull_off_force))
    assert 0.0 < loop.turn.penetration < 1.2 * under_load


@pytest.mark.parametrize("wall", [rc.HardWall(), rc.LennardJones93.repulsive(1.0, 1.0)])
def test_a_wall_that_only_repels_needs_a_depth(wall):
    with pytest.raises(ValueError, match="needs deepest"):
        loop_of(tip(wall=wall))


class Glue(Interaction):
    """Wall that attracts at all gaps below its cutoff, and never repels."""

    cutoff, contact_distance, work_of_adhesion, attraction_range = 1.0, 0.0, 0.01, 1.0

    def evaluate(self, gap):
        below = np.minimum(gap - self.cutoff, 0.0)
        return 0.01 * below, np.where(below < 0.0, -0.01, 0.0), np.zeros_like(below)


def test_a_loop_that_is_never_pressed_ends_with_an_error():
    with pytest.raises(RuntimeError, match=r"does not turn.* give deepest"):
        loop_of(tip(wall=Glue()), step=10.0, tolerance=0.5)


@pytest.mark.parametrize("place", ["first", "before the turn", "turn", "retraction"])
def test_a_resumed_loop_turns_at_the_same_state(tmp_path, place):
    turn = len(rough().approach)
    counts = {"first": 1, "before the turn": turn - 1, "turn": turn}
    output = rc.Output(trajectory=tmp_path / "loop.traj", resume=True)

    last = counts.get(place, turn + 2) - 1

    def stop(state):
        if state.step == last:
            raise InterruptedError

    with pytest.raises(InterruptedError):
        loop_of(tip(ROUGH), output=output, callback=stop)
    resumed = loop_of(tip(ROUGH), output=output)
    assert resumed.turn.height == rough().turn.height
    assert len(resumed.approach) == turn
    assert resumed.pull_off_force == pytest.approx(rough().pull_off_force, rel=1e-6)
