"""What other papers report, found again on small grids."""

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

FOLDER = Path(__file__).resolve().parents[1] / "examples" / "published"
QUICK = {
    "light_contact": ("kappa", "kappa_two", "kappa_hurst"),
    "nayak": ("nayak",),
    "challenge": ("challenge_area",),
    "percolation": ("percolation",),
    "lateral": ("lateral",),
    "uniform_pressure": ("square", "triangle"),
}


@pytest.fixture(scope="module")
def published():
    """The module with claims and values."""
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(FOLDER))
        yield import_module("published")
    for name in ("published", "report", "rough_flats"):
        sys.modules.pop(name, None)


def found(published, name):
    """Return the values of a script on its small grids."""
    script = import_module(name)
    rows = [row for case in script.QUICK for row in script.calculate(*case)]
    return script.reported(published.rows_of(script.FIELDS, rows))


@pytest.mark.parametrize("name", QUICK)
def test_a_published_number_is_found_on_a_small_grid(published, name):
    claims, values = published.claims(), found(published, name)
    for key in QUICK[name]:
        assert values[key].agrees(claims[key]), values[key]


def test_uniform_pressure_on_a_rhombus_has_its_closed_form(published):
    # 4/pi times the integral of 1/cos over the angles of a quarter of the rhombus
    script = import_module("uniform_pressure")
    slope = script.DIAGONALS
    angles = np.arcsinh(slope) + np.arcsinh(1.0 / slope)
    middle = 4.0 / np.pi * slope / np.hypot(slope, 1.0) * angles
    circle = 2.0 * np.sqrt(2.0 * slope / np.pi)
    value = found(published, "uniform_pressure")["rhombus"].value
    assert value == pytest.approx(circle / middle, rel=1e-3)


def test_theory_of_a_wavy_sphere_without_waves_is_jkr(published):
    script = import_module("wavy_sphere")
    smooth = script.WavySphere(script.RADIUS, 0.0, script.WAVELENGTH)
    pull_off = 1.5 * np.pi * script.WORK * script.RADIUS
    assert script.pull_off_of_theory(smooth) == pytest.approx(pull_off, rel=1e-4)


@pytest.mark.slow  # 16 s
def test_waves_on_a_sphere_raise_its_pull_off_force(published):
    values = found(published, "wavy_sphere")
    assert values["wavy_sphere"].value > 1.15
