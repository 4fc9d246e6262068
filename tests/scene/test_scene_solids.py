"""Solids of scene files: moduli, hardness, and how a run names them."""

import json
import math

import numpy as np
import pytest
from ase.build import bulk
from ase.units import GPa
from matplotlib.figure import Figure
from matscipy.calculators.eam.io import EAMParameters, write_eam
from small_scene import SMALL
from spring_crystal import fcc_springs

import ase_roughcontact as rc
from ase_roughcontact.cli.description import bodies, theory
from ase_roughcontact.cli.figures import draw
from ase_roughcontact.elasticity import Crystal, Cubic, Isotropic, Layer
from ase_roughcontact.elasticity.material import HARDNESS
from ase_roughcontact.scene import Scene, Steps
from ase_roughcontact.scene.reference import reference_for

A = 3.6


@pytest.fixture(scope="module")
def crystal_file(tmp_path_factory):
    file = tmp_path_factory.mktemp("crystal") / "springs.json"
    springs, _ = fcc_springs(A)
    crystal = Crystal.from_calculator(springs, bulk("Cu", a=A), layers=9, size=5)
    crystal.write(file)
    return file


MODULUS = "contact_modulus = 100.0"


def scene(lines, modulus=MODULUS):
    return Scene.parse(SMALL.replace(MODULUS, f"{modulus}\n{lines}"))


LAYER = "layer_thickness = 30.0\nlayer_modulus = 50.0"
CONSTANTS = "elastic_constants = [165.7, 63.9, 79.6]"


@pytest.mark.parametrize(
    "lines, modulus, expected",
    [
        ("", MODULUS, Isotropic(100 * GPa)),
        (
            "anisotropic = true",
            'material = "Cu"',
            Cubic(168.4 * GPa, 121.4 * GPa, 75.4 * GPa),
        ),
        (
            'anisotropic = true\nsurface = "bcc100"',
            "elastic_constants = [231.0, 135.0, 116.0]",
            Cubic(231 * GPa, 135 * GPa, 116 * GPa, "100"),
        ),
        (LAYER, MODULUS, Layer(50 * GPa, 30.0, 100 * GPa)),
        (
            LAYER.replace("30.0", '"3 nm"') + "\nlayer_poisson = 0.2\nsliding = true",
            f"{MODULUS}\npoisson = 0.4",
            Layer(50 * GPa, 30.0, 100 * GPa, 0.2, 0.4, bonded=False),
        ),
        (f"{LAYER}\nrigid_base = true", "", Layer(50 * GPa, 30.0)),
    ],
)
def test_solids_and_their_runs(lines, modulus, expected, tmp_path):
    made = scene(lines, modulus)
    assert made.solid.todict() == pytest.approx(expected.todict())
    assert made.contact_modulus == pytest.approx(expected.contact_modulus)
    assert made.plan().steps[0].problem == ""
    *_, last = made.run(tmp_path)
    assert last.converged and last.repulsive_atoms > 10
    used = made.atoms().calc.parameters
    assert (used["solid"] is None) == isinstance(expected, Isotropic)


def test_a_crystal_beside_the_scene_sets_spacing_and_modulus(crystal_file, tmp_path):
    text = SMALL.replace(MODULUS, 'crystal = "springs.json"')
    made = Scene.parse(text, str(crystal_file.parent / "my.toml"))
    crystal, out = Crystal.read(crystal_file), tmp_path / "run"
    assert made.spacing == crystal.spacing
    assert made.contact_modulus == crystal.contact_modulus
    assert made.radius == pytest.approx(60.0 * crystal.spacing)
    *_, last = made.run(out)
    assert last.converged
    assert list(made.run(out))[-1].normal_force == last.normal_force
    assert json.loads((out / "springs.json").read_text())["symbol"] == "Cu"
    assert Scene.read(out / "scene.toml").solid.todict()["name"] == "Crystal"
    assert f"E* = {crystal.contact_modulus / GPa:.4g} GPa" in bodies(made)["solid"]
    other = scene("").with_values({"substrate.spacing": crystal.spacing})
    with pytest.raises(ValueError, match=r"another scene.*crystal was"):
        list(other.run(out))


