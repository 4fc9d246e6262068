"""Files of stresses have the values, names and places of the planes."""

import base64
from xml.etree import ElementTree

import numpy as np
import pytest
from ase.units import GPa
from scipy.io import netcdf_file

from ase_roughcontact.analysis import ContactMap, stress_planes, write_stress
from ase_roughcontact.cli import main
from ase_roughcontact.elasticity import Isotropic, von_mises
from ase_roughcontact.scene import Scene

SOLID, DEPTHS = Isotropic(0.9, 0.3), [20.0, 5.0]
NAMES = [f"stress_{name}" for name in ("xx", "yy", "zz", "yz", "xz", "xy")]


def contact_map():
    x, y = 2.0 * np.arange(-8.0, 8.0), 2.0 * np.arange(-6.0, 7.0)
    pressure = np.maximum(0.05 - 1e-3 * (x[:, None] ** 2 + (y - 1) ** 2), 0.0)
    return ContactMap(pressure, pressure > 0, 2.0, (x[0], y[0]), periodic=False)


def read_npz(file):
    return dict(np.load(file))


def read_netcdf(file):
    with netcdf_file(file, mmap=False) as data:
        assert data.variables["stress_xx"].units == b"GPa"
        return {name: each.data.copy() for name, each in data.variables.items()}


def read_vtk(file):
    """Fields and axes of a file of VTK, with its units checked."""
    grid = ElementTree.parse(file).getroot()[0]
    assert grid.get("WholeExtent") == "0 15 0 12 0 1"
    found = {}
    for array in grid.iter("DataArray"):
        name, raw = array.get("Name"), base64.b64decode(array.text)
        (unit,) = array.findall("InformationKey")
        assert unit.get("name") == "UNITS_LABEL"
        if name in "xyz":
            assert unit.text == "nm" and array.get("type") == "Float64"
            found[name] = np.frombuffer(raw[8:], "<f8")
        else:  # x varies fastest
            assert unit.text == "GPa" and array.get("type") == "Float32"
            values = np.frombuffer(raw[8:], "<f4")
            found[name] = values.reshape(2, 13, 16).transpose(0, 2, 1)
    if grid.tag == "ImageData":
        ends = [grid.get(key).split() for key in ("Origin", "Spacing")]
        for axis, first, step, count in zip("xyz", *ends, (16, 13, 2), strict=True):
            found[axis] = float(first) + float(step) * np.arange(count)
    return found


@pytest.mark.parametrize(
    ("suffix", "read"),
    [("npz", read_npz), ("nc", read_netcdf), ("vtr", read_vtk), ("vti", read_vtk)],
)
def test_files_have_the_stress_of_the_planes(suffix, read, tmp_path):
    seen, file = contact_map(), tmp_path / f"stress.{suffix}"
    write_stress(seen, SOLID, DEPTHS, file)
    found = read(file)
    np.testing.assert_allclose(found["z"], [-2.0, -0.5], rtol=1e-6)
    np.testing.assert_allclose(found["x"], seen.x / 10, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(found["y"], seen.y / 10, rtol=1e-6, atol=1e-9)
    for number, plane in enumerate(stress_planes(seen, SOLID, DEPTHS)):
        expected = plane.stress / GPa
        for name, values in zip(NAMES, expected, strict=True):
            np.testing.assert_allclose(found[name][number], values, atol=1e-5)
        largest = found["von_mises"][number]
        np.testing.assert_allclose(largest, von_mises(expected), atol=1e-5)


def test_wrong_files_are_refused(tmp_path):
    with pytest.raises(ValueError, match=r"\.vtr"):
        write_stress(contact_map(), SOLID, DEPTHS, tmp_path / "stress.xyz")
    with pytest.raises(ValueError, match="depths"):
        write_stress(contact_map(), SOLID, [], tmp_path / "stress.npz")
    for depths in ([1.0], [1.0, 2.0, 4.0]):
        with pytest.raises(ValueError, match=r"\.vtr"):
            write_stress(contact_map(), SOLID, depths, tmp_path / "stress.vti")


SCENE = """
[substrate]
contact_modulus = 100.0
poisson = 0.3
hardness = inf
shape = [32, 32]
[sphere]
unit = "a0"
radius = 400.0
[interaction]
kind = "hard"
[path]
values = [20.0]
"""


def test_command_writes_the_stress_at_the_given_depths(tmp_path, capsys):
    (tmp_path / "scene.toml").write_text(SCENE)
    out = str(tmp_path / "out")
    assert main(["run", str(tmp_path / "scene.toml"), "--out", out]) == 0
    assert main(["maps", out, "--format", "npz", "--depths", "0.5,20 Å"]) == 0
    found = read_npz(tmp_path / "out" / "maps" / "stress-0000.npz")
    np.testing.assert_allclose(found["z"], [-2.0, -0.5])
    assert found["von_mises"].shape == (2, 64, 64)  # the grid of the continuum
    for depths, name in (("2,1,3", "stress-0000.vti"), ("1,2,4", "stress-0000.vtr")):
        assert main(["maps", out, "--format", "vti", "--depths", depths]) == 0
        assert name in capsys.readouterr().out
    assert main(["maps", out, "--depths", "-1"]) != 0
    assert "--depths" in capsys.readouterr().err


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_stress_of_a_run_without_the_poisson_ratio_needs_only_the_ratio(
    tmp_path, capsys
):
    list(Scene.parse(SCENE.replace("poisson = 0.3", "")).run(tmp_path))
    command = ["maps", str(tmp_path), "--format", "npz", "--depths", "0.5"]
    assert main(command) != 0
    file = tmp_path / "scene.toml"
    error = capsys.readouterr().err
    assert "poisson" in error and str(file) in error
    file.write_text(file.read_text().replace("[substrate]", "[substrate]\npoisson=0.3"))
    assert main(command) == 0
    assert (tmp_path / "maps" / "stress-0000.npz").exists()
