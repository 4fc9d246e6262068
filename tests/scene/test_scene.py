"""Scenes and scene files."""

import pickle
from unittest.mock import patch

import numpy as np
import pytest
from ase.optimize import LBFGS
from small_scene import SMALL

from ase_roughcontact import NewtonKrylov
from ase_roughcontact.interactions import wall_parameters
from ase_roughcontact.scene import OPTIMIZERS, Scene, Steps, default_text, on_modes
from ase_roughcontact.scene.config import SubstrateConfig
from ase_roughcontact.scene.file import SECTIONS


def test_built_in_scene_is_the_paper_s_roughness_over_four_decades_of_load():
    scene = Scene.default()
    rough = scene.roughness
    assert scene.shape is None and scene.sphere.radius == "2500 a0"
    assert (rough.short_wavelength, rough.long_wavelength) == ("4 a0", "512 a0")
    assert len(scene.targets) >= 10
    assert scene.targets[-1] / scene.targets[0] == pytest.approx(1e4)


def test_the_built_in_scene_explains_every_key():
    text = default_text()
    for title, section in SECTIONS.items():
        keys = dict.fromkeys(section().entries())
        if title == "interaction":
            keys |= dict.fromkeys(wall_parameters())
        assert f"[{title}]" in text
        assert [key for key in keys if f"{key} = " not in text] == []


def test_adhesion_increases_the_predicted_area_unless_flats_adhere():
    def predicted(work):
        interaction = f'[interaction]\nkind = "adhesive"\nwork_of_adhesion = {work}\n'
        return Scene.parse(SMALL + interaction).bodies.predicted_area(1.0)

    assert predicted(0.05) > Scene.parse(SMALL).bodies.predicted_area(1.0)
    assert np.isnan(predicted(9.5))


def test_run_writes_the_scene_with_or_without_the_text_of_its_file(tmp_path):
    scene, file = Scene.parse(SMALL), tmp_path / "scene.toml"
    next(scene.run(tmp_path))
    assert Scene.read(file) == scene
    next(scene.run(tmp_path, text=SMALL))
    assert file.read_text() == SMALL


@pytest.mark.parametrize(
    "scene",
    [
        Scene.default(),
        Scene.parse('interaction = { kind = "adhesive", work_of_adhesion = 1e-5 }'),
        Scene(path=Steps(loads=(np.float64(1.5), np.int64(2)))),
        Scene(substrate=SubstrateConfig(model='"Å"\n')),
    ],
    ids=range(4),
)
def test_the_text_of_a_scene_is_that_scene(scene):
    assert Scene.parse(scene.toml) == scene


def test_the_error_of_a_changed_scene_lists_the_changes(tmp_path):
    next(Scene.parse(SMALL).run(tmp_path))
    path = "first = 0.2\nlast = 0.6\nsteps = 2"
    changed = SMALL.replace("60.0", "61.0").replace(path, "values = [0.3]")
    changed = changed.replace('[roughness]\nunit = "a0"\nlong_wavelength = 16.0\n', "")
    with pytest.raises(ValueError, match="another scene") as error:
        next(Scene.parse(changed).run(tmp_path))
    text = str(error.value)
    assert "[sphere] radius was 60.0, is 61.0" in text
    assert "[path] penetrations was {" in text
    assert "[roughness] long_wavelength was 16.0, is not given" in text
    assert "append to its lists" in text
    assert "profile" not in text and "was not given, is not given" not in text
    (tmp_path / "scene.toml").unlink()
    with pytest.raises(ValueError, match="can't resume"):
        next(Scene.parse(changed).run(tmp_path))


@pytest.mark.parametrize("name", ["curve.csv", "scene.toml"])
def test_a_run_does_not_replace_files_that_are_not_of_a_run(tmp_path, name):
    file = tmp_path / name
    file.write_text("distance (nm),force (nN)\n")
    with pytest.raises(ValueError, match=f"{name} .*another folder"):
        next(Scene.default().run(tmp_path))
    assert file.read_text() == "distance (nm),force (nN)\n"


def test_an_extended_path_resumes_in_the_same_folder(tmp_path):
    short = list(Scene.parse(SMALL).run(tmp_path))
    path = "first = 0.2\nlast = 0.6\nsteps = 2", "values = [0.2, 0.6, 0.5]"
    records = list(Scene.parse(SMALL.replace(*path)).run(tmp_path))
    assert records[:2] == short
    assert len(records) == 3 and records[2].converged


HUGE = "9" * 400  # beyond all floats


