"""Line profiles: statistics, and no contact."""

import math

import numpy as np
import pytest

from ase_roughcontact import HeightMap
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
