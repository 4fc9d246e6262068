"""Stated errors of scans against the true ones of synthetic surfaces."""

import logging
import math

import numpy as np
import pytest

from ase_roughcontact import HeightMap, SelfAffine
from ase_roughcontact.results import scan_errors
from ase_roughcontact.results.scan_errors import ScanErrors
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.config import FrictionConfig
from ase_roughcontact.topography.spectrum import smooth_component

SCENE = """
[substrate]
contact_modulus = 100.0
hardness = inf
[sphere]
radius = "100 nm"
[topography]
file = "scan.npy"
role = "substrate"
unit = "nm"
spacing = 0.5
detrend = "none"
[interaction]
kind = "hard"
[path]
values = [150.0, 600.0]
[solver]
accuracy = "fast"
"""
POINTS, PIXEL = 128, 0.5  # nm


def surface(seed, waves):
    domain = POINTS * PIXEL
    lengths = waves * PIXEL, domain / 2.0
    return SelfAffine(0.1, 0.8, *lengths, seed=seed, domain=domain).heights(
        (POINTS, POINTS), PIXEL
    )


@pytest.fixture
def pressed(tmp_path, monkeypatch):
    """Return a function from heights to the steps of a scan of them."""
    monkeypatch.chdir(tmp_path)

    def steps(heights, *, errors=True, **changes):
        np.save("scan.npy", heights)
        scene = Scene.parse(SCENE).with_values(changes)
        return list(scene.relax(validity="ignore", scan_errors=errors))

    return steps


@pytest.mark.parametrize(
    ("seed", "waves", "ratio", "points", "lines"),
    [
        (1, 4, 2, 0.0, 0.0),
        pytest.param(2, 8, 4, 0.0, 0.0, marks=pytest.mark.slow),
        (3, 8, 1, 0.01, 0.0),
        pytest.param(4, 8, 1, 0.005, 0.01, marks=pytest.mark.slow),
        (5, 4, 2, 0.01, 0.01),
    ],
)
def test_errors_cover_those_by_pixels_and_noise(
    pressed, seed, waves, ratio, points, lines
):
    heights = surface(seed, waves)
    rng = np.random.default_rng(seed)
    scan = heights[::ratio, ::ratio]
    scan = scan + points * rng.normal(size=scan.shape)
    scan = scan + lines * rng.normal(size=scan.shape[1])
    exact = pressed(heights, errors=False)
    spacing = {"topography.spacing": PIXEL * ratio}
    plain = pressed(scan, errors=False, **spacing)
    stated = pressed(scan, **spacing)
    for true, step, without in zip(exact, stated, plain, strict=True):
        assert step.continuum_area == without.continuum_area
        error = abs(true.continuum_area - step.continuum_area)
        assert error < 2.0 * step.area_error
        assert step.area_error > 2.0 * without.area_error
        assert step.area_error < step.continuum_area
        assert abs(true.height - step.height) < 3.0 * step.height_error


def test_a_scan_without_noise_whose_waves_are_resolved_has_small_errors(pressed):
    for step in pressed(surface(1, 16)):
        assert step.area_error < 0.03 * step.continuum_area


def test_errors_of_a_given_depth_agree_with_force_and_area(pressed):
    noise = 0.02 * np.random.default_rng(1).normal(size=(POINTS, POINTS))
    depths = {"path.control": "penetration", "path.values": ("0.5 nm", "1 nm")}
    heights = surface(1, 8)
    exact = pressed(heights, errors=False, **depths)
    for true, step in zip(exact, pressed(heights + noise, **depths), strict=True):
        force = abs(true.normal_force - step.normal_force)
        assert 0.0 < force < 3.0 * step.force_error
        assert step.height_error == step.penetration_error == 0.0


@pytest.mark.parametrize("control", ["penetration", "height"])
def test_errors_next_to_a_target_at_which_the_scan_fails_are_not_known(
    pressed, monkeypatch, control
):
    press = scan_errors.relax_in_contact

    def fail_at_the_second(stepper, state, target, number):
        if number == 1:
            raise RuntimeError("not possible")
        return press(stepper, state, target, number)

    monkeypatch.setattr(scan_errors, "relax_in_contact", fail_at_the_second)
    values = {"penetration": ("0.5 nm", "0.8 nm", "1 nm")}
    values["height"] = ("-0.2 nm", "-0.5 nm", "-0.7 nm")
    path = {"path.control": control, "path.values": values[control]}
    first, second, third = pressed(surface(1, 8), **path)
    assert math.isnan(second.area_error)
    assert "not possible" in second.unknown_errors
    for step in (first, third):
        assert 0.0 < step.area_error < step.continuum_area


