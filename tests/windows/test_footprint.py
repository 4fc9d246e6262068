"""Footprints: bounding boxes of the atoms where an indenter is below a level."""

import numpy as np
import pytest

from ase_roughcontact import HeightMap, RoughSphere, SelfAffine
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.windows.footprint import Footprint


def rough_sphere(seed=1, radius=60.0, domain=64.0):
    rough = SelfAffine(0.3, 0.8, 4.0, 16.0, seed=seed, domain=domain)
    return RoughSphere(radius, rough)


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("depth", [0.0, 0.05, 0.5, 3.0])
def test_box_contains_exactly_the_atoms_below_a_level(seed, depth):
    sphere = rough_sphere(seed)
    heights = sphere.heights((64, 64), 1.0, (-32.0, -32.0))
    found = Footprint(sphere, 1.0)
    assert found.lowest == heights.min()
    low = heights <= heights.min() + depth
    assert found.box_below(heights.min() + depth + 1e-12) == Box.bounding(
        low, (-32, -32)
    )


def test_box_of_a_level_does_not_depend_on_levels_asked_for_before():
    sphere = rough_sphere(radius=400.0, domain=128.0)
    footprint = Footprint(sphere, 1.0)
    levels = footprint.lowest + np.array([0.1, 1.0, 2.0, 4.0])
    boxes = [footprint.box_below(level) for level in levels]
    assert boxes == [Footprint(sphere, 1.0).box_below(level) for level in levels]
    assert boxes[-1].size > boxes[0].size


def test_lattice_may_be_shifted_relative_to_the_axis():
    sphere, origin = RoughSphere(50.0), (-0.25, 7.5)
    box = Footprint(sphere, 1.0, origin).box_below(0.5)
    heights = sphere.heights((40, 40), 1.0, (-20.25, -20.5))
    assert box.shape == Box.bounding(heights < 0.5, (0, 0)).shape


@pytest.mark.parametrize(
    "surface",
    [
        rough_sphere().roughness,
        RoughSphere(np.inf),
        HeightMap(np.eye(4), 1.0, periodic=True),
    ],
    ids=["self-affine", "flat", "periodic map"],
)
def test_unbounded_surface_needs_a_fixed_window(surface):
    with pytest.raises(ValueError, match=r"fixed\s+window"):
        Footprint(surface, 1.0).box_below(1.0)