def test_a_flat_on_a_crystal_has_its_spacing(crystal_file):
    folder = crystal_file.parent
    np.save(folder / "scan.npy", np.cos(np.arange(64.0))[:, None] * np.ones((1, 8)))
    text = """
    substrate = { crystal = "springs.json", hardness = inf }
    sphere = { radius = inf }
    path = { values = ["100 MPa"] }
    [topography]
    file = "scan.npy"
    role = "substrate"
    unit = "nm"
    periodic = true
    spacing = 2.0
    """
    with pytest.raises(ValueError, match=r"\[sphere\] the atoms .*, the grid 20\.0"):
        _ = Scene.parse(text, str(folder / "my.toml")).bodies
    pixels = text.replace("2.0", f"{Crystal.read(crystal_file).spacing / 10.0!r}")
    assert Scene.parse(pixels, str(folder / "my.toml")).is_flat


def test_the_soft_base_of_a_stiff_layer_does_not_refuse_a_load():
    soft = scene("", "contact_modulus = 0.1").with_values(
        {
            "substrate.shape": "auto",
            "path": Steps(loads=(20.0, 40.0)),
        }
    )
    with pytest.raises(ValueError, match="load of 20 to 40 nN: "):
        soft.check_path()
    layer = {"layer_thickness": "1 µm", "layer_modulus": 100.0}
    soft.with_values({f"substrate.{k}": v for k, v in layer.items()}).check_path()


def test_a_plan_tells_that_uniform_compression_is_left_out():
    def left_out(lines, modulus):
        return " ".join(scene(f"{lines}\nperiodic = true", modulus).plan().left_out)

    rigid = f"{LAYER}\nrigid_base = true\nlayer_poisson = 0.3"
    assert "uniform compression of the layer" in left_out(rigid, "")
    assert "uniform" not in left_out("", MODULUS)


@pytest.mark.parametrize(
    "lines, message",
    [
        ('calculator = "emt"\nanisotropic = true', "give one of calculator and aniso"),
        ("anisotropic = true", "elastic_constants instead of contact_modulus"),
        ('symbol = "Si"\nmaterial = "Au"', "symbol and material are one key"),
        ('material = "silica"', "did you mean 'SiO2'"),
        (
            "layer_modulus = 5.0\nsliding = true",
            "layer_thickness; frictionless_interface needs",
        ),
        ("layer_thickness = 5.0", "give layer_contact_modulus"),
        (LAYER.replace("50.0", "1e6"), "layer_contact_modulus is in GPa"),
        (f"{LAYER}\nlayer_poisson = 0.7", "poisson must be"),
        (f"{LAYER}\nrigid_base = true", "contact_modulus: omit it or rigid_base"),
        ("elastic_constants = [168e9, 121e9, 75e9]", "elastic_constants is in GPa"),
        ('calculator = "emt"', "contact_modulus .*omit it"),
        ('surface = "bcc100"', "surface needs one of calculator, potential, crystal, "),
    ],
)
def test_contradictions_are_errors(lines, message):
    modulus = "" if "elastic_constants = " in lines else MODULUS
    with pytest.raises(ValueError, match=message):
        scene(lines, modulus).check()


@pytest.mark.parametrize(
    "lines, message",
    [
        ('calculator = "dft"', "calculator"),
        ('calculator = "emt"\nsymbol = "Pb"', " Al, .*Pt, got .*'Pb'"),
        ('potential = "missing.alloy"', "can't read .*missing.alloy"),
        ('potential = "."', "can't read .*directory"),
        ('material = "Cu"\npotential = "Cu.eam.fs"', r"eam/fs: .*\.alloy, \.fs, \.eam"),
        ('material = "Cu"\npotential = "Cu.adp"', "eam/alloy: .*write a crystal"),
        (
            'symbol = "Cu"\ncalculator = "emt"\nsurface = "bcc100"',
            "Cu is fcc, .*surface='fcc100'",
        ),
        ('symbol = "Cu"\nanisotropic = true\nsurface = "fcc111"', "surface"),
        ('crystal = "small_scene.py"', "is not a crystal"),
        ('symbol = "Ag"\ncrystal = "springs.json"', "of Cu, got material = 'Ag'"),
        ('crystal = "springs.json"\nspacing = 2.0', "spacing of 2.545584"),
        ('crystal = "springs.json"\nsurface = "bcc100"', "fcc100, got .* 'bcc100'"),
    ],
)
def test_unsuitable_files_are_errors(lines, message, crystal_file):
    folder = crystal_file.parent
    for name in ("small_scene.py", "Cu.eam.fs", "Cu.adp"):
        (folder / name).write_text(SMALL)
    text = SMALL.replace(MODULUS, lines)
    with pytest.raises(ValueError, match=message):
        Scene.parse(text, str(folder / "my.toml")).check()


