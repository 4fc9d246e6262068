"""Names that users import, keywords that they give, and errors for wrong ones."""

import ast
import re
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest
from ase.units import J, m
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact import foundation

ROOT = Path(__file__).resolve().parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "examples" / "guide").glob("*.md"))]
SCRIPTS = sorted((ROOT / "examples" / "gallery").glob("*.py"))
PACKAGES = {
    "analysis",
    "elasticity",
    "ensemble",
    "foundation",
    "interactions",
    "optimize",
    "plot",
    "scene",
    "theory",
    "topography",
}
SPHERE = rc.RoughSphere(60.0)


def imported_names(text):
    """Modules of the package and the names that a script imports from them."""
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and node.module.startswith(rc.__name__):
            for alias in node.names:
                yield node.module, alias.name


def code_of(page):
    """Blocks of Python on a page that import the package."""
    for block in re.findall(r"(?sm)^```(?:python)?\n(.*?)^```", page.read_text()):
        if re.search(r"(?m)^\s*(from|import) ase_roughcontact", block):
            yield block


def test_guide_and_gallery_import_public_names_alone():
    blocks = [block for page in PAGES for block in code_of(page)]
    texts = [*blocks, *(script.read_text() for script in SCRIPTS)]
    found = {each for text in texts for each in imported_names(text)}
    assert len(found) > 50
    private = []
    for module, name in sorted(found):
        package = module.partition(".")[2]
        names = import_module(module).__all__ if package in PACKAGES else ()
        if not package:
            names = {*rc.__all__, *PACKAGES}
        if name not in names:
            private.append(f"{module}.{name}")
    assert not private


@pytest.mark.parametrize("package", sorted(PACKAGES))
def test_packages_are_attributes_without_an_import_of_their_own(package, monkeypatch):
    module = import_module(f"ase_roughcontact.{package}")
    monkeypatch.delattr(rc, package, raising=False)
    assert getattr(rc, package) is module


def test_explicit_atoms_are_a_package_and_names_without_it_work():
    for name in foundation.__all__:
        assert getattr(rc, name) is getattr(foundation, name)
    assert not {*foundation.__all__} & {*rc.__all__}
    with pytest.raises(AttributeError, match="'ase_roughcontact' has no attribute 'x'"):
        _ = rc.x


def test_units_are_values_in_units_of_ase():
    found = [rc.nN, rc.nm, rc.GPa]
    assert found == pytest.approx([1e-9 * J / m, 10.0, 1e9 * J / m**3], rel=1e-14)


ATOMS = atoms_under(SPHERE)
CALLS = [
    ("load_path", "window", lambda **wrong: rc.load_path(ATOMS, **wrong)),
    ("time_path", "window", lambda **wrong: rc.time_path(ATOMS, **wrong)),
    ("adhesion_loop", "window", lambda **wrong: rc.adhesion_loop(ATOMS, **wrong)),
    ("Scene.relax", "validity", lambda **wrong: rc.Scene.default().relax(**wrong)),
    ("substrate", "height", lambda **wrong: rc.substrate("Cu", (8, 8), **wrong)),
    (
        "FreeHalfSpace",
        "engine",
        lambda **wrong: rc.elasticity.FreeHalfSpace((8, 8), 1.0, 1.0, **wrong),
    ),
]


@pytest.mark.parametrize("name, keyword, call", CALLS, ids=[each[0] for each in CALLS])
def test_a_wrong_keyword_is_an_error_with_the_function_and_a_suggestion(
    name, keyword, call
):
    typo = keyword[:-2] + keyword[-1]
    with pytest.raises(TypeError, match=rf"{name}\(\).*{typo}.*mean '{keyword}'"):
        call(**{typo: "auto"})


def test_lengths_with_a_unit_are_for_scene_files():
    for call in (
        lambda: rc.RoughSphere("30 nm"),
        lambda: rc.load_path(ATOMS, penetrations="3 nm"),
        lambda: rc.substrate("Cu", (8, 8), SPHERE, spacing="2 Å"),
    ):
        with pytest.raises(ValueError, match=r"units of ASE \(Å, eV\)"):
            call()


def test_options_of_scans_fail_before_the_run():
    with pytest.raises(TypeError, match="scan_errors must be callable, got 3"):
        rc.StepOptions(scan_errors=3)
    with pytest.raises(ValueError, match="scan_errors must be true or false, got 3"):
        rc.Scene.default().relax(scan_errors=3)


def test_wall_has_an_earlier_name():
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.02)
    calc = rc.RoughContact(SPHERE, 1.0, interaction=wall)
    assert calc.parameters["wall"] == wall
    calc.set(interaction=rc.HardWall())
    assert calc.parameters["wall"] == rc.HardWall()
    with pytest.raises(TypeError, match="interaction"):
        rc.RoughContact(SPHERE, 1.0, wall, interaction=wall)


def test_one_number_is_a_path_of_one_step():
    (one,) = rc.load_path(atoms_under(SPHERE), loads=2.0, window="auto")
    (other,) = rc.load_path(atoms_under(SPHERE), loads=[2.0], window="auto")
    assert one.contact_area == other.contact_area
    assert one.normal_force == pytest.approx(2.0, rel=1e-3)


def test_the_path_fixes_and_frees_the_indenter():
    atoms = atoms_under(SPHERE, shape=(24, 24))
    (pressed,) = rc.load_path(atoms, penetrations=0.5)
    (loaded,) = rc.load_path(atoms, loads=pressed.normal_force, accuracy=1e-6)
    assert not atoms.constraints
    assert loaded.penetration == pytest.approx(0.5, rel=1e-3)
    (again,) = rc.load_path(atoms, penetrations=0.5)
    assert [each.index.tolist() for each in atoms.constraints] == [[len(atoms) - 1]]
    assert again.normal_force == pytest.approx(pressed.normal_force, rel=1e-3)


@pytest.mark.parametrize("fixed, path", [(True, "loads"), (False, "heights")])
def test_a_support_that_was_given_stays(fixed, path):
    atoms = atoms_under(SPHERE, fixed=fixed)
    with pytest.raises(ValueError, match=f"without fixed={fixed}"):
        rc.load_path(atoms, **{path: 1.0})


def test_a_folder_is_an_output_from_which_the_path_is_resumed(tmp_path):
    folder = tmp_path / "new" / "out"
    path = {"output": folder, "window": "auto"}
    first = list(rc.load_path(atoms_under(SPHERE), loads=[1.0, 2.0], **path))
    names = {"curve.csv", "sweep.traj", "sweep.restart.npz"}
    assert {each.name for each in folder.iterdir()} == names
    again = list(rc.load_path(atoms_under(SPHERE), loads=[1.0, 2.0, 3.0], **path))
    assert [each.seconds for each in again[:2]] == [each.seconds for each in first]
    assert len(again) == 3


def test_amplitudes_of_roughness_are_properties():
    rough = rc.SelfAffine(0.1, 0.8, short_wavelength=16.0, long_wavelength=32.0)
    heights = rough.heights((128, 128), 1.0)
    q = 2 * np.pi * np.fft.fftfreq(128)
    square = q[:, None] ** 2 + q**2
    power = np.abs(np.fft.fft2(heights) / heights.size) ** 2
    expected = [np.sqrt((square**n * power).sum()) for n in (0, 1, 2)]
    surface = rc.HeightMap(heights, 1.0, periodic=True)
    for each, rel in ((rough, 1e-9), (surface, 0.01)):  # a map is a spline
        found = each.rms_height, each.rms_slope, each.rms_curvature
        assert found == pytest.approx(expected, rel=rel)