def only(monkeypatch, kind):
    """Let scans have copies of one kind."""
    every = HeightMap.copies

    def some(self):
        return {k: maps if k == kind else [] for k, maps in every(self).items()}

    monkeypatch.setattr(HeightMap, "copies", some)


def test_copies_with_more_noise_alone_tell_its_error(pressed, monkeypatch):
    heights = surface(3, 8)
    noisy = heights + 0.01 * np.random.default_rng(3).normal(size=heights.shape)
    exact = pressed(heights, errors=False)
    plain = pressed(noisy, errors=False)
    only(monkeypatch, "noisy")
    for true, without, step in zip(exact, plain, pressed(noisy), strict=True):
        error = true.continuum_area - step.continuum_area
        by_noise = step.area_error - without.area_error
        assert 0.5 * error < by_noise < 2.0 * error


def test_the_error_by_edges_is_the_change_if_they_fit(pressed, monkeypatch):
    part = surface(1, 16)[:50, :50]
    flat = {"sphere.radius": math.inf, "path.values": ("20 MPa",)}
    flat["topography.periodic"] = True
    (plain,) = pressed(part, errors=False, **flat)
    (fitting,) = pressed(part - smooth_component(part), errors=False, **flat)
    only(monkeypatch, "seamless")
    (step,) = pressed(part, **flat)
    change = abs(fitting.continuum_area - plain.continuum_area)
    assert change > 0.05 * plain.continuum_area
    by_edges = step.area_error - plain.area_error  # on a coarser grid
    assert 0.5 * change < by_edges < 2.0 * change
    (fits,) = pressed(surface(1, 16), **flat)
    assert fits.area_error < 0.05 * fits.continuum_area


def test_the_model_of_atoms_has_the_errors_of_the_scan_too(pressed):
    noise = 0.02 * np.random.default_rng(1).normal(size=(POINTS, POINTS))
    atoms = {"substrate.model": "atoms"}
    for step in pressed(surface(1, 8) + noise, **atoms):
        assert step.area_error > 0.05 * step.contact_area