@pytest.mark.slow
def test_calculators_by_name(tmp_path):
    made = scene('calculator = "emt"', 'material = "Cu"')
    assert made.spacing * np.sqrt(2) == pytest.approx(3.5898, abs=1e-4)
    assert made.contact_modulus / GPa == pytest.approx(152.99, rel=1e-3)
    assert list(made.run(tmp_path))[-1].converged


@pytest.mark.slow
def test_formats_of_potentials_of_embedded_atoms(tmp_path):
    solids = []
    for kind in ("alloy", "fs"):
        write_sutton_chen(tmp_path / f"Cu.eam.{kind}", f"eam/{kind}")
        solids.append(
            scene(f'potential = "{tmp_path}/Cu.eam.{kind}"', 'material = "Cu"').solid
        )
    first, second = solids
    assert 3.5 < first.spacing * np.sqrt(2) < 3.7
    assert 40 < first.contact_modulus / GPa < 200
    assert max(first.figures.values()) < 1e-4
    assert second.spacing == pytest.approx(first.spacing, rel=1e-5)
    assert second.contact_modulus == pytest.approx(first.contact_modulus, rel=1e-4)


def write_sutton_chen(file, kind, cutoff=4.5):
    """Write the potential of A. P. Sutton, J. Chen, Philos. Mag. Lett. 61, 139 (1990).

    The functions for copper fall smoothly to zero between 80 % of the cutoff and it.
    """
    energy, a, c, n, m = 1.2382e-2, 3.61, 39.432, 9, 6
    r, rho = np.linspace(0.0, cutoff, 4000), 0.1 * np.arange(4000)
    x = np.clip((cutoff - r) / (0.2 * cutoff), 0.0, 1.0)
    smooth = x**3 * (10 - 15 * x + 6 * x**2)
    density, pair = ((a / np.maximum(r, 0.5)) ** k * smooth for k in (m, n))
    density = density.reshape((1, 4000) if kind == "eam/alloy" else (1, 1, 4000))
    lattice = ["Cu"], [29], [63.546], [a], ["fcc"]
    grid = EAMParameters(*lattice, 4000, 4000, 0.1, r[1], cutoff)
    embedding = -energy * c * np.sqrt(rho)[None]
    write_eam("", grid, embedding, density, (r * energy * pair)[None, None], file, kind)


NAMED = 'layer_thickness = "2 nm"\nlayer_modulus = 5.0'


@pytest.mark.parametrize(
    "lines, hardness",
    [
        ('material = "Cu"', HARDNESS["Cu"]),
        ('material = "Si"\ncontact_modulus = 171.2', HARDNESS["Si"]),
        ("contact_modulus = 100.0", math.nan),
        ("contact_modulus = 100.0\nhardness = 2.0", 2.0),
        ("contact_modulus = 100.0\nhardness = inf", math.inf),
        (f"anisotropic = true\n{CONSTANTS}", math.nan),
        (f"{NAMED}\nrigid_base = true", math.nan),
        (f'symbol = "Si"\n{NAMED}', math.nan),
        (f'symbol = "Si"\n{NAMED}\nhardness = 2.0', 2.0),
    ],
)
def test_the_hardness_of_an_element_is_only_for_its_surface(lines, hardness):
    made = scene(lines, "")
    assert made.hardness / GPa == pytest.approx(hardness, nan_ok=True)
    words = {math.inf: "elastic"}.get(hardness, f"hardness {hardness:.3g} GPa")
    known = "hardness unknown" if math.isnan(hardness) else words
    assert known in bodies(made)["solid"]
    assert Scene.parse(made.toml) == made


