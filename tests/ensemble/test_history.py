"""Walls whose states depend on those before, in ensembles that are interrupted."""

import os
import signal
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from ase.db.core import Database
from ensemble_scenes import finish, killed, rows

from ase_roughcontact.ensemble import product, read_ensemble, sample_ensemble
from ase_roughcontact.scene import InteractionConfig, Scene

SCENE = Scene.parse("""
[substrate]
contact_modulus = 100.0
spacing = 2.5
[sphere]
radius = 60.0
[roughness]
long_wavelength = 16.0
[path]
control = "penetration"
values = [0.5, 2.0, 1.2]
""")
PLASTIC = InteractionConfig("plastic", {"hardness": 3.0, "permanent": True})
ADHESIVE = InteractionConfig("adhesive", {"work_of_adhesion": 1.0})
CONTINUUM = {"interaction": PLASTIC, "substrate.model": "continuum"}
SCENES = {
    "plastic": SCENE.with_values({"interaction": PLASTIC}),
    "plastic-continuum": SCENE.with_values(CONTINUUM),
    "adhesive": SCENE.with_values({"interaction": ADHESIVE}),
}


def assert_rows_are_those_of_the_whole_path(database, scene):
    columns, whole = read_ensemble(database), list(scene.relax(validity="ignore"))
    for name in ("normal_force", "contact_area", "continuum_area", "plastic_depth"):
        expected = [getattr(step, name) for step in whole]
        np.testing.assert_allclose(columns[name], expected, rtol=1e-5)


@pytest.mark.parametrize("scene", SCENES.values(), ids=SCENES)
def test_a_missing_last_step_continues_the_ones_before(tmp_path, scene, monkeypatch):
    database, relaxed, relax = tmp_path / "e.db", [], Scene.relax

    def counted(*arguments, **options):
        for step in relax(*arguments, **options):
            relaxed.append(step.step)
            yield step

    monkeypatch.setattr(Scene, "relax", counted)
    assert finish([scene], database, steps=[range(2)]).steps == 2
    assert relaxed == [0, 1]
    assert finish([scene], database).steps == 3
    assert_rows_are_those_of_the_whole_path(database, scene)


def die_before_the_last_row(scene, database):
    """Run, and be killed when the frame of the last step is stored, but not its row."""
    write, written = Database.write, []

    def deadly(*arguments, **options):
        written.append(True)
        if len(written) == 3:
            os.kill(os.getpid(), signal.SIGKILL)
        return write(*arguments, **options)

    Database.write = deadly
    finish([scene], database)


def die_after_two_rows(scene, database):
    """Run, and be killed when the last step begins."""
    relax = Scene.relax

    def deadly(*arguments, **options):
        for step in relax(*arguments, **options):
            yield step
            if step.step == 1:
                os.kill(os.getpid(), signal.SIGKILL)

    Scene.relax = deadly
    finish([scene], database)


@pytest.mark.parametrize(
    "die",
    [pytest.param(die_before_the_last_row, marks=pytest.mark.slow), die_after_two_rows],
)
def test_a_killed_case_continues_in_its_plastic_shape(tmp_path, die):
    scene, database = SCENES["plastic-continuum"], tmp_path / "e.db"
    killed(die, scene, database)
    assert len(rows(database, record="step")) == 2
    assert finish([scene], database).steps == 3
    assert_rows_are_those_of_the_whole_path(database, scene)


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
