"""Marks, errors and convergence of resumed steps by the present settings."""

import numpy as np
import pytest

from ase_roughcontact.cli import main
from ase_roughcontact.scene import Scene

TEXT = """
[substrate]
contact_modulus = 100.0
spacing = 2.5
[sphere]
unit = "a0"
radius = 60.0
[path]
values = [1.0, 20.0]
"""
SCENE = Scene.parse(TEXT)
HARD = SCENE.with_values({"substrate.hardness": 0.5})  # GPa


def results(scene, folder):
    return list(scene.run(folder, "ignore"))


def test_steps_are_marked_for_a_hardness_that_is_given_afterwards(tmp_path):
    first = results(SCENE, tmp_path / "a")
    assert "hardness" not in "".join(step.validity for step in first)
    marked = results(HARD, tmp_path / "a")
    whole = results(HARD, tmp_path / "b")
    assert [s.validity for s in marked] == [s.validity for s in whole]
    assert all("largest pressure/hardness" in step.validity for step in marked)
    table = (tmp_path / "a" / "curve.csv").read_text()
    assert table.count("largest pressure/hardness") == 2
    # and no more without it
    again = results(SCENE, tmp_path / "a")
    assert [s.validity for s in again] == [s.validity for s in first]


def test_a_bound_of_the_hardness_is_marked_only_while_no_hardness_is_given(tmp_path):
    material = {"substrate.contact_modulus": None, "substrate.material": "mica"}
    path = {"path.control": "penetration", "path.values": (1.0, 5.0)}
    mica = SCENE.with_values(material | path)
    first = results(mica, tmp_path / "a")
    assert "largest pressure/bound of the hardness" in first[-1].validity
    hard = mica.with_values({"substrate.hardness": 100.0})  # GPa
    marked = results(hard, tmp_path / "a")
    assert [s.validity for s in marked] == [
        s.validity for s in results(hard, tmp_path / "b")
    ]
    assert "hardness" not in "".join(step.validity for step in marked)
    again = results(mica, tmp_path / "a")
    assert [s.validity for s in again] == [s.validity for s in first]


def test_a_strict_run_stops_at_a_step_of_an_earlier_run_that_exceeds_a_limit(tmp_path):
    file, out = tmp_path / "x.toml", str(tmp_path / "out")
    file.write_text(TEXT)
    assert main(["run", str(file), "--out", out, "--quiet"]) == 0
    file.write_text(HARD.toml)
    assert main(["run", str(file), "--out", out, "--quiet", "--strict"]) == 2


def test_steps_that_did_not_converge_are_calculated_again_in_more_steps(tmp_path):
    values = {"path.values": (1.0, 5.0, 20.0), "interaction.kind": "repulsive"}
    scene = SCENE.with_values(values)
    few = scene.with_values({"solver.max_steps": 1})
    assert not any(step.converged for step in results(few, tmp_path / "a"))
    kept = results(few, tmp_path / "a")
    assert not any(step.converged for step in kept)  # nothing could mend them
    mended = results(scene, tmp_path / "a")
    whole = results(scene, tmp_path / "b")
    assert all(step.converged for step in mended)
    assert [s.contact_area for s in mended] == [s.contact_area for s in whole]


def test_converged_steps_before_the_first_failure_are_kept(tmp_path):
    scene = SCENE.with_values({"interaction.kind": "repulsive"})
    whole = results(scene, tmp_path / "b")
    most = min(step.iterations for step in whole)
    values = (0.0, *SCENE.path.values)  # the first step needs no iteration
    longer = scene.with_values({"path.values": values})
    few = longer.with_values({"solver.max_steps": max(most - 1, 1)})
    before = results(few, tmp_path / "a")
    assert before[0].converged and not before[-1].converged
    mended = results(longer, tmp_path / "a")
    assert mended[0] == before[0]
    assert all(step.converged for step in mended)


def test_errors_by_the_noise_of_a_scan_are_not_kept_for_another_noise(tmp_path):
    rng = np.random.default_rng(0)
    heights = np.cumsum(np.cumsum(rng.normal(size=(32, 32)), 0), 1) * 2e-3
    np.save(tmp_path / "scan.npy", heights)
    (tmp_path / "s.toml").write_text("""
substrate = { contact_modulus = 50.0 }
sphere = { radius = "30 nm" }
topography = { file = "scan.npy", role = "substrate", unit = "nm", spacing = 1.0 }
interaction = { kind = "hard" }
path = { values = ["1 nN"] }
""")
    scene = Scene.read(tmp_path / "s.toml")
    results(scene, tmp_path / "out")
    noisy = scene.with_values({"topography.noise": "0.05 nm"})
    with pytest.raises(ValueError, match="noise"):
        results(noisy, tmp_path / "out")
