"""Scenes: what a TOML file says, and what it may not say."""

import numpy as np
import pytest
from ase.units import GPa, J, m
from small_scene import SMALL

from ase_roughcontact.atoms.substrate import fcc_spacing
from ase_roughcontact.interactions import (
    HardWall,
    LennardJones93,
    wall_parameters,
)
from ase_roughcontact.paths.accuracy import LEVELS
from ase_roughcontact.scene import NANONEWTON, PathConfig, Scene, default_text
from ase_roughcontact.scene.config import SECTIONS
from ase_roughcontact.topography import RoughSphere, SelfAffine


def test_lengths_of_the_indenter_are_in_units_of_the_spacing():
    scene = Scene.parse(SMALL)
    a0 = fcc_spacing("Cu")
    rough = SelfAffine(0.1, 0.8, 4 * a0, 16 * a0)
    assert scene.surface == RoughSphere(60 * a0, rough)


def test_moduli_are_in_gigapascal_and_works_of_adhesion_in_joule_per_square_metre():
    text = SMALL + '[interaction]\nkind = "adhesive"\nwork_of_adhesion = 0.05\n'
    scene = Scene.parse(text)
    modulus = 100 * GPa
    assert scene.contact_modulus == modulus
    assert scene.wall == LennardJones93.adhesive(
        modulus, scene.spacing, 0.05 * J / m**2
    )


@pytest.mark.parametrize(
    "kind, wall",
    [
        ("hard", lambda e, a: HardWall()),
        ("repulsive", LennardJones93.repulsive),
        ("full", lambda e, a: LennardJones93.full(a, 0.1 * J / m**2)),
    ],
)
def test_every_kind_of_wall_can_be_named(kind, wall):
    work = "work_of_adhesion = 0.1\n" if kind == "full" else ""
    scene = Scene.parse(SMALL + f'[interaction]\nkind = "{kind}"\n{work}')
    assert scene.wall == wall(scene.contact_modulus, scene.spacing)


def test_the_attraction_of_a_full_wall_decays_over_the_distance_of_its_minimum():
    def scene(kind):
        adhesive = f'[interaction]\nkind = "{kind}"\nwork_of_adhesion = 0.1\n'
        return Scene.parse(SMALL + adhesive)

    assert scene("full").wall.attraction_range == scene("full").spacing
    wall = scene("adhesive").wall
    assert wall.attraction_range == wall.cutoff - wall.distance
    assert Scene.parse(SMALL).wall.attraction_range == 0.0


def test_loads_are_in_nanonewton():
    text = SMALL.replace('"penetration"', '"load"').replace('"linear"', '"geometric"')
    np.testing.assert_allclose(
        Scene.parse(text).steps, np.array([0.2, 0.6]) * NANONEWTON, rtol=1e-14
    )
    assert pytest.approx(0.6241509, rel=1e-6) == NANONEWTON  # eV/Å


def test_values_can_be_listed():
    text = SMALL.replace("first = 0.2\nlast = 0.6\nsteps = 2", "values = [0.1, 0.3]")
    np.testing.assert_array_equal(Scene.parse(text).steps, [0.1, 0.3])


def test_built_in_scene_is_the_paper_s_roughness_over_four_decades_of_load():
    scene = Scene.default()
    assert scene.shape is None
    assert scene.sphere.radius == 1000.0
    assert (scene.roughness.short_wavelength, scene.roughness.long_wavelength) == (
        4.0,
        512.0,
    )
    assert len(scene.steps) >= 10
    assert scene.steps[-1] / scene.steps[0] == pytest.approx(1e4)


def test_every_key_of_the_format_stands_in_the_built_in_scene():
    text = default_text()
    for title, section in SECTIONS.items():
        assert f"[{title}]" in text
        keys = section().entries() | dict.fromkeys(wall_parameters())
        wanted = keys if title == "interaction" else section().entries()
        assert [key for key in wanted if f"{key} = " not in text] == []


def test_adhesion_changes_the_prediction_until_it_makes_the_surfaces_stick():
    def predicted(work):
        interaction = f'[interaction]\nkind = "adhesive"\nwork_of_adhesion = {work}\n'
        return Scene.parse(SMALL + interaction).predicted_area(1.0)

    assert predicted(0.05) > Scene.parse(SMALL).predicted_area(1.0)
    assert np.isnan(predicted(50.0))


def test_without_roughness_the_prediction_is_hertz():
    text = SMALL.replace("[roughness]\nlong_wavelength = 16.0\n", "")
    scene = Scene.parse(text)
    np.testing.assert_array_equal(scene.predicted_area(2.0), scene.hertz_area(2.0))


