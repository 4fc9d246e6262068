"""Output columns: units and descriptions of ours, and columns added from outside."""

import json
import math
import pickle
import re
from dataclasses import asdict, dataclass, fields

import numpy as np
import pytest
from ase.io import read
from built import atoms_under
from written_path import written_path

import ase_roughcontact as rc
from ase_roughcontact._util.files import table_rows
from ase_roughcontact.cli.common import json_line
from ase_roughcontact.paths.restart import read_steps, restart_file
from ase_roughcontact.results.errors import errors_of
from ase_roughcontact.results.record import columns_of, units_of

# A column from outside the package: one entry of a subclass


@dataclass(frozen=True)
class StepWithLargestGap(rc.LoadStep):
    largest_gap: float = rc.column(
        lambda s: float(s.fields.gap.max()), "largest gap in the window", "Å"
    )


def make_atoms(**options):
    sphere = rc.RoughSphere(10.0)
    return atoms_under(sphere, shape=(12, 12), **options)


def test_own_column_is_in_result_csv_trajectory_and_json(tmp_path):
    table, movie = tmp_path / "curve.csv", tmp_path / "sweep.traj"
    options = {"record": StepWithLargestGap, "csv": table, "trajectory": movie}
    atoms = make_atoms()
    (step,) = written_path(atoms, [0.4], **options)
    assert step.largest_gap == atoms.calc.state(atoms).gap.max() > 0.0
    with open(table, newline="") as file:
        (row,) = table_rows(file)
    assert list(row) == [*columns_of(), "largest_gap"]
    assert float(row["largest_gap"]) == step.largest_gap
    assert read(movie).info["load_step"].keys() == asdict(step).keys()
    assert read_steps(restart_file(movie), StepWithLargestGap) == [step]
    line = json.loads(json_line(asdict(step), units_of(type(step))))
    assert line["largest_gap"] == step.largest_gap
    assert line["units"] == {**units_of(), "largest_gap": "Å"}


@dataclass(frozen=True)
class StepWithUnknown(rc.LoadStep):
    unknown: float = rc.column(lambda s: math.nan, "a number that is not defined")


def test_an_own_column_that_is_nan_is_not_one_that_the_run_did_not_have():
    (step,) = rc.load_path(
        make_atoms(), penetrations=[0.4], output=rc.Output(record=StepWithUnknown)
    )
    assert "function" in step.not_known["unknown"]
    columns = asdict(step)
    again = StepWithUnknown.from_columns(columns)
    assert again.not_known == step.not_known
    del columns["unknown"], columns["largest_pressure"]
    older = StepWithUnknown.from_columns(columns)
    assert older.not_known["unknown"] == older.not_known["largest_pressure"]
    assert "run" in older.not_known["unknown"]


def test_copies_of_a_result_know_which_columns_a_file_did_not_have():
    asked = rc.LoadStep.with_columns(["conductance"])
    (step,) = rc.load_path(make_atoms(), penetrations=[0.4])
    older = asked.from_columns(asdict(step))
    again = pickle.loads(pickle.dumps(older))
    assert again.not_known == older.not_known
    assert "run" in again.not_known["conductance"]


def test_own_columns_that_would_be_lost_are_refused():
    class Undecorated(rc.LoadStep):
        gap: float = rc.column(lambda s: s.fields.gap.max(), "largest gap", "Å")

    @dataclass(frozen=True)
    class OnTop(Undecorated):
        pass

    @dataclass(frozen=True)
    class NotAColumn(rc.LoadStep):
        gap: float = 1.0

    for record, words in (
        (Undecorated, "dataclass"),
        (OnTop, "Undecorated"),
        (NotAColumn, "NotAColumn"),
    ):
        with pytest.raises(TypeError, match=words):
            written_path(make_atoms(), [0.4], record=record)


def test_a_column_of_what_a_step_does_not_have_is_named_with_where_it_is():
    @dataclass(frozen=True)
    class Area(rc.LoadStep):
        my_area: float = rc.column(lambda s: s.contact_area, "area", "Å^2")

    with pytest.raises(AttributeError, match=r"'my_area'.*step\.fields"):
        list(written_path(make_atoms(), [0.4], record=Area))


def test_own_columns_use_the_errors_that_were_estimated_once():
    seen = []

    @dataclass(frozen=True)
    class StepWithErrors(rc.LoadStep):
        relative_error: float = rc.column(
            lambda s: (
                seen.append(errors_of(s)) or errors_of(s).force / s.fields.normal_force
            ),
            "error of the force, relative to it",
        )
        errors: int = rc.column(
            lambda s: seen.append(errors_of(s)) or 3, "number of errors"
        )

    (step,) = written_path(make_atoms(), [0.4], record=StepWithErrors)
    assert seen[0] is seen[1]
    assert step.relative_error == step.force_error / step.normal_force > 0.0


@pytest.mark.parametrize("before, after", [(0, 1), (1, 0)])
def test_a_path_is_resumed_with_other_columns(tmp_path, before, after):
    records, file = (rc.LoadStep, StepWithLargestGap), tmp_path / "sweep.traj"
    files = {"trajectory": file, "csv": tmp_path / "curve.csv"}
    (old,) = written_path(make_atoms(), [0.4], record=records[before], **files)
    options = {"record": records[after], "resume": True}
    first, second = written_path(make_atoms(), [0.4, 0.5], **options, **files)
    assert type(first) is type(second) is records[after]
    assert first.normal_force == old.normal_force < second.normal_force
    with open(tmp_path / "curve.csv", newline="") as table:
        rows = [list(row.values()) for row in table_rows(table)]
    assert rows[0][:3] == [str(value) for value in list(asdict(old).values())[:3]]
    assert len(rows[0]) == len(rows[1]) == len(asdict(first))
    if after:
        assert math.isnan(first.largest_gap) and second.largest_gap > 0.0


def test_loop_has_own_columns_too():
    loop = rc.adhesion_loop(
        make_atoms(), deepest=0.1, step=0.1, output=rc.Output(record=StepWithLargestGap)
    )
    assert loop.approach[-1].largest_gap < loop.approach[0].largest_gap


# Columns of the package


def test_documentation_of_the_class_describes_every_column():
    for name, each in columns_of().items():
        entry = rf"\n    {name} : \w+\n        {re.escape(each.description)}"
        assert re.search(entry, rc.LoadStep.__doc__)


def test_values_have_the_type_of_their_column():
    (step,) = written_path(make_atoms(), [0.4])
    types = {"int": int, "float": float, "bool": bool, "str": str}
    for each in fields(rc.LoadStep):
        assert isinstance(getattr(step, each.name), types[each.type])
    assert np.isfinite(step.energy)
