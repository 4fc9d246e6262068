"""Solids of scene files."""

import json

import numpy as np
import pytest
from ase.build import bulk
from ase.calculators.eam import EAM
from ase.units import GPa
from matscipy.calculators.eam.io import read_eam, write_eam
from small_scene import SMALL
from spring_crystal import fcc_springs

from ase_roughcontact.cli import main
from ase_roughcontact.elasticity import Crystal, Cubic, Isotropic, Layer
from ase_roughcontact.scene import Scene

A = 3.6


@pytest.fixture(scope="module")
def crystal_file(tmp_path_factory):
    file = tmp_path_factory.mktemp("crystal") / "springs.json"
    springs, _ = fcc_springs(A)
    crystal = Crystal.from_calculator(springs, bulk("Cu", a=A), layers=9, size=5)
    crystal.write(file)
    return file


def scene(lines, modulus="contact_modulus = 100.0"):
    return Scene.parse(SMALL.replace("contact_modulus = 100.0", f"{modulus}\n{lines}"))


LAYER = "layer_thickness = 30.0\nlayer_modulus = 50.0"
CONSTANTS = "elastic_constants = [165.7, 63.9, 79.6]"


@pytest.mark.parametrize(
    "lines, modulus, expected",
    [
        ("", "contact_modulus = 100.0", Isotropic(100 * GPa)),
        ("anisotropic = true", "", Cubic(168.4 * GPa, 121.4 * GPa, 75.4 * GPa)),
        (
            "anisotropic = true",
            "elastic_constants = [150.0, 100.0, 40.0]",
            Cubic(150 * GPa, 100 * GPa, 40 * GPa),
        ),
        (
            'anisotropic = true\nsurface = "bcc100"',
            "elastic_constants = [231.0, 135.0, 116.0]",
            Cubic(231 * GPa, 135 * GPa, 116 * GPa, "100"),
        ),
        (LAYER, "contact_modulus = 100.0", Layer(50 * GPa, 30.0, 100 * GPa)),
        (
            LAYER.replace("30.0", '"3 nm"') + "\nlayer_poisson = 0.2\nsliding = true",
            "contact_modulus = 100.0\npoisson = 0.4",
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


def test_a_crystal_sets_spacing_and_modulus(crystal_file, tmp_path):
    made = scene(f'crystal = "{crystal_file}"', "")
    crystal = Crystal.read(crystal_file)
    assert made.spacing == crystal.spacing
    assert made.contact_modulus == crystal.contact_modulus
    assert made.radius == pytest.approx(60.0 * crystal.spacing)
    *_, last = made.run(tmp_path / "run")
    assert last.converged
    resumed = list(made.run(tmp_path / "run"))
    assert resumed[-1].normal_force == last.normal_force
    other = scene("").with_values({"substrate.spacing": crystal.spacing})
    with pytest.raises(ValueError, match=r"another scene.*crystal was"):
        list(other.run(tmp_path / "run"))


def test_a_crystal_is_found_beside_the_scene_and_copied_to_the_results(
    crystal_file, tmp_path, capsys
):
    text = SMALL.replace("contact_modulus = 100.0", 'crystal = "springs.json"')
    (tmp_path / "my.toml").write_text(text)
    (tmp_path / "springs.json").write_text(crystal_file.read_text())
    out = tmp_path / "out"
    assert main(["run", str(tmp_path / "my.toml"), "--out", str(out)]) == 0
    modulus = Crystal.read(crystal_file).contact_modulus / GPa
    assert f"E* = {modulus:.4g} GPa" in capsys.readouterr().out
    assert json.loads((out / "springs.json").read_text())["symbol"] == "Cu"
    assert Scene.read(out / "scene.toml").solid.todict()["name"] == "Crystal"


def test_the_soft_base_of_a_stiff_layer_does_not_refuse_a_load():
    def check(lines):
        text = SMALL.replace("shape = [32, 30]\ncontact_modulus = 100.0", lines)
        text = text.replace(
            '"penetration"\nfirst = 0.2\nlast = 0.6', '"load"\nlast = 40'
        )
        Scene.parse(text.replace("steps = 2", "first = 20\nsteps = 2")).check_path()

    base = "contact_modulus = 0.1"
    with pytest.raises(ValueError, match="load of 20 to 40 nN: "):
        check(base)
    check(f'{base}\nlayer_thickness = "1 µm"\nlayer_modulus = 100.0')


def test_a_plan_tells_that_uniform_compression_is_left_out():
    def left_out(lines, modulus):
        return " ".join(scene(f"{lines}\nperiodic = true", modulus).plan().left_out)

    rigid = f"{LAYER}\nrigid_base = true\nlayer_poisson = 0.3"
    assert "uniform compression of the layer" in left_out(rigid, "")
    assert "uniform" not in left_out("", "contact_modulus = 100.0")


@pytest.mark.parametrize(
    "lines, message",
    [
        ('calculator = "emt"\nanisotropic = true', "give one of calculator and aniso"),
        ("anisotropic = true", "elastic_constants instead of contact_modulus"),
        ('symbol = "Si"\nmaterial = "Au"', "not both, got 'Si' and 'Au'"),
        ('material = "silica"', "did you mean 'SiO2'"),
        (
            "layer_modulus = 5.0\nlayer_poisson = 0.0",
            "layer_thickness; layer_poisson ne",
        ),
        ("layer_thickness = 5.0", "give layer_modulus"),
        (LAYER.replace("50.0", "1e6"), "layer_modulus is in GPa"),
        (f"{LAYER}\nlayer_poisson = 0.7", "poisson must be"),
        (f"{LAYER}\nrigid_base = true", "a rigid base has no contact_modulus"),
        (f"{LAYER}\nrigid_base = true\n{CONSTANTS}", "rigid base has no elastic_const"),
        (f"{LAYER}\nrigid_base = true\npoisson = 0.3", "a rigid base has no poisson"),
        ("anisotropic = true\nelastic_constants = [168e9, 121e9, 75e9]", "is in GPa"),
        ("elastic_constants = [168e9, 121e9, 75e9]", "elastic_constants is in GPa"),
        ('calculator = "emt"', "contact_modulus follows from the forces"),
        ('surface = "bcc100"', "surface needs one of calculator, potential, crystal, "),
        (f'{LAYER}\nsurface = "fcc100"', "surface needs one of calculator"),
    ],
)
def test_contradictions_are_errors(lines, message):
    modulus = "" if "elastic_constants = " in lines else "contact_modulus = 100.0"
    with pytest.raises(ValueError, match=message):
        scene(lines, modulus).check()


@pytest.mark.parametrize(
    "lines, message",
    [
        ('calculator = "dft"', "calculator"),
        ('calculator = "emt"\nsymbol = "Pb"', "EMT knows .* Al, .*Pt, got .*'Pb'"),
        ('potential = "missing.alloy"', "can't read .*missing.alloy"),
        ('potential = "."', "can't read .*directory"),
        ('crystal = "."', "can't read .*directory"),
        ('potential = "Cu.eam.fs"', "in the format eam/fs: .*from the end of the name"),
        ('potential = "Cu.eam"', "in the format eam: "),
        ('potential = "Cu.adp"', "in the format eam/alloy: .*written with Python"),
        ('calculator = "emt"\nsurface = "bcc100"', "Cu is fcc, .*surface='fcc100'"),
        ('anisotropic = true\nsurface = "fcc111"', "surface"),
        ('crystal = "small_scene.py"', "is not a crystal"),
        ('symbol = "Ag"\ncrystal = "springs.json"', "of Cu, not of symbol = 'Ag'"),
        ('crystal = "springs.json"\nspacing = 2.0', "spacing of 2.545584"),
        ('crystal = "springs.json"\nsurface = "bcc100"', "fcc100, not .* 'bcc100'"),
    ],
)
def test_unsuitable_files_are_errors(lines, message, crystal_file):
    folder = crystal_file.parent
    for name in ("small_scene.py", "Cu.eam.fs", "Cu.eam", "Cu.adp"):
        (folder / name).write_text(SMALL)
    text = SMALL.replace("contact_modulus = 100.0", lines)
    with pytest.raises(ValueError, match=message):
        Scene.parse(text, str(folder / "my.toml")).check()


@pytest.mark.slow
def test_calculators_by_name(tmp_path):
    made = scene('calculator = "emt"', "")
    assert made.spacing * np.sqrt(2) == pytest.approx(3.5898, abs=1e-4)
    assert made.contact_modulus / GPa == pytest.approx(152.99, rel=1e-3)
    assert list(made.run(tmp_path))[-1].converged


@pytest.mark.slow
def test_formats_of_potentials_of_embedded_atoms(tmp_path):
    alloy, fs = tmp_path / "Cu.eam.alloy", tmp_path / "Cu.eam.fs"
    write_sutton_chen(alloy, cutoff=4.5)
    source, parameters, embedding, density, pair = read_eam(alloy)
    write_eam(source, parameters, embedding, density[:, None], pair, fs, "eam/fs")
    first, second = (scene(f'potential = "{file}"', "").solid for file in (alloy, fs))
    assert 3.5 < first.spacing * np.sqrt(2) < 3.7
    assert 40 < first.contact_modulus / GPa < 200
    assert max(first.figures.values()) < 1e-4
    assert second.spacing == pytest.approx(first.spacing, rel=1e-5)
    assert second.contact_modulus == pytest.approx(first.contact_modulus, rel=1e-4)


def write_sutton_chen(file, cutoff=5.0):
    """Write the potential of A. P. Sutton, J. Chen, Philos. Mag. Lett. 61, 139 (1990).

    The functions for copper fall smoothly to zero between 80 % of the cutoff and it.
    """
    energy, a, c, n, m = 1.2382e-2, 3.61, 39.432, 9, 6

    def power(exponent):
        def values(r):
            x = np.clip((cutoff - np.asarray(r)) / (0.2 * cutoff), 0.0, 1.0)
            return (
                (a / np.maximum(r, 0.5)) ** exponent * x**3 * (10 - 15 * x + 6 * x**2)
            )

        return values

    pair = power(n)
    potential = EAM(
        elements=["Cu"],
        embedded_energy=np.array([lambda rho: -energy * c * np.sqrt(rho)]),
        electron_density=np.array([power(m)]),
        phi=np.array([[lambda r: energy * pair(r)]]),
        d_embedded_energy=np.array([None]),
        d_electron_density=np.array([None]),
        d_phi=np.array([[None]]),
        cutoff=cutoff,
        form="alloy",
        Z=[29],
        nr=4000,
        nrho=4000,
        dr=cutoff / 3999,
        drho=0.1,
        lattice=["fcc"],
        mass=[63.546],
        a=[a],
    )
    potential.Nelements = 1
    potential.write_potential(str(file), numformat="%.14e")
