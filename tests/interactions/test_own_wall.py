"""A wall that is defined outside of the package, by one class."""

from dataclasses import dataclass
from unittest.mock import patch

import numpy as np
import pytest
from ase.units import GPa
from built import atoms_under
from numpy.testing import assert_allclose
from small_scene import SMALL
from written_path import written_path

import ase_roughcontact as rc
from ase_roughcontact.cli import main
from ase_roughcontact.contact import Contact
from ase_roughcontact.contact.support import Support
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace
from ase_roughcontact.interactions import WALLS, Parameter
from ase_roughcontact.scene import Scene
from ase_roughcontact.solvers.soft.energy import ContactEnergy, EnergyState

with patch.dict(WALLS):  # other tests have the kinds of the package alone

    @dataclass(frozen=True)
    class Penalty(rc.Interaction):
        """Pressure proportional to the overlap."""

        kind = "penalty"
        parameters = {"modulus": Parameter("GPa", default=1e4, above=1.0)}
        cutoff = contact_distance = work_of_adhesion = attraction_range = 0.0

        stiffness: float

        @classmethod
        def for_substrate(cls, contact_modulus, spacing, **parameters):
            return cls(parameters["modulus"] / spacing)

        def evaluate(self, gap):
            overlap = np.maximum(-gap, 0.0)
            pressure = self.stiffness * overlap
            return 0.5 * pressure * overlap, pressure, self.stiffness * (gap < 0.0)


KEYS = '[interaction]\nkind = "penalty"\nmodulus = 2e5\n'


@pytest.fixture(autouse=True)
def known():
    with patch.dict(WALLS, penalty=Penalty):
        yield


def path(wall, depths, **files):
    """Press a sphere into 24 x 24 atoms."""
    sphere = rc.RoughSphere(radius=40.0)
    atoms = atoms_under(sphere, wall, (24, 24))
    return list(written_path(atoms, depths, **files))


def test_scene_file_makes_the_wall_from_its_parameters():
    scene = Scene.parse(SMALL + KEYS)
    assert scene.wall == Penalty(2e5 * GPa / scene.spacing)
    assert "wall=Penalty(" in repr(scene.atoms().calc)


class Exponential(Penalty):
    """Energy, pressure and stiffness are the same numbers, in one array."""

    cutoff = 30.0

    def evaluate(self, gap):
        pressure = self.stiffness * np.exp(-gap)
        return pressure, pressure, pressure


def test_wall_may_return_one_array_for_all():
    halfspace = FreeHalfSpace((3, 4), 1.0, 1.0)
    contact = Contact(halfspace, np.zeros((3, 4)), Exponential(0.5))
    energy = ContactEnergy.of(contact, Support.of(None))
    state = EnergyState(energy, np.full((3, 4), 0.1), 0.2)
    pressure = 0.5 * np.exp(-state.gap())
    assert_allclose(state.stiffness, pressure)
    assert_allclose(state.residual, pressure - 0.1)


def test_scene_file_may_leave_out_a_parameter_with_a_default():
    scene = Scene.parse(SMALL + '[interaction]\nkind = "penalty"\n')
    assert scene.wall == Penalty(1e4 * GPa / scene.spacing)


@pytest.mark.parametrize(
    "line, message",
    [
        ("modulus = 0.5", r"modulus .* > 1 GPa, got 0\.5"),
        ("modulus = nan", "modulus"),
        ("cutoff = 3.0", "'penalty' .* parameters: modulus"),
        ("module = 3.0", "did you mean 'modulus'"),
    ],
)
def test_wrong_parameters_are_refused_by_name(line, message):
    with pytest.raises(ValueError, match=message):
        Scene.parse(SMALL + f'[interaction]\nkind = "penalty"\n{line}\n').check()


@pytest.mark.usefixtures("no_pictures")
def test_command_runs_a_scene_with_the_wall(tmp_path, capsys):
    file = tmp_path / "penalty.toml"
    file.write_text(SMALL + KEYS)
    assert main(["run", str(file), "--out", str(tmp_path / "results")]) == 0
    assert "penalty wall" in capsys.readouterr().out


