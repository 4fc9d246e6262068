"""Trade-off of grids for the continuum."""

import json

import numpy as np
import pytest

from ase_roughcontact.cli import main
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.grid_trials import GridTrial, grid_table, grid_trials

SCENE = Scene.parse("""
[substrate]
spacing = 2.0
contact_modulus = 100.0
hardness = inf
model = "continuum"
[sphere]
radius = 100.0
[roughness]
long_wavelength = 16.0
[interaction]
kind = "hard"
[path]
values = [30.0, 100.0]
""")


@pytest.fixture(scope="module")
def trials():
    return grid_trials(SCENE, SCENE.steps, 60.0)


def test_errors_are_those_against_the_limit_of_fine_grids(trials):
    labels = [trial.label for trial in trials]
    assert labels == ["coarsen 2", "refine 1", "refine 2", "refine 4"]
    fine = SCENE.with_values({"substrate.refine": 8}).relax()
    exact = np.array([step.continuum_area for step in fine])
    for trial in trials:
        steps = SCENE.with_values(trial.settings).relax()
        areas = np.array([step.continuum_area for step in steps])
        true = abs(areas / exact - 1.0).max()
        assert trial.area_error == pytest.approx(true, abs=2.0 * trial.limit_error)
        assert trial.error == trial.area_error + trial.limit_error
    assert trials[-1].area_error < trials[0].area_error / 1.5
    assert trials[-1].limit_error < 0.05


def test_grids_that_take_too_long_are_omitted():
    assert grid_trials(SCENE, SCENE.steps, 0.0) == ()


def test_grids_that_do_not_fit_the_window_are_omitted():
    odd = SCENE.with_values({"substrate.shape": (31, 31)})
    trials = grid_trials(odd, odd.steps[:1], 60.0)
    assert [trial.label for trial in trials] == ["refine 1", "refine 2", "refine 4"]


def test_table_recommends_the_cheapest_grid_that_suffices():
    made = [
        GridTrial({"substrate.refine": n}, 0.1 / n, 0.01, 1.0 * n, 1e9) for n in (1, 2)
    ]
    assert "error of 0.07: refine 2." in grid_table(made, 0.07)
    assert "error of 0.2: refine 1." in grid_table(made, 0.2)
    text = grid_table(made, 0.05)
    assert "No grid is known to have an error of 0.05 or less" in text
    assert "known to 1.0e-02" in text


@pytest.mark.parametrize("model", ["atoms", "continuum"])
def test_command_compares_grids_for_the_continuum_only(model, tmp_path, capsys):
    file = tmp_path / "my.toml"
    file.write_text(SCENE.with_values({"substrate.model": model}).toml)
    assert main(["tradeoff", str(file), "--error", "0.1", "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    grids = [line for line in lines if "limit_error" in line]
    assert len(grids) == (4 if model == "continuum" else 0)
