"""Columns that need a solution of their own are calculated where they are asked for."""

import copy
import json
import math
import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np
import pytest
from ase.io import read
from built import atoms_under
from small_scene import SMALL
from written_path import written_path

import ase_roughcontact as rc
from ase_roughcontact._util.files import table_rows
from ase_roughcontact.cli import main
from ase_roughcontact.ensemble import case_of, product, read_ensemble, run_ensemble
from ase_roughcontact.paths.restart import read_steps, restart_file
from ase_roughcontact.results.column import column_on_request
from ase_roughcontact.results.record import (
    columns_of,
    columns_on_request,
)
from ase_roughcontact.scene import Scene

ASKED = {"columns": ["conductance"]}
ASKING = SMALL + '[output]\ncolumns = ["conductance"]\n'
FLAT = """
substrate = { contact_modulus = 100.0, hardness = inf }
sphere = { radius = inf }
interaction = { kind = "hard" }
path = { values = ["100 MPa", "1 GPa"] }
[roughness]
unit = "a0"
short_wavelength = 8.0
long_wavelength = 32.0
domain = 64.0
"""


def make_atoms():
    return atoms_under(rc.RoughSphere(10.0), shape=(12, 12))


def rows_of(file):
    with open(file, newline="") as table:
        return list(table_rows(table))


def test_a_column_that_was_not_asked_for_is_absent(tmp_path):
    file = tmp_path / "curve.csv"
    (step,) = written_path(make_atoms(), [0.4], csv=file)
    assert "conductance" not in rows_of(file)[0]
    assert not hasattr(step, "conductance")
    with pytest.raises(AttributeError, match=r"Output\(columns=\['conductance'\]\)"):
        _ = step.conductance


def test_a_column_that_was_asked_for_is_in_all_files(tmp_path):
    files = {"csv": tmp_path / "curve.csv", "trajectory": tmp_path / "sweep.traj"}
    (step,) = written_path(make_atoms(), [0.4], **files, **ASKED)
    assert step.conductance > 0.0
    assert float(rows_of(files["csv"])[0]["conductance"]) == step.conductance
    info = read(files["trajectory"]).info["load_step"]
    assert info["conductance"] == step.conductance
    asked = rc.LoadStep.with_columns(["conductance"])
    assert read_steps(restart_file(files["trajectory"]), asked) == [step]


def test_other_columns_are_there_whether_or_not_they_are_asked_for():
    columns = ["contact_stiffness", "conductance", "conductance"]
    (step,) = written_path(make_atoms(), [0.4], columns=columns)
    assert list(columns_of(type(step))) == [*columns_of(), "conductance"]


@pytest.mark.parametrize(
    ("columns", "error", "advice"),
    [
        (["conductence"], ValueError, "did you mean 'conductance'"),
        (["lateral_stiffness"], ValueError, "Known: conductance"),
        ("conductance", TypeError, "a list .* 'conductance'"),
    ],
)
def test_columns_that_do_not_exist_are_refused(columns, error, advice):
    with pytest.raises(error, match=advice):
        list(written_path(make_atoms(), [0.4], columns=columns))


def test_own_columns_may_be_on_request():
    @dataclass(frozen=True)
    class Own(rc.LoadStep):
        largest_gap = column_on_request(
            lambda s: float(s.fields.gap.max()), "largest gap in the window", "Å"
        )

    columns = ["largest_gap", "conductance"]
    atoms = make_atoms()
    (step,) = written_path(atoms, [0.4], record=Own, columns=columns)
    assert isinstance(step, Own)
    assert step.largest_gap == atoms.calc.state(atoms).gap.max()
    added = columns_on_request(Own).keys() - columns_on_request(rc.LoadStep).keys()
    assert added == {"largest_gap"}


def test_results_with_columns_on_request_are_copied_and_pickled():
    atoms = atoms_under(rc.RoughSphere(10.0), rc.PlasticWall(1.0), (12, 12))
    (step,) = written_path(atoms, [0.4], **ASKED)
    for other in (pickle.loads(pickle.dumps(step)), copy.deepcopy(step)):
        assert other == step
        assert type(other) is type(step)
    both = rc.SlidingStep.with_columns(["conductance", "lateral_stiffness"])
    one_by_one = rc.SlidingStep.with_columns(["conductance"])
    assert one_by_one.with_columns(["lateral_stiffness"]) is both


