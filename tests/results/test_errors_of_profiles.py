"""Estimated errors of the continuum, against closed forms for rigid indenters.

Profiles r^n and flat punches: I. N. Sneddon, Int. J. Eng. Sci. 3, 47 (1965).
"""

import math
from dataclasses import dataclass

import numpy as np
import pytest
from built import atoms_under

from ase_roughcontact import HardWall, load_path
from ase_roughcontact.topography import BoundedSurface


@dataclass(frozen=True)
class Profile(BoundedSurface):
    """The heights of c r^n about an axis between the atoms, for E* = 1."""

    exponent: float
    radius: float
    shift: tuple[float, float] = (0.0, 0.0)

    @property
    def depth(self):
        """Penetration of a contact of the radius."""
        half = self.exponent / 2
        ratio = math.gamma(half + 1.0) / math.gamma(half + 0.5)
        return 0.3 * math.sqrt(math.pi) * ratio

    @property
    def force(self):
        """Force of a contact of the radius."""
        return 2.0 * self.radius * self.depth * self.exponent / (self.exponent + 1.0)

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        x, y = (o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True))
        r = np.hypot(x[:, None] - self.shift[0], y - self.shift[1])
        return 0.3 * (r / self.radius) ** self.exponent

    def reach(self, level, spacing, origin=(0.0, 0.0)):
        r = self.radius * (max(level, 0.0) / 0.3) ** (1.0 / self.exponent)
        return r + sum(self.shift)


@dataclass(frozen=True)
class Punch(BoundedSurface):
    """Flat punch, far above the surface beyond its radius."""

    radius: float
    depth: float = 0.5

    @property
    def force(self):
        return 2.0 * self.radius * self.depth

    def heights(self, shape, spacing, origin=(0.0, 0.0)):
        x, y = (o + spacing * np.arange(n) for o, n in zip(origin, shape, strict=True))
        return 1e3 * (np.hypot(x[:, None], y) > self.radius)

    def reach(self, level, spacing, origin=(0.0, 0.0)):
        return self.radius


def ratios(indenter, accuracy):
    """Return true errors over their estimates, at given load, height, penetration."""
    area, found = math.pi * indenter.radius**2, {}
    force, depth = indenter.force, indenter.depth
    targets = {"loads": force, "heights": -depth, "penetrations": depth}
    given = {"loads": ["force"], "heights": ["height"]}
    # the penetration counts from the lowest point of the grid
    given["penetrations"] = ["penetration", "height"]
    for control, target in targets.items():
        atoms = atoms_under(indenter, HardWall(), fixed=control != "loads")
        grid = {"grid": "continuum", "accuracy": accuracy, "window": "auto"}
        (step,) = load_path(atoms, **{control: [target]}, **grid, validity="ignore")
        errors = {
            "area": step.continuum_area - area,
            "force": step.normal_force - force,
            "height": step.height + depth,
            "penetration": step.penetration - depth,
        }
        for name, error in errors.items():
            if name not in given[control]:
                estimate = getattr(step, f"{name}_error")
                found[control, name] = abs(error) / estimate if error else 0.0
    return found


@pytest.mark.parametrize("accuracy", ["fast", "normal", "high"])
@pytest.mark.parametrize(
    "exponent, shift",
    [
        (1.0, (0.0, 0.0)),
        (1.0, (0.37, 0.0)),
        (1.0, (0.37, 0.13)),
        (1.5, (0.5, 0.5)),
        (2.0, (0.37, 0.13)),
        (4.0, (0.0, 0.0)),
        (8.0, (0.0, 0.0)),
    ],
)
def test_errors_of_profiles_are_below_twice_the_estimate(exponent, shift, accuracy):
    found = ratios(Profile(exponent, 12.3, shift), accuracy)
    assert len(found) == 8
    assert max(found.values()) < 2.0
    # and of its order where the lowest point has no part in it
    assert found["heights", "force"] > 0.3
    assert found["loads", "height"] > 0.3


@pytest.mark.parametrize("accuracy", ["fast", "normal", "high"])
@pytest.mark.parametrize("radius", [12.0, 30.0])
def test_edge_of_a_punch_is_an_error_of_force_and_height(radius, accuracy):
    found = ratios(Punch(radius), accuracy)
    assert max(found.values()) < 1.0
    for name in ("height", "penetration"):
        assert found["loads", name] > 0.1
    assert found["heights", "force"] > 0.1
    # the punch is flat: all errors of the force are errors of its edge
    assert found["penetrations", "force"] == pytest.approx(found["heights", "force"])


@pytest.mark.slow
@pytest.mark.parametrize("accuracy", ["fast", "normal", "high"])
@pytest.mark.parametrize("radius", [5.2, 12.3, 17.1, 30.0])
def test_errors_of_all_profiles(radius, accuracy):
    for exponent in (1.0, 1.5, 2.0, 4.0, 8.0):
        for shift in ((0.0, 0.0), (0.37, 0.0), (0.37, 0.13), (0.5, 0.5)):
            found = ratios(Profile(exponent, radius, shift), accuracy)
            assert max(found.values()) < 1.8  # 1.78 measured
    assert max(ratios(Punch(radius), accuracy).values()) < 0.5  # 0.48 measured
