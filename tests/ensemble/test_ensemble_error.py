"""Ensembles that grow until the mean areas have a wanted error."""

import json
import math
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from shutil import copyfile

import numpy as np
import pytest
from ensemble_scenes import SCENE, finish
from scipy.stats import t

from ase_roughcontact._util.printing import plain
from ase_roughcontact.cli import main
from ase_roughcontact.cli.means import means_table
from ase_roughcontact.ensemble import (
    MeanArea,
    Progress,
    adaptive,
    case_of,
    mean_areas,
    product,
    read_ensemble,
    sample_ensemble,
)
from ase_roughcontact.ensemble.database import EnsembleDatabase
from ase_roughcontact.scene import Scene, Steps

LOADS = replace(SCENE, path=Steps(loads=(0.3, 10.0)))


def sample(scene, database, error, **options):
    """Run with one thread, and return all reports."""
    with ThreadPoolExecutor(1) as pool:
        options = {"executor": pool, "interval": 0.01, **options}
        return list(sample_ensemble(scene, database, error, **options))


@pytest.fixture(scope="module")
def sampled(tmp_path_factory):
    database = tmp_path_factory.mktemp("sampled") / "e.db"
    return database, sample(LOADS, database, 0.08)


def test_errors_of_all_means_are_below_the_wanted_one(sampled):
    database, reports = sampled
    last = reports[-1]
    assert last.done and last.missing == 0
    columns = read_ensemble(database)
    for number, mean in enumerate(last.means):
        areas = columns["contact_area"][columns["step"] == number]
        assert mean.target == LOADS.targets[number]
        assert mean.realisations == areas.size
        assert mean.mean == pytest.approx(areas.mean())
        # half of Student's interval of 95 %, in units of the normal distribution's
        half = t.interval(0.95, areas.size - 1, scale=areas.std(ddof=1))[1]
        error = half / 1.959964 / np.sqrt(areas.size) / areas.mean()
        assert mean.error == pytest.approx(error)
        assert mean.scatter == pytest.approx(areas.std(ddof=1))
        assert error <= 0.08
    # light loads get more realisations, and heavy ones no more than they need
    light, heavy = (mean.realisations for mean in last.means)
    assert light > 2 * heavy == 16
    seeds = columns["seed"][columns["step"] == 0]
    assert sorted(seeds) == list(range(light))
    # about as many as the pilot has predicted
    pilot = next(r for r in reports if r.means[0].realisations == 8)
    assert not pilot.done
    assert pilot.means[0].expected == pytest.approx(light, rel=0.6)
    assert pilot.missing == pilot.means[0].expected - 8


IN_TIME = """
[substrate]
model = "continuum"
contact_modulus = "2 MPa"
spacing = "4 nm"
shape = [16, 16]
hardness = inf
relaxation_moduli = [0.6]
relaxation_times = [0.5]
[sphere]
radius = "100 nm"
[roughness]
unit = "a0"
long_wavelength = 8.0
[interaction]
kind = "hard"
[path]
kind = "time"
control = "load"
values = [0, 0.2]
rate = 2.0
dwell = 2.0
"""


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_means_in_time_are_those_at_the_ends_of_load_and_dwell(tmp_path):
    scene = Scene.parse(IN_TIME)
    *_, last = sample(scene, tmp_path / "e.db", 10.0, pilot=2)
    assert [mean.target for mean in last.means] == pytest.approx([0.1, 2.1])
    paths = [list(each.relax()) for each in product(scene, {"roughness.seed": [0, 1]})]
    for mean in last.means:
        areas = [
            min(steps, key=lambda step: abs(step.time - mean.target)).continuum_area
            for steps in paths
        ]
        assert mean.mean == pytest.approx(np.mean(areas), rel=1e-6)
    assert last.means[1].mean > 1.3 * last.means[0].mean
    columns = read_ensemble(tmp_path / "e.db")
    assert set(columns["rate"]) == {2.0}


def test_finished_ensemble_calculates_nothing_and_a_smaller_error_only_what_is_new(
    sampled,
):
    database, reports = sampled
    before = len(read_ensemble(database)["step"])
    (again,) = sample(LOADS, database, 0.08)[-1:]
    assert again.means == reports[-1].means
    assert len(read_ensemble(database)["step"]) == before
    smaller = sample(LOADS, database, 0.07)
    assert smaller[0].means[0].realisations >= 8
    assert smaller[-1].done
    assert len(read_ensemble(database)["step"]) > before


def test_steps_of_an_ordinary_ensemble_are_used_and_the_largest_number_is_kept(
    tmp_path,
):
    database = tmp_path / "e.db"
    scenes = product(LOADS, {"roughness.seed": range(3)})
    finish(scenes, database)
    ids = read_ensemble(database)["case"]
    last = sample(LOADS, database, 5.0, pilot=3)[-1]
    assert [mean.realisations for mean in last.means] == [3, 3]
    last = sample(LOADS, database, 0.01, pilot=2, most=3)[-1]
    assert not last.done and last.missing > 0
    assert [mean.realisations for mean in last.means] == [3, 3]
    np.testing.assert_array_equal(read_ensemble(database)["case"], ids)
    assert set(ids) == set(map(case_of, scenes))


