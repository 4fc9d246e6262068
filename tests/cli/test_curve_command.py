"""The command that reads a force curve and fits an indenter to it."""

import json

import numpy as np
import pytest

from ase_roughcontact.cli import main

STIFFNESS, MODULUS, RADIUS = 0.05, 20e-6, 5000.0  # nN/nm, nN/nm^2 (20 kPa), nm


@pytest.fixture
def file(tmp_path):
    """Approach to a soft sample; the first contact is at the base 0."""
    depth = np.linspace(0.0, 300.0, 2001)
    force = 4.0 / 3.0 * MODULUS * np.sqrt(RADIUS) * depth**1.5
    base = np.linspace(1500.0, -(depth + force / STIFFNESS)[-1], 1200)
    force = np.interp(-base, depth + force / STIFFNESS, force)
    force += 0.01 * np.random.default_rng(0).normal(size=base.size) + 0.2
    table = np.column_stack([base, force])
    head = "height (nm),force (nN)"
    name = tmp_path / "curve.csv"
    np.savetxt(name, table, delimiter=",", header=head, comments="")
    return name


def test_a_curve_is_printed_and_drawn_as_it_was_read(file, tmp_path, capsys):
    picture = tmp_path / "read.png"
    words = ["curve", str(file), "--cantilever", "0.05 N/m", "--picture", str(picture)]
    assert main(words) == 0
    printed = capsys.readouterr().out
    assert "approach, 1200 points: base from" in printed
    assert "0.05000" in printed
    assert picture.read_bytes().startswith(b"\x89PNG")


def test_an_indenter_is_fitted(file, tmp_path, capsys):
    words = ["curve", str(file), "--cantilever", "0.05 N/m", "--json"]
    words += ["--indenter", "paraboloid 5 um", "--picture", str(tmp_path / "f.png")]
    assert main(words) == 0
    line = json.loads(capsys.readouterr().out)
    assert line["units"]["contact_modulus"] == "kPa"
    assert line["contact_modulus"] == pytest.approx(20.0, rel=0.02)
    assert line["contact_depth"] == pytest.approx(0.0, abs=3.0)
    assert line["warnings"] == []
    assert (tmp_path / "f.png").exists()


def test_a_wrong_indenter_is_an_error(file, tmp_path, capsys):
    words = ["curve", str(file), "--cantilever", "0.05 N/m", "--indenter", "ball 1 um"]
    assert main([*words, "--picture", str(tmp_path / "f.png")]) == 2
    assert "unknown indenter 'ball'" in capsys.readouterr().err


@pytest.mark.parametrize(
    "options",
    [
        ["--indenter", "sphere 5 um", "--relaxation", "1", "--deepest", "100 nm"],
        ["--indenter", "sphere 5 um", "--relaxation", "1", "--adhesion", "jkr"],
        ["--adhesion", "jkr"],
    ],
)
def test_options_that_the_fit_would_ignore_are_an_error(file, options, capsys):
    assert main(["curve", str(file), "--cantilever", "0.05 N/m", *options]) == 2
    assert options[-2] in capsys.readouterr().err


def test_a_curve_that_cannot_be_fitted_is_printed_and_drawn_with_its_checks(
    tmp_path, capsys
):
    # the deflection of a rigid sample, with a sensitivity that is 1.4 times too large
    height = np.linspace(300.0, -100.0, 600)
    deflection = 1.4 * np.maximum(-height, 0.0)
    deflection += np.random.default_rng(0).normal(size=height.size)
    file, picture = tmp_path / "steep.csv", tmp_path / "f.png"
    rows = np.column_stack([height, deflection])
    head = "distance (nm),deflection (nm)"
    np.savetxt(file, rows, delimiter=",", header=head, comments="")
    words = ["curve", str(file), "--cantilever", "1 N/m", "--picture", str(picture)]
    assert main([*words, "--indenter", "paraboloid 100 nm"]) == 2
    printed = capsys.readouterr()
    assert "sensitivity" in printed.out
    assert "no contact is found" in printed.err
    assert picture.exists()


def test_a_plan_of_a_curve_names_the_command_that_draws_it(file, capsys):
    assert main(["plan", str(file)]) == 2
    assert f"ase-roughcontact curve {file}" in capsys.readouterr().err
