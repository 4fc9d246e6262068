"""Cases of ensembles and places on a scan are known by the contents of their files."""

import os

import numpy as np
import pytest
from ensemble_scenes import Here, finish, rows

from ase_roughcontact.ensemble import case_of, read_ensemble, run_ensemble
from ase_roughcontact.scene import Scene

TEXT = """
[substrate]
model = "atoms"
spacing = 2.5
shape = [16, 16]
contact_modulus = 30.0
[sphere]
radius = "3 nm"
[topography]
file = "scan.txt"
role = "substrate"
margin = "2 nm"
[path]
control = "penetration"
values = [0.5, 1.0]
"""
FILES = {
    "topography": '[topography]\nfile = "{}"',
    "heterogeneity": '[heterogeneity]\nfile = "{}"',
    "potential": '[substrate]\npotential = "{}"',
    "crystal": '[substrate]\ncrystal = "{}"',
}


def write_scan(folder, height):
    """Write a bump, and return the scene in its folder."""
    x, y = 0.25 * np.arange(41)[:, None], 0.25 * np.arange(33)
    bump = height * np.exp(-((x - 5) ** 2) - (y - 4) ** 2)
    folder.mkdir(exist_ok=True)
    header = "Width: 10.25 nm\nHeight: 8.25 nm\nValue units: nm"
    np.savetxt(folder / "scan.txt", bump.T, header=header)
    (folder / "scene.toml").write_text(TEXT)
    return Scene.read(folder / "scene.toml")


@pytest.mark.parametrize("text", FILES.values(), ids=FILES)
def test_a_case_depends_on_the_contents_of_a_file_and_not_on_its_name(tmp_path, text):
    names = []
    for name, contents in [("a", "one"), ("b", "one"), ("a", "two"), ("a", "three")]:
        (tmp_path / name).write_text(contents)
        os.utime(tmp_path / name, ns=(len(names), len(names)))
        names.append(case_of(Scene.parse(text.format(tmp_path / name))))
    assert names[0] == names[1] and len(set(names)) == 3


def test_a_replaced_scan_is_another_case_and_a_copied_one_the_same(tmp_path):
    database, here = tmp_path / "e.db", write_scan(tmp_path / "here", 0.1)
    assert finish([here], database).steps == 2
    before = read_ensemble(database)["normal_force"]
    there = write_scan(tmp_path / "there", 0.1)
    assert finish([there], database).steps == 2
    assert len(rows(database, record="step")) == 2
    replaced = write_scan(tmp_path / "here", 0.2)
    assert finish([replaced], database).steps == 2
    after = read_ensemble(database, case=case_of(replaced))["normal_force"]
    assert len(rows(database, record="step")) == 4
    expected = [step.normal_force for step in replaced.relax()]
    np.testing.assert_array_equal(after, expected)
    assert (abs(after - before) > 0.01 * before).all()


def test_a_scan_replaced_by_one_of_equal_size_and_time_is_read_again(tmp_path):
    forces, names = [], []
    for height in (0.1, 0.2):
        scene = write_scan(tmp_path, height)
        os.utime(tmp_path / "scan.txt", ns=(1, 1))
        forces.append(next(scene.relax(validity="ignore")).normal_force)
        names.append(case_of(scene))
    expected = next(write_scan(tmp_path / "b", 0.2).relax(validity="ignore"))
    assert forces[1] == expected.normal_force != forces[0]
    assert names[0] != names[1]


def test_a_scan_that_is_replaced_while_the_ensemble_runs_fails_the_case(tmp_path):
    database, scene = tmp_path / "e.db", write_scan(tmp_path / "here", 0.1)
    late = Here(lambda: write_scan(tmp_path / "here", 0.2))
    *_, last = run_ensemble([scene], database, late, interval=0.01)
    (message,) = last.failures.values()
    assert "scan.txt" in message and last.steps == 0


def test_files_of_one_name_are_refused(tmp_path):
    scene = write_scan(tmp_path / "here", 0.1)
    (tmp_path / "scan.txt").write_text("1 2\n3 4")
    other = tmp_path / "scan.txt"
    text = f'{TEXT}[heterogeneity]\nfile = "{other}"'
    both = Scene.parse(text, str(tmp_path / "here" / "scene.toml"))
    with pytest.raises(ValueError, match="different names"):
        both.check()
    assert scene.files == both.files[:1]