@pytest.mark.parametrize(
    "section, line, message",
    [
        ("spere", "radius = 3", r"unknown section 'spere'; .*'sphere'"),
        ("wall", "radius = 3", r"unknown section 'wall': give \[interaction\]"),
        ("substrate", "symbl = 'Cu'", "unknown key 'symbl'"),
        ("substrate", "shape = 32", "shape must be"),
        ("substrate", 'periodic = "false"', "periodic must be true or false"),
        ("substrate", "contact_modulus = nan", "contact_modulus must be .*, got nan"),
        ("substrate", "elastic_constants = [1.0, 2.0, 3.0]", "elastic_constants must"),
        ("substrate", f"elastic_constants = [{HUGE}, 1, 1]", "elastic_constants must"),
        (
            "substrate",
            "contact_modulus = 9\nhardness = 5e3",
            "hardness is in GPa, at most 1000, got 5000",
        ),
        ("substrate", "spacing = -2.5", "spacing must be .* number > 0, got -2.5"),
        ("substrate", 'symbol = "Sj"', "unknown material 'Sj'; "),
        ("substrate", "periodic = true", r"shape = .auto. .*give .*\[n, m\]"),
        ("sphere", "radius = 9", 'needs a unit: give "9 nm", or "9 a0" .*, or unit'),
        ("sphere", 'radius = "-1 nm"', "radius must be a finite .*, got '-1 nm'"),
        ("sphere", 'radius = "2 Å"', r"a0 = 2.553 Å, got '2 Å', 0.783 a0"),
        ("sphere", 'profile = "cone"', "profile must be 'paraboloid' or 'sphere'"),
        ("roughness", "rms_slope = 0", "rms_slope must be a finite number > 0"),
        (
            "roughness",
            "short_wavelength = '1 a0'",
            "must be at least 2 a0, .* got 1 a0",
        ),
        (
            "roughness",
            "domain = '2048.5 a0'",
            'multiple of the spacing, 1 a0, .*: give "2049 a0',
        ),
        ("interaction", 'kind = "sof"\nrange = 1', "unknown kind of interaction 'sof'"),
        ("interaction", 'kind = "JKR"', "interaction 'JKR': give \"adhesive\" with"),
        ("tip", 'radius = "9 nm"', r"unknown key 'radius': give it in \[sphere\]"),
        ("indenter", 'radius = "9 nm"', "give tip_radius, .* is the section .sphere"),
        ("interaction", 'kind = "full"', "kind = 'full' needs work_of_adhesion"),
        (
            "interaction",
            "cutoff = '3 a0'\nexponent = 2",
            "has no cutoff, .* no exponent",
        ),
        ("path", "values = [true]", "loads must be a list of numbers or a range, got"),
        ("path", "loads = []", "give loads, penetrations or heights"),
        ("path", f"loads = [{HUGE}]", "loads must be"),
        ("path", "loads = [1.0]\nheights = [1.0]", "loads or heights, not both"),
        ("path", 'control = "height"\nloads = [1.0]', "give loads without control"),
        ("path", "loads = { first = 1, lst = 2 }", "unknown key of the range .*'lst'"),
        ("path", 'control = "lod"\nvalues = [1.0]', "unknown control 'lod'; .*'load'"),
        ("path", "first = 1.0", "give last, steps for the range of loads, or a list"),
        ("path", 'control = "displacement"', "control 'displacement': give penetrat"),
        ("path", 'first = 1\nlast = 2\nsteps = 2\nscale = "log"', 'give "geometric"'),
        ("path", "first = inf\nlast = 1\nsteps = 2", "first must be a finite number"),
        ("path", "first = 1\nlast = 2\nsteps = 0", "steps must be an integer >= 1"),
        ("path", "first = 1\nlast = 2\nsteps = 10000000", "steps must be at most 1000"),
        ("path", "first = -1\nlast = 2\nsteps = 2", "first and last .* got -1 and 2"),
        ("solver", "accuracy = 2.0", "accuracy must be a relative error from"),
        ("solver", 'accuracy = "exact"', "unknown accuracy 'exact'"),
        ("solver", "fmax = -1.0", "fmax must be a finite number > 0, got -1.0"),
        ("solver", "max_steps = 0", "max_steps must be an integer >= 1, got 0"),
        ("solver", 'engine = "pyfft"', "unknown engine 'pyfft'; .*'pyfftw'"),
        ("solver", 'optimizer = "LFBGS"', "unknown optimizer 'LFBGS'; .*'LBFGS'"),
    ],
)
def test_errors_name_file_section_and_key(section, line, message, tmp_path):
    file = tmp_path / "my.toml"
    path = "" if section == "path" else "[path]\nvalues = [1.0]\n"
    solid = "" if section == "substrate" else '[substrate]\nmaterial = "Cu"\n'
    file.write_text(f"{solid}[{section}]\n{line}\n{path}")
    title = "" if section in ("spere", "wall") else rf"\[{section}\] "
    with pytest.raises(ValueError, match=rf"my\.toml: {title}.*{message}"):
        Scene.read(file)


@pytest.mark.parametrize(
    "text", ["[path", "seed = " + "9" * 5000, "values = " + "[" * 5000], ids=range(3)
)
def test_text_that_is_not_toml_is_an_error(text):
    with pytest.raises(ValueError, match="not a TOML file"):
        Scene.parse(text)


