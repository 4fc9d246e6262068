"""An indenter that is defined outside of the package, by one class."""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from built import atoms_under
from written_path import written_path

from ase_roughcontact import (
    DugdaleWall,
    RoughContact,
    RoughSphere,
    load_path,
    substrate,
)
from ase_roughcontact.topography import BoundedSurface, Topography
from ase_roughcontact.topography.topography import topography_of

A0 = 1.0


@dataclass(frozen=True)
class Cone(BoundedSurface):
    """Cone with sides that rise with a slope."""

    slope: float

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        x, y = (o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True))
        return self.slope * np.hypot(x[:, None], y)

    def reach(self, level, spacing, origin=(0.0, 0.0)):
        return max(level, 0.0) / self.slope


@dataclass(frozen=True)
class Ball(BoundedSurface):
    """Paraboloid, which has a radius and no roughness."""

    radius: float

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        x, y = (o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True))
        return (x[:, None] ** 2 + y**2) / (2.0 * self.radius)

    def reach(self, level, spacing, origin=(0.0, 0.0)):
        return math.sqrt(2.0 * self.radius * max(level, 0.0))


class Flute:
    """Waves without end, described by their heights alone."""

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        x = origin[0] + spacing * np.arange(shape[0])
        return np.repeat(1.0 - np.cos(x / 3.0)[:, None], shape[1], axis=1)


def path(indenter, depths, shape=(24, 24), **options):
    """Press an indenter into atoms."""
    atoms = atoms_under(indenter, shape=shape, spacing=A0)
    return list(written_path(atoms, depths, **options))


def test_window_follows_the_contact_and_gives_the_result_of_a_large_one():
    chosen = path(Cone(0.2), [0.5, 2.0], shape=(4, 4), window="auto")
    fixed = path(Cone(0.2), [0.5, 2.0], shape=(48, 48))
    assert chosen[0].window != chosen[1].window
    for one, other in zip(chosen, fixed, strict=True):
        assert one.converged
        assert one.normal_force == pytest.approx(other.normal_force, rel=1e-4)


def test_load_agrees_with_sneddon():
    (record,) = path(Cone(0.05), [4.0], window="auto")
    # I. N. Sneddon, Int. J. Eng. Sci. 3, 47 (1965): N = 2 E* d^2/(pi slope)
    assert record.normal_force == pytest.approx(2 * 4.0**2 / (np.pi * 0.05), rel=0.01)


def test_a_sphere_of_its_own_class_has_an_automatic_window_under_attraction():
    paths = []
    for sphere in (Ball(200.0), RoughSphere(200.0)):
        atoms = substrate("Cu", (8, 8), sphere, spacing=A0)
        atoms.calc = RoughContact(sphere, 1.0, DugdaleWall(0.05, 1.0))
        (step,) = load_path(atoms, penetrations=[0.5], window="auto")
        paths.append(step)
    own, known = paths
    assert own.converged and own.normal_force == pytest.approx(known.normal_force)


def test_path_is_resumed_with_the_same_indenter_only(tmp_path):
    files = {"trajectory": tmp_path / "path.traj", "resume": True, "window": "auto"}
    whole = path(Cone(0.2), [0.5, 1.0], window="auto")
    path(Cone(0.2), [0.5], **files)
    resumed = path(Cone(0.2), [0.5, 1.0], **files)
    assert resumed[1].normal_force == pytest.approx(whole[1].normal_force, rel=1e-4)
    with pytest.raises(ValueError, match=r"indenter\.slope was 0\.2, is 0\.3"):
        path(Cone(0.3), [0.5, 1.0], **files)


@pytest.mark.parametrize(
    "value, message",
    [
        (np.nan, "finite, got 64"),
        (np.inf, "finite, got 64"),
        ("1.0", "heights must be .* real numbers, got shape .* <U3"),
        (1.0 + 0.0j, "heights must be .* real numbers, got shape .* complex128"),
    ],
)
@pytest.mark.parametrize("height", [None, 1.0])
def test_heights_that_are_not_finite_real_numbers_are_refused(value, message, height):
    class Wrong:
        def heights(self, shape, spacing, origin=(0.0, 0.0)):
            return np.full(shape, value)

    with pytest.raises(ValueError, match=message):
        atoms = atoms_under(Wrong(), spacing=A0, height=height)
        atoms.get_potential_energy()


