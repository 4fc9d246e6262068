"""The paper's figures, redrawn from the committed table."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from ase_roughcontact.ensemble import case_of, read_ensemble

ROOT = Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
TABLE = EXAMPLES / "paper" / "results" / "figure2-paper.csv"


@pytest.fixture(scope="module")
def examples():
    """The scripts, as modules."""
    pytest.importorskip("matplotlib").use("Agg")
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(EXAMPLES / "paper"))
        import figure1
        import figure2
        import paper_scenes
        import reproduction
    return {"1": figure1, "2": figure2, "paper": paper_scenes, "numbers": reproduction}


@pytest.fixture(scope="module")
def table(examples):
    return examples["paper"].read_table(TABLE)


def is_picture(file):
    return file.read_bytes()[:8] == b"\x89PNG\r\n\x1a\n"


def test_every_row_of_the_table_is_a_step_of_the_scenes(examples, table):
    scenes = [scene for band in examples["paper"].scenes("paper") for scene in band]
    loads = {
        (case_of(scene), step): load
        for scene in scenes
        for step, load in enumerate(scene.targets)
    }
    rows = list(zip(table["case"].tolist(), table["step"].tolist(), strict=True))
    assert len(rows) == len(set(rows)) > 1000
    wanted = [loads[row] for row in rows]
    np.testing.assert_allclose(table["target"], wanted, rtol=1e-9)


def test_table_is_small_and_converged(table):
    assert TABLE.stat().st_size < 1e6
    assert table["converged"].all()
    assert np.isfinite(table["continuum_area"][table["kind"] == "hard"]).all()
    np.testing.assert_allclose(table["normal_force"], table["target"], rtol=1e-3)


def test_hard_wall_knows_only_the_product_of_radius_and_slope(examples, table):
    # heights times a number: loads times it, and the same atoms in contact
    curves = {
        (curve.radius, curve.slope): curve
        for curve in examples["paper"].curves(table)
        if curve.kind == "hard"
    }
    sharp, blunt = curves[1e3, 0.1], curves[1e4, 0.01]
    both = min(len(sharp.loads), len(blunt.loads))
    sharp, blunt = sharp.areas[:both], blunt.areas[:both]
    known = np.isfinite(sharp) & np.isfinite(blunt)
    assert known.sum() > 80
    np.testing.assert_allclose(sharp[known], blunt[known], rtol=0.02, atol=1.0)


def test_largest_contacts_agree_with_hertz(examples, table):
    curves = [c for c in examples["paper"].curves(table) if c.radius * c.slope <= 10]
    assert curves
    for curve in curves:
        area = np.nanmean(curve.areas[-1])
        assert area == pytest.approx(curve.hertz[-1], rel=0.02)


def test_figure_1_is_drawn_from_maps_that_are_kept(examples, tmp_path):
    examples["1"].main(["--scale", "tiny", "--out", str(tmp_path)])
    maps, picture = tmp_path / "figure1-tiny.npz", tmp_path / "figure1.png"
    seen = examples["1"].load(maps)
    loads = [4.0 * a**3 / 3e4 for a in examples["1"].CONTACTS["tiny"]]
    np.testing.assert_allclose([s.normal_force for s in seen], loads, rtol=1e-3)
    assert is_picture(picture)


def test_figure_2_is_drawn_from_a_table_alone(examples, tmp_path):
    shutil.copy(TABLE, tmp_path)
    examples["2"].main(["--scale", "paper", "--draw", "--out", str(tmp_path)])
    assert is_picture(tmp_path / "figure2-paper.png")
    assert len(list(tmp_path.iterdir())) == 2


def test_a_database_filled_from_the_table_holds_the_same(tmp_path, examples):
    head, *lines = TABLE.read_text().splitlines()
    some = tmp_path / "some.csv"
    some.write_text("\n".join([head, *lines[::20]]))
    paper = examples["paper"]
    assert paper.fill_database(tmp_path / "filled.db", some) == len(lines[::20])
    assert paper.fill_database(tmp_path / "filled.db", some) == 0
    found = read_ensemble(tmp_path / "filled.db", kind="hard", seed=0)
    table = paper.read_table(some)
    wanted = (table["kind"] == "hard") & (table["seed"] == 0)
    assert wanted.sum() > 5
    np.testing.assert_array_equal(found["contact_area"], table["contact_area"][wanted])


def test_page_has_the_numbers_of_the_table(examples, tmp_path):
    page = EXAMPLES / "guide" / "reproduction.md"
    again = shutil.copy(page, tmp_path / page.name)
    examples["numbers"].main(["--page", str(again)])
    assert again.read_text() == page.read_text()


def test_kappa_of_an_exactly_linear_area_is_found(examples):
    loads = np.geomspace(1e-3, 1e6, 60)
    area = 2.5 * loads / 0.1 * np.array([[1.0], [1.2]])
    curve = examples["paper"].Curve("hard", 1e5, 0.1, 0.0, loads, area.T, area.T / 2)
    kappas = examples["numbers"].kappas
    np.testing.assert_allclose(kappas(curve, curve.areas), [2.5, 3.0])
    np.testing.assert_allclose(kappas(curve, curve.corrected), [1.25, 1.5])
