"""Scenes and scene files."""

import pickle

import numpy as np
import pytest
from ase.units import GPa, J, m
from small_scene import SMALL

from ase_roughcontact import fcc_spacing
from ase_roughcontact.interactions import (
    HardWall,
    LennardJones93,
    wall_parameters,
)
from ase_roughcontact.paths.accuracy import OF_ATOMS
from ase_roughcontact.scene import NANONEWTON, Scene, Steps, build, default_text
from ase_roughcontact.scene.config import SECTIONS, SubstrateConfig
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
        (
            "full",
            lambda e, a: LennardJones93.full(
                distance=a, work_of_adhesion=0.1 * J / m**2
            ),
        ),
    ],
)
def test_walls_are_made_by_kind(kind, wall):
    work = "work_of_adhesion = 0.1\n" if kind == "full" else ""
    scene = Scene.parse(SMALL + f'[interaction]\nkind = "{kind}"\n{work}')
    assert scene.wall == wall(scene.contact_modulus, scene.spacing)


def test_ranges_of_the_attraction():
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
        Scene.parse(text).targets, np.array([0.2, 0.6]) * NANONEWTON, rtol=1e-14
    )
    assert pytest.approx(0.6241509, rel=1e-6) == NANONEWTON  # eV/Å


def test_targets_can_be_listed():
    text = SMALL.replace("first = 0.2\nlast = 0.6\nsteps = 2", "values = [0.1, 0.3]")
    np.testing.assert_array_equal(Scene.parse(text).targets, [0.1, 0.3])


def test_built_in_scene_is_the_paper_s_roughness_over_four_decades_of_load():
    scene = Scene.default()
    assert scene.shape is None
    assert scene.sphere.radius == 2500.0
    assert (scene.roughness.short_wavelength, scene.roughness.long_wavelength) == (
        4.0,
        512.0,
    )
    assert len(scene.targets) >= 10
    assert scene.targets[-1] / scene.targets[0] == pytest.approx(1e4)


def test_the_built_in_scene_explains_every_key():
    text = default_text()
    for title, section in SECTIONS.items():
        assert f"[{title}]" in text
        keys = section().entries() | dict.fromkeys(wall_parameters())
        wanted = keys if title == "interaction" else section().entries()
        assert [key for key in wanted if f"{key} = " not in text] == []


def test_adhesion_increases_the_predicted_area_unless_flats_adhere():
    def predicted(work):
        interaction = f'[interaction]\nkind = "adhesive"\nwork_of_adhesion = {work}\n'
        return Scene.parse(SMALL + interaction).predicted_area(1.0)

    assert predicted(0.05) > Scene.parse(SMALL).predicted_area(1.0)
    assert np.isnan(predicted(9.5))


def test_the_predicted_area_of_a_smooth_sphere_is_hertz():
    text = SMALL.replace("[roughness]\nlong_wavelength = 16.0\n", "")
    scene = Scene.parse(text)
    np.testing.assert_array_equal(scene.predicted_area(2.0), scene.hertz_area(2.0))


def test_run_writes_csv_and_trajectory_and_resumes(tmp_path):
    scene = Scene.parse(SMALL)
    first = next(scene.run(tmp_path))
    records = list(scene.run(tmp_path))
    assert records[0] == first
    assert [record.converged for record in records] == [True, True]
    assert len((tmp_path / "curve.csv").read_text().splitlines()) == 3


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
        Scene(path=Steps(values=(np.float64(1.5), np.int64(2)))),
        Scene(substrate=SubstrateConfig(symbol='"Å"\n')),
    ],
    ids=range(4),
)
def test_the_text_of_a_scene_is_that_scene(scene):
    assert Scene.parse(scene.toml) == scene


def test_a_folder_with_results_of_another_scene_is_an_error(tmp_path):
    next(Scene.parse(SMALL).run(tmp_path))
    other = Scene.parse(SMALL.replace("radius = 60.0", "radius = 61.0"))
    with pytest.raises(ValueError, match="contains results of another scene"):
        next(other.run(tmp_path))


def test_the_error_of_a_changed_scene_lists_the_changes(tmp_path):
    next(Scene.parse(SMALL).run(tmp_path))
    path = "first = 0.2\nlast = 0.6\nsteps = 2"
    changed = SMALL.replace("60.0", "61.0").replace(path, "values = [0.3]")
    with pytest.raises(ValueError, match="contains results of another scene") as error:
        next(Scene.parse(changed).run(tmp_path))
    assert "[sphere] radius was 60.0, is 61.0" in str(error.value)
    assert "[path] values was not given, is [0.3]" in str(error.value)
    assert "rms_slope" not in str(error.value)


