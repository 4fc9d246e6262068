"""A solid from outside the package: one class, used like the isotropic one."""

from dataclasses import dataclass, field

import numpy as np
import pytest
from ase.units import GPa

import ase_roughcontact as rc
from ase_roughcontact.elasticity.greens import ElasticSolid, Isotropic
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.elasticity.material import HARDNESS

STIFFNESS = 1.5  # of the foundation on the surface
SPHERE = rc.RoughSphere(radius=20.0)


class Coated(ElasticSolid):
    """Isotropic half space under an elastic (Winkler) foundation of stiffness k."""

    def __init__(self, contact_modulus, stiffness):
        self.contact_modulus, self.stiffness = contact_modulus, stiffness

    def wave_compliance(self, qx, qy):
        bare = Isotropic(self.contact_modulus)
        return bare.wave_compliance(qx, qy) + 1.0 / self.stiffness

    def cell_compliance(self, i, j, spacing):
        bare = Isotropic(self.contact_modulus).cell_compliance(i, j, spacing)
        return bare + ((np.asarray(i) == 0) & (np.asarray(j) == 0)) / self.stiffness


class Film(Coated):
    """The same as a layer of finite thickness."""

    thickness = 30.0


class Springs(rc.Interaction):
    """Linear springs instead of the foundation: p = -k g where the gap is negative."""

    cutoff = contact_distance = work_of_adhesion = attraction_range = 0.0

    def evaluate(self, gap):
        depth = np.maximum(-np.asarray(gap), 0.0)
        stiffness = np.where(depth > 0.0, STIFFNESS, 0.0)
        return 0.5 * STIFFNESS * depth**2, STIFFNESS * depth, stiffness


def relaxed(periodic, wall, trajectory=None, **solid):
    atoms = rc.substrate(
        "Cu", (24, 20), SPHERE, spacing=1.0, periodic=periodic, fixed=False
    )
    atoms.calc = rc.RoughContact(SPHERE, wall=wall, **solid)
    path = rc.load_path(
        atoms, loads=[5.0, 20.0], fmax=1e-9, output=rc.Output(trajectory=trajectory)
    )
    return list(path), atoms.calc.state(atoms)


def test_a_foundation_on_the_solid_acts_like_springs_on_the_indenter(
    periodic, tmp_path
):
    file = tmp_path / "coated.traj"
    coated, state = relaxed(periodic, rc.HardWall(), file, solid=Coated(1.0, STIFFNESS))
    springs, expected = relaxed(periodic, Springs(), contact_modulus=1.0)
    assert all(step.converged for step in coated + springs)
    for one, other in zip(coated, springs, strict=True):
        assert one.repulsive_atoms == other.repulsive_atoms > 10
    np.testing.assert_allclose(state.pressure, expected.pressure, atol=1e-6)


class OnlyWaves(ElasticSolid):
    """Isotropic half space without its response to pressure on a cell."""

    contact_modulus = 1.0

    def wave_compliance(self, qx, qy):
        return Isotropic(1.0).wave_compliance(qx, qy)


def test_periodic_boundaries_need_the_compliance_of_waves_alone():
    waves, state = relaxed(True, rc.HardWall(), solid=OnlyWaves())
    _, expected = relaxed(True, rc.HardWall(), contact_modulus=1.0)
    assert [step.converged for step in waves] == [True, True]
    np.testing.assert_array_equal(state.pressure, expected.pressure)
    with pytest.raises(NotImplementedError, match=r"OnlyWaves .* periodic"):
        relaxed(False, rc.HardWall(), solid=OnlyWaves())


def test_a_path_on_another_solid_is_not_resumed(tmp_path):
    file = tmp_path / "coated.traj"
    relaxed(False, rc.HardWall(), file, solid=Coated(1.0, STIFFNESS))
    atoms = rc.substrate("Cu", (24, 20), SPHERE, spacing=1.0, fixed=False)
    solid = Coated(1.0, 2.0)
    atoms.calc = rc.RoughContact(SPHERE, wall=rc.HardWall(), solid=solid)
    output = rc.Output(trajectory=file, resume=True)
    with pytest.raises(ValueError, match="stiffness"):
        list(rc.load_path(atoms, loads=[5.0], fmax=1e-9, output=output))


def test_contact_modulus_and_solid_exclude_each_other():
    atoms = rc.substrate("Cu", (4, 4), SPHERE, spacing=1.0)
    atoms.calc = rc.RoughContact(SPHERE, contact_modulus=1.0, solid=Isotropic(1.0))
    with pytest.raises(ValueError, match="contact_modulus or solid"):
        atoms.get_potential_energy()


@pytest.mark.parametrize("kind", [PeriodicHalfSpace, FreeHalfSpace])
def test_spectra_are_kept_for_equal_solids_only(kind):
    shape, grid = (8, 6), (20, 15)
    spectrum = kind(shape, 2.0, 1.5).spectrum(grid)
    assert kind((5, 5), 2.0, Isotropic(1.5)).spectrum(grid) is spectrum
    assert not spectrum.flags.writeable
    for other in (kind(shape, 2.0, 3.0), kind(shape, 1.0, 1.5)):
        np.testing.assert_allclose(other.spectrum(grid), spectrum / 2.0)
    solid = Coated(1.5, STIFFNESS)
    first = kind(shape, 2.0, solid).spectrum(grid)
    solid.contact_modulus, solid.stiffness = 3.0, 2.0 * STIFFNESS
    np.testing.assert_allclose(kind(shape, 2.0, solid).spectrum(grid), first / 2.0)


class Scaled(Isotropic):
    """With a parameter that the comparison of its base class leaves out."""

    factor = 1.0

    def wave_compliance(self, qx, qy):
        return self.factor * super().wave_compliance(qx, qy)


@dataclass(frozen=True)
class WithArray(Isotropic):
    """Frozen, but a parameter has no hash."""

    factors: np.ndarray = field(default_factory=lambda: np.array([2.0]))

    def wave_compliance(self, qx, qy):
        return self.factors[0] * super().wave_compliance(qx, qy)


def test_spectra_of_solids_that_are_not_compared_by_value_are_not_kept():
    bare = PeriodicHalfSpace((8, 8), 1.0, Isotropic(1.0)).spectrum((8, 8))
    for factor in (1.0, 5.0):
        solid = Scaled(1.0)
        object.__setattr__(solid, "factor", factor)
        spectrum = PeriodicHalfSpace((8, 8), 1.0, solid).spectrum((8, 8))
        np.testing.assert_allclose(spectrum, factor * bare)
    spectrum = PeriodicHalfSpace((8, 8), 1.0, WithArray(1.0)).spectrum((8, 8))
    np.testing.assert_allclose(spectrum, 2.0 * bare)


@pytest.mark.parametrize("solid, judged", [(Coated, True), (Film, False)])
def test_only_a_half_space_of_silicon_is_compared_with_the_hardness_of_it(
    solid, judged
):
    atoms = rc.substrate("Si", (12, 12), SPHERE)
    atoms.calc = rc.RoughContact(SPHERE, solid=solid(6.0, stiffness=100.0))
    (step,) = rc.load_path(
        atoms, penetrations=[0.5], window="unchecked", validity="ignore"
    )
    assert step.normal_force / step.contact_area > HARDNESS["Si"] * GPa
    assert ("hardness" in step.validity) == judged
