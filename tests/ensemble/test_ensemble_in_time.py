"""Ensembles of paths in time: killed, continued, averaged and sampled."""

import os
import re
import signal
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from ase.db import connect
from ensemble_scenes import finish, killed, rows

from ase_roughcontact.cli import main
from ase_roughcontact.ensemble import (
    case_of,
    mean_areas,
    product,
    read_ensemble,
    sample_ensemble,
)
from ase_roughcontact.scene import Scene

SCENE = Scene.parse("""
[substrate]
contact_modulus = 2.0
spacing = "1 nm"
relaxation_moduli = [0.5, 0.3]
relaxation_times = [0.1, 2.0]
[sphere]
radius = "20 nm"
[roughness]
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
DEADLY = 20


@pytest.fixture(scope="module")
def whole():
    return list(SCENE.relax(validity="ignore"))


def assert_rows_are_those_of(whole, database):
    columns = read_ensemble(database)
    assert columns["step"].tolist() == list(range(len(whole)))
    for name in ("time", "normal_force", "contact_area", "energy", "dissipation"):
        expected = np.array([getattr(step, name) for step in whole])
        np.testing.assert_allclose(
            columns[name], expected, rtol=1e-5, atol=1e-7 * abs(expected).max()
        )


def test_all_time_steps_are_stored_with_their_columns(tmp_path, whole):
    database = tmp_path / "e.db"
    progress = finish([SCENE], database)
    assert (progress.steps, progress.total) == (1, 1)  # a path
    assert_rows_are_those_of(whole, database)
    columns = read_ensemble(database)
    assert set(columns["rate"]) == {0.8}
    assert columns["target"].max() == pytest.approx(4.0)  # Å
    assert np.isnan(columns["base"]).all()
    assert not (columns["lost_energy"] > 0.0).any()


def die_after_some_rows(scene, database):
    """Run, and be killed when a time step is relaxed, but not stored."""
    relax = Scene.relax

    def deadly(*arguments, **options):
        for step in relax(*arguments, **options):
            if step.step == DEADLY:
                os.kill(os.getpid(), signal.SIGKILL)
            yield step

    Scene.relax = deadly
    finish([scene], database)


def test_a_killed_case_continues_with_its_history(tmp_path, whole):
    database = tmp_path / "e.db"
    killed(die_after_some_rows, SCENE, database)
    assert len(rows(database, record="step")) == DEADLY
    relaxed = []
    relax = Scene.relax

    def counted(*arguments, **options):
        for step in relax(*arguments, **options):
            relaxed.append(step.step)
            yield step

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Scene, "relax", counted)
        assert finish([SCENE], database).steps == 1
    assert relaxed[0] == DEADLY  # from the checkpoint
    assert_rows_are_those_of(whole, database)


def test_a_missing_last_step_is_calculated_after_all_before_it(tmp_path, whole):
    database = tmp_path / "e.db"
    finish([SCENE], database)
    with connect(database) as db:  # no checkpoint is left either
        last = max(row.step for row in db.select(record="step"))
        found = [*db.select(record="step", step=last), *db.select(record="case")]
        db.delete([row.id for row in found])
    assert finish([SCENE], database).steps == 1
    assert_rows_are_those_of(whole, database)


@pytest.fixture(scope="module")
def two_seeds(tmp_path_factory):
    """Database of two realisations, and their scenes."""
    database = tmp_path_factory.mktemp("two") / "e.db"
    scenes = product(SCENE, {"roughness.seed": range(2)})
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
        *_, last = sample_ensemble(SCENE, database, 0.01, pool, **options)
    assert not last.done  # as it may have four
    assert [mean.realisations for mean in last.means] == [4, 4]
    cases = {row.case for row in rows(database, record="case", state="done")}
    assert cases == {*map(case_of, product(SCENE, {"roughness.seed": range(4)}))}


def test_the_command_prints_means_over_time(two_seeds, tmp_path, capsys):
    (file := tmp_path / "rubber.toml").write_text(SCENE.toml)
    database = ["--database", str(two_seeds[0]), "--workers", "1"]
    assert main(["ensemble", str(file), "--set", "roughness.seed=0,1", *database]) == 0
    printed = capsys.readouterr().out
    assert "2/2 paths" in printed
    assert re.search(r"time .*\n *\(s\)", printed)
    assert re.search(r"\n *0.5000 .*\n *1.500 ", printed)


def test_loops_are_refused_with_advice(tmp_path):
    keys = {"interaction.kind": "adhesive", "interaction.work_of_adhesion": 0.05}
    keys |= {"path.kind": "loop", "path.deepest": 1.0}
    solid = {"substrate.relaxation_moduli": None, "substrate.relaxation_times": None}
    with pytest.raises(ValueError, match='give kind = "steps" or "time"'):
        finish([SCENE.with_values(keys | solid)], tmp_path / "e.db")
