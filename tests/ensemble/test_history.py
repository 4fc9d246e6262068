"""Paths with states that depend on earlier ones, in ensembles that are killed.

Walls with attraction or a plastic shape, and paths in time.
"""

import re
from concurrent.futures import ThreadPoolExecutor
from shutil import copyfile

import numpy as np
import pytest
from ase.db import connect
from ensemble_scenes import die, finish, killed, rows

from ase_roughcontact import LoadStep
from ase_roughcontact.cli import main
from ase_roughcontact.ensemble import (
    case_of,
    mean_areas,
    product,
    read_ensemble,
    sample_ensemble,
)
from ase_roughcontact.scene import InteractionConfig, Scene

SCENE = Scene.parse("""
substrate = { model = "atoms", contact_modulus = 100.0, spacing = 2.5 }
sphere = { unit = "a0", radius = 60.0 }
roughness = { unit = "a0", long_wavelength = 16.0 }
path = { control = "penetration", values = [0.5, 2.0, 1.2] }
""")
PLASTIC = InteractionConfig("plastic", {"hardness": 3.0, "permanent": True})
ADHESIVE = InteractionConfig("adhesive", {"work_of_adhesion": 1.0})
CONTINUUM = {"interaction": PLASTIC, "substrate.model": "continuum"}
SCENES = {
    "plastic": SCENE.with_values({"interaction": PLASTIC}),
    "plastic-continuum": SCENE.with_values(CONTINUUM),
    "adhesive": SCENE.with_values({"interaction": ADHESIVE}),
}
# The first step stays elastic, so that the surface first flows in the second one.
FIRST_FLOW = SCENES["plastic"].with_values({"path.values": (0.02, 2.0, 1.2)})
TIME = Scene.parse("""
[substrate]
model = "atoms"
contact_modulus = 2.0
spacing = "1 nm"
relaxation_moduli = [0.5, 0.3]
relaxation_times = [0.1, 2.0]
[sphere]
radius = "20 nm"
[roughness]
unit = "a0"
long_wavelength = 16.0
[interaction]
kind = "hard"
[path]
kind = "time"
control = "penetration"
values = [0, "0.4 nm"]
rate = 0.8
dwell = 1.0
""")
COLUMNS = (
    *("time", "normal_force", "contact_area", "continuum_area", "plastic_depth"),
    *("energy", "dissipation"),
)


@pytest.fixture
def relaxed(monkeypatch):
    """Numbers of the steps that are relaxed."""
    numbers, result_of = [], LoadStep.of.__func__

    def counted(record, step):
        numbers.append(step.number)
        return result_of(record, step)

    monkeypatch.setattr(LoadStep, "of", classmethod(counted))
    return numbers


def assert_rows_are_those_of_the_whole_path(database, scene):
    columns, whole = read_ensemble(database), list(scene.relax(validity="ignore"))
    assert columns["step"].tolist() == list(range(len(whole)))
    for name in COLUMNS:
        expected = np.array([getattr(step, name, np.nan) for step in whole])
        np.testing.assert_array_equal(columns[name], expected)


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_a_missing_last_step_continues_the_ones_before(tmp_path, scene, relaxed):
    database = tmp_path / "e.db"
    assert finish([scene], database, steps=[range(2)]).steps == 2
    assert relaxed == [0, 1]
    assert finish([scene], database).steps == 3
    assert_rows_are_those_of_the_whole_path(database, scene)


@pytest.mark.parametrize(
    "scene, number, stored",
    [
        pytest.param(SCENES["plastic-continuum"], 2, False, marks=pytest.mark.slow),
        (FIRST_FLOW, 1, False),
        (SCENES["plastic-continuum"], 1, True),
        (TIME, 20, False),
    ],
)
def test_a_killed_case_continues_with_its_history(
    tmp_path, scene, number, stored, relaxed
):
    database = tmp_path / "e.db"
    killed(die, scene, database, number, stored)
    assert len(rows(database, record="step")) == number + stored
    progress = finish([scene], database)
    assert progress.steps == progress.total
    assert relaxed[0] == number + 1  # after the last step of the restart file
    assert_rows_are_those_of_the_whole_path(database, scene)