def test_a_resumed_run_has_the_errors_of_an_uninterrupted_one(pressed, tmp_path):
    noise = 0.02 * np.random.default_rng(1).normal(size=(POINTS // 2, POINTS // 2))
    spacing = {"topography.spacing": 2.0 * PIXEL}
    steps = pressed(surface(1, 8)[::2, ::2] + noise, **spacing)
    expected = [step.area_error for step in steps]
    scene = Scene.parse(SCENE).with_values(spacing)
    run = scene.run(tmp_path / "out", validity="ignore")
    next(run)
    run.close()
    resumed = scene.run(tmp_path / "out", validity="ignore")
    assert [step.area_error for step in resumed] == pytest.approx(expected, rel=1e-9)


def test_a_contact_that_a_quarter_of_the_pixels_can_not_contain_has_an_error(pressed):
    x = PIXEL * np.arange(-24, 25)
    tip = 5.0 - (x[:, None] ** 2 + x**2) / 60.0
    whole = {"sphere.radius": math.inf, "topography.role": "indenter"}
    for step in pressed(tip, **whole, **{"path.values": (260.0,)}):
        assert 0.0 < step.area_error < 0.2 * step.continuum_area


def test_copies_are_pressed_only_when_an_error_is_asked_for(pressed, monkeypatch):
    np.save("scan.npy", surface(1, 8))

    def fail(self, step):
        raise AssertionError("copies are pressed")

    scene = Scene.parse(SCENE)
    list(scene.run("out", validity="ignore"))
    monkeypatch.setattr(ScanErrors, "__call__", fail)
    list(scene.relax(validity="ignore", scan_errors=False))
    list(Scene.parse(SCENE).run("out", validity="ignore"))  # it is complete


def test_a_sliding_path_presses_copies_once_at_its_load(pressed, monkeypatch):
    targets, results = [], ScanErrors._results

    def counted(errors, rough, at):
        targets.append(at)
        return results(errors, rough, at)

    monkeypatch.setattr(ScanErrors, "_results", counted)
    sliding = {
        "substrate.poisson": 0.3,
        "friction": FrictionConfig(0.3),
        "path.kind": "sliding",
        "path.displacements": [0.0, 0.1],
        "path.steps": 2,
    }
    steps = pressed(surface(2, 8), **{"path.values": [150.0]}, **sliding)
    (alone,) = pressed(surface(2, 8), **{"path.values": [150.0]})
    assert {len(at) for at in targets} == {1}
    for step in (steps[0], steps[2]):
        assert step.area_error == pytest.approx(alone.area_error)


def test_the_copy_that_is_pressed_is_logged(pressed, caplog):
    caplog.set_level(logging.INFO, "ase_roughcontact")
    pressed(surface(2, 8), **{"path.values": [150.0]})
    count = len(caplog.messages)
    assert count >= 3  # the scan, half and a quarter of its pixels
    assert caplog.messages == [
        f"errors of the scan: copy {i + 1} of {count}" for i in range(count)
    ]


WHOLE_TIP = {"sphere.radius": math.inf, "topography.role": "indenter"}


def tip_scan():
    """Scan of a tip on which copies with fewer pixels reach beyond the edge first."""
    x = PIXEL * np.arange(-24, 25)
    return 5.0 - (x[:, None] ** 2 + x**2) / 60.0


@pytest.mark.parametrize("loads", [(100.0, 600.0), (600.0, 100.0)])
def test_errors_are_not_known_only_where_copies_can_not_be_pressed(pressed, loads):
    (alone,) = pressed(tip_scan(), **WHOLE_TIP, **{"path.values": (100.0,)})
    steps = pressed(tip_scan(), **WHOLE_TIP, **{"path.values": loads})
    light, heavy = sorted(steps, key=lambda step: step.normal_force)
    assert light.area_error == pytest.approx(alone.area_error, rel=1e-3)
    assert light.unknown_errors == alone.unknown_errors == ""
    assert np.isnan([heavy.area_error, heavy.height_error]).all()
    assert "fewer pixels" in heavy.unknown_errors and "12 nm" in heavy.unknown_errors


def spoilt(monkeypatch, kind, index):
    """Let scans have copies of one kind; one of them ends within the contact."""
    every = HeightMap.copies

    def some(self):
        maps = every(self)[kind]
        inner = maps[index].heights((5, 5), 0.1 * min(maps[index].spacing))
        maps[index] = HeightMap(inner, 0.1 * min(maps[index].spacing))
        return {k: maps if k == kind else [] for k in every(self)}

    monkeypatch.setattr(HeightMap, "copies", some)


def test_three_of_four_noisy_copies_are_enough(pressed, monkeypatch):
    noise = 0.01 * np.random.default_rng(3).normal(size=(POINTS, POINTS))
    noisy = surface(3, 8) + noise
    with monkeypatch.context() as patch:
        only(patch, "noisy")
        all_four = pressed(noisy)
    spoilt(monkeypatch, "noisy", 0)
    for step, complete in zip(pressed(noisy), all_four, strict=True):
        assert step.unknown_errors == ""
        assert step.area_error == pytest.approx(complete.area_error, rel=0.4)


def test_a_quarter_of_the_pixels_alone_is_enough(pressed, monkeypatch):
    heights = surface(1, 8)[:113, :113]  # every fourth point has the same middle
    plain = pressed(heights, errors=False)
    quarter = pressed(
        heights[::4, ::4], errors=False, **{"topography.spacing": 4 * PIXEL}
    )
    spoilt(monkeypatch, "coarser", 0)
    for given, coarse, step in zip(plain, quarter, pressed(heights), strict=True):
        assert step.unknown_errors == ""
        third = abs(given.continuum_area - coarse.continuum_area) / 3.0
        by_pixels = step.area_error - given.area_error
        assert by_pixels == pytest.approx(third, rel=0.2)


def test_errors_are_known_of_no_step_if_no_copy_touches(pressed):
    """The first, middle and last depth are out of contact."""
    depths = {"path.control": "height", "path.values": (9e3, 0.0, 9e3, 0.0, 9e3)}
    steps = pressed(surface(1, 8), **depths)
    assert [step.area_error for step in steps[::2]] == [0.0, 0.0, 0.0]
    assert math.isnan(steps[1].area_error) and "touch" in steps[1].unknown_errors