def test_run_writes_table_and_trajectory_and_goes_on_where_it_was(tmp_path):
    scene = Scene.parse(SMALL)
    first = next(scene.run(tmp_path))
    records = list(scene.run(tmp_path))
    assert records[0] == first
    assert [record.converged for record in records] == [True, True]
    assert len((tmp_path / "curve.csv").read_text().splitlines()) == 3


def test_a_folder_of_another_scene_is_refused(tmp_path):
    next(Scene.parse(SMALL).run(tmp_path))
    other = Scene.parse(SMALL.replace("radius = 60.0", "radius = 61.0"))
    with pytest.raises(ValueError, match="another path or system"):
        next(other.run(tmp_path))


def test_a_changed_scene_is_refused_with_what_differs(tmp_path):
    (tmp_path / "scene.toml").write_text(SMALL)
    next(Scene.parse(SMALL).run(tmp_path))
    path = "first = 0.2\nlast = 0.6\nsteps = 2"
    changed = SMALL.replace("60.0", "61.0").replace(path, "values = [0.3]")
    with pytest.raises(ValueError, match="contains a run of another scene") as told:
        next(Scene.parse(changed).run(tmp_path))
    assert "[sphere] radius was 60.0, is 61.0" in str(told.value)
    assert "[path] values was not given, is [0.3]" in str(told.value)
    assert "rms_slope" not in str(told.value)


def test_a_table_that_was_not_there_is_told(tmp_path):
    (tmp_path / "scene.toml").write_text(SMALL)
    next(Scene.parse(SMALL).run(tmp_path))
    smooth = SMALL.replace("[roughness]\nlong_wavelength = 16.0\n", "")
    with pytest.raises(ValueError, match=r"\[roughness\] was removed"):
        next(Scene.parse(smooth).run(tmp_path))


@pytest.mark.parametrize(
    "longer",
    [
        ("last = 0.6\nsteps = 2", "last = 1.0\nsteps = 3"),
        ("first = 0.2\nlast = 0.6\nsteps = 2", "values = [0.2, 0.6, 0.5]"),
    ],
    ids=["ends", "values"],
)
def test_a_path_that_was_made_longer_goes_on_in_the_same_folder(longer, tmp_path):
    (tmp_path / "scene.toml").write_text(SMALL)
    short = list(Scene.parse(SMALL).run(tmp_path))
    records = list(Scene.parse(SMALL.replace(*longer)).run(tmp_path))
    assert records[:2] == short
    assert len(records) == 3 and records[2].converged


@pytest.mark.parametrize(
    "text, message",
    [
        ("[spere]\nradius = 3", "unknown section 'spere'; .*'sphere'"),
        ("[substrate]\nsymbl = 'Cu'", r"\[substrate\] .*'symbl'; .*'symbol'"),
        ("[roughness]\nrms_slop = 1", "unknown key 'rms_slop'; .*'rms_slope'"),
        ("substrate = 3", r"\[substrate\] must be a section, got 3"),
        ("[path]\nvalues = ['1']", "values must be a list of numbers, got"),
        ("[path]\nvalues = [true]", "values must be a list of numbers, got"),
        ("[path", "not a TOML file"),
        pytest.param("seed = " + "9" * 5000, "not a TOML file", id="too long"),
        pytest.param("values = " + "[" * 5000, "not a TOML file", id="too deep"),
    ],
)
def test_what_is_not_in_the_format_is_named_with_the_nearest_right_word(text, message):
    with pytest.raises(ValueError, match=message):
        Scene.parse(text)


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("contact_modulus = 100.0", "contact_modulus = -1.0", "contact_modulus"),
        ("contact_modulus = 100.0", "contact_modulus = nan", "contact_modulus"),
        ("contact_modulus = 100.0", 'spacing = "wide"', "spacing"),
        ("contact_modulus = 100.0", 'symbol = "Fe"', "Fe is not fcc"),
        ("shape = [32, 30]", "shape = [12]", "shape"),
        ("radius = 60.0", "radius = 0.0", "radius"),
        ("long_wavelength = 16.0", "long_wavelength = 2.0", "wavelength"),
        ("long_wavelength = 16.0", 'long_wavelength = "x"', "long_wavelength"),
        ("long_wavelength = 16.0", "short_wavelength = 1.0", "short_wavelength"),
        ('control = "penetration"', 'control = "lod"', "'lod'; .*'load'"),
        ("steps = 2", "steps = 0", "steps"),
        (
            "shape = [32, 30]",
            "shape = 32",
            "shape must be a list of numbers or a string",
        ),
        ("shape = [32, 30]", 'periodic = "false"', "periodic must be true or false"),
        ("steps = 2", "steps = true", "steps must be a number"),
        ('control = "penetration"', "control = 1", "control must be a string"),
        ("first = 0.2\nlast = 0.6\nsteps = 2", "values = 0.3", "values must be a list"),
        ("first = 0.2", "", "first"),
        ("first = 0.2", "first = inf", "first"),
        ('scale = "linear"', 'scale = "log"', "scale"),
        ('scale = "linear"\n', "", "geometric|must"),
        ('"LBFGS"', '"LFBGS"', "'LFBGS'; .*'LBFGS'"),
        ("fmax = 1e-4", "fmax = 0.0", "fmax"),
        ("[solver]", '[interaction]\nkind = "soft"\n[solver]', "kind"),
        ("[solver]", '[interaction]\nkind = "adhesive"\n[solver]', "work_of_adhesion"),
        ("[solver]", "[interaction]\nwork_of_adhesion = 1.0\n[solver]", "no work_of"),
    ],
)
def test_wrong_values_are_refused_by_name(old, new, message, tmp_path):
    text = SMALL.replace(old, new)
    if message.startswith("geometric"):
        text = text.replace("first = 0.2", "first = -0.2")
    with pytest.raises(ValueError, match=message):
        list(Scene.parse(text).run(tmp_path))