def test_a_missing_last_time_is_calculated_after_all_before_it(tmp_path):
    database = tmp_path / "e.db"
    progress = finish([TIME], database)
    assert (progress.steps, progress.total) == (1, 1)  # a path
    columns = read_ensemble(database)
    assert set(columns["rate"]) == {0.8}
    assert columns["target"].max() == pytest.approx(4.0)  # Å
    assert np.isnan(columns["base"]).all()
    assert not (columns["lost_energy"] > 0.0).any()
    with connect(database) as db:  # no checkpoint is left either
        last = max(row.step for row in db.select(record="step"))
        found = [*db.select(record="step", step=last), *db.select(record="case")]
        db.delete([row.id for row in found])
    assert finish([TIME], database).steps == 1
    assert_rows_are_those_of_the_whole_path(database, TIME)


@pytest.mark.parametrize("deleted", [[3, 5], [-1]])
def test_deleted_times_are_calculated_again(two_seeds, deleted, tmp_path):
    database, (scene, _) = tmp_path / "e.db", two_seeds[1]
    copyfile(two_seeds[0], database)
    before = rows(database, record="step", case=case_of(scene))
    with connect(database) as db:
        db.delete([before[number].id for number in deleted])
    assert finish([scene], database).steps == 1
    columns = read_ensemble(database, case=case_of(scene))
    assert columns["step"].tolist() == list(range(len(before)))
    forces = [row.normal_force for row in before]
    np.testing.assert_allclose(columns["normal_force"], forces, rtol=1e-5)


def test_realisations_of_a_sample_have_the_history_of_the_whole_path(tmp_path):
    """The second step needs more of them than the first one, on which it depends."""
    scene = SCENES["plastic"].with_values({"path.values": (2.0, 1.5)})
    database = tmp_path / "e.db"
    with ThreadPoolExecutor(1) as pool:
        options = {"pilot": 2, "interval": 0.01}
        last = list(sample_ensemble(scene, database, 0.1, pool, **options))[-1]
    count = last.means[1].realisations
    assert last.done and count > 2
    columns = read_ensemble(database)
    for each in product(scene, {"roughness.seed": range(count)}):
        whole = [step.normal_force for step in each.relax(validity="ignore")]
        of_seed = columns["seed"] == each.roughness.seed
        np.testing.assert_allclose(columns["normal_force"][of_seed], whole, rtol=1e-5)


# Paths in time


@pytest.fixture(scope="module")
def two_seeds(tmp_path_factory):
    """Database of two realisations, and their scenes."""
    database = tmp_path_factory.mktemp("two") / "e.db"
    scenes = product(TIME, {"roughness.seed": range(2)})
    assert finish(scenes, database).steps == 2
    return database, scenes


def test_areas_are_averaged_at_the_ends_of_approach_and_dwell(two_seeds):
    database, scenes = two_seeds
    means = mean_areas(scenes, database)
    assert [mean.target for mean in means] == pytest.approx([0.5, 1.5])  # s
    columns = read_ensemble(database)
    for mean in means:
        areas = columns["contact_area"][np.isclose(columns["time"], mean.target)]
        assert mean.realisations == len(areas) == 2
        assert mean.mean == pytest.approx(areas.mean())


@pytest.mark.slow
def test_realisations_are_added_while_the_error_is_large(tmp_path):
    database = tmp_path / "e.db"
    with ThreadPoolExecutor(1) as pool:
        options = {"pilot": 2, "interval": 0.01, "most": 4}
        *_, last = sample_ensemble(TIME, database, 0.01, pool, **options)
    assert not last.done  # as it may have four
    assert [mean.realisations for mean in last.means] == [4, 4]
    cases = {row.case for row in rows(database, record="case", state="done")}
    assert cases == {*map(case_of, product(TIME, {"roughness.seed": range(4)}))}


def test_the_command_prints_means_over_time(two_seeds, tmp_path, capsys):
    (file := tmp_path / "rubber.toml").write_text(TIME.toml)
    database = ["--database", str(two_seeds[0]), "--workers", "1"]
    assert main(["ensemble", str(file), "--set", "roughness.seed=0,1", *database]) == 0
    printed = capsys.readouterr().out
    assert "2/2 paths" in printed
    assert re.search(r"time .*\n *\(s\)", printed)
    assert re.search(r"\n *0.5000 .*\n *1.500 ", printed)
