"""Maps written to files have the values, names and units of the contact."""

import base64
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
from ase.units import GPa
from built import atoms_under
from scipy.io import netcdf_file

import ase_roughcontact as rc
from ase_roughcontact.analysis import ContactMap, write_map
from ase_roughcontact.cli import main
from ase_roughcontact.scene import Scene

SHAPE = (14, 11)


@pytest.fixture(scope="module")
def atoms():
    sphere = rc.RoughSphere(40.0)
    atoms = atoms_under(sphere, shape=SHAPE, modulus=0.9, spacing=2.5, height=-0.5)
    assert rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
    return atoms


def read_npz(file):
    return {name: each for name, each in np.load(file).items() if each.ndim}


def read_netcdf(file):
    with netcdf_file(file, mmap=False) as data:
        assert data.length_unit == b"nm"
        assert data.variables["pressure"].units == b"GPa"
        assert data.variables["pressure"].dimensions == ("x", "y")
        return {name: each.data.copy() for name, each in data.variables.items()}


def read_vtk(file):
    image = ElementTree.parse(file).getroot().find("ImageData")
    fields = {}
    for array in image.iter("DataArray"):
        raw = base64.b64decode(array.text)
        kind = {"Float64": "<f8", "Int8": "i1"}[array.get("type")]
        assert int.from_bytes(raw[:8], "little") == len(raw) - 8
        values = np.frombuffer(raw[8:], kind)
        if array.get("NumberOfTuples") is None:  # a number of the whole map
            fields[array.get("Name")] = values.reshape(SHAPE, order="F")
    origin, spacing = (
        [float(each) for each in image.get(key).split()]
        for key in ("Origin", "Spacing")
    )
    fields["x"], fields["y"] = (
        origin[i] + spacing[i] * np.arange(SHAPE[i]) for i in (0, 1)
    )
    return fields


READERS = {".npz": read_npz, ".nc": read_netcdf, ".vti": read_vtk}


@pytest.mark.parametrize("suffix", READERS)
@pytest.mark.parametrize("source", ["atoms", "frame"])
def test_fields_agree_with_the_contact(atoms, tmp_path, suffix, source):
    indenter = atoms.calc.parameters["indenter"]
    made = {
        "atoms": lambda: ContactMap.from_atoms(atoms),
        "frame": lambda: ContactMap.from_frame(rc.snapshot(atoms), indenter),
    }[source]()
    write_map(made, tmp_path / f"map{suffix}")
    fields = READERS[suffix](tmp_path / f"map{suffix}")
    state = atoms.calc.state(atoms)
    n, m = SHAPE
    grid = atoms.positions[:-1, 2].reshape(state.forces.shape)[:n, :m]
    expected = {
        "pressure": state.pressure / GPa,
        "gap": state.gap / 10,
        "displacement": -grid / 10,
        "contacting_points": state.contact,
        "x": made.x / 10,
        "y": made.y / 10,
    }
    assert fields.keys() == expected.keys()
    for name, values in expected.items():
        np.testing.assert_allclose(fields[name], values, rtol=1e-6, atol=1e-9)
    assert fields["displacement"].max() > 0.0


def numbers_in(file):
    """Numbers of a map in a file, apart from its fields."""
    if file.suffix == ".npz":
        return {
            name: float(each) for name, each in np.load(file).items() if not each.ndim
        }
    if file.suffix == ".nc":
        with netcdf_file(file, mmap=False) as data:
            assert data.height_unit == b"nm" and data.normal_force_unit == b"nN"
            names = "normal_force", "contact_area", "step", "height", "penetration"
            return {name: float(getattr(data, name)) for name in names}
    data = ElementTree.parse(file).getroot().find("ImageData").find("FieldData")
    return {
        each.get("Name"): np.frombuffer(base64.b64decode(each.text)[8:], "<f8")[0]
        for each in data
    }


