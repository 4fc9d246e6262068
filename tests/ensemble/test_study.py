"""Studies: values of parameters in a scene or in options, with a table and a figure."""

import csv
import json
import re
from pathlib import Path

import numpy as np
import pytest
from ensemble_scenes import SCENE, Here
from matplotlib.figure import Figure
from scipy.stats import t

from ase_roughcontact._util.printing import number
from ase_roughcontact.cli import main
from ase_roughcontact.ensemble import read_ensemble, study_points
from ase_roughcontact.scene import Scene, Steps
from ase_roughcontact.theory import Hertz, MaugisDugdale

LOADS = SCENE.with_values({"path": Steps(loads=(2.0, 10.0))})
STUDY = """
[study]
seeds = 3
sphere.radius = { first = 40, last = 80, steps = 3 }
"""


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Run the command on a scene in this process; return its output and figures."""
    for module in ("run", "adaptive"):
        pool = f"ase_roughcontact.ensemble.{module}.worker_pool"
        monkeypatch.setattr(pool, lambda executor, workers: Here())
    drawn = []

    def saved(figure, file, **_):
        drawn.append(figure)
        Path(file).touch()

    monkeypatch.setattr(Figure, "savefig", saved)

    def run_with(text, *options):
        (tmp_path / "my.toml").write_text(text)
        database = str(tmp_path / "e.db")
        given = [str(tmp_path / "my.toml"), "--database", database]
        assert main(["ensemble", *given, *options]) == 0
        return drawn

    return run_with


def rows_of(folder):
    with open(folder / "e-study.csv", newline="") as file:
        return list(csv.DictReader(file))


def test_a_study_ends_with_means_over_the_seeds_and_a_figure(
    run, tmp_path, capsys, monkeypatch
):
    monkeypatch.setattr("ase_roughcontact.cli.study.MIN_PRINTED_ERROR", 0.0)
    (figure,) = run(LOADS.toml + STUDY)
    rows = rows_of(tmp_path)
    assert [row["sphere.radius"] for row in rows] == [
        "40",
        "40",
        "60",
        "60",
        "80",
        "80",
    ]
    steps = read_ensemble(tmp_path / "e.db")
    for row in rows:
        same = steps["radius"] == float(row["sphere.radius"])
        same &= np.isclose(steps["target"], float(row["target"]))
        areas = steps["contact_area"][same]
        assert areas.size == int(row["realisations"]) == 3
        assert float(row["mean"]) == pytest.approx(areas.mean())
        assert float(row["scatter"]) == pytest.approx(np.std(areas, ddof=1))
        half = t.ppf(0.975, 2) * np.std(areas, ddof=1) / np.sqrt(3)
        assert float(row["standard_error"]) == pytest.approx(half / 1.959964)
    (axes,) = figure.axes
    bars = axes.containers[0].lines[2][0].get_paths()
    assert all(np.isfinite(bar.vertices).all() for bar in bars)
    lines = [line for line in axes.lines if line.get_linestyle() == "-"]
    lines = [line for line in lines if len(line.get_xdata()) == 3]
    means = [float(row["mean"]) / 100.0 for row in rows]  # nm^2
    np.testing.assert_allclose(lines[0].get_xdata(), [40.0, 60.0, 80.0])
    np.testing.assert_allclose(lines[0].get_ydata(), means[::2])
    np.testing.assert_allclose(lines[1].get_ydata(), means[1::2])
    assert axes.get_xlabel() == "sphere radius"
    printed = capsys.readouterr().out
    assert f"{means[0]:.4g}"[:4] in printed and "e-study.png" in printed
    page = (tmp_path / "e-study.html").read_text()
    (answer,) = re.findall(r'class="answer">(.*?)</p>', page)
    error = float(rows[0]["standard_error"]) / 100.0
    assert f"{number(means[0])} ± {number(error, 2)} nm² at sphere radius 40" in answer
    assert "at sphere radius 80" in answer and "3 realisations" in answer
    (text,) = re.findall(r'id="data">(.*?)</script>', page)
    data = json.loads(text)
    filters = {each["label"]: each["values"] for each in data["filters"]}
    assert filters["sphere radius"] == ["40", "40", "60", "60", "80", "80"]
    assert filters["target"][::2] == 3 * filters["target"][:1]
    columns = {each["name"]: each for each in data["columns"]}
    assert columns["sphere.radius"]["values"] == [40.0, 40.0, 60.0, 60.0, 80.0, 80.0]
    assert columns["contact_area"]["unit"] == "nm²"
    np.testing.assert_allclose(columns["contact_area"]["values"], means)
    errors = [float(row["standard_error"]) / 100.0 for row in rows]
    np.testing.assert_allclose(columns["contact_area"]["errors"], errors)
    largest = max(float(row["value_error"]) for row in rows) / 100.0  # nm^2
    shown = printed.split("single values by up to ")[1].split(",")[0]
    assert float(shown) == pytest.approx(largest, rel=0.05)


def test_a_study_of_smooth_spheres_stands_beside_hertz(run, tmp_path):
    scene = LOADS.with_values({"roughness": None})
    run(scene.toml, "--set", "sphere.radius=100:400:3:geometric")
    rows = rows_of(tmp_path)
    assert [float(row["sphere.radius"]) for row in rows[::2]] == [100.0, 200.0, 400.0]
    for row in rows:
        radius = float(row["sphere.radius"]) * scene.spacing
        hertz = Hertz(radius, scene.contact_modulus)
        expected = float(hertz.contact_area(float(row["target"])))
        assert float(row["theory"]) == pytest.approx(expected)


def test_the_theory_of_a_cone_has_the_name_of_a_cone(tmp_path):
    cone = Scene.parse(
        'substrate = { material = "Cu" }\n'
        'indenter = { kind = "cone", half_angle = 70.0 }'
    )
    scene = cone.with_values({"path": LOADS.path})
    points = study_points(scene, {}, tmp_path / "e.db", "contact_area")
    for point in points:
        # I. N. Sneddon, Int. J. Eng. Sci. 3, 47 (1965): N = E* A / (2 tan(theta))
        area = 2.0 * np.tan(np.radians(70.0)) * point.mean.target
        assert point.theory == pytest.approx(area / scene.contact_modulus)
        assert point.theory_name == "Sneddon, smooth cone"
    assert len(points) == 2


def test_the_pull_off_force_of_a_sticky_rough_sphere_stands_beside_a_smooth_one(
    tmp_path,
):
    scene = Scene.parse("""
        substrate = { contact_modulus = "1.4 GPa", spacing = "3.6 nm" }
        sphere.radius = "1 um"
        roughness.rms_height = "0.8 nm"
        roughness.short_wavelength = "21.6 nm"
        roughness.long_wavelength = "86.4 nm"
        interaction.kind = "adhesive"
        interaction.work_of_adhesion = "50 mJ/m^2"
        interaction.attraction_range = "1 nm"
        path.kind = "loop"
    """)
    heights = {"roughness.rms_height": ["0.8 nm", "3.2 nm"]}
    points = study_points(scene, heights, tmp_path / "e.db", "pull_off_force")
    sphere = scene.radius, scene.contact_modulus, scene.wall.work_of_adhesion
    smooth = MaugisDugdale(*sphere, scene.wall.attraction_range)
    for point in points:  # rougher ones are not sticky, and have no other line
        assert point.theory == pytest.approx(smooth.pull_off_force)
        assert point.theory_name == "Maugis-Dugdale, smooth sphere"


def test_options_replace_values_of_the_section_and_are_drawn_in_their_unit(
    run, tmp_path
):
    options = ["--set", "roughness.seed=4:5:2", "--over", "roughness.rms_height"]
    heights = 'roughness.rms_height="0.1 nm","50 pm"'
    (figure,) = run(LOADS.toml + STUDY, *options, "--set", heights)
    rows = rows_of(tmp_path)
    assert {row["realisations"] for row in rows} == {"2"} and len(rows) == 3 * 2 * 2
    assert set(read_ensemble(tmp_path / "e.db")["seed"]) == {4, 5}
    axes = figure.axes[0]
    assert axes.get_xlabel() == "rms height (nm)"
    np.testing.assert_allclose(axes.lines[0].get_xdata(), [0.05, 0.1])
    ends = [part.get_paths() for part in axes.containers[0].lines[2]]
    assert not any(np.isfinite(path.vertices).all() for path in ends[0])  # two seeds


def test_keys_that_vary_together_are_one_line_of_similar_surfaces(run, tmp_path):
    study = """
    [study]
    together = ["roughness.rms_height", "roughness.long_wavelength"]
    roughness.rms_height = { first = 0.1, last = 0.4, steps = 3, scale = "geometric" }
    sphere.radius = [40]
    roughness.long_wavelength = { first = 8, last = 32, steps = 3, scale = "geometric" }
    """
    path = {"path": Steps(loads=(2.0,)), "roughness.short_wavelength": 4.0}
    (figure,) = run(LOADS.with_values(path).toml + study)
    rows = rows_of(tmp_path)
    assert [row["roughness.rms_height"] for row in rows] == ["0.1", "0.2", "0.4"]
    assert [row["roughness.long_wavelength"] for row in rows] == ["8", "16", "32"]
    found = read_ensemble(tmp_path / "e.db")
    np.testing.assert_allclose(found["rms_height"] * 80, found["long_wavelength"])
    assert len(figure.axes[0].containers) == 1


@pytest.mark.parametrize(
    ("together", "message"),
    [('"sphere.radius", "path.last"', "2 of path.last"), ('"sphere.rad"', "radius")],
)
def test_keys_that_vary_together_need_equal_numbers_of_values(
    tmp_path, capsys, together, message
):
    study = f"{STUDY}path.last = [2.0, 3.0]\ntogether = [{together}]"
    (tmp_path / "my.toml").write_text(SCENE.toml + study)
    options = ["--database", str(tmp_path / "e.db")]
    assert main(["ensemble", str(tmp_path / "my.toml"), *options]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "e.db").exists()


def test_targets_that_change_with_the_parameter_are_lines_over_it(run):
    path = {
        "path": Steps.of({"first": 2.0, "last": 10.0, "steps": 3}),
        "roughness": None,
    }
    scene = SCENE.with_values(path)
    (figure,) = run(scene.toml, "--set", "path.last=10,20,30,40")
    lines = [line for line in figure.axes[0].lines if line.get_linestyle() == "-"]
    lines = [line for line in lines if len(line.get_xdata()) == 4]
    assert len(lines) == 3
    np.testing.assert_allclose(lines[2].get_xdata(), [10.0, 20.0, 30.0, 40.0])
    # the last target is the parameter, the first is the same for all its values
    assert (np.diff(lines[2].get_ydata()) > 0.0).all()
    np.testing.assert_allclose(np.ptp(lines[0].get_ydata()), 0.0)


def test_a_study_with_an_error_has_as_many_seeds_as_it_needs(run, tmp_path):
    text = LOADS.toml + STUDY.replace("seeds = 3", "error = 0.5")
    run(text.replace("steps = 3 }", "steps = 2 }"), "--quiet")
    rows = rows_of(tmp_path)
    assert all(int(row["realisations"]) >= 8 for row in rows)
    assert all(float(row["standard_error"]) <= 0.5 * float(row["mean"]) for row in rows)


def test_a_study_does_not_change_the_scene(tmp_path):
    scene = Scene.parse(LOADS.toml + STUDY)
    assert scene.identity == LOADS.identity
    again = Scene.parse(scene.toml)
    assert again.study == scene.study and again.study.parameters == {
        "sphere.radius": (40, 60, 80)
    }


@pytest.mark.parametrize(
    ("given", "values"),
    [
        ('{ first = "1 nm", last = "4 nm", steps = 3, scale = "geometric" }',
         ("1 nm", "2 nm", "4 nm")),
        ('{ first = "1 nm", last = "1.0000003 nm", steps = 4 }',
         ("1 nm", "1.0000001 nm", "1.0000002 nm", "1.0000003 nm")),
        ("{ first = 0.0, last = 1.0, steps = 5 }", (0.0, 0.25, 0.5, 0.75, 1.0)),
        ("{ first = 0, last = 3, steps = 4 }", (0, 1, 2, 3)),
        ('["1 nm", 3]', ("1 nm", 3)),
    ],
)  # fmt: skip
def test_values_are_lists_or_ranges(given, values):
    study = Scene.parse(f"[study]\nsphere.radius = {given}").study
    assert study.parameters["sphere.radius"] == values


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("sphere.radius = []", "at least one"),
        ("sphere.radius = { first = 1, last = 2 }", "steps"),
        ("sphere.radius = { first = 1, last = 2, steps = 1 }", "steps"),
        ('sphere.radius = { first = "1 nm", last = 2, steps = 2 }', "one unit"),
        ('sphere.radius = { first = 0, last = 2, steps = 2, scale = "geometric" }',
         "one sign"),
        ("radius = [1, 2]", "section"),
        ("sphere.radius = { first = 1, last = 2, number = 2 }", "number"),
        ('sphere.radius = { first = 1, last = 2, steps = 2, scale = ["a"] }', "scale"),
        ("seeds = 0", "seeds"),
        ("seeds = -3", "seeds"),
        ("error = 0.0", "error"),
        ("error = -1.0", "error"),
    ],
)  # fmt: skip
def test_wrong_values_are_refused(given, message):
    with pytest.raises(ValueError, match=message):
        Scene.parse(f"[study]\n{given}")


def test_a_figure_over_the_seeds_is_refused_before_the_run(tmp_path, capsys):
    (tmp_path / "my.toml").write_text(LOADS.toml + STUDY)
    options = ["--database", str(tmp_path / "e.db"), "--over", "roughness.seed"]
    assert main(["ensemble", str(tmp_path / "my.toml"), *options]) == 2
    assert "another parameter" in capsys.readouterr().err
    assert not (tmp_path / "e.db").exists()


def test_seeds_and_an_error_exclude_each_other(tmp_path, capsys):
    study = STUDY.replace("seeds = 3", "seeds = 3\nerror = 0.1")
    (tmp_path / "my.toml").write_text(LOADS.toml + study)
    assert main(["ensemble", str(tmp_path / "my.toml")]) == 2
    assert "omit seeds" in capsys.readouterr().err
