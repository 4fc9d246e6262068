"""Scenes with realisations of a scan: seeds, identity, ensembles, places, resuming."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from ase_roughcontact import SelfAffine
from ase_roughcontact.cli import main
from ase_roughcontact.ensemble import product, read_ensemble, run_ensemble, run_places
from ase_roughcontact.ensemble.study import is_seed
from ase_roughcontact.scene import Scene

SCENE = """
[substrate]
contact_modulus = 100.0
spacing = "0.5 nm"
hardness = inf
[sphere]
unit = "a0"
radius = {radius}
[topography]
file = "scan.npy"
role = "substrate"
spacing = "1 nm"
unit = "nm"
{keys}
[interaction]
kind = "hard"
[path]
values = [{load}]
"""
#: Heights (nm) of a worn surface, which are not Gaussian.
HEIGHTS = SelfAffine(0.05, 0.8, 4.0, 24.0, domain=96.0, seed=2).heights((48, 48), 1.0)
HEIGHTS -= 0.7 * np.maximum(HEIGHTS - 0.05, 0.0)


@pytest.fixture
def scene_with(tmp_path):
    """Return a function that reads a scene beside its scan."""
    np.save(tmp_path / "scan.npy", HEIGHTS)

    def read(keys="seed = 3", radius='"30 nm"', load='"1 nN"'):
        text = SCENE.format(keys=keys, radius=radius, load=load)
        (tmp_path / "scene.toml").write_text(text)
        return Scene.read(tmp_path / "scene.toml")

    return read


def test_each_seed_is_another_surface_with_the_slope_of_the_scan(scene_with):
    scan = scene_with("").rough.statistics()
    found = [scene_with(f"seed = {seed}").rough for seed in (0, 1)]
    assert found[0] != found[1]
    for rough in found:
        assert rough.statistics().rms_slope == pytest.approx(scan.rms_slope, rel=0.05)
        assert rough.periods == (480.0, 480.0)


def test_the_highest_point_of_the_realisation_is_on_the_axis(scene_with):
    rough = scene_with('seed = 3\ncenter = "highest"').rough
    heights = rough.heights((48, 48), 10.0, tuple(-np.array(rough.center)))
    assert rough.heights((1, 1), 10.0)[0, 0] == pytest.approx(heights.min())


def test_the_identity_has_the_seed_and_the_contents_of_the_scan(scene_with, tmp_path):
    scan, first, second = (scene_with(k) for k in ("", "seed = 0", "seed = 1"))
    assert len({scan.identity, first.identity, second.identity}) == 3
    before = first.identity
    assert Scene.parse(first.toml).identity == before
    text = SCENE.format(keys="seed = 0", radius='"30 nm"', load='"1 nN"')
    np.save(tmp_path / "scan.npy", 1.1 * HEIGHTS)
    assert Scene.parse(text, str(tmp_path / "scene.toml")).identity != before


def test_seeds_are_cases_of_an_ensemble_and_a_run_is_resumed(scene_with, tmp_path):
    scene = scene_with()
    cases = product(scene, {"roughness.seed": [0, 1]})
    again = product(scene, {"topography.seed": [0, 1]})
    assert [each.identity for each in cases] == [each.identity for each in again]
    assert is_seed("topography.seed")
    with ThreadPoolExecutor(1) as pool:
        for _ in run_ensemble(cases, tmp_path / "tips.db", pool):
            pass
    found = read_ensemble(tmp_path / "tips.db")
    assert sorted(found["seed"]) == [0, 1]
    assert len(set(found["penetration"])) == 2
    (first,) = scene.run(tmp_path / "out", validity="ignore")
    (resumed,) = Scene.of_results(tmp_path / "out").run(tmp_path / "out", "ignore")
    assert resumed.penetration == first.penetration


def test_a_map_of_places_is_made_on_a_realisation(scene_with, tmp_path):
    scene = scene_with()
    with ThreadPoolExecutor(1) as pool:
        places = list(run_places(scene, (1, 2), tmp_path / "map", pool))
    assert all(each.converged for each in places)
    assert places[0].area != places[1].area


def test_a_flat_is_pressed_with_a_realisation(scene_with):
    scene = scene_with(radius="inf", load='"20 MPa"')
    (step,) = scene.relax(validity="ignore", scan_errors=False)
    assert 0.0 < step.continuum_area < scene.bodies.nominal_area
    assert scene.bodies.problem.topography.rough.edge_change == 0.0


def test_the_plan_says_that_it_is_a_realisation(scene_with, tmp_path, capsys):
    scene_with()
    assert main(["plan", str(tmp_path / "scene.toml")]) == 0
    assert "realisation with seed 3" in capsys.readouterr().out


def test_a_tip_is_not_made_random(scene_with, tmp_path):
    x = np.arange(48.0) - 23.5
    np.save(tmp_path / "scan.npy", -(x[:, None] ** 2 + x**2) / 60.0)
    with pytest.raises(ValueError, match="curvature"):
        scene_with("seed = 0")


def test_a_seed_that_is_no_number_is_refused(scene_with):
    for seed in ("-1", "1.5"):
        with pytest.raises(ValueError, match="seed must be"):
            scene_with(f"seed = {seed}")