def test_the_number_of_realisations_is_at_most_doubled_at_once(tmp_path):
    scene = replace(SCENE, path=Steps(loads=(0.3,)))
    with ThreadPoolExecutor(1) as pool:
        options = {"executor": pool, "interval": 0.01, "pilot": 2, "most": 64}
        reports = sample_ensemble(scene, tmp_path / "e.db", 1e-3, **options)
        totals = [2]
        while totals[-1] < 8:
            totals.append(next(reports).progress.total)
        reports.close()
    assert sorted(set(totals)) == [2, 4, 8]


def test_steps_that_have_not_converged_are_not_in_the_mean(tmp_path):
    database, scenes = tmp_path / "e.db", product(LOADS, {"roughness.seed": range(2)})
    finish(scenes, database)
    assert [mean.realisations for mean in mean_areas(scenes, database)] == [2, 2]
    hasty = [each.with_values({"solver.max_steps": 1}) for each in scenes]
    finish(hasty, database)
    assert read_ensemble(database)["converged"].sum() == 4
    assert [mean.realisations for mean in mean_areas(hasty, database)] == [0, 0]


def test_steps_without_contact_are_left_out(tmp_path):
    scene = replace(LOADS, path=Steps(penetrations=(-1.0, 0.4)))
    last = sample(scene, tmp_path / "e.db", 0.2)[-1]
    free, touching = last.means
    assert (free.realisations, free.mean) == (8, 0.0) and math.isnan(free.error)
    assert last.done and last.error == touching.error <= 0.2
    table, note, _, done = means_table(scene, last.means, last)
    assert plain(table).splitlines()[-2].split()[2:] == ["-", "0", "8", "-"]
    assert note == f"Errors are not known in 1 of 2 steps: {free.unknown}."
    assert done == "All other means have a standard error of 20 % or less."


def test_a_path_without_contact_ends_with_the_pilot(tmp_path):
    scene = replace(LOADS, path=Steps(penetrations=(-2.0, -1.0)))
    last = sample(scene, tmp_path / "e.db", 0.1)[-1]
    assert math.isnan(last.error) and not last.done and last.missing == 0
    assert [mean.realisations for mean in last.means] == [8, 8]
    (_, note) = means_table(scene, last.means, last)
    assert note.startswith("Errors are not known in 2 of 2 steps")


def test_steps_that_do_not_converge_end_with_the_pilot(tmp_path):
    hasty = LOADS.with_values({"solver.max_steps": 1})
    last = sample(hasty, tmp_path / "e.db", 0.1, pilot=3)[-1]
    assert last.progress.steps == last.progress.total == 6
    assert not last.done and "converged" in last.means[0].unknown


def test_seeds_that_do_not_converge_are_made_up_for_in_few_rounds(
    tmp_path, monkeypatch
):
    """Every second realisation of a step with areas that scatter by a half."""
    rounds = []

    def stored(scenes, database, executor, **options):
        rounds.append(len(scenes))
        rng = np.random.default_rng(1)
        areas = rng.normal(1.0, 0.5, len(scenes)).tolist()
        rows = [
            {
                **{"case": case_of(each), "step": 0, "height": 0.0, "energy": 0.0},
                **{"converged": number % 2 == 0, "contact_area": areas[number]},
            }
            for number, each in enumerate(scenes)
        ]
        EnsembleDatabase(str(database)).add_steps(rows, {})
        yield Progress(steps=len(rows), total=len(rows))

    monkeypatch.setattr(adaptive, "run_ensemble", stored)
    scene = replace(LOADS, path=Steps(loads=(1.0,)))
    last = sample(scene, tmp_path / "e.db", 0.05)[-1]
    (mean,) = last.means
    assert last.done and mean.realisations == pytest.approx(100, rel=0.3)
    assert rounds[-1] < 2.5 * mean.realisations
    assert len(rounds) < 12


@pytest.mark.parametrize("spread", [0.1, 0.31])
@pytest.mark.parametrize("shape", ["normal", "skewed"])
def test_range_of_a_pilot_contains_the_number_that_is_needed(spread, shape):
    """Simulated areas: in about 90 % of the pilots of eight."""
    rng = np.random.default_rng(1)
    areas = rng.normal(1.0, spread, (3000, 8))
    if shape == "skewed":
        areas = rng.gamma(spread**-2, spread**2, (3000, 8))
    pilots = [MeanArea.of(1.0, each, 0.02) for each in areas]
    # realisations until 1.96 standard errors are Student's interval
    needed = (spread / 0.02) ** 2 + 0.5 * (1.96**2 + 1.0)
    inside = [least <= needed <= most for least, most in (p.likely for p in pilots)]
    assert np.mean(inside) == pytest.approx(0.9, abs=0.04)
    assert np.mean([p.expected for p in pilots]) == pytest.approx(needed, rel=0.1)


