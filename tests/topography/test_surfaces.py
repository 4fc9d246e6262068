"""All surfaces: copies, and the windows on which they are sampled."""

import copy
import math
import pickle

import numpy as np
import pytest

from ase_roughcontact.topography import HeightMap, RoughSphere, SelfAffine

# Waves of 4 to 32 on a domain of 128.
SURFACE = SelfAffine(0.1, 0.8, 4.0, 32.0, seed=7)
BUMPS = np.random.default_rng(0).standard_normal((9, 12))
SURFACES = [SURFACE, RoughSphere(10.0, SURFACE), HeightMap(BUMPS, 1.0)]


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize(
    "copied", [copy.deepcopy, lambda s: pickle.loads(pickle.dumps(s))]
)
def test_copies_are_the_same_surface(surface, copied):
    twin = copied(surface)
    assert twin == surface
    assert hash(twin) == hash(surface)


@pytest.mark.parametrize("surface", SURFACES)
def test_changes_of_returned_heights_do_not_change_the_surface(surface):
    first = surface.heights((4, 4), 1.0)
    expected = first.copy()
    first += 1.0
    np.testing.assert_array_equal(surface.heights((4, 4), 1.0), expected)


@pytest.mark.parametrize("surface", SURFACES)
@pytest.mark.parametrize(
    ("window", "message"),
    [
        ({"shape": (0, 4)}, "shape must be .*>= 1"),
        ({"shape": (4.5, 4)}, "shape must be"),
        ({"shape": 4}, "shape must be"),
        ({"spacing": 0.0}, "spacing must be a finite number > 0"),
        ({"spacing": math.nan}, "spacing must be a finite number > 0"),
        ({"origin": (0.0, math.inf)}, "origin_y must be a finite number, got inf"),
        ({"origin": 0.0}, "origin must be"),
        ({"origin": ("a", 0.0)}, "origin_x must be a finite number"),
    ],
)
def test_invalid_windows_are_refused(surface, window, message):
    window = {"shape": (4, 4), "spacing": 1.0} | window
    with pytest.raises(ValueError, match=message):
        surface.heights(**window)
