"""Every example of the gallery, run at a small size: its result and its picture."""

import re
from pathlib import Path

import numpy as np
import pytest

from ase_roughcontact import ActiveSet, NewtonKrylov

EXAMPLES = Path(__file__).resolve().parents[1] / "examples"
GALLERY = EXAMPLES / "gallery"
# Constants at the head of each example, made smaller.
SMALL = {
    "first_contact": {"SIZE": 24},
    "hertz_optimizers": {"SIZE": 12},
    "load_sweep": {"RADIUS": 100.0},
    "cantilever": {"STEPS": 25},
    "pull_off_rates": {"RATES": (10.0,)},
    "creep_under_load": {"DWELL": 4.0},
    "friction_loop": {"STEPS": 4},
    "static_friction": {"LOAD": 0.5, "HOLDS": [100.0, 1000.0], "RATES": [1.0, 9.0]},
    "lateral_stiffness": {
        "LOADS": (1e-6, 10.0),
        "SLAB": {"layers": 9, "size": 3, "tolerance": 1.0},
    },
    "measured_topography": {"PLACES": 2},
    "adhesion_loop": {"RADIUS": 30.0, "STIFFNESSES": (1.0,)},
    "adhesion_hysteresis": {"DEEPEST": -0.7},
    "ensemble_database": {"SEEDS": 2, "LOADS": (1.0, 3.0), "WORKERS": 1},
    "crystals": {
        "METALS": ("Cu",),
        "SLAB": {"layers": 9, "size": 3, "tolerance": 1.0},
    },
    "atoms_under_sphere": {
        "SIZE, LAYERS": (5, 4),
        "DEPTHS": (0.1,),
        "SLAB": {"layers": 9, "size": 5, "tolerance": 1.0},
    },
    "own_wall": {},
    "plastic_contact": {"LOADS": (2.0, 10.0)},
    "mixed_calculator": {"SIZE": 6},
}


@pytest.fixture
def run(tmp_path, monkeypatch, capsys):
    """Variables of an example after it has run, and what it printed."""
    pyplot = pytest.importorskip("matplotlib.pyplot")
    pyplot.switch_backend("Agg")

    def ran(name):
        monkeypatch.chdir(tmp_path)
        script = (GALLERY / f"{name}.py").read_text()
        for constant, value in SMALL[name].items():
            line = f"{constant} = {value!r}"
            script, times = re.subn(rf"(?m)^{constant} = .*$", line, script)
            assert times == 1, f"{name}.py must set {constant} once"
        variables = {"__name__": "__main__"}
        exec(compile(script, f"{name}.py", "exec"), variables)
        assert (tmp_path / f"{name}.png").stat().st_size > 5000
        return variables, capsys.readouterr().out

    yield ran
    pyplot.close("all")


@pytest.mark.parametrize(
    "name, tolerance",
    [
        ("first_contact", 0.01),
        ("cantilever", 0.03),
        ("creep_under_load", 0.04),
        ("measured_topography", 0.02),
        ("crystals", 0.5),
        ("own_wall", 5e-4),
    ],
)
def test_printed_error_is_small(run, name, tolerance):
    variables, text = run(name)
    assert abs(variables["error"]) < tolerance
    printed = float(re.findall(r"(-?\d+\.\d+) %", text)[-1])
    assert printed / 100 == pytest.approx(variables["error"], abs=5e-4)


def test_five_optimizers_find_the_force_of_hertz(run):
    errors = run("hertz_optimizers")[0]["errors"]
    assert len(errors) == 5
    assert max(map(abs, errors.values())) < 0.02


def test_adhesion_loop_has_the_pull_off_force_of_maugis_and_dugdale(run):
    variables, text = run("adhesion_loop")
    force, theory = map(float, text.splitlines()[-1].split()[1:3])
    assert force == pytest.approx(theory, rel=0.02)
    (loop,) = variables["loops"].values()
    assert loop.pull_off_force == pytest.approx(force * np.pi * 0.02 * 30, rel=1e-3)


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore:the pull-off force")
def test_hysteresis_of_patches_and_roughness(run):
    lost = run("adhesion_hysteresis")[0]["lost"]
    assert abs(lost["smooth and uniform"]) < 0.02
    assert lost["patches of adhesion"] > 0.05  # less than after a deep indentation
    assert lost["random roughness"] > 0.2


