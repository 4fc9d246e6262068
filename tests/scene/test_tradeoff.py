"""Trade-off between accuracy and cost of a scene."""

import re
from dataclasses import replace
from functools import cache

import pytest

from ase_roughcontact._util.threads import threads
from ase_roughcontact.paths.accuracy import accuracy_of
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.tradeoff import tradeoff

TEXT = """
[substrate]
contact_modulus = 100.0
shape = [36, 36]
[sphere]
radius = 60.0
[roughness]
long_wavelength = 16.0
domain = 128.0
[path]
control = "penetration"
values = [0.3, 0.6, 0.9, 1.2, 1.5, 1.8, 2.1]
[solver]
optimizer = "FIRE2"
fmax = 1e-3
"""
# Accuracy of what trials are compared with.
REFERENCE = 1e-10
AUTO = TEXT.replace("shape = [36, 36]", "").partition("[solver]")[0]
FULL = AUTO + '[interaction]\nkind = "full"\nwork_of_adhesion = 0.1\n'


@cache
def studied(text=TEXT, error=1e-2, **options):
    with threads(1):
        return tradeoff(Scene.parse(text), error, **options)


def test_the_settings_of_the_scene_are_the_first_trial():
    assert studied().trials[0].settings == {
        "solver.fmax": 1e-3,
        "solver.optimizer": "FIRE2",
    }


def test_the_first_middle_and_last_steps_are_calculated_each_after_its_predecessor():
    assert studied().steps == ("0.3 Å", "0.9 Å", "1.2 Å", "1.8 Å", "2.1 Å")


def test_a_single_step_suffices():
    assert studied(steps=1).steps == ("0.3 Å",)


def test_steps_that_are_too_slow_are_left_out():
    study = studied(seconds=1e-9)
    assert study.steps == ("0.3 Å",)
    assert study.omitted == 6
    assert "6 slow steps omitted" in str(study)


def test_the_cheapest_sufficient_setting_is_recommended():
    study = studied()
    assert study.best.error + study.reference_error < study.requested
    better = [t for t in study.trials if t.error <= study.best.error]
    assert study.best.work == min(t.work for t in better)
    assert study.best.work < study.trials[0].work


def test_the_recommendation_is_part_of_a_scene_file_and_has_the_requested_error():
    study = studied()
    advice = str(study).partition("Recommended for an error of 0.01:")[2]
    scene = Scene.parse(TEXT.partition("[solver]")[0] + advice)
    wanted = replace(scene, solver=replace(scene.solver, accuracy=1e-9))
    with threads(1):
        for record, truth in zip(scene.relax(), wanted.relax(), strict=True):
            assert record.normal_force == pytest.approx(truth.normal_force, rel=1e-2)


def test_the_reference_is_much_more_accurate_than_the_trials():
    study = studied()
    assert study.reference_error < 1e-3 * study.requested
    errors = [
        t.error for t in study.trials if t.settings.get("solver.accuracy") == 1e-6
    ]
    assert study.reference_error < min(errors) < 1e-6


def stall_reference(monkeypatch, ratio):
    """Stop the reference at a multiple of its tolerance."""
    original = Scene.relax

    def relax(scene, *steps, **options):
        first, *others = original(scene, *steps, **options)
        if scene.solver.accuracy == REFERENCE:
            force = ratio * first.tolerance
            first = replace(first, converged=False, max_force=force, message="stalled")
        return iter([first, *others])

    monkeypatch.setattr(Scene, "relax", relax)


def test_a_reference_stopped_by_rounding_suffices_for_much_larger_errors(monkeypatch):
    stall_reference(monkeypatch, ratio=1e3)
    with threads(1):
        study = tradeoff(Scene.parse(TEXT), 1e-2, steps=1)
    assert study.reference_error == pytest.approx(1e3 * REFERENCE)
    assert study.best is not None


def test_a_reference_of_insufficient_accuracy_is_an_error(monkeypatch):
    stall_reference(monkeypatch, ratio=1e8)
    with pytest.raises(RuntimeError, match=r"no reference .* stalls at 1\.0e-02"):
        tradeoff(Scene.parse(TEXT), 1e-2, steps=1)


def test_if_no_setting_suffices_the_smallest_error_is_printed():
    study = replace(studied(), requested=1e-30)
    assert study.best is None
    last = str(study).splitlines()[-1]
    assert last.startswith("No setting is safe for an error of 1e-30")
    assert "Recommended" not in str(study)


def test_the_error_of_the_reference_counts():
    study = studied()
    assert replace(study, reference_error=study.requested).best is None


def test_named_accuracies_have_nominal_errors_and_tolerances_have_none():
    first, *others = studied().trials
    assert first.nominal_error == 0.0
    for trial in others:
        accuracy = accuracy_of(trial.settings["solver.accuracy"])
        assert trial.nominal_error == accuracy.error


def test_a_wrong_number_of_atoms_is_an_error_of_the_area():
    study = studied()
    worst = max(study.trials, key=lambda trial: trial.atoms)
    assert worst.atoms > 0 and worst.area_error > 0.0
    assert all(t.area_error == 0.0 for t in study.trials if t.atoms == 0)


def test_the_columns_are_explained_below_the_table():
    table, _, legend = str(studied()).partition("\n\n")
    for column in ("error", "atoms", "pairs"):
        assert column in table.splitlines()[0]
        assert column in legend.splitlines()[0].lower()


def test_cutoffs_of_a_full_wall_are_compared_and_one_is_recommended():
    study = studied(FULL, 1e-1, steps=1)
    errors = {
        t.settings.get("interaction.cutoff"): t.response_error
        for t in study.trials
        if t.settings.get("solver.accuracy") == 1e-6
    }
    assert min(errors[3.0], errors[5.0]) > errors[10.0] > errors[20.0]
    tried = {t.settings.get("interaction.cutoff"): t.error for t in study.trials[1:5]}
    safe = min(cutoff for cutoff, error in tried.items() if error <= 0.3 * 1e-1)
    assert any(0.3 * 1e-1 < error < 1e-1 for error in tried.values())
    assert {t.settings.get("interaction.cutoff") for t in study.trials[5:]} == {safe}
    cutoff = re.search(r"\[interaction\]\ncutoff = (.*)", str(study))
    assert float(cutoff[1]) == study.best.settings.get("interaction.cutoff")


def test_under_load_control_the_penetration_is_compared():
    study = studied(AUTO.replace('"penetration"', '"load"'), steps=1)
    assert 0.0 < study.best.response_error < 1e-2
    assert study.best.compared == "penetration"
    assert "penetration error" in str(study) and "force error" not in str(study)
    assert "force error" in str(studied())


@pytest.mark.parametrize("given", [{"error": 0.0}, {"steps": 0}, {"seconds": -1.0}])
def test_arguments_out_of_range_are_errors(given):
    (name,) = given
    with pytest.raises(ValueError, match=name):
        tradeoff(Scene.parse(TEXT), **given)
