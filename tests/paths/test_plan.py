"""Plans: windows, memory and time of a path before it is calculated."""

import itertools
import time

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact._util.printing import plain
from ase_roughcontact.atoms.calculator import problem_of
from ase_roughcontact.paths.plan import plan_path
from ase_roughcontact.scene import Scene
from ase_roughcontact.windows.memory import check_memory

ROUGH = rc.RoughSphere(300.0, rc.SelfAffine(0.1, 0.8, 4.0, 64.0, seed=1, domain=512.0))
WALLS = {
    "hard": rc.HardWall(),
    "repulsive": rc.LennardJones93.repulsive(1.0, 1.0),
    "adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.01),
}


def make_atoms(sphere=ROUGH, wall="hard", shape=(8, 8), **options):
    return atoms_under(sphere, WALLS[wall], shape, **options)


def points(text):
    return int(np.prod([int(n) for n in text.split("x")]))


@pytest.mark.parametrize("wall", WALLS)
def test_planned_windows_agree_roughly_with_the_run(wall):
    loads = [1e-3, 1.0, 100.0]
    atoms = make_atoms(wall=wall, fixed=False)
    plan = plan_path(*problem_of(atoms), "loads", loads, "auto")
    records = list(rc.load_path(atoms, loads=loads, window="auto"))
    # adhesion alone makes a contact under the lighter loads
    first = 2 if wall == "adhesive" else 1
    for step, record in zip(plan.steps[first:], records[first:], strict=True):
        assert 0.4 < points(step.window) / points(record.window) < 2.5
    assert plan.fits and plan.seconds > 0.0


@pytest.mark.parametrize("control", ["penetrations", "heights"])
def test_windows_at_given_heights_are_planned_exactly(control):
    atoms = make_atoms()
    first = plan_path(*problem_of(atoms), "penetrations", [0.0], "auto")
    assert first.steps[0].window == "9x9"  # the smallest window there is
    record = next(rc.load_path(atoms, penetrations=[2.0], window="auto"))
    target = 2.0 if control == "penetrations" else record.height
    (step,) = plan_path(*problem_of(make_atoms()), control, [target], "auto").steps
    assert (step.window, step.grid) == (record.window, record.grid)


def test_plan_lists_what_is_left_out_and_why():
    hard = plan_path(*problem_of(make_atoms()), "heights", [0.0], "auto").left_out
    assert any("can't touch" in text for text in hard)
    adhesive = plan_path(
        *problem_of(make_atoms(wall="adhesive")), "heights", [1.0], "auto"
    ).left_out
    assert any("enlarged until none is missing" in text for text in adhesive)
    assert any("beyond a gap of 1.346" in text for text in adhesive)
    periodic = make_atoms(shape=(16, 16), periodic=True)
    reasons = plan_path(*problem_of(periodic), "heights", [0.0], "fixed").left_out
    assert any("repeats along x and y" in text for text in reasons)


def test_step_beyond_the_roughness_has_a_problem_and_the_others_are_planned():
    plan = plan_path(*problem_of(make_atoms()), "heights", [0.0, -300.0], "auto")
    assert [bool(step.window) for step in plan.steps] == [True, False]
    assert "which is defined up to 25.6 nm" in plan.steps[1].problem
    assert plan.fits and not plan.runs
    text = " ".join(plain(*plan.printed("height (Å)", 1.0)).split())
    assert "CAN'T RUN" in text and "1 of 2 steps can't run: atoms can touch" in text
    assert "To run all, give the roughness a domain" in text


@pytest.mark.parametrize(
    "heights, text",
    [([0.0], "In all about"), ([0.0, -300.0], "The other steps about")],
)
def test_a_plan_has_the_time_of_the_steps_that_can_run(heights, text):
    plan = plan_path(*problem_of(make_atoms()), "heights", heights, "auto")
    assert text in plain(*plan.printed("height (Å)", 1.0))


def test_a_plan_without_a_step_that_can_run_has_no_time():
    plan = plan_path(*problem_of(make_atoms()), "heights", [-300.0], "auto")
    assert "about" not in plain(*plan.printed("height (Å)", 1.0)).partition("Left")[0]