def test_a_quantity_without_quotes_is_an_error_that_shows_them():
    with pytest.raises(ValueError, match=r'need quotes, as radius = "30 nm"$'):
        Scene.parse("[sphere]\nradius = 30 nm\n")


def test_a_file_that_can_not_be_read_is_an_error(tmp_path):
    with pytest.raises(ValueError, match=r"can't read the scene .*absent\.toml"):
        Scene.read(tmp_path / "absent.toml")
    np.save(tmp_path / "scan.npy", np.arange(6.0))
    with pytest.raises(ValueError, match=r"scan\.npy is not a TOML file"):
        Scene.read(tmp_path / "scan.npy")


@pytest.mark.parametrize(
    "text, parts",
    [
        (
            """
            substrate = { modulus = 3, contact_modulus = "3 nm" }
            path = { kind = "loop", depest = 1.0, first = 2.0, last = 3.0 }
            """,
            ["'modulus'", "[path] first, last need", "'depest'; did you mean"],
        ),
        (
            'substrate = { symbol = "W", shape = [0, 1] }',
            [
                "the (100) surface of W",
                "give spacing; ",
                "Ag, Al, Au, Cu, Ge, Ni, Si",
                "; [substrate] shape must be",
            ],
        ),
        (
            'substrate = { material = "Cu" }\nfriction = { coefficient = 0.3 }\n'
            "path = { values = [1.0] }",
            ["sliding", "or omit [friction]"],
        ),
        (
            """
            substrate = { material = "Sj", hardness = "3 GPA" }
            sphere = { radius = "3 inch" }
            roughness = { rms_height = 1, rms_slop = 0.1 }
            """,
            [
                "'GPA'",
                "unknown material 'Sj'",
                "unknown unit of radius 'inch'",
                "'rms_slop'; did you mean",
            ],
        ),
        (
            """
            substrate = { periodic = false }
            path = { loads = [1.0], heights = [1.0] }
            solver = { fmax = -1.0, max_steps = 0, optimizer = "LFBGS" }
            output = { keep = "some" }
            """,
            [
                "[substrate] the elastic solid is not given",
                "loads or heights, not both",
                "fmax must be",
                "max_steps must be",
                "'LFBGS'; did you mean",
                "keep must be",
            ],
        ),
    ],
    ids=["types", "values", "path", "units", "sections"],
)
def test_independent_errors_are_reported_at_once(text, parts):
    with pytest.raises(ValueError, match=r"scene: \[(substrate|friction)\]") as error:
        Scene.parse(text).check()
    assert [part for part in parts if part not in str(error.value)] == []


@pytest.mark.parametrize("longest, side", [("39.7", 160.0), ("39.75", 159.0)])
def test_the_default_domain_is_a_number_of_spacings_suited_to_ffts(longest, side):
    scene = Scene.parse(SMALL.replace("16.0", longest))
    assert scene.rough.side / scene.spacing == pytest.approx(side, rel=1e-14)


def test_a_roughness_that_needs_too_much_memory_is_an_error():
    scene = Scene.parse(
        'substrate = { material = "Cu" }\n'
        'roughness = { long_wavelength = "1e6 a0" }\npath = { values = [1.0] }'
    )
    message = r"large: \[roughness\] .* domain of 4000000 x 4000000 .* smaller domain"
    with pytest.raises(MemoryError, match=message):
        scene.check("large")


def test_words_for_the_accuracy_are_one_number_for_atoms():
    scene = Scene.parse(SMALL.replace("fmax = 1e-4", 'accuracy = "high"'))
    assert (scene.grid_model.error, scene.fmax) == (1e-4, None)


def test_relax_can_begin_in_the_middle_of_the_path():
    scene = Scene.parse(SMALL)
    whole = list(scene.relax())
    assert next(scene.relax(scene.targets[1:])).height == whole[1].height


def test_a_scene_is_sent_to_processes_without_what_was_built():
    scene = Scene.parse(SMALL)
    short = pickle.dumps(scene)
    scene.check()
    assert pickle.dumps(scene) == short and pickle.loads(short) == scene


class FewSteps(NewtonKrylov):
    """Newton-Krylov solver that takes one step at most."""

    def run(self, fmax=0.05, steps=1):
        return super().run(fmax, min(steps, 1))


@pytest.mark.parametrize(
    "optimizer, converged",
    [(on_modes(LBFGS, alpha=1.0, memory=5), True), (FewSteps, False)],
)
def test_a_scene_file_names_an_optimizer_after_one_entry(optimizer, converged):
    text = SMALL.replace("LBFGS", "mine").replace("[32, 30]", "[22, 20]")
    with patch.dict(OPTIMIZERS, mine=optimizer):
        steps = list(Scene.parse(text.replace("0.6", "0.3")).relax())
    assert {step.converged for step in steps} == {converged}