def test_hard_wall_of_a_user_is_relaxed_by_the_active_set():
    class Rigid(rc.Interaction):
        hard = True
        cutoff = contact_distance = work_of_adhesion = attraction_range = 0.0

        def evaluate(self, gap):
            return np.zeros((3, *np.shape(gap)))

    own, hard = path(Rigid(), [0.5])[0], path(rc.HardWall(), [0.5])[0]
    assert own.converged
    assert own.normal_force == hard.normal_force


def test_kind_of_another_wall_is_refused():
    with pytest.raises(ValueError, match=r"'hard' .* HardWall"):

        class Another(rc.Interaction):
            kind = "hard"


def test_unknown_unit_of_a_parameter_is_refused():
    with pytest.raises(ValueError, match="inch"):
        Parameter("inch")


@pytest.mark.parametrize(
    "own, depends",
    [
        ({}, False),
        ({"work_of_adhesion": 0.1}, True),
        ({"hardness": 1.0}, False),
        ({"hardness": 1.0, "permanent": True}, True),
    ],
)
def test_states_depend_on_those_before_by_attraction_or_a_kept_shape(own, depends):
    assert type("Own", (Penalty,), own)(10.0).depends_on_history == depends


# Walls that contradict themselves


class Faulty(Penalty):
    kind = ""

    def __init__(self, fault):
        super().__init__(10.0)
        object.__setattr__(self, "fault", fault)

    def evaluate(self, gap):
        return self.fault(gap, *super().evaluate(gap))


@pytest.mark.parametrize(
    "fault, words",
    [
        (lambda g, e, p, k: (e, -p, k), "pressure .* derivative"),
        (lambda g, e, p, k: (e, 1.01 * p, 1.01 * k), "pressure .* derivative"),
        (lambda g, e, p, k: (e, p, -k), "stiffness .* derivative"),
        (lambda g, e, p, k: (e, p, np.zeros_like(k)), "stiffness .* derivative"),
        (lambda g, e, p, k: (np.sqrt(g), p, k), "finite"),
        (lambda g, e, p, k: (e, p), "evaluate"),
        (lambda g, e, p, k: (e.sum(), p, k), "shape"),
    ],
    ids=["sign", "factor", "stiffness", "none", "NaN", "two", "sum"],
)
def test_a_wall_that_contradicts_itself_is_refused(fault, words):
    with (
        np.errstate(invalid="ignore"),
        pytest.raises(ValueError, match=words),
    ):
        path(Faulty(fault), [0.1])


def test_kinks_jumps_and_strong_walls_are_not_taken_for_errors():
    class Jump(Penalty):
        kind = ""
        cutoff = 1.0
        work_of_adhesion = attraction_range = 0.2

        def evaluate(self, gap):
            energy, pressure, stiffness = super().evaluate(gap)
            near = (gap >= 0.0) & (gap < 1.0)
            energy = energy - np.where(gap < 0.0, 0.2, 0.2 * (1.0 - gap) * near)
            return energy, pressure - 0.2 * near, stiffness

    for stiffness in (1e-6, 1.0, 1e9):
        assert path(Jump(stiffness), [-5.0])[0].normal_force == 0.0


def test_a_wall_without_its_attributes_is_refused_by_name():
    class Bare(rc.Interaction):
        def evaluate(self, gap):
            return gap, gap, gap

    with pytest.raises(ValueError, match=r"Bare .* cutoff"):
        path(Bare(), [0.1])


@pytest.mark.parametrize(
    ("wall", "kappa", "factor"),
    [
        (rc.HardWall(), rc.theory.KAPPA_HARD, 1.0),
        (Penalty(0.5), rc.theory.KAPPA_REPULSIVE, 3.0),
    ],
    ids=["hard", "soft"],
)
def test_a_wall_says_what_theory_needs_of_it(wall, kappa, factor):
    assert (wall.kappa_repulsive, wall.asperity_factor) == (kappa, factor)
    assert np.isnan(wall.extrapolated_below)


def test_a_wall_of_ones_own_may_have_a_kappa_of_its_own():
    class Measured(Penalty):
        kappa = 2.1

    assert Measured(0.5).kappa_repulsive == 2.1
    assert rc.LennardJones93.repulsive(1.0, 2.0).extrapolated_below == 1.0