@pytest.mark.parametrize(
    "table, line, told",
    [
        (
            "substrate",
            "spacing = -2.5",
            "spacing must be a finite number > 0, got -2.5",
        ),
        ("substrate", 'symbol = "Fe"', "symbol = 'Fe': give spacing"),
        ("substrate", "contact_modulus = 0", "contact_modulus must be .* > 0, got 0"),
        ("substrate", "elastic_constants = [1.0, 2.0, 3.0]", "elastic_constants must"),
        ("substrate", "shape = [0, 4]", "shape must be two whole numbers >= 1"),
        ("substrate", "periodic = true", "shape = .auto. needs a free half space"),
        ("sphere", "radius = -1", "radius must be a finite number > 0, got -1"),
        ("sphere", 'profile = "cone"', "profile must be 'paraboloid' or 'sphere'"),
        ("roughness", "rms_slope = 0", "rms_slope must be a finite number > 0"),
        ("roughness", "hurst = 1.5", "hurst must lie between 0 and 1, got 1.5"),
        (
            "roughness",
            "short_wavelength = 600",
            "least short_wavelength = 600, got 512",
        ),
        ("roughness", "seed = -1", "seed must be an integer >= 0, got -1"),
        ("roughness", "domain = 3.0", "domain must be at least long_wavelength = 512"),
        ("interaction", 'kind = "full"', "kind = 'full' needs work_of_adhesion"),
        ("interaction", "cutoff = 3.0", "kind = 'repulsive' has no cutoff, got 3.0"),
        (
            "interaction",
            'kind = "full"\nwork_of_adhesion = 1.0\ncutoff = 1.0',
            "cutoff must be > 1 a0, got 1.0",
        ),
        ("path", "values = []", "values must have at least one step"),
        ("path", "values = [nan]", "values must be finite"),
        ("path", "first = 1.0", "not given: last, steps"),
        (
            "path",
            "values = [1.0]\nfirst = 1.0\nsteps = 3",
            "not both: got values and first, steps",
        ),
        ("substrate", "contact_modulus = 1e9", "contact_modulus is in GPa, at most"),
        ("roughness", "short_wavelength = 1.0", "must be at least 2 a0 .* got 1"),
        (
            "roughness",
            "long_wavelength = 39.7\ndomain = 200.5",
            "domain must be a whole number of a0, got 200.5: give 201",
        ),
        (
            "path",
            "first = 1.0\nlast = 2.0\nsteps = 1000000000000000",
            "steps must be at most 1000000, got 1000000000000000",
        ),
        (
            "path",
            'first = -1e308\nlast = 1e308\nsteps = 3\nscale = "linear"',
            "first = -1e.308 and last = 1e.308 are too far apart",
        ),
        ("interaction", 'kind = "sof"', "unknown kind of interaction 'sof'"),
        (
            "interaction",
            'kind = "sof"\nwork_of_adhesion = 1.0',
            "unknown kind of interaction 'sof'",
        ),
        ("solver", "accuracy = 2.0", "accuracy must be a relative error from"),
        ("solver", 'accuracy = "exact"', "unknown accuracy 'exact'"),
        ("solver", "fmax = -1.0", "fmax must be a finite number > 0, got -1.0"),
        ("solver", "max_steps = 0", "max_steps must be an integer >= 1, got 0"),
    ],
)
def test_a_value_out_of_range_is_told_with_file_table_and_key(
    table, line, told, tmp_path
):
    file = tmp_path / "my.toml"
    path = "" if table == "path" else "[path]\nvalues = [1.0]\n"
    file.write_text(f"[{table}]\n{line}\n{path}")
    with pytest.raises(ValueError, match=rf"my\.toml: \[{table}\] .*{told}"):
        Scene.read(file)