def test_the_hardness_of_the_base_is_not_taken_for_a_layer_in_python():
    sphere = rc.RoughSphere(60.0)
    atoms = rc.substrate("Cu", (24, 24), sphere)
    atoms.calc = rc.RoughContact(sphere, solid=Layer(0.5, thickness=20.0))
    for hardness, known in ((None, False), (np.nan, False), (1e-4, True)):
        limits = rc.Validity("ignore", hardness)
        (step,) = rc.load_path(atoms, penetrations=[0.5], validity=limits)
        assert ("hardness" in step.validity) == known


@pytest.mark.parametrize(
    "lines, label",
    [
        ('symbol = "Si"', "Si, E* = 171.2 GPa, spacing"),
        ('material = "mica"', "mica, E* = 55.78 GPa, spacing"),
        ("contact_modulus = 100", "half space of given moduli, E* = 100 GPa, spacing"),
        (
            'material = "Cu"\nanisotropic = true',
            "Cu, anisotropic continuum, E* = ",
        ),
        (f'symbol = "Si"\n{NAMED}', "layer of 2 nm, E* = 5 GPa, bonded to Si, E* = 1"),
        (
            f"{NAMED}\nrigid_base = true\nsliding = true",
            "layer of 2 nm, E* = 5 GPa, sliding on a rigid base, spacing",
        ),
        (
            f"{NAMED}\nrigid_base = true\nlayer_poisson = 0.3\nperiodic = true",
            "layer of 2 nm, E* = 5 GPa, bonded to a rigid base, heights from the mean "
            "plane of its surface, spacing",
        ),
    ],
)
def test_the_first_line_of_a_run_names_the_solid(lines, label):
    assert bodies(scene(lines, ""))["solid"].startswith(label)


HALF_SPACES = [
    ('material = "Cu"', "the base without a layer"),
    ("rigid_base = true", "material of the layer"),
]


@pytest.mark.parametrize("lines, half_space", HALF_SPACES)
def test_the_theory_beside_a_layer_names_its_half_space(lines, half_space):
    described = theory(reference_for(scene(f"{NAMED}\n{lines}", "")))
    assert described["A/A_Hertz"].endswith(half_space)


@pytest.mark.parametrize("lines, half_space", HALF_SPACES)
def test_legends_of_a_layer_name_the_half_space_of_theory(
    lines, half_space, tmp_path, monkeypatch
):
    figures, saved = [], Figure.savefig

    def kept(figure, *args, **options):
        figures.append(figure)
        saved(figure, *args, **options)

    monkeypatch.setattr(Figure, "savefig", kept)
    layered = scene(f"{NAMED}\n{lines}", "")
    steps = list(layered.run(tmp_path, validity="ignore"))
    draw(reference_for(layered), steps, tmp_path)
    legends = [each for figure in figures for each in figure.legends]
    texts = {text.get_text() for legend in legends for text in legend.get_texts()}
    of_theory = [text for text in texts if "Hertz" in text or "theory" in text]
    assert len(of_theory) >= 2
    assert all(text.endswith(half_space) for text in of_theory)


@pytest.mark.parametrize("young, poisson", [(91.0, 0.3), (75.0, 0.5)])
def test_youngs_modulus_with_poissons_ratio_is_the_contact_modulus(young, poisson):
    given = f'youngs_modulus = "{young} GPa"\npoisson = {poisson}'
    assert scene("", given).contact_modulus == pytest.approx(100.0 * GPa)
    of_python = Isotropic.from_young(young * GPa, poisson)
    assert of_python.contact_modulus == pytest.approx(100.0 * GPa)
    assert of_python.poisson == poisson


@pytest.mark.parametrize(
    "keys, message",
    [
        ("youngs_modulus = 91.0", "youngs_modulus needs poisson"),
        ("youngs_modulus = 91.0\npoisson = 0.6", "poisson"),
        ("youngs_modulus = 2e5\npoisson = 0.3", "youngs_modulus is in GPa"),
        (
            f"youngs_modulus = 91.0\npoisson = 0.3\n{MODULUS}",
            "contact_modulus or young",
        ),
    ],
)
def test_youngs_modulus_alone_or_beside_another_modulus_is_an_error(keys, message):
    with pytest.raises(ValueError, match=message):
        scene("", keys).check()
