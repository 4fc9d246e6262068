"""Progress and order of the cases of an ensemble, and units of its columns."""

from dataclasses import replace

import numpy as np
import pytest
from ase.db import connect
from ensemble_scenes import Here

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.ensemble import case_of, product, read_ensemble, run_ensemble
from ase_roughcontact.ensemble.columns import scene_columns
from ase_roughcontact.ensemble.progress import ProgressMeter
from ase_roughcontact.scene import InteractionConfig, Scene

SCENE = Scene.parse(
    """
    substrate = { model = "atoms", spacing = 2.5, contact_modulus = 80.0 }
    sphere = { unit = "a0", radius = 60.0 }
    path = { control = "penetration", values = [0.1] }
    """
)


def finish(scenes, database):
    """Run one case after another; return the last progress."""
    return list(run_ensemble(scenes, database, Here(), interval=1e-3))[-1]


def order(database):
    """Return the cases in the order of their first steps."""
    rows = connect(database).select(record="step")
    return list(dict.fromkeys(row.case for row in sorted(rows, key=lambda r: r.id)))


# Variants of the scene, the most expensive one last.
MOST_EXPENSIVE_LAST = {
    "penetrations": {"path.values": [(0.1,), (8.0,)]},
    "heights": {"path.values": [(2.0, 2.0, -6.0), (2.0, -3.0, -3.0)]},
    "loads": {"path.values": [(1.0,), (2000.0,)]},
    "many small steps": {"path.values": [(4.0,), (0.1, 0.1, 0.1)]},
    "larger windows": {"substrate.shape": [(40, 40), (80, 80)]},
}
CONTROLS = {"heights": "height", "loads": "load"}


@pytest.mark.parametrize("variants", MOST_EXPENSIVE_LAST)
def test_the_most_expensive_cases_are_calculated_first(variants, tmp_path):
    control = CONTROLS.get(variants, "penetration")
    scene = replace(SCENE, path=SCENE.path.changed("control", control))
    cheap, expensive = product(scene, MOST_EXPENSIVE_LAST[variants])
    finish([cheap, expensive], tmp_path / "e.db")
    assert order(tmp_path / "e.db") == [case_of(expensive), case_of(cheap)]


def test_time_left_is_proportional_to_the_remaining_cost():
    meter = ProgressMeter({"a": {0: 1.0, 1: 3.0}, "b": {0: 2.0}})
    assert np.isnan(meter.progress().left)
    for case, step in ("a", 0), ("b", 7), ("a case of another ensemble", 0):
        meter.finish(case, step)
    progress = meter.progress()
    assert progress.left == pytest.approx(5.0 * progress.elapsed)
    assert (progress.steps, progress.total) == (1, 3)


def test_steps_of_an_earlier_run_do_not_count_as_done_in_the_time_of_this_one():
    meter = ProgressMeter({"a": {0: 1.0, 1: 3.0, 2: 5.0}})
    meter.finish("a", 0)
    assert np.isnan(meter.progress().left)  # here the run begins
    meter.finish("a", 1)
    progress = meter.progress()
    assert progress.left == pytest.approx(5.0 / 3.0 * progress.elapsed)
    assert (progress.steps, progress.total) == (2, 3)


def test_failed_and_complete_cases_are_not_expected_to_take_time():
    meter = ProgressMeter({case: {0: 1.0} for case in "ab"})
    meter.finish("a", 0)
    meter.failures["b"] = "ValueError: too deep"
    progress = meter.progress()
    assert not meter.unfinished()
    assert str(progress) == "1/2 steps, 1 failed, about 0:00:00 left"


@pytest.mark.parametrize("control", ["load", "height"])
def test_columns_are_in_the_units_of_the_file_or_of_ase(control, tmp_path):
    scene = Scene.parse(
        f"""
        substrate = {{ model = "atoms", spacing = 2.5, contact_modulus = 80.0 }}
        sphere = {{ unit = "a0", radius = 60.0 }}
        roughness = {{ unit = "a0", long_wavelength = 16.0, seed = 5 }}
        interaction = {{ kind = "adhesive", work_of_adhesion = 0.05 }}
        path = {{ control = "{control}", values = [3.0, 1.0, 2.0] }}
        """
    )
    finish([scene], tmp_path / "e.db")
    columns = read_ensemble(tmp_path / "e.db")
    inputs = {
        "control": control,
        "radius": 60.0,
        "rms_slope": 0.1,
        "hurst": 0.8,
        "short_wavelength": 4.0,
        "long_wavelength": 16.0,
        "seed": 5,
        "kind": "adhesive",
        "work_of_adhesion": 0.05,
    }
    for name, value in inputs.items():
        assert columns[name].tolist() == [value] * 3
    np.testing.assert_allclose(columns["spacing"], 2.5)
    np.testing.assert_allclose(columns["contact_modulus"], 80.0 * UNITS["GPa"])
    unit = UNITS["nN"] if control == "load" else 1.0
    np.testing.assert_allclose(columns["target"], [3.0 * unit, unit, 2.0 * unit])
    assert columns["step"].tolist() == [0, 1, 2]
    reached = {"load": "normal_force"}.get(control, control)
    np.testing.assert_allclose(columns[reached], columns["target"], rtol=1e-3)


@pytest.mark.parametrize(
    ("kind", "parameters"),
    [
        ("plastic", {"hardness": 0.4, "permanent": True}),
        ("dugdale", {"work_of_adhesion": 0.05, "attraction_range": "2 a0"}),
    ],
)
def test_parameters_of_walls_are_columns(kind, parameters):
    wall = InteractionConfig(kind, parameters)
    columns = scene_columns(replace(SCENE, interaction=wall))
    expected = {**parameters}
    if "attraction_range" in parameters:
        expected["attraction_range"] = 2.0  # in spacings
    assert {name: columns[name] for name in parameters} == pytest.approx(expected)


def test_parameters_of_missing_roughness_and_adhesion_are_nan(tmp_path):
    finish([SCENE], tmp_path / "e.db")
    columns = read_ensemble(tmp_path / "e.db")
    assert columns["rms_slope"] == [0.0] and columns["seed"] == [-1]
    for name in ("hurst", "short_wavelength", "long_wavelength", "work_of_adhesion"):
        assert np.isnan(columns[name]).all()
