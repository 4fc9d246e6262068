"""Scenes with a power spectrum from a file: statistics, identity, ensembles, plans."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from ase_roughcontact.cli import main
from ase_roughcontact.cli.description import bodies
from ase_roughcontact.ensemble import product, read_ensemble, run_ensemble
from ase_roughcontact.scene import Scene

SCENE = """
[substrate]
spacing = 2.0
contact_modulus = 100.0
hardness = inf
[sphere]
radius = "20 nm"
[roughness]
kind = "spectrum"
file = "spectrum.csv"
domain = "64 a0"
{keys}
[interaction]
kind = "hard"
[path]
values = ["1 nN"]
"""
# 1/nm and nm^4; wavelengths from 12.8 to 1 nm
Q = np.geomspace(2 * np.pi / 12.8, 2 * np.pi / 1.0, 30)
DENSITY = 1e-3 * Q**-3.6


@pytest.fixture
def scene_with(tmp_path):
    """Return a function that reads a scene beside the file of the spectrum."""
    table = np.stack([Q, DENSITY], axis=1)
    np.savetxt(tmp_path / "spectrum.csv", table, header="q (1/nm), C2D (nm^4)")
    np.savetxt(tmp_path / "plain.csv", table)

    def read(keys="", **changes):
        text = SCENE.format(keys=keys)
        for old, new in changes.items():
            text = text.replace(old, new)
        (tmp_path / "scene.toml").write_text(text)
        return Scene.read(tmp_path / "scene.toml")

    return read


def rms_slope(scene):
    """Return the rms slope (1) of a period of a scene's roughness, by an FFT."""
    heights = scene.rough.heights((64, 64), 2.0)
    q = 2.0 * np.pi * np.fft.fftfreq(64, 2.0)
    power = abs(np.fft.fft2(heights, norm="forward")) ** 2
    return np.sqrt(((q[:, None] ** 2 + q**2) * power).sum())


def test_the_roughness_has_the_slope_of_the_file(scene_with):
    k = 2 * np.pi / 12.8 * np.fft.fftfreq(64, 1 / 64)
    q = np.hypot(k[:, None], k)
    inside = (q > Q[0] - 1e-9) & (q < Q[-1] + 1e-9)
    density = np.exp(np.interp(np.log(q[inside]), np.log(Q), np.log(DENSITY)))
    expected = np.sqrt((q[inside] ** 2 * density).sum()) / 12.8
    for seed in (0, 3):
        scene = scene_with(f"seed = {seed}")
        assert rms_slope(scene) == pytest.approx(expected, rel=1e-6)


def test_it_is_scaled_to_an_amplitude(scene_with):
    assert rms_slope(scene_with("rms_slope = 0.2")) == pytest.approx(0.2)
    scene = scene_with('rms_height = "0.3 nm"')
    assert scene.rough.heights((64, 64), 2.0).std() == pytest.approx(3.0)


def test_a_table_without_a_head_needs_unit_and_convention(scene_with):
    plain = {"spectrum.csv": "plain.csv"}
    keys = 'unit = "nm"\nconvention = "C2D"'
    assert rms_slope(scene_with(keys, **plain)) == pytest.approx(
        rms_slope(scene_with())
    )
    with pytest.raises(ValueError, match="convention"):
        scene_with('unit = "nm"', **plain)
    with pytest.raises(ValueError, match="unit"):
        scene_with('convention = "C2D"', **plain)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ("hurst = 0.8", "has no hurst"),
        ("anisotropy = 2.0", "has no anisotropy"),
        ('rms_height = "1 nm"\nrms_slope = 0.1', "give one of"),
    ],
)
def test_keys_of_other_kinds_are_refused(scene_with, keys, message):
    with pytest.raises(ValueError, match=message):
        scene_with(keys)


def test_a_grid_that_does_not_resolve_the_table_is_refused(scene_with):
    with pytest.raises(ValueError, match="short_wavelength must be at least"):
        scene_with(**{"spacing = 2.0": "spacing = 8.0"})
    cut = scene_with('short_wavelength = "2 nm"', **{"spacing = 2.0": "spacing = 8.0"})
    assert cut.rough.shortest_wavelength == pytest.approx(20.0)


def test_the_identity_follows_the_contents_of_the_file(scene_with, tmp_path):
    first = scene_with()
    renamed = tmp_path / "other.csv"
    renamed.write_bytes((tmp_path / "spectrum.csv").read_bytes())
    same = scene_with(**{"spectrum.csv": "other.csv"})
    assert same.identity == first.identity
    renamed.write_text(renamed.read_text().replace("e-04", "e-05", 1))
    assert scene_with(**{"spectrum.csv": "other.csv"}).identity != first.identity
    assert Scene.parse(first.toml).identity == first.identity


def test_the_statistics_are_printed_and_the_plan_is_made(scene_with, tmp_path, capsys):
    scene = scene_with()
    found = scene.rough.statistics()
    assert f"rms height {found.rms_height / 10:.4g} nm" in bodies(scene)["roughness"]
    assert main(["plan", str(tmp_path / "scene.toml")]) == 0
    assert f"slope {found.rms_slope:.4g}" in capsys.readouterr().out


def test_seeds_are_cases_of_an_ensemble_and_a_run_is_resumed(scene_with, tmp_path):
    scene = scene_with()
    cases = product(scene, {"roughness.seed": [0, 1]})
    with ThreadPoolExecutor(1) as pool:
        for _ in run_ensemble(cases, tmp_path / "tips.db", pool):
            pass
    found = read_ensemble(tmp_path / "tips.db")
    assert sorted(found["seed"]) == [0, 1]
    assert len(set(found["penetration"])) == 2
    first = list(scene.run(tmp_path / "out", validity="ignore"))
    again = Scene.of_results(tmp_path / "out")
    assert again.identity == scene.identity
    (step,) = again.run(tmp_path / "out", validity="ignore")
    assert step.penetration == first[0].penetration