HUGE = "9" * 400  # beyond all floats


@pytest.mark.parametrize(
    "key",
    [
        "substrate.spacing",
        "substrate.contact_modulus",
        "sphere.radius",
        "roughness.rms_slope",
        "roughness.long_wavelength",
        "interaction.work_of_adhesion",
        "interaction.cutoff",
        "path.first",
        "path.steps",
        "solver.accuracy",
        "solver.fmax",
        "substrate.shape",
        "substrate.elastic_constants",
        "path.values",
    ],
)
def test_a_whole_number_beyond_all_floats_is_told_by_name(key):
    title, _, name = key.partition(".")
    listed = name in ("shape", "elastic_constants", "values")
    tables = {
        "interaction": 'kind = "full"\nwork_of_adhesion = 1.0\n',
        "path": "first = 1.0\nlast = 2.0\nsteps = 2\n",
    }
    lines = [x for x in tables.get(title, "").splitlines() if not x.startswith(name)]
    lines.append(f"{name} = [{HUGE}, 1, 1]" if listed else f"{name} = {HUGE}")
    if name == "shape":
        lines[-1] = f"shape = [{HUGE}, 1]"
    tables[title] = "\n".join(lines) + "\n"
    text = "\n".join(f"[{title}]\n{lines}" for title, lines in tables.items())
    with pytest.raises(ValueError, match=rf"\[{title}\] {name} must"):
        Scene.parse(text).check()


@pytest.mark.parametrize("values", [("1",), (True,)])
def test_values_given_in_python_are_numbers_too(values):
    with pytest.raises(ValueError, match="values must be a number or an array of them"):
        _ = PathConfig(values=values).targets


def test_the_default_domain_is_a_whole_number_of_spacings_that_transforms_like():
    def side(long_wavelength):
        text = SMALL.replace("long_wavelength = 16.0", long_wavelength)
        scene = Scene.parse(text)
        return scene.surface.roughness.side / scene.spacing

    assert side("long_wavelength = 39.7") == pytest.approx(160.0, rel=1e-14)
    assert side("long_wavelength = 39.75") == pytest.approx(159.0, rel=1e-14)
    assert len(Scene.parse(SMALL.replace("16.0", "39.7")).atoms()) > 32 * 30


def test_a_roughness_beyond_the_memory_is_refused_before_it_is_made(tmp_path):
    file = tmp_path / "large.toml"
    file.write_text("[roughness]\nlong_wavelength = 1e6\n[path]\nvalues = [1.0]\n")
    told = r"large.toml: \[roughness\] .* domain of 4000000 x 4000000 .* smaller domain"
    with pytest.raises(MemoryError, match=told):
        Scene.read(file)


def test_an_unreadable_file_is_refused_by_name(tmp_path):
    with pytest.raises(ValueError, match=r"can't read the scene .*absent\.toml"):
        Scene.read(tmp_path / "absent.toml")


def test_a_window_of_its_own_for_every_step_needs_a_free_half_space():
    text = SMALL.replace("shape = [32, 30]", 'shape = "auto"\nperiodic = true')
    with pytest.raises(ValueError, match="needs a free half space"):
        Scene.parse(text).atoms()


def test_accuracy_is_a_word_or_a_number_and_an_explicit_fmax_wins():
    text = SMALL.replace("fmax = 1e-4", 'accuracy = "high"')
    assert Scene.parse(text).accuracy == LEVELS["high"]
    assert Scene.parse(text).fmax is None
    scene = Scene.parse(SMALL.replace("fmax", "accuracy = 1e-3\nfmax"))
    assert scene.accuracy.error == 1e-3
    tolerance = 1e-4 * scene.contact_modulus * scene.spacing**2
    assert next(scene.relax()).tolerance == tolerance


def test_steps_can_be_relaxed_from_the_middle_of_a_path():
    scene = Scene.parse(SMALL)
    whole = list(scene.relax())
    assert next(scene.relax(scene.steps[1:])).height == whole[1].height
