"""Preview of a scene on a coarser grid, with its error."""

import numpy as np
import pytest

from ase_roughcontact.cli import main
from ase_roughcontact.scene import InteractionConfig, Scene
from ase_roughcontact.scene.preview import preview

TEXT = """
[substrate]
spacing = 2.0
contact_modulus = 100.0
hardness = inf
{substrate}
[sphere]
unit = "a0"
radius = 300.0
[roughness]
unit = "a0"
long_wavelength = 32.0
[path]
{path}
"""


MANY = f"values = {[float(n) for n in range(1, 11)]}"


def scene(substrate="", path="first = 10.0\nlast = 200.0\nsteps = 12"):
    if "model" not in substrate:
        substrate = f'model = "atoms"\n{substrate}'
    return Scene.parse(TEXT.format(substrate=substrate, path=path))


@pytest.mark.parametrize("seed", [1, 2])
def test_preview_has_three_areas_within_twice_its_error(seed):
    full = scene().with_values({"roughness.seed": seed, "path.steps": 32})
    coarse = preview(full)
    assert coarse.grid_change.label == "4 a0"
    np.testing.assert_allclose(coarse.targets, full.targets[[10, 21, 31]])
    exact = list(full.relax(full.targets[[10, 21, 31]]))
    for step, truth in zip(coarse.relax(validity="ignore"), exact, strict=True):
        error = abs(step.continuum_area - truth.contact_area)
        assert error < 2.0 * step.area_error


@pytest.mark.parametrize(
    "substrate, path, spacing, steps",
    [
        ('model = "continuum"', MANY, "2 a0", [4.0, 7.0, 10.0]),
        ("shape = [62, 62]", MANY, "2 a0", [4.0, 7.0, 10.0]),
        ("shape = [61, 61]", MANY, "a0", [10.0]),
        ("", MANY, "4 a0", [4.0, 7.0, 10.0]),
        ("", "values = [5e4]", "4 a0", [5e4]),
    ],
)
def test_grid_and_steps_fit_the_scene(substrate, path, spacing, steps):
    coarse = preview(scene(substrate, path))
    coarse.check()
    assert coarse.grid_change.label == spacing
    assert list(coarse.path.values) == steps


def test_grid_loses_at_most_half_the_slope():
    short = {"roughness.hurst": 0.1, "roughness.long_wavelength": 16.0}
    coarse = preview(scene().with_values(short))
    assert coarse.grid_change.label == "2 a0"
    coarser = coarse.with_values({"substrate.coarsen": 4, "substrate.refine": None})
    assert coarse.lost_slope < 0.5 < coarser.lost_slope < 0.6


ADHESIVE = {"interaction.kind": "adhesive", "interaction.work_of_adhesion": 5.0}


@pytest.mark.parametrize(
    "values", [{}, {"substrate.shape": (64, 64)}, ADHESIVE], ids=range(3)
)
def test_run_of_few_small_steps_is_its_own_preview(values):
    short = scene(path=MANY.replace(", 10.0", "")).with_values(values)
    assert preview(short) is short
    coarse = preview(scene(path=MANY).with_values(values))
    assert len(coarse.targets) < 4


@pytest.mark.parametrize(
    "values",
    [
        {"path.values": (5e4,)},
        {"substrate.shape": (320, 320), "roughness.domain": "512 a0"},
        # JKR's contact is large under any load
        {**ADHESIVE, "sphere.radius": "2e4 a0", "roughness": None},
    ],
    ids=range(3),
)
def test_few_steps_in_large_windows_have_a_preview(values):
    large = scene(path="values = [5.0]").with_values(values)
    assert preview(large).grid_change.label == "4 a0"


def test_tolerance_of_forces_is_not_kept():
    tight = scene().with_values({"solver.fmax": 1e-9})
    assert preview(tight).solver.fmax is None


def test_built_in_scene_is_planned_in_a_fifth_of_its_time():
    full = Scene.default()
    assert preview(full).plan().seconds < 0.2 * full.plan().seconds


@pytest.mark.parametrize("radius, spacing", [(100.0, "a0"), (20_000.0, "4 a0")])
def test_preview_of_a_loop_is_its_deepest_state(radius, spacing):
    text = 'substrate = { material = "Cu" }\npath = { kind = "loop", deepest = 2.0 }'
    loop = Scene.parse(text).with_values(ADHESIVE)
    weak = {"interaction.work_of_adhesion": 0.1, "sphere.radius": f"{radius} a0"}
    shown = preview(loop.with_values(weak))
    assert list(shown.targets) == [2.0] and shown.path.control == "penetration"
    assert shown.grid_change.label == spacing


def test_crystal_becomes_an_isotropic_solid_of_its_modulus(crystal, tmp_path):
    crystal.write(tmp_path / "springs.json")
    file = tmp_path / "springs.json"
    coarse = preview(
        Scene.parse(f'[substrate]\ncrystal = "{file}"\n[path]\nvalues = [1.0]')
    )
    coarse.check()
    assert coarse.is_continuum and not coarse.substrate.of_atoms
    assert coarse.contact_modulus == pytest.approx(crystal.contact_modulus)
    assert coarse.spacing == pytest.approx(crystal.spacing)


@pytest.fixture
def run_preview(tmp_path, capsys):
    """Function that previews a scene by the command: output, and folder of results."""

    def command(scene):
        file, out = tmp_path / "my.toml", tmp_path / "out"
        file.write_text(scene.toml)
        assert main(["run", str(file), "--out", str(out), "--preview"]) == 0
        assert not out.exists()
        return capsys.readouterr().out, tmp_path / "out-preview"

    return command


def test_command_writes_a_preview_beside_the_run(run_preview):
    text, folder = run_preview(scene())
    assert "grid of spacing 4 a0 =" in text and "% of the rms slope" in text
    assert "errors of areas " in text and "estimated" in text
    assert Scene.read(folder / "scene.toml") == preview(scene())
    assert len((folder / "curve.csv").read_text().splitlines()) == 4


def test_command_calculates_a_short_run_itself(run_preview):
    text, folder = run_preview(scene(path="values = [5.0]"))
    assert text.startswith("The run is as short as a preview")
    assert Scene.read(folder / "scene.toml") == scene(path="values = [5.0]")


def test_preview_of_a_wall_with_a_history_turns_where_its_path_does():
    plastic = InteractionConfig.of(
        {"kind": "plastic", "permanent": True, "hardness": 1}
    )
    path = f"values = {[10.0 * n for n in (*range(1, 17), *range(15, 0, -1), 2)]}"
    full = scene(path=path).with_values({"interaction": plastic})
    assert {160.0, 10.0} <= set(preview(full).path.values)