def test_the_error_of_a_changed_scene_lists_removed_keys(tmp_path):
    next(Scene.parse(SMALL).run(tmp_path))
    smooth = SMALL.replace("[roughness]\nlong_wavelength = 16.0\n", "")
    with pytest.raises(ValueError, match=r"long_wavelength was 16.0, is not given"):
        next(Scene.parse(smooth).run(tmp_path))


@pytest.mark.parametrize(
    "longer",
    [
        ("last = 0.6\nsteps = 2", "last = 1.0\nsteps = 3"),
        ("first = 0.2\nlast = 0.6\nsteps = 2", "values = [0.2, 0.6, 0.5]"),
    ],
    ids=["ends", "values"],
)
def test_an_extended_path_resumes_in_the_same_folder(longer, tmp_path):
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
def test_unknown_names_and_wrong_types_are_errors(text, message):
    with pytest.raises(ValueError, match=message):
        Scene.parse(text)


@pytest.mark.parametrize(
    "old, new, message",
    [
        ("contact_modulus = 100.0", "contact_modulus = -1.0", "contact_modulus"),
        ("contact_modulus = 100.0", "contact_modulus = nan", "contact_modulus"),
        ("contact_modulus = 100.0", 'spacing = "wide"', "spacing"),
        ("contact_modulus = 100.0", 'symbol = "Fe"', "surface of Fe is not known"),
        ("shape = [32, 30]", "shape = [12]", "shape"),
        ("radius = 60.0", "radius = 0.0", "radius"),
        (
            "radius = 60.0",
            "radius = 0.26",
            r"at least the spacing .* got 0.26, 0.26 a0",
        ),
        ("radius = 60.0", 'radius = "2 Å"', r"a0 = 2.553 Å, got '2 Å', 0.783 a0"),
        (
            "contact_modulus = 100.0",
            "hardness = 3e9",
            "in GPa, above 0 and at most 1000, or inf",
        ),
        ("contact_modulus = 100.0", "hardness = -1.0", "in GPa, .* or inf, got -1$"),
        ("radius = 60.0", 'radius = "-10 nm"', "number > 0, got '-10 nm'"),
        ("radius = 60.0", 'radius = -10.0\nunit = "nm"', "number > 0, got -10.0"),
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
def test_errors_of_invalid_values_name_the_key(old, new, message, tmp_path):
    text = SMALL.replace(old, new)
    if message.startswith("geometric"):
        text = text.replace("first = 0.2", "first = -0.2")
    with pytest.raises(ValueError, match=message):
        list(Scene.parse(text).run(tmp_path))


@pytest.mark.parametrize(
    "section, line, message",
    [
        (
            "substrate",
            "spacing = -2.5",
            "spacing must be a finite number > 0, got -2.5",
        ),
        ("substrate", 'symbol = "Fe"', "symbol = 'Fe': the .* of Fe is not known"),
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
        ("path", "first = 1.0", "give either values, or .*, got first"),
        (
            "path",
            "values = [1.0]\nfirst = 1.0\nsteps = 3",
            "give either values, or .*, got values, first, steps",
        ),
        ("substrate", "contact_modulus = 1e9", "contact_modulus is in GPa, at most"),
        ("roughness", "short_wavelength = 1.0", "must be at least 2 a0 .* got 1"),
        (
            "roughness",
            "long_wavelength = 39.7\ndomain = 200.5",
            'domain must be a whole number of a0, got 200.5 a0: give "201 a0',
        ),
        (
            "path",
            "first = 1.0\nlast = 2.0\nsteps = 1000000000000000",
            "steps must be at most 1000000, got 1000000000000000",
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
def test_errors_of_values_out_of_range_name_file_section_and_key(
    section, line, message, tmp_path
):
    file = tmp_path / "my.toml"
    path = "" if section == "path" else "[path]\nvalues = [1.0]\n"
    file.write_text(f"[{section}]\n{line}\n{path}")
    with pytest.raises(ValueError, match=rf"my\.toml: \[{section}\] .*{message}"):
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
def test_integers_beyond_the_range_of_floats_are_errors(key):
    title, _, name = key.partition(".")
    listed = name in ("shape", "elastic_constants", "values")
    tables = {
        "interaction": 'kind = "full"\nwork_of_adhesion = 1.0\n',
        "path": "" if listed else "first = 1.0\nlast = 2.0\nsteps = 2\n",
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
def test_values_given_in_python_must_be_numbers(values):
    with pytest.raises(ValueError, match="values must be a number"):
        _ = Scene(path=Steps(values=values)).targets


def test_the_default_domain_is_an_integer_number_of_spacings_suited_to_ffts():
    def side(long_wavelength):
        text = SMALL.replace("long_wavelength = 16.0", long_wavelength)
        scene = Scene.parse(text)
        return scene.surface.roughness.side / scene.spacing

    assert side("long_wavelength = 39.7") == pytest.approx(160.0, rel=1e-14)
    assert side("long_wavelength = 39.75") == pytest.approx(159.0, rel=1e-14)
    assert len(Scene.parse(SMALL.replace("16.0", "39.7")).atoms()) > 32 * 30


def test_a_roughness_that_needs_too_much_memory_is_an_error(tmp_path):
    file = tmp_path / "large.toml"
    file.write_text("[roughness]\nlong_wavelength = 1e6\n[path]\nvalues = [1.0]\n")
    message = (
        r"large.toml: \[roughness\] .* domain of 4000000 x 4000000 .* smaller domain"
    )
    with pytest.raises(MemoryError, match=message):
        Scene.read(file)


def test_a_file_that_can_not_be_read_is_an_error(tmp_path):
    with pytest.raises(ValueError, match=r"can't read the scene .*absent\.toml"):
        Scene.read(tmp_path / "absent.toml")


def test_an_array_given_as_a_scene_is_named_as_no_toml(tmp_path):
    np.save(tmp_path / "scan.npy", np.arange(6.0))
    with pytest.raises(ValueError, match=r"scan\.npy is not a TOML file: it is not"):
        Scene.read(tmp_path / "scan.npy")


def test_automatic_windows_need_a_free_half_space():
    text = SMALL.replace("shape = [32, 30]", 'shape = "auto"\nperiodic = true')
    with pytest.raises(ValueError, match="needs a free half space"):
        Scene.parse(text).atoms()


def test_accuracy_is_a_name_or_a_number_and_fmax_replaces_it():
    text = SMALL.replace("fmax = 1e-4", 'accuracy = "high"')
    assert Scene.parse(text).accuracy.error == OF_ATOMS
    assert Scene.parse(text).fmax is None
    scene = Scene.parse(SMALL.replace("fmax", "accuracy = 1e-3\nfmax"))
    assert scene.accuracy.error == 1e-3
    tolerance = 1e-4 * scene.contact_modulus * scene.spacing**2
    assert next(scene.relax()).tolerance == tolerance


def test_relax_can_begin_in_the_middle_of_the_path():
    scene = Scene.parse(SMALL)
    whole = list(scene.relax())
    assert next(scene.relax(scene.targets[1:])).height == whole[1].height


@pytest.mark.parametrize("kind", ["adhesive", "full"])
def test_a_work_of_adhesion_that_no_solid_has_is_an_error(kind):
    text = SMALL + f'[interaction]\nkind = "{kind}"\nwork_of_adhesion = 50.0\n'
    with pytest.raises(ValueError, match=r"> 0 and < 10 J/m\^2, got 50.0"):
        Scene.parse(text).check()


def test_all_that_is_not_known_of_a_substrate_is_reported_at_once():
    with pytest.raises(ValueError, match=r"\[substrate\] .*W.*fcc") as error:
        Scene.parse('[substrate]\nsymbol = "W"\n[path]\nvalues = [1.0]\n').check()
    text = str(error.value)
    assert "give spacing; symbol = 'W': the elastic constants" in text
    assert "those of Ag, Al, Au, Cu, Ge, Ni, Si" in text
    assert text.count("spacing") == 1


def test_the_parts_of_a_scene_are_built_once(monkeypatch):
    built = []
    for part in ("solid_of", "make_wall", "random_field"):
        original = getattr(build, part)
        monkeypatch.setattr(
            build, part, lambda *args, p=part, b=original: built.append(p) or b(*args)
        )
    scene = Scene.parse(SMALL)
    scene.check()
    list(scene.relax(validity="ignore"))
    assert sorted(built) == ["make_wall", "random_field", "solid_of"]


def test_a_scene_is_sent_to_processes_without_what_was_built():
    scene = Scene.parse(SMALL)
    short = pickle.dumps(scene)
    scene.check()
    assert pickle.dumps(scene) == short and pickle.loads(short) == scene