def test_load_sweep_and_ensemble_write_files_with_columns(run, tmp_path):
    variables, text = run("load_sweep")
    assert 0.5 < variables["ratio"] < 2.0
    assert f"{variables['ratio']:.3f} of Eq. (4)" in text
    assert (tmp_path / "sweep.traj").exists()
    assert "pressure:R:1" in (tmp_path / "sweep.extxyz").read_text()
    variables, text = run("ensemble_database")
    assert 0.3 < variables["ratio"] < 10.0
    assert "of 4 steps" in text and (tmp_path / "spheres.db").exists()


@pytest.mark.parametrize(
    "name, optimizer",
    [("first_contact", ActiveSet), ("measured_topography", NewtonKrylov)],
)
def test_example_raises_if_a_contact_does_not_converge(
    run, monkeypatch, name, optimizer
):
    monkeypatch.setattr(optimizer, "run", lambda *_, **__: False)
    with pytest.raises(RuntimeError, match="not converge"):
        run(name)


def test_plastic_contact_bears_the_hardness(run):
    variables, text = run("plastic_contact")
    assert 1.0 < variables["ratio"] < 1.3
    assert f"over N/H: {variables['ratio']:.3f}" in text
    assert (variables["areas"][2:] > 0).any() and variables["areas"][-1] == 0


def test_atoms_under_a_sphere_begin_as_an_elastic_half_crystal(run):
    variables, text = run("atoms_under_sphere")
    assert variables["forces"][1] == pytest.approx(variables["expected"][1], rel=0.05)
    assert f"{variables['forces'][1]:.2f} eV/Å" in text
    assert not variables["change"].any()


def test_a_fast_pull_off_and_springs_of_a_mixed_calculator(run):
    # several times the force of the elastic solid; the state with constraints
    assert 3.0 < run("pull_off_rates")[0]["effective"][0] < 4.5
    assert run("mixed_calculator")[0]["error"] < 1e-5


def test_index_lists_every_example_with_its_picture():
    index = (EXAMPLES / "README.md").read_text()
    assert {path.stem for path in GALLERY.glob("*.py")} == set(SMALL)
    for name in SMALL:
        assert f"[`{name}.py`](gallery/{name}.py)" in index
        assert f"images/{name}.png" in index
    for target in re.findall(r'(?:\]\(|src=")([^)":]+)[)"]', index):
        assert (EXAMPLES / target).exists(), target


@pytest.mark.slow
def test_static_friction_has_the_effects_of_rate_and_state(run):
    found = re.findall(r"by ([\d.]+) ln t .*, ([\d.]+) ln V", run("static_friction")[1])
    assert len(found) == 2
    for by_time, by_rate in found:
        assert float(by_time) == pytest.approx(0.015, rel=0.05)
        assert float(by_rate) == pytest.approx(0.01, rel=0.15)


@pytest.mark.parametrize("name", SMALL)
def test_examples_and_their_pictures_are_small(name):
    lines = (GALLERY / f"{name}.py").read_text().splitlines()
    code = [line for line in lines if line.strip() and not line.startswith("#")]
    assert len(code) <= 65
    assert (EXAMPLES / "images" / f"{name}.png").stat().st_size < 150_000


def test_lateral_stiffness_and_stick_area_agree_with_mindlin(run):
    ratios = run("lateral_stiffness")[0]["results"]
    for name in ("smooth, isotropic", "rough, isotropic"):
        assert ratios[name][0] == pytest.approx(1.4 / 1.7, rel=0.03)
    errors = re.findall(r"stick area to ([\d.]+)", run("friction_loop")[1])
    assert float(errors[0]) < 0.05 and len(errors) == 2
