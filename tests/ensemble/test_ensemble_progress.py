"""Progress of ensembles: expected costs, time left, order of the cases."""

from dataclasses import replace

import numpy as np
import pytest
from ensemble_scenes import SCENE

from ase_roughcontact.ensemble.progress import ProgressMeter, expected_costs
from ase_roughcontact.scene import PathConfig


def test_time_left_is_proportional_to_the_remaining_cost():
    costs = {"a": np.array([0.0, 1.0, 4.0]), "b": np.array([0.0, 2.0])}
    meter = ProgressMeter(costs)
    assert np.isnan(meter.progress().left)
    meter.add(["a", "a case of another ensemble"])
    progress = meter.progress()
    assert progress.left == pytest.approx(5.0 * progress.elapsed)
    assert (progress.steps, progress.total) == (1, 3)


def test_steps_of_an_earlier_run_do_not_count_as_done_in_the_time_of_this_one():
    meter = ProgressMeter({"a": np.array([0.0, 1.0, 4.0, 9.0])})
    meter.add(["a"])
    assert np.isnan(meter.progress().left)  # here the run begins
    meter.add(["a"])
    progress = meter.progress()
    assert progress.left == pytest.approx(5.0 / 3.0 * progress.elapsed)
    assert (progress.steps, progress.total) == (2, 3)


def test_failed_and_complete_cases_are_not_expected_to_take_time():
    meter = ProgressMeter(dict.fromkeys("ab", np.array([0.0, 1.0])))
    meter.add("a")
    meter.failures["b"] = "ValueError: too deep"
    progress = meter.progress()
    assert not meter.unfinished()
    assert str(progress) == "1/2 steps, 1 failed, about 0:00:00 left"


def test_large_loads_are_expected_to_cost_more():
    path = PathConfig("load", values=(1.0, 1e6))
    start, light, both = expected_costs(replace(SCENE, path=path))
    assert start == 0.0
    assert both - light > 2 * light
