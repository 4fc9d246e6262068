"""The section [heterogeneity] of a scene, and hard walls with attraction in scenes."""

import numpy as np
import pytest

from ase_roughcontact.scene import Scene

TEXT = """
substrate = { model = "atoms", contact_modulus = 100.0, spacing = 2.0 }
sphere = { unit = "a0", radius = 60.0 }
interaction = { kind = "exponential", work_of_adhesion = 0.3 }
path = { control = "penetration", values = [-0.1, 0.2] }
"""
RANDOM = "[heterogeneity]\nrms = 0.3\nshort_wavelength = '8 Å'\nseed = 5\n"


def test_random_field_in_spacings_follows_from_its_seed(tmp_path):
    scene = Scene.parse(TEXT + RANDOM)
    field = scene.bodies.problem.heterogeneity.pattern
    assert (field.short_wavelength, field.long_wavelength) == (8.0, 64.0)
    assert (scene.bodies.problem.heterogeneity.rms, field.seed) == (0.3, 5)
    assert Scene.parse(scene.toml) == scene
    other = scene.with_values({"heterogeneity.seed": 6})
    forces = [
        [step.normal_force for step in each.relax(validity="ignore")]
        for each in (Scene.parse(TEXT), scene, other)
    ]
    assert len({round(last, 6) for _, last in forces}) == 3


@pytest.mark.parametrize(
    "wall, period",
    [("exponential", 512.0), ("full", 512.0), ("adhesive", 128.0)],
)
def test_default_period_holds_the_window_of_a_long_range(wall, period):
    text = TEXT.replace("exponential", wall).replace("= 60.0", "= 600.0")
    scene = Scene.parse(text + RANDOM)
    assert scene.bodies.problem.heterogeneity.pattern.side == period * scene.spacing
    given = scene.with_values({"heterogeneity.domain": "128 a0"})
    assert given.bodies.problem.heterogeneity.pattern.side == 128.0 * scene.spacing


def test_file_is_a_map_of_the_work_of_adhesion(tmp_path):
    values = np.arange(1.0, 17.0).reshape(4, 4)
    np.savetxt(tmp_path / "w.txt", values)
    text = TEXT + "[heterogeneity]\nfile = 'w.txt'\n"
    scene = Scene.parse(text, str(tmp_path / "my.toml"))
    factors = scene.bodies.problem.heterogeneity.factors((4, 4), 2.0, (-4.0, -4.0))
    np.testing.assert_allclose(factors, values / 8.5, rtol=1e-12)
    assert scene.files == [str(tmp_path / "w.txt")]


@pytest.mark.parametrize(
    "text, message",
    [
        (TEXT + "[heterogeneity]\n", "give rms, of a random field, or file"),
        (
            '[substrate]\nmaterial = "Cu"\n' + RANDOM,
            r"\[heterogeneity\] .*kind = .repulsive.*omit \[heterogeneity\]",
        ),
        (TEXT + RANDOM.replace("8 Å", "3 Å"), "short_wavelength must be at least"),
    ],
)
def test_invalid_sections_are_errors(text, message):
    with pytest.raises(ValueError, match=message):
        Scene.parse(text).check()


def test_an_empty_file_is_named(tmp_path):
    (tmp_path / "empty.npy").write_bytes(b"")
    text = TEXT + "[heterogeneity]\nfile = 'empty.npy'\n"
    with pytest.raises(ValueError, match=r"cannot read a matrix from .*empty\.npy"):
        Scene.parse(text, str(tmp_path / "my.toml")).check()