@pytest.mark.parametrize("keep", ["all", "last"])
def test_a_path_that_is_resumed_with_a_column_has_it_from_there_on(tmp_path, keep):
    files = {"trajectory": tmp_path / "sweep.traj", "csv": tmp_path / "curve.csv"}
    options = {**files, "keep": keep}
    list(written_path(make_atoms(), [0.3, 0.4], **options))
    *_, second, third = written_path(
        make_atoms(), [0.3, 0.4, 0.5], resume=True, **ASKED, **options
    )
    assert math.isnan(second.conductance) and third.conductance > 0.0
    *before, last = (row["conductance"] for row in rows_of(files["csv"]))
    assert before == ["nan", "nan"]
    assert float(last) == third.conductance
    # and without it again
    for step in written_path(make_atoms(), [0.3, 0.4, 0.5], resume=True, **options):
        assert not hasattr(step, "conductance")


@pytest.mark.filterwarnings("ignore:the pull-off force")
def test_a_loop_has_the_column_in_all_of_its_states():
    sphere = rc.RoughSphere(20.0)
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.05)
    loop = rc.adhesion_loop(
        atoms_under(sphere, wall, (20, 20)),
        deepest=0.3,
        step=0.2,
        tolerance=0.1,
        validity="ignore",
        output=rc.Output(**ASKED),
    )
    states = (*loop.approach, *loop.retraction)
    touching = [state for state in states if state.repulsive_atoms]
    assert min(state.normal_force for state in touching) < 0.0
    for state in states:
        # a cell has 0.79 of the diameter of a circle of its area, times two
        diameters = 4.0 * math.sqrt(state.contact_area / math.pi)
        assert 0.7 * diameters <= state.conductance <= 1.5 * diameters


def test_a_scene_asks_in_its_section_output(tmp_path):
    first, _ = Scene.parse(ASKING).run(tmp_path, validity="ignore")
    assert first.conductance > 0.0
    assert Scene.of_results(tmp_path).record is type(first)
    assert float(rows_of(tmp_path / "curve.csv")[0]["conductance"]) > 0.0


def test_columns_do_not_make_another_scene(tmp_path):
    scene, asking = Scene.parse(SMALL), Scene.parse(ASKING)
    assert asking.identity == scene.identity
    assert asking.changes_from(scene) == []
    next(scene.run(tmp_path, validity="ignore"))
    first, second = asking.run(tmp_path, validity="ignore")
    assert math.isnan(first.conductance) and second.conductance > 0.0


@pytest.mark.parametrize(
    ("columns", "advice"),
    [("[1.0]", "a list of names"), ('["k"]', r"\[output\].*Known: conductance")],
)
def test_columns_of_a_scene_are_checked(columns, advice):
    with pytest.raises(ValueError, match=advice):
        Scene.parse(f"{SMALL}[output]\ncolumns = {columns}\n").check()


def test_rough_flats_ask_for_the_conductance_by_default(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for step in Scene.parse(FLAT).relax(validity="ignore"):
        # the elastic contact of a hard wall agrees with a punch
        stiffness = 0.5 * step.conductance * Scene.parse(FLAT).contact_modulus
        assert stiffness == pytest.approx(step.contact_stiffness, rel=1e-3)
    none = "output = { columns = [] }\n" + FLAT
    assert "conductance" not in columns_of(Scene.parse(none).record)
    for text, shown in ((FLAT, True), (none, False)):
        (tmp_path / "flat.toml").write_text(text)
        main(["run", "flat.toml", "--out", f"out{shown}"])
        assert ("conductance" in capsys.readouterr().out) is shown


def test_lines_of_json_have_the_column_with_its_unit(capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "small.toml").write_text(ASKING)
    main(["run", "small.toml", "--out", "out", "--json"])
    line = json.loads(capsys.readouterr().out.splitlines()[0])
    assert line["conductance"] > 0.0
    assert line["units"]["conductance"] == "Å"


def test_an_ensemble_has_the_column_of_the_cases_that_asked(tmp_path):
    database = tmp_path / "ensemble.db"
    for text, radius in ((SMALL, 60.0), (ASKING, 70.0)):
        cases = product(Scene.parse(text), {"sphere.radius": [radius]})
        with ThreadPoolExecutor(1) as pool:
            list(run_ensemble(cases, database, pool, interval=0.02))
    found = read_ensemble(database)
    asked = found["case"] == case_of(*cases)
    assert 0 < np.count_nonzero(asked) < len(asked)
    assert np.isnan(found["conductance"][~asked]).all()
    assert (found["conductance"][asked] > 0.0).all()
    assert np.isnan(found["lateral_stiffness"]).all()
