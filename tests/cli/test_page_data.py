"""Numbers on a page that its script shows, beside the files of the run."""

import base64
import json

import numpy as np
import pytest
from small_scene import SMALL

from ase_roughcontact._util.files import table_rows
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.cli.page_data import as_json, data_of_places, data_of_run
from ase_roughcontact.ensemble.places import Place
from ase_roughcontact.scene import Results, Scene


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("run")
    (folder / "scene.toml").write_text(SMALL)
    out = folder / "out"
    main(["run", str(folder / "scene.toml"), "--out", str(out), "--quiet"])
    return Results(out)


@pytest.fixture(scope="module")
def data(results):
    return json.loads(as_json(data_of_run(results)))


@pytest.mark.parametrize(
    "name, unit",
    [("normal_force", "nN"), ("contact_area", "nm²"), ("contact_stiffness", "N/m")],
)
def test_columns_are_the_columns_of_the_table_in_printed_units(
    results, data, name, unit
):
    rows = table_rows((results.folder / "curve.csv").read_text().splitlines())
    expected = [float(row[name]) / UNITS[unit] for row in rows]
    (column,) = [each for each in data["columns"] if each["name"] == name]
    assert column["unit"] == unit
    np.testing.assert_allclose(column["values"], expected, rtol=1e-12)


def test_columns_that_are_not_defined_are_left_out(results, data):
    assert np.isnan(results["gap_error"]).all()
    assert "gap_error" not in [each["name"] for each in data["columns"]]


def test_no_text_ends_the_element_of_the_data():
    assert "</script>" not in as_json({"label": "</script><b>"})
    assert json.loads(as_json({"label": "</script>"})) == {"label": "</script>"}


@pytest.mark.parametrize("field", ["pressure", "gap"])
def test_maps_are_the_fields_of_the_frames(results, data, field):
    frame = data["maps"]["frames"][-1]
    seen = results.map(frame["step"])
    values = np.frombuffer(base64.b64decode(frame[field]), "<f4")
    (left, right, columns), (low, high, rows) = frame["x"], frame["y"]
    expected = getattr(seen, field).astype("f4").T
    np.testing.assert_array_equal(values.reshape(rows, columns), expected)
    ends = [left, right, low, high]
    np.testing.assert_allclose(
        10 * np.array(ends), [*seen.x[[0, -1]], *seen.y[[0, -1]]]
    )


def test_contact_is_a_bit_for_each_point(results, data):
    frame = data["maps"]["frames"][-1]
    seen = results.map(frame["step"])
    bits = np.frombuffer(base64.b64decode(frame["contact"]), "u1")
    found = np.unpackbits(bits, bitorder="little")[: seen.contact.size]
    np.testing.assert_array_equal(found, seen.contact.T.ravel())
    assert found.sum() == results[frame["step"]].repulsive_atoms


def test_of_large_maps_every_other_point_is_on_the_page(results, monkeypatch):
    monkeypatch.setattr("ase_roughcontact.cli.page_data._MAX_POINTS", 8)
    frame = data_of_run(results)["maps"]["frames"][-1]
    seen = results.map(frame["step"])
    every = frame["every"]
    assert every == -(-max(seen.pressure.shape) // 8) > 1
    values = np.frombuffer(base64.b64decode(frame["pressure"]), "<f4")
    expected = seen.pressure[::every, ::every].T.ravel()
    np.testing.assert_array_equal(values, expected.astype("f4"))


def test_maps_of_places_have_the_values_at_their_places():
    scene = Scene.parse(SMALL)
    places = [
        Place(x, y, area=100.0 * (x + 10.0 * y), converged=True)
        for y in (20.0, 10.0)
        for x in (1.0, 2.0, 3.0)
    ]
    maps = data_of_places(scene, places)["maps"]
    (frame,) = maps["frames"]
    assert frame["x"] == pytest.approx([0.1, 0.3, 3])
    assert frame["y"] == pytest.approx([1.0, 2.0, 2])
    values = np.frombuffer(base64.b64decode(frame["area"]), "<f4").reshape(2, 3)
    np.testing.assert_allclose(values, [[101, 102, 103], [201, 202, 203]])
    assert data_of_places(scene, places[:5])["maps"] is None
