"""Load steps of ensembles as arrays and as CSV files."""

import csv

import numpy as np
import pytest
from ensemble_scenes import (
    SCENES,
    STEPS,
    assert_same,
    assert_same_states,
    finish,
    rows,
)

from ase_roughcontact.ensemble import (
    case_of,
    fill_database,
    read_csv,
    read_ensemble,
    write_csv,
)


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
    columns = read_csv(tmp_path / "e.csv")
    assert_same(columns, read_ensemble(undisturbed), rtol=5e-10)
    np.testing.assert_allclose(
        columns["seconds"], read_ensemble(undisturbed)["seconds"], rtol=5e-10
    )
    assert len(columns["case"]) == STEPS


def test_csv_fills_a_database_once_and_is_written_from_it_unchanged(
    undisturbed, tmp_path
):
    database, file, again = (tmp_path / name for name in ("e.db", "e.csv", "f.csv"))
    write_csv(undisturbed, file)
    assert fill_database(database, file) == STEPS
    assert fill_database(database, file) == 0
    write_csv(database, again)
    assert again.read_text() == file.read_text()


def test_csv_adds_the_missing_steps_of_a_case(undisturbed, tmp_path):
    database, part, whole = (tmp_path / name for name in ("e.db", "p.csv", "e.csv"))
    write_csv(undisturbed, part, "step<2")
    write_csv(undisturbed, whole)
    begun = fill_database(database, part)
    assert fill_database(database, whole) == STEPS - begun


def test_csv_with_a_step_twice_is_rejected(undisturbed, tmp_path):
    database, file = tmp_path / "e.db", tmp_path / "e.csv"
    write_csv(undisturbed, file)
    with open(file, "a") as stream:
        stream.write(file.read_text().splitlines()[3] + "\n")
    with pytest.raises(ValueError, match=r"e\.csv must .* step 2 of case c\w+ twice"):
        fill_database(database, file)
    assert not database.exists()


def test_csv_of_every_digit_is_read_exactly(undisturbed, tmp_path):
    columns = read_ensemble(undisturbed)
    with open(tmp_path / "e.csv", "w", newline="") as stream:
        writer = csv.writer(stream)
        writer.writerow(columns)
        writer.writerows(zip(*(x.tolist() for x in columns.values()), strict=True))
    for name, values in read_csv(tmp_path / "e.csv").items():
        np.testing.assert_array_equal(values, columns[name], name)


def test_a_run_continues_from_a_csv_file(undisturbed, tmp_path):
    database, file = tmp_path / "e.db", tmp_path / "e.csv"
    write_csv(undisturbed, file, "step<2")
    fill_database(database, file)
    before = {row.unique_id for row in rows(database, record="step")}
    assert len(before) == 2 * len(SCENES)
    assert finish(SCENES[:4], database).steps == 4 * 3
    assert before <= {row.unique_id for row in rows(database, record="step")}
    for scene in SCENES[:4]:
        whole, again = (
            read_ensemble(origin, case=case_of(scene))
            for origin in (undisturbed, database)
        )
        assert_same_states(again, whole)


def test_csv_with_other_columns_or_types_is_rejected(undisturbed, tmp_path):
    file = tmp_path / "e.csv"
    file.write_text("case,seed\nc,1\n")
    with pytest.raises(ValueError, match=r"e\.csv: the columns must be case, step and"):
        read_csv(file)
    file.write_text("case,step,colour\nc,1,red\n")
    with pytest.raises(ValueError, match="got case, step, colour"):
        read_csv(file)
    write_csv(undisturbed, file)
    file.write_text(file.read_text().replace(",True,", ",yes,"))
    with pytest.raises(ValueError, match=r"line 2: converged must be .*, got 'yes'"):
        read_csv(file)
    file.write_text("case,step\nc,first\n")
    with pytest.raises(ValueError, match=r"line 2: step must be .*, got 'first'"):
        read_csv(file)


def test_csv_that_is_cut_off_is_rejected(undisturbed, tmp_path):
    file = tmp_path / "e.csv"
    write_csv(undisturbed, file)
    file.write_text(file.read_text()[:-100])
    with pytest.raises(ValueError, match=r"must be of type \w+, got ''"):
        read_csv(file)


def test_columns_that_a_csv_file_lacks_are_missing_values(tmp_path):
    file = tmp_path / "e.csv"
    file.write_text("case,step\nc,1\n")
    columns = read_csv(file)
    assert columns["step"].tolist() == [1]
    assert np.isnan(columns["memory"]).all()


def test_reading_does_not_create_a_database(tmp_path):
    with pytest.raises(ValueError, match="there is no database"):
        read_ensemble(tmp_path / "e.db")
    assert not list(tmp_path.iterdir())