def test_a_window_that_exceeds_the_memory_is_an_error_with_advice():
    class Large(Flute):
        def heights(self, *_):
            raise MemoryError("Unable to allocate 671 GiB")

    with pytest.raises(MemoryError, match=r"window of 8 x 8 atoms .* smaller shape"):
        substrate("Cu", (8, 8), Large(), spacing=A0)


@pytest.mark.parametrize(
    ("indenter", "window", "method"),
    [
        (Flute(), "unchecked", r"BoundedSurface with a method reach.* fixed"),
        (RoughSphere(40.0, Flute()), "fixed", r"a method lowest.* fixed window"),
    ],
    ids=["indenter", "roughness"],
)
def test_heights_alone_are_enough_in_a_fixed_window(indenter, window, method):
    (record,) = path(indenter, [0.2], window=window)
    assert record.converged
    assert record.normal_force > 0.0
    with pytest.raises(ValueError, match=method):
        path(indenter, [0.2], window="auto")


class Ripples(Topography):
    """Waves along x, with what is known about them."""

    @property
    def shortest_wavelength(self):
        return 8.0

    @property
    def periods(self):
        return 8.0, np.inf

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        x = origin[0] + spacing * np.arange(shape[0])
        return np.repeat(-0.1 * np.cos(np.pi / 4.0 * x)[:, None], shape[1], axis=1)

    def lowest(self, spacing, origin=(0.0, 0.0)):
        return -0.1


class UnrelatedRipples:
    """The same waves in a class without the base class."""

    short_wavelength = 8.0
    periods = 8.0, np.inf
    heights = Ripples.heights
    lowest = Ripples.lowest


@pytest.mark.parametrize("rough", [Ripples(), UnrelatedRipples()])
def test_what_a_roughness_knows_is_used_with_and_without_the_base_class(rough):
    known = topography_of(RoughSphere(40.0, rough))
    assert known.rough.shortest_wavelength == 8.0
    assert known.periods == (8.0, np.inf)
    assert known.reach(0.7, A0) == pytest.approx(np.sqrt(2.0 * 40.0 * 0.8))


@pytest.mark.parametrize("rough", [Ripples(), UnrelatedRipples()])
def test_window_follows_a_sphere_with_a_roughness_of_ones_own(rough):
    sphere = RoughSphere(40.0, rough)
    (chosen,) = path(sphere, [0.5], shape=(4, 4), window="auto")
    (fixed,) = path(sphere, [0.5], shape=(32, 32))
    assert chosen.normal_force == pytest.approx(fixed.normal_force, rel=1e-4)


@pytest.mark.parametrize("indenter", [Flute(), Cone(0.2), Ripples()])
def test_what_an_indenter_does_not_define_is_not_known(indenter):
    known = topography_of(indenter)
    assert known.rough is known
    assert known.apex_radius == np.inf
    assert np.isnan([known.pixel, *vars(known.statistics()).values()]).all()


def test_a_smooth_sphere_has_a_roughness_of_height_zero():
    known = topography_of(RoughSphere(40.0))
    assert known.apex_radius == 40.0
    assert known.rough.statistics().rms_slope == 0.0
    assert not known.rough.heights((3, 2), A0).any()


def test_a_topography_without_heights_is_refused():
    class Nothing(Topography):
        pass

    with pytest.raises(TypeError, match="heights"):
        Nothing()


def test_slope_that_a_coarser_grid_loses_is_not_known_without_statistics():
    class Smoothed(Cone):
        def band_limited(self, shortest):
            return Cone(self.slope)

    with pytest.warns(UserWarning, match="not known"):
        (step,) = path(Smoothed(0.2), [0.5], grid="2 a0")
    assert step.converged
    assert np.isnan(step.area_error)
