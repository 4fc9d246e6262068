"""Steps away from an attractive wall that are longer than its range."""

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.theory import MaugisDugdale

RADIUS, WORK, RANGE = 100.0, 0.04, 0.4
# A step of 3.5 times the range, in parts of half of it, and one that tears off.
COARSE, PARTS, TORN = [0.8, -0.6], np.linspace(0.8, -0.6, 8), -1.2
COLUMNS = "normal_force", "energy", "repulsive_atoms", "attractive_atoms"


class Flat:
    """Flat square punch."""

    def __init__(self, side):
        self.side = side

    def heights(self, shape, spacing, origin):
        x, y = (
            start + spacing * np.arange(n)
            for n, start in zip(shape, origin, strict=True)
        )
        outside = np.maximum(abs(x)[:, None], abs(y)) > self.side / 2
        return np.where(outside, 100.0, 0.0)

    def todict(self):
        return {"name": "flat", "side": self.side}


def tip(wall=None, sphere=None, shape=(44, 44), **options):
    sphere = sphere or rc.RoughSphere(radius=RADIUS)
    return atoms_under(sphere, wall or rc.DugdaleWall(WORK, RANGE), shape, **options)


def path(targets, atoms=None, **options):
    options = {"validity": "ignore", **options}
    return list(rc.load_path(atoms or tip(), penetrations=targets, **options))


def assert_same(found, expected, columns=COLUMNS):
    for name in columns:
        expected_value = pytest.approx(getattr(expected, name), rel=1e-3)
        assert getattr(found, name) == expected_value, name


def test_a_contact_holds_in_a_step_longer_than_the_range_of_the_wall():
    coarse, fine = path(COARSE), path(PARTS)
    assert_same(coarse[-1], fine[-1])
    curve, forces = MaugisDugdale(RADIUS, 1.0, WORK, RANGE).curve(20.0)
    stable = slice(int(np.argmin(curve)), None)
    theory = np.interp(COARSE[-1], curve[stable], forces[stable])
    assert coarse[-1].normal_force == pytest.approx(theory, rel=0.03)


def test_asperities_hold_in_a_step_in_which_others_remain_in_contact():
    sphere = rc.RoughSphere(200.0, rc.SelfAffine(0.15, 0.8, 8.0, 32.0, seed=2))
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.04)
    coarse, fine = (
        path(targets, tip(wall, sphere, (48, 48)), window="unchecked")[-1]
        for targets in ([2.0, -0.5], np.linspace(2.0, -0.5, 17))
    )
    assert_same(coarse, fine, ["normal_force", "repulsive_atoms"])


def test_heights_are_followed_as_penetrations_are():
    expected = path(COARSE)
    heights = [step.height for step in expected]
    (*_, last) = rc.load_path(tip(), heights=heights, validity="ignore")
    assert_same(last, expected[-1])


@pytest.mark.parametrize(
    ("cell", "options"), [({}, {"window": "auto"}), ({"periodic": True}, {})]
)
def test_windows_and_cells_follow_the_contact(cell, options):
    coarse = path(COARSE, tip(**cell), **options)
    assert_same(coarse[-1], path(PARTS, tip(**cell), **options)[-1])


def test_a_contact_that_does_not_hold_has_torn_off():
    coarse = path([0.8, TORN])[-1]
    fine = path(np.linspace(0.8, TORN, 21))[-1]
    assert coarse.normal_force == fine.normal_force == 0.0
    assert coarse.converged


def test_an_approach_from_outside_finds_no_contact():
    (step,) = path(COARSE[-1:])
    assert step.normal_force == 0.0


def test_the_cost_of_the_parts_counts_in_the_step():
    coarse, fine = path(COARSE)[-1], path(PARTS)[1:]
    pairs = sum(step.pairs for step in fine)
    assert coarse.pairs == pytest.approx(pairs, rel=0.2)
    assert coarse.pairs > 1.5 * fine[-1].pairs
    assert coarse.iterations > fine[-1].iterations


def test_short_steps_cost_what_they_did():
    short = path(PARTS)
    assert max(step.pairs for step in short) < 1.5 * short[0].pairs


def test_a_resumed_path_follows_the_contact(tmp_path):
    expected = path(COARSE)[-1]
    output = rc.Output(trajectory=tmp_path / "path.traj", resume=True)
    path(COARSE[:1], output=output)
    assert_same(path(COARSE, output=output)[-1], expected)


def test_a_path_begins_with_the_contact_of_its_atoms():
    atoms = tip()
    path(COARSE[:1], atoms)
    assert_same(path(COARSE[1:], atoms)[-1], path(COARSE)[-1])


@pytest.mark.parametrize("coupling", ["neglected", "solved"])
def test_a_sliding_tip_is_raised_with_its_contact(coupling):
    solid, friction = Isotropic(1.0, poisson=0.4), rc.Coulomb(0.3)
    options = {"displacements": [0.0, 0.1], "validity": "ignore", "coupling": coupling}
    coarse = list(
        rc.sliding_path(tip(solid=solid), friction, penetrations=COARSE, **options)
    )
    options["displacements"] = np.append(np.zeros(len(PARTS) - 1), 0.1)
    fine = list(
        rc.sliding_path(tip(solid=solid), friction, penetrations=PARTS, **options)
    )
    assert_same(coarse[-1], fine[-1], ["normal_force", "contact_area"])
    assert coarse[-1].lateral_force_x == pytest.approx(
        fine[-1].lateral_force_x, rel=0.02
    )
    assert coarse[-1].pairs > 2.0 * fine[-1].pairs


def test_a_flat_punch_whose_atoms_are_all_pulled_holds():
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.02, attraction_range=0.5)

    def pulled(targets):
        return path(targets, tip(wall, Flat(20.0), (30, 30)), window="unchecked")[-1]

    fine = pulled([0.1, -0.2, -0.4, -0.6, -0.8, -1.0])
    assert fine.repulsive_atoms == 0 and fine.normal_force < 0.0
    assert_same(pulled([0.1, -0.2, -1.0]), fine)
    assert_same(pulled([0.1, -1.0]), fine)