@pytest.mark.parametrize("suffix", READERS)
def test_load_height_and_step_are_written(tmp_path, suffix):
    atoms = atoms_under(rc.RoughSphere(40.0), shape=SHAPE)
    *_, step = rc.load_path(atoms, penetrations=[0.1, 0.2])
    file = tmp_path / f"map{suffix}"
    write_map(ContactMap.from_atoms(atoms), file, step)
    expected = {
        "normal_force": step.normal_force / rc.nN,
        "contact_area": step.contact_area / rc.nm**2,
        "step": 1,
        "height": step.height / rc.nm,
        "penetration": 0.2 / rc.nm,
    }
    assert numbers_in(file) == pytest.approx(expected, rel=1e-6)


def test_fields_that_are_not_known_are_left_out(atoms, tmp_path):
    write_map(ContactMap.from_frame(rc.snapshot(atoms)), tmp_path / "map.npz")
    assert "gap" not in np.load(tmp_path / "map.npz")


@pytest.mark.parametrize("suffix", READERS)
@pytest.mark.parametrize(
    "name, factor",
    [
        ("slip", 0.1),  # nm
        ("slip_rate_x", 0.1),  # nm/s
        ("slip_rate_y", 0.1),
        ("friction_state", 1.0),
        ("slipping", 1.0),
        ("traction_x", 1.0 / GPa),
        ("displacement_y", 0.1),
    ],
)
def test_fields_of_friction_are_written_in_their_units(
    atoms, tmp_path, suffix, name, factor
):
    field = np.full(SHAPE, 0.5)
    made = replace(ContactMap.from_atoms(atoms), lateral={name: field})
    write_map(made, tmp_path / f"map{suffix}")
    fields = READERS[suffix](tmp_path / f"map{suffix}")
    np.testing.assert_allclose(fields[name], 0.5 * factor)


def test_an_unknown_format_is_refused(atoms, tmp_path):
    with pytest.raises(ValueError, match=r"'\.png'"):
        write_map(ContactMap.from_atoms(atoms), tmp_path / "map.png")


@pytest.mark.parametrize("suffix", ["nc", "vti"])
def test_the_command_writes_a_map_for_each_step(tmp_path, capsys, suffix):
    text = '[substrate]\nmaterial = "Cu"\nshape = [12, 12]\n'
    text += '[sphere]\nradius = "20 a0"\n'
    text += '[path]\ncontrol = "penetration"\nvalues = [0.1, 0.3]\n'
    steps = list(Scene.parse(text).run(tmp_path, validity="ignore"))
    assert main(["maps", str(tmp_path), "--format", suffix]) == 0
    names = capsys.readouterr().out.split()
    assert names == [str(tmp_path / "maps" / f"step-000{i}.{suffix}") for i in (0, 1)]
    if suffix == "nc":
        contact = read_netcdf(names[1])["contacting_points"]
        assert np.count_nonzero(contact) == steps[1].repulsive_atoms


# Python 3.10 closes the archive a second time
@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")
@pytest.mark.parametrize("suffix", ["npz", "vti"])
def test_a_map_that_does_not_fit_leaves_the_old_one(
    atoms, tmp_path, suffix, largest_file
):
    file = tmp_path / f"map.{suffix}"
    file.write_text("old")
    with largest_file(500), pytest.raises(OSError, match=str(file)):
        write_map(ContactMap.from_atoms(atoms), file)
    assert file.read_text() == "old" and list(tmp_path.iterdir()) == [file]


def test_a_link_in_place_of_the_folder_of_maps_is_refused(tmp_path, capsys):
    scene = Scene.parse(
        'substrate = { material = "Cu", shape = [8, 8] }\npath = { values = [0.01] }'
    )
    list(scene.run(tmp_path, validity="ignore"))
    (tmp_path / "other").mkdir()
    (tmp_path / "maps").symlink_to(tmp_path / "other")
    assert main(["maps", str(tmp_path)]) == 2
    assert f"{tmp_path / 'maps'} is a symbolic link" in capsys.readouterr().err
    assert not list((tmp_path / "other").iterdir())