@pytest.mark.parametrize(
    "scene, options, message",
    [
        (replace(LOADS, roughness=None), {}, r"\[roughness\]"),
        (LOADS, {"error": 0.0}, "error"),
        (LOADS, {"pilot": 1}, "pilot .* 2"),
        (LOADS, {"most": 4}, "most .* 8"),
    ],
)
def test_bad_options_are_rejected_at_once(tmp_path, scene, options, message):
    with pytest.raises(ValueError, match=message):
        sample(scene, tmp_path / "e.db", **{"error": 0.1, **options})
    assert not list(tmp_path.iterdir())


# Command


def test_table_has_errors_and_predictions(sampled):
    _, reports = sampled
    pilot = next(r for r in reports if r.means[0].realisations == 8)
    table, limits, rest = means_table(LOADS, pilot.means, pilot)
    _, _, light, heavy = plain(table).splitlines()
    mean = pilot.means[0]
    row = (0.3, mean.mean / 100.0, 100.0 * mean.error, mean.scatter / 100.0, 8)
    row = (*row, mean.expected)
    shown_row, likely = light.rstrip(" *").split("(")
    assert likely == "{} to {})".format(*mean.likely)
    for shown, value in zip(shown_row.split(), row, strict=True):
        assert float(shown) == pytest.approx(value, rel=0.05)
    assert heavy.split()[0] == "10.00"
    count = pilot.means[1].realisations
    assert f"mean pressure/hardness in {count} of {count}" in plain(limits)
    assert rest == (
        f"About {pilot.missing} more steps (likely {mean.likely[0] - 8} to "
        f"{mean.likely[1] - 8}) for a standard error of 8 %."
    )


def test_command_continues_a_sampled_ensemble(sampled, tmp_path, capsys):
    file, database = tmp_path / "my.toml", str(sampled[0])
    file.write_text(LOADS.toml)
    command = ["ensemble", str(file), "--database", database, "--workers", "1"]
    assert main([*command, "--error", "0.2", "--set", "roughness.seed=1,2"]) == 2
    assert "--error chooses the seeds" in capsys.readouterr().err
    variant = ["--set", "sphere.radius=60.0"]
    assert main([*command, "--error", "0.2", *variant]) == 0
    text = capsys.readouterr().out
    assert "\nsphere.radius = 60.0\n" in text
    assert "All means have a standard error of 20 % or less" in text
    assert main([*command, "--error", "0.2", "--json"]) == 0
    lines = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    means = [line for line in lines if "mean" in line][-2:]
    progress = [line for line in lines if "elapsed" in line][-1]
    assert progress["error"] == max(line["error"] for line in means)
    assert (
        f"steps, about 0:00:00 left, standard error {100 * progress['error']:.2g} %"
        in text
    )
    assert [line["target"] for line in means] == pytest.approx(LOADS.targets)
    assert max(line["error"] for line in means) <= 0.2
    units = {"mean": "Å^2", "scatter": "Å^2", "target": "eV/Å"}
    assert means[0]["units"] == units


def test_command_ends_at_the_largest_number_of_seeds_and_says_so(
    sampled, tmp_path, capsys
):
    file = tmp_path / "my.toml"
    file.write_text(LOADS.toml)
    command = ["ensemble", str(file), "--database", str(sampled[0]), "--workers", "1"]
    assert main([*command, "--error", "0.001", "--most", "8"]) == 1
    message = capsys.readouterr().err
    assert "with 8 seeds" in message and "--most" in message


def test_command_prints_mean_areas_over_given_seeds(sampled, tmp_path, capsys):
    file, database = tmp_path / "my.toml", tmp_path / "e.db"
    file.write_text(LOADS.toml)
    copyfile(sampled[0], database)
    command = ["ensemble", str(file), "--database", str(database), "--workers", "1"]
    command += ["--set", "roughness.seed=0,1,2,3", "--set", "sphere.radius=60.0"]
    assert main(command) == 0
    columns = read_ensemble(database)
    light = columns["contact_area"][(columns["seed"] < 4) & (columns["step"] == 0)]
    scatter = light.std(ddof=1)
    error = t.ppf(0.975, 3) / 1.959964 * scatter / 2.0 / light.mean()
    lines = capsys.readouterr().out.splitlines()
    place = lines.index("sphere.radius = 60.0")
    assert "standard error" in lines[place + 1] and "expected" not in lines[place + 2]
    row = [float(word) for word in lines[place + 3].rstrip(" *").split()]
    expected = [0.3, light.mean() / 100, 100 * error, scatter / 100, 4]
    assert row == pytest.approx(expected, rel=0.03)
    assert main([*command, "--json"]) == 0
    *_, found, _ = map(json.loads, capsys.readouterr().out.splitlines())
    assert found["error"] == pytest.approx(error)
    assert found["sphere.radius"] == 60.0 and "expected" not in found
    assert main([*command, "--quiet"]) == 0
    assert capsys.readouterr().out == ""
