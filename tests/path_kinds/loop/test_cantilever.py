"""Force curves of a cantilever from a loop of heights."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from ase.constraints import Hookean
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact import cantilever_curve
from ase_roughcontact._util.units import UNITS

STIFFNESS = 2.0
DEEPEST = 2.5


def tip(**options):
    sphere = rc.RoughSphere(50.0)
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.05)
    return atoms_under(sphere, wall, (40, 40), **options)


@cache
def loop():
    return rc.adhesion_loop(
        tip(), deepest=DEEPEST, step=0.5, tolerance=3e-3, validity="ignore"
    )


def zero():
    """Height of first contact, from which distances of the base are counted."""
    first = loop().approach[0]
    return first.height + first.penetration


def curve(stiffness=STIFFNESS):
    return cantilever_curve(loop(), stiffness)


def test_a_stiff_cantilever_has_the_curve_of_the_held_tip():
    stiff = curve(1e6)
    assert stiff.pull_off_force == pytest.approx(loop().pull_off_force, rel=1e-6)
    assert stiff.snap_in.distance == pytest.approx(loop().jump_in - zero(), abs=2e-3)
    assert stiff.dissipated_energy == pytest.approx(loop().dissipated_energy, rel=1e-2)


def test_distance_and_deflection_are_the_negative_penetration():
    for branch in (curve().approach, curve().retraction):
        np.testing.assert_allclose(branch.force, STIFFNESS * branch.deflection)
    assert zero() > 0.5  # the range of the repulsion
    turn = curve().approach
    depth = -(turn.distance[-1] + turn.deflection[-1])
    assert depth == pytest.approx(loop().approach[-1].penetration)


def test_the_base_moves_in_one_direction_and_jumps_at_constant_distance():
    assert (np.diff(curve().approach.distance) <= 0.0).all()
    assert (np.diff(curve().retraction.distance) >= 0.0).all()
    for branch in (curve().approach, curve().retraction):
        for jump in branch.jumps:
            at = np.flatnonzero(branch.distance == jump.distance)
            assert branch.force[at[0]] == jump.force_before
            assert branch.force[at[-1]] == jump.force_after


def test_a_soft_cantilever_snaps_in_earlier_and_dissipates_more():
    stiff, soft = curve(20.0), curve(STIFFNESS)
    assert soft.snap_in.distance > stiff.snap_in.distance
    assert soft.snap_in.force_after < soft.snap_in.force_before < 0.0
    assert soft.dissipated_energy > stiff.dissipated_energy
    assert soft.pull_off.force_before == pytest.approx(-soft.pull_off_force, rel=1e-2)
    assert soft.pull_off.force_after > -0.01 * soft.pull_off_force


@pytest.mark.parametrize("branch", ["approach", "retraction"])
@pytest.mark.parametrize("share", [0.2, 0.7])
def test_states_agree_with_a_tip_on_a_spring(branch, share):
    followed = getattr(curve(), branch)
    states = getattr(loop(), branch)
    i = int(share * len(followed.distance))
    base, expected = followed.distance[i] + zero(), followed.force[i]
    atoms = tip(fixed=False)
    x, y, _ = atoms.positions[-1]
    near = min(states, key=lambda s: abs(s.height - base - expected / STIFFNESS))
    atoms.positions[-1, 2] = near.height
    # springs of both signs: one to a point far above and one far below
    far, half = 1e3, STIFFNESS / 2
    ends = (base + far, base - far)
    atoms.set_constraint(
        [Hookean(len(atoms) - 1, (x, y, end), half, rt=0.0) for end in ends]
    )
    assert rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-7)
    found = atoms.calc.state(atoms).normal_force
    assert found == pytest.approx(expected, abs=5e-3 * curve().pull_off_force)


def test_a_cantilever_that_jumps_beyond_the_loop_is_refused():
    (jump,) = loop().approach_jumps
    last = loop().approach.index(jump.after)
    way = loop().approach[: last + 1]
    shallow = replace(loop(), approach=way, retraction=(jump.after,))
    given = STIFFNESS / UNITS["J/m^2"]
    with pytest.raises(ValueError, match=rf"of {given:.4g} N/m jumps .* deepest .* nm"):
        cantilever_curve(shallow, STIFFNESS)
