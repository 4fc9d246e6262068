"""The HTML page of a run: complete, without other files, with warnings and units."""

import json
import math
import re
from dataclasses import replace
from unittest.mock import patch

import numpy as np
import pytest
from command_cases import keep_figure
from loop_scene import LOOP
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from small_scene import SMALL

from ase_roughcontact._util.files import table_rows
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.cli.page import page
from ase_roughcontact.results.record import columns_of
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.reference import reference_for
from ase_roughcontact.scene.results import outputs


def page_of(folder, scene):
    (folder / "a < b.toml").write_text(scene)
    results = folder / "results"
    main(["run", str(folder / "a < b.toml"), "--out", str(results), "--quiet"])
    assert main(["report", str(results)]) == 0
    return (results / "report.html").read_text()


@pytest.fixture(scope="module")
def steps(tmp_path_factory):
    scene = SMALL.replace("fmax = 1e-4", "fmax = 1e-9\nmax_steps = 3")
    return page_of(tmp_path_factory.mktemp("steps"), f"# a < b & c\n{scene}")


def test_the_page_needs_no_other_file(steps):
    links = re.findall(r'(?:src|href)="([^"]{1,40})', steps)
    table, *images = sorted(links, reverse=True)
    assert table.startswith("data:text/csv;base64,") and len(images) == 3
    assert all(link.startswith("data:image/png;base64,") for link in images)


def test_the_page_has_the_scene_as_text(steps):
    assert "# a &lt; b &amp; c\n" in steps
    assert "long_wavelength = 16.0" in steps


def test_the_page_has_a_row_for_each_step_with_units(steps):
    table, _, _ = steps[steps.index('<table class="steps">') :].partition("</table>")
    assert table.count("<tr") == 3
    heads = ("normal force", "nN"), ("contact stiffness", "N/m"), ("height", "Å")
    for name, unit in heads:
        assert f'>{name}<br><span class="unit">({unit})</span>' in table


def test_steps_that_are_no_results_are_warnings(steps):
    assert "Steps 0, 1 did not converge: " in steps
    assert steps.count('<tr class="failed">') == 2


def test_steps_that_are_no_results_are_marked_in_chart_and_maps(steps):
    (text,) = re.findall(r'id="data">(.*?)</script>', steps)
    data = json.loads(text)
    assert data["failed"] == [0, 1]
    labels = [frame["label"] for frame in data["maps"]["frames"]]
    assert labels[0].startswith("step 0 (not converged): penetration 0.2 Å, ")


def test_the_meaning_of_the_columns_is_on_the_page(steps):
    meaning = columns_of()["penetration"].description
    assert f"<th>penetration</th><td>{meaning}</td>" in steps


def test_numbers_of_atoms_are_whole(tmp_path):
    scene = Scene.parse(SMALL)
    (tmp_path / "scene.toml").write_text(SMALL)
    (state,) = scene.relax([1.0], validity="ignore")
    many = replace(state, repulsive_atoms=123456)
    assert "<td>123456</td>" in page(reference_for(scene), [many], tmp_path)


def test_the_page_of_an_interrupted_run_says_so(tmp_path, steps):
    scene = Scene.parse(SMALL)
    (tmp_path / "scene.toml").write_text(SMALL)
    states = list(scene.relax([1.0], validity="ignore"))
    assert "not finished: 1 of 2 steps" in page(reference_for(scene), states, tmp_path)
    assert "not finished" not in steps


def test_an_error_that_is_not_known_is_no_negligible_one(tmp_path):
    scene = Scene.parse(SMALL)
    (tmp_path / "scene.toml").write_text(SMALL)
    (state,) = scene.relax([1.0], validity="ignore")
    values = {"contact_area": 1e3, "area_error": math.nan, "unknown_errors": "a jump"}
    text = page(reference_for(scene), [replace(state, **values)], tmp_path)
    assert '<td>10.00 <span class="error">± not known</span></td>' in text
    assert "in 1 of 1 steps: a jump" in text


@pytest.fixture(scope="module")
def loop(tmp_path_factory):
    folder = tmp_path_factory.mktemp("loop")
    return folder / "results", page_of(folder, LOOP)


def test_names_of_all_results_are_known(loop):
    folder, _ = loop
    assert "cantilever.csv" in outputs()
    assert {path.name for path in folder.iterdir()} <= outputs()


def test_the_page_of_a_loop_has_its_values_and_force_curves(loop):
    _, text = loop
    for words in (
        "<th>pull-off force</th>",
        "<th>cantilever</th><td>60 N/m",
        "<th>cantilever snap-in</th><td>from ",
    ):
        assert words in text
    for caption in ("tip held at each height", "curve of the cantilever", "Pressure"):
        assert caption in text


def test_areas_of_a_loop_are_drawn_over_all_forces_and_forces_once(loop):
    (folder, _), figures = loop, {}
    with patch.object(Figure, "savefig", keep_figure(figures)):
        assert main(["figure", str(folder), "--format", "svg"]) == 0
    assert set(figures) == {"curve.svg", "contact.svg", "loop.svg", "cantilever.svg"}
    (axes,) = figures["curve.svg"].axes
    lines = {line.get_label(): np.array(line.get_data()) for line in axes.lines}
    force, area = np.concatenate([lines["approach"], lines["retraction"]], axis=1)
    states = list(table_rows((folder / "curve.csv").read_text().splitlines()))
    for drawn, column, unit in (
        (force, "normal_force", UNITS["nN"]),
        (area, "contact_area", UNITS["nm²"]),
    ):
        expected = np.array([float(state[column]) for state in states]) / unit
        np.testing.assert_allclose(drawn, expected)
    assert axes.get_xlabel().endswith("(nN)") and "(nm$^2$)" in axes.get_ylabel()


def test_theory_of_the_areas_of_a_loop_ends_at_its_pull_off_force(loop):
    (folder, _), figures = loop, {}
    with patch.object(Figure, "savefig", keep_figure(figures)):
        main(["figure", str(folder)])
    lines = figures["curve.png"].axes[0].lines
    (jkr,) = [each for each in lines if each.get_label().startswith("JKR")]
    force, area = jkr.get_data()
    work, radius = 1.0, 5.0  # J/m², nm
    pull_off = 1.5 * np.pi * work * radius
    assert force[np.isfinite(area)].min() == pytest.approx(-pull_off, rel=0.02)


def test_figures_of_a_loop_are_drawn_again_with_a_map_of_the_deepest_state(
    loop, capsys, monkeypatch
):
    (folder, _), titles = loop, []
    (folder / "loop.png").unlink()
    monkeypatch.setattr(Axes, "set_title", lambda _, text, **__: titles.append(text))
    assert main(["figure", str(folder)]) == 0
    assert "loop.png" in capsys.readouterr().out
    for name in ("loop.png", "cantilever.png", "view.traj"):
        assert (folder / name).stat().st_size > 5000
    states = list(table_rows((folder / "curve.csv").read_text().splitlines()))
    deepest = max(states, key=lambda state: float(state["penetration"]))
    force = f"{float(deepest['normal_force']) / UNITS['nN']:.3g} nN"
    assert any(force in title for title in titles)