@pytest.mark.parametrize("control", ["penetrations", "heights", "loads"])
def test_contact_wider_than_a_fixed_window_is_a_problem(control):
    sphere = rc.RoughSphere(300.0)  # contact radius 30 at a depth of 3
    loads = control == "loads"
    targets = {
        "penetrations": [0.1, 3.0],
        "heights": [-0.1, -3.0],
        "loads": [1.0, 4.0 / 3.0 * 30.0**3 / 300.0],
    }[control]
    atoms = make_atoms(sphere, shape=(40, 44), fixed=not loads)
    plan = plan_path(*problem_of(atoms), control, targets, "fixed")
    assert plan.steps[0].problem == ""
    assert "60 atoms wide, the window has 40x44" in plan.steps[1].problem
    path = rc.load_path(atoms, **{control: targets})
    assert next(path).converged
    with pytest.raises(RuntimeError, match="edge of the window"):
        next(path)


def test_fixed_window_beside_the_first_contact_is_reported():
    atoms = make_atoms(shape=(8, 8))
    plan = plan_path(*problem_of(atoms), "penetrations", [0.1], "fixed")
    assert "lowest outside the window of 8x8 atoms" in plan.left_out[-1]


def test_a_periodic_window_is_never_too_small():
    atoms = make_atoms(rc.RoughSphere(300.0), shape=(8, 8), periodic=True)
    assert plan_path(*problem_of(atoms), "heights", [-3.0], "fixed").runs


def test_plan_as_text_has_a_line_for_every_step():
    scene = Scene.default()
    text = plain(*scene.plan().printed("load (nN)", 1.0))
    assert len(text.splitlines()) > len(scene.targets) + 3
    assert "In all about" in text and "Left out:" in text


def test_a_plan_has_the_total_time_and_the_peak_memory():
    depths = [1e-4, 1e-2, 1e-3]
    atoms = make_atoms(rc.RoughSphere(1e6), "repulsive")
    plan = plan_path(*problem_of(atoms), "penetrations", depths, "auto")
    assert plan.seconds == pytest.approx(sum(step.seconds for step in plan.steps))
    assert plan.memory == max(step.memory for step in plan.steps)
    assert [step.target for step in plan.steps] == depths


@pytest.mark.parametrize("window", ["fixed", "auto", "periodic"])
@pytest.mark.parametrize("wall", WALLS)
def test_planned_memory_agrees_with_the_results(wall, window):
    periodic, fixed = window == "periodic", window != "auto"
    window = "fixed" if fixed else "auto"
    atoms = make_atoms(rc.RoughSphere(100.0), wall, (64, 60), periodic=periodic)
    plan = plan_path(*problem_of(atoms), "penetrations", [0.5, 1.0], window)
    records = rc.load_path(atoms, penetrations=[0.5, 1.0], window=window)
    for step, record in zip(plan.steps, records, strict=True):
        tolerance = 1e-12 if step.window == record.window else 0.05
        assert step.memory == pytest.approx(record.memory, rel=tolerance)
        assert not fixed or (step.window, step.grid) == ("64x60", record.grid)


# Measured time of a step, in convolutions, for windows of 100 to 1700 atoms a side.
MEASURED = {"hard": (106, 197), "repulsive": (132, 248), "adhesive": (218, 463)}


@pytest.mark.parametrize("wall", WALLS)
def test_the_time_of_a_step_is_in_the_measured_range(wall, monkeypatch):
    ticks = itertools.count()
    monkeypatch.setattr(time, "process_time", lambda: float(next(ticks)))
    atoms = make_atoms(rc.RoughSphere(1000.0), wall, (16, 16), periodic=True)
    (step,) = plan_path(*problem_of(atoms), "penetrations", [0.1], "fixed").steps
    fewest, most = MEASURED[wall]
    assert fewest < step.seconds < most


# Memory


def test_window_too_large_for_the_memory_is_an_error_with_the_numbers():
    with pytest.raises(MemoryError, match=r"3.5e\+05 GB .* 1000000 x 1000000 atoms"):
        check_memory((10**6, 10**6))


def test_path_stops_before_it_exceeds_the_memory(monkeypatch):
    monkeypatch.setattr(
        "ase_roughcontact.windows.memory.available_memory", lambda: 231e6
    )
    atoms = make_atoms(rc.RoughSphere(300.0), fixed=False)
    path = rc.load_path(atoms, loads=[1e-3, 2e5], window="auto", validity="ignore")
    assert next(path).converged
    with pytest.raises(MemoryError, match=r"0\.231 GB are free"):
        next(path)
