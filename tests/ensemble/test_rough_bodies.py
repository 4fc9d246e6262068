"""Ensembles, places and resumed runs of two rough bodies."""

import numpy as np
import pytest
from ensemble_scenes import Here

from ase_roughcontact.ensemble import product, read_ensemble, run_ensemble, run_places
from ase_roughcontact.ensemble.means import mean_values
from ase_roughcontact.ensemble.study import study_points
from ase_roughcontact.scene import Scene

SPECTRUM = "unit = 'a0'\nshort_wavelength = 4.0\nlong_wavelength = 16.0\n"
TEXT = f"""
[substrate]
contact_modulus = 100.0
hardness = inf
spacing = 2.5
[tip]
contact_modulus = 300.0
[tip.roughness]
rms_slope = 0.03
{SPECTRUM}
[sphere]
unit = "a0"
radius = 60.0
[interaction]
kind = "hard"
[path]
values = [5.0, 20.0]
"""
SUBSTRATE = f"[substrate.roughness]\nrms_slope = 0.04\n{SPECTRUM}"
SCENE = Scene.parse(TEXT + SUBSTRATE)
LAST = SCENE.with_values({"path.values": (20.0,)})


def test_seeds_of_one_body_and_of_both_have_rows_and_means(tmp_path):
    database = tmp_path / "e.db"
    one = product(LAST, {"substrate.roughness.seed": [0, 1]})
    both = product(LAST, {"roughness.seed": [0, 1]})
    list(run_ensemble([*one, *both], database, Here()))
    rows = read_ensemble(database)
    # the first scenes of both are the same
    seeds = sorted(zip(rows["tip_seed"], rows["substrate_seed"], strict=True))
    assert seeds == [(0, 0), (0, 1), (1, 1)]
    assert rows["tip_rms_slope"] == pytest.approx(0.03)
    assert rows["substrate_rms_slope"] == pytest.approx(0.04)
    assert rows["rms_slope"] == pytest.approx(0.05)
    assert len(set(rows["contact_area"])) == 3
    [mean] = mean_values(both, database, "normal_force")
    assert mean.realisations == 2
    choices = {"sphere.radius": [60.0], "substrate.roughness.seed": [0, 1]}
    [point] = study_points(LAST, choices, database, "normal_force")
    assert point.mean.realisations == 2


def test_a_run_is_resumed_with_the_same_bodies_only(tmp_path):
    [whole] = [step for step in SCENE.run(tmp_path / "whole") if step.step == 1]
    shorter = SCENE.with_values({"path.values": (5.0,)})
    list(shorter.run(tmp_path / "part"))
    *_, last = SCENE.run(tmp_path / "part")
    assert last.contact_area == whole.contact_area
    assert last.height == whole.height
    other = SCENE.with_values({"substrate.roughness.seed": 3})
    with pytest.raises(ValueError, match=r"\[substrate.roughness\] seed was 0, is 3"):
        list(other.run(tmp_path / "part"))


def test_a_rough_tip_is_moved_over_a_scan_of_the_substrate(tmp_path):
    x, y = 2.5 * np.arange(41)[:, None], 2.5 * np.arange(41)
    bump = 4.0 * np.exp(-((x - 50.0) ** 2 + (y - 50.0) ** 2) / 800.0)
    np.save(tmp_path / "scan.npy", bump)
    scan = "[substrate.topography]\nfile = 'scan.npy'\nunit = 'Å'\nspacing = 2.5\n"
    scan += "detrend = 'none'\nmargin = 40.0\n"
    scene = Scene.parse(TEXT + scan, str(tmp_path / "scene.toml"))
    scene = scene.with_values({"path.values": (5.0,), "substrate.shape": (24, 24)})
    places = run_places(scene, (1, 3), tmp_path / "places", Here())
    found = sorted(places, key=lambda place: place.y)
    assert [place.y for place in found] == [40.0, 50.0, 60.0]
    for place in found:
        center = f"{place.x} Å", f"{place.y} Å"
        [step] = scene.with_values({"substrate.topography.center": center}).relax(
            scan_errors=False
        )
        assert place.penetration == pytest.approx(step.penetration, rel=1e-9)
    assert len({place.penetration for place in found}) == 3
