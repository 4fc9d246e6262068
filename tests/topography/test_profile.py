"""Line profiles: statistics, and the contact of an extruded one."""

import math

import numpy as np
import pytest

from ase_roughcontact import HeightMap
from ase_roughcontact.scene import Scene
from ase_roughcontact.topography.profile import LineProfile
from ase_roughcontact.topography.scan_files import read_scan

X = np.arange(1000) / 50.0
WAVE = np.sin(2.0 * np.pi * X / 2.0)


@pytest.mark.parametrize("tilt", [0.0, 0.3])
def test_a_wave_has_the_height_and_slope_of_its_amplitude(tilt):
    places = np.append(X, 20.0)  # ten periods of 2 nm
    heights = np.append(WAVE, 0.0) + tilt * places
    height, slope = LineProfile(heights, places, "nm").statistics()
    # a straight line through ten periods of a sine explains 6 / (10 pi)^2 of it
    left = 1.0 - 6.0 / (10.0 * math.pi) ** 2
    assert height == pytest.approx(10.0 * math.sqrt(left / 2.0), rel=1e-3)
    assert slope == pytest.approx(math.pi / math.sqrt(2.0), rel=1e-2)


def test_statistics_are_not_known_without_unit_or_places():
    assert np.isnan(LineProfile(WAVE, X).statistics()).all()
    assert np.isnan(LineProfile(WAVE, None, "nm").statistics()).all()
    assert np.isfinite(LineProfile(WAVE, X).statistics("nm")).all()


@pytest.mark.parametrize("table", [np.c_[X, WAVE], WAVE[:, None]])
def test_a_profile_is_read_as_one_and_refused_as_a_scan(tmp_path, table):
    file = tmp_path / "profile.txt"
    np.savetxt(file, table)
    profile = read_scan(file)
    np.testing.assert_allclose(profile.heights, WAVE)
    with pytest.raises(ValueError, match=r"1000 points.* scan an area"):
        HeightMap.from_topography(file, "substrate", unit="nm")


def test_the_error_has_the_statistics_of_the_profile(tmp_path):
    np.savetxt(tmp_path / "profile.csv", np.c_[X, WAVE], delimiter=",")
    with pytest.raises(ValueError, match=r"rms height 0\.7\d* µ?nm, rms slope 2\.2"):
        HeightMap.from_topography(tmp_path / "profile.csv", "substrate", unit="nm")


def test_a_profile_of_a_profilometer_has_its_units(tmp_path, topography):
    head = "Scan Parameters\nID,0\n\nScan Data\n\nLateral um,Raw nm,\n"
    rows = "\n".join(f"{x:.2f},{z:.9f}," for x, z in zip(X, WAVE, strict=True))
    (tmp_path / "profile.csv").write_text(head + rows)
    height, slope = read_scan(tmp_path / "profile.csv").statistics()
    assert height == pytest.approx(10.0 * WAVE.std(), rel=0.02)
    assert slope == pytest.approx(1e-3 * math.pi / math.sqrt(2.0), rel=0.02)


def extruded(file, pressures):
    text = f"""
    [substrate]
    contact_modulus = "1 GPa"
    hardness = inf
    [sphere]
    radius = inf
    [topography]
    file = "{file}"
    role = "substrate"
    extrude = true
    periodic = true
    detrend = "mean"
    [interaction]
    kind = "hard"
    [path]
    values = {pressures}
    """
    return list(Scene.parse(text, str(file)).relax(validity="ignore"))


def test_an_extruded_wave_is_the_line_contact_of_westergaard(tmp_path):
    x = np.arange(512.0)  # nm
    table = np.c_[x, 2.0 * np.cos(2.0 * np.pi * x / 512.0)]
    np.savetxt(file := tmp_path / "wave.txt", table, header="units: nm")
    # H. M. Westergaard, J. Appl. Mech. 6, 49 (1939): full contact at pi E* h / lambda
    complete = np.pi * 1000.0 * 2.0 / 512.0  # MPa
    shares = np.array([0.08, 0.3, 0.8])
    steps = extruded(file, [f"{share * complete} MPa" for share in shares])
    for step, share in zip(steps, shares, strict=True):
        nominal = step.normal_force / step.nominal_pressure
        exact = 2.0 / np.pi * np.arcsin(np.sqrt(share)) * nominal
        assert abs(step.continuum_area - exact) < 2.0 * step.area_error
        assert step.continuum_area == pytest.approx(exact, rel=0.01)


def test_uneven_places_of_a_profile_are_interpolated():
    places = np.delete(X, [100, 101, 500])
    raw = LineProfile(np.delete(WAVE, [100, 101, 500]), places, "nm").extruded()
    np.testing.assert_allclose(raw.spacing, 0.02)
    assert (raw.heights == raw.heights[:, :1]).all()
    np.testing.assert_allclose(raw.heights[:, 0], WAVE, atol=2e-2)


def test_only_a_profile_is_extruded(tmp_path):
    np.savetxt(file := tmp_path / "map.txt", WAVE.reshape(25, 40))
    with pytest.raises(ValueError, match=r"a line profile, got 40 x 25 points"):
        HeightMap.from_topography(
            file, "substrate", spacing=1.0, unit="nm", extrude=True
        )
