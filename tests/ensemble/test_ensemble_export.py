"""Load steps of ensembles as arrays and as CSV files."""

import pickle
from shutil import copyfile

import numpy as np
import pytest
from ensemble_scenes import SCENES, STEPS, rows

from ase_roughcontact._util.files import table_rows
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.ensemble import case_of, read_ensemble, write_csv


def test_steps_can_be_queried_by_input_and_store_the_whole_scene(undisturbed):
    columns = read_ensemble(undisturbed, "penetration>0.3,kind=adhesive", seed=1)
    assert set(columns["work_of_adhesion"]) == {0.05}
    assert len(columns["step"]) == 2
    (row,) = rows(undisturbed, kind="repulsive", seed=1, step=2)
    assert row.case == case_of(SCENES[2])
    assert row.data["scene"]["roughness"]["seed"] == 1
    assert row.positions[0, 2] == row.height
    assert row.converged and row.max_force < row.tolerance


def test_csv_has_ten_digits(undisturbed, tmp_path):
    write_csv(undisturbed, tmp_path / "e.csv")
    with open(tmp_path / "e.csv", newline="") as stream:
        lines = stream.readlines()
    heads = "radius (a0)", "normal_force (eV/Å)", "contact_modulus (eV/Å^3)", "seed"
    assert set(heads) < set(lines[0].strip().split(","))
    rows = list(table_rows(lines))
    assert len(rows) == STEPS
    for name, values in read_ensemble(undisturbed).items():
        written = np.array([row[name] for row in rows])
        if values.dtype.kind == "f":
            np.testing.assert_allclose(written.astype(float), values, rtol=5e-10)
        else:
            np.testing.assert_array_equal(written, values.astype(str))


def test_a_table_does_not_replace_its_database(undisturbed, tmp_path):
    database = tmp_path / "e.db"
    copyfile(undisturbed, database)
    with pytest.raises(ValueError, match="one file"):
        write_csv(database, tmp_path / "x" / ".." / "e.db")
    options = ["--database", str(database), "--table", str(database)]
    assert main(["ensemble", *options]) == 2
    assert len(read_ensemble(database)["step"]) == STEPS


def test_columns_of_an_ensemble_have_units_tables_and_figures(undisturbed, tmp_path):
    steps = read_ensemble(undisturbed)
    assert steps.units["radius"] == "a0" and steps.units["normal_force"] == "eV/Å"
    assert "target" not in steps.units  # it depends on the control
    cases = len({*steps["case"]})
    assert repr(steps).startswith(f"EnsembleTable(cases={cases}, steps={STEPS}, ")
    figure = steps.figure(file=tmp_path / "area.svg")
    assert (tmp_path / "area.svg").read_bytes()[:5] == b"<?xml"
    (axes,) = figure.axes
    assert axes.get_xlabel() == "normal force (nN)"
    (points,) = (each for each in axes.lines if each.get_label() == "simulation")
    np.testing.assert_allclose(points.get_xdata() * UNITS["nN"], steps["normal_force"])
    assert points.get_linestyle() == "None"
    table = steps._repr_html_()
    assert "<th>contact area (nm²)</th>" in table and "contact modulus" not in table
    with pytest.raises(ValueError, match="'normal_force'"):
        steps.figure("normal_forse")
    found = pickle.loads(pickle.dumps(steps))
    assert found.units == steps.units and found.keys() == steps.keys()


def test_columns_of_an_ensemble_are_a_table_of_pandas(undisturbed):
    pytest.importorskip("pandas", reason="needs the extra tables")
    cases = read_ensemble(undisturbed, record="case")
    table = cases.to_pandas()
    assert table.attrs["units"]["contact_modulus"] == "eV/Å^3"
    assert table["state"].tolist() == cases["state"].tolist()
