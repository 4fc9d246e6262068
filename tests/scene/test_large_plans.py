"""Plans of scenes of any size, and runs that are refused before they begin."""

import re
import time
from types import SimpleNamespace

import psutil
import pytest

from ase_roughcontact._util.printing import plain
from ase_roughcontact.cli import main
from ase_roughcontact.paths.plan import plan_path
from ase_roughcontact.scene import Scene
from ase_roughcontact.windows.auto import AutoWindow
from ase_roughcontact.windows.memory import memory_of

HUGE_LOAD = """
substrate = { material = "Cu" }
path = { values = [1e12] }
"""
LONG_RANGE = """
substrate = { material = "Cu" }
sphere = { unit = "a0", radius = 1e8 }
interaction = { kind = "full", work_of_adhesion = 0.05 }
path = { values = [1.0, 1e3] }
"""
LARGE_DOMAIN = """
substrate = { material = "Cu" }
sphere = { unit = "a0", radius = 1e5 }
roughness = { unit = "a0", domain = 16384.0 }
path = { values = [1.0, 1e9] }
"""
SMALL_DOMAIN = """
substrate = { material = "Cu" }
sphere = { unit = "a0", radius = 300.0 }
roughness = { unit = "a0", long_wavelength = 16.0 }
path = { values = [1.0, 300.0, 1e4, 3e4] }
"""
HARD = """
substrate = {{ contact_modulus = 100.0, {} }}
sphere = {{ unit = "a0", radius = {} }}
roughness = {{ unit = "a0", long_wavelength = {} }}
interaction = {{ kind = "hard" }}
path = {{ values = [1000.0] }}
"""


def points(text):
    n, m = map(int, text.split("x"))
    return n * m


@pytest.mark.parametrize("text", [HUGE_LOAD, LONG_RANGE], ids=["load", "range"])
def test_windows_that_no_machine_holds_are_planned_within_ten_seconds(text):
    start = time.perf_counter()
    plan = Scene.parse(text).plan()
    assert time.perf_counter() - start < 10.0
    assert plan.steps[-1].memory > 1e12 and not plan.fits


def test_the_plan_has_the_memory_of_the_frames_that_a_run_writes():
    scene = Scene.parse(
        "[substrate]\nmaterial = 'Cu'\nshape = [64, 64]\n[path]\nvalues = [1.0]\n"
    )
    path = scene.problem, scene.start, scene.control, scene.targets
    calculated = plan_path(*path, "fixed").memory
    figures = 165e6 + 22e6 + 280 * 64 * 64  # with the libraries
    assert calculated < scene.plan().memory == pytest.approx(figures)


def test_a_run_warns_if_the_expected_memory_is_not_free(tmp_path, monkeypatch):
    scene = Scene.parse(
        "[substrate]\nmaterial = 'Cu'\nshape = [64, 64]\n[path]\nvalues = [1.0]\n"
    )
    memory = SimpleNamespace(available=1e8)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: memory)
    with pytest.warns(UserWarning, match=r"0\.19 GB .* 0\.1 GB are free"):
        next(scene.run(tmp_path))


def test_a_run_times_no_transforms_before_its_first_step(tmp_path, monkeypatch):
    def measured(*_):
        raise AssertionError("transforms are timed")

    monkeypatch.setattr("ase_roughcontact.paths.plan.step_timer", measured)
    values = {"substrate.material": "Cu", "sphere.radius": "30 nm", "path.loads": [1.0]}
    scene = Scene().with_values(values | {"interaction.kind": "hard"})
    (step,) = scene.run(tmp_path, validity="ignore")
    assert step.converged
    with pytest.raises(AssertionError):
        scene.plan()


@pytest.mark.slow
def test_a_roughness_of_many_points_is_not_synthesised_for_a_plan():
    start = time.perf_counter()
    plan = Scene.parse(LARGE_DOMAIN).plan()
    assert time.perf_counter() - start < 10.0
    assert plan.steps[0].window and plan.steps[1].problem
    assert re.search(r"domain of 73\d{3} spacings .* 16\d GB", plan.advice)


@pytest.mark.parametrize("length", [4.0, 400.0])
def test_windows_planned_on_a_coarser_lattice_are_about_the_same(length):
    scene = Scene.parse(
        f"""
        substrate = {{ material = "Cu" }}
        roughness = {{ unit = "a0", short_wavelength = {length}, domain = 4096.0 }}
        path = {{ control = "penetration", values = [20.0, 200.0] }}
        """
    )
    exact, plan = AutoWindow(scene.problem), scene.plan()
    for step, target in zip(plan.steps, scene.targets, strict=True):
        n, m = exact.forecast(scene.control, target).shape
        assert 0.8 < points(step.window) / (n * m) < 1.25
    domain = scene.problem.topography.points(scene.spacing)
    memory = memory_of((n, m), scene.wall, scene.solid, points=domain)
    assert plan.memory == pytest.approx(memory, rel=0.05)


def test_a_large_random_flat_is_planned_without_its_heights():
    flat = """
    substrate = { contact_modulus = 100.0, model = "continuum", refine = 1 }
    sphere = { radius = inf }
    roughness = { unit = "a0", domain = 2560.0 }
    interaction = { kind = "hard" }
    path = { values = ["10 MPa"] }
    """
    start = time.perf_counter()
    (step,) = Scene.parse(flat).plan().steps
    assert time.perf_counter() - start < 5.0
    assert points(step.window) == 2560**2 and step.memory > 80 * 2560**2


def test_long_paths_are_listed_in_part():
    text = '[substrate]\nmaterial = "Cu"\n[path]\nfirst = 1.0\nlast = 100.0\nsteps = {}'
    short, long = (Scene.parse(text.format(n)).plan() for n in (500, 1_000_000))
    assert len(long.steps) == len(short.steps) == 500
    assert sum(step.count for step in long.steps) == 1_000_000
    assert [step.count for step in short.steps] == [1] * 500
    ends = [long.steps[i].target for i in (0, -1)]
    assert ends == [short.steps[i].target for i in (0, -1)]
    assert long.seconds == pytest.approx(2000 * short.seconds, rel=0.5)
    assert "These are 500 of 1000000 steps." in long.printed("load (eV/Å)", 1.0)


def with_advised_domain(scene, text):
    (side,) = re.findall("give the roughness a domain of ([0-9]+) a0", text)
    return scene.with_values({"roughness.domain": float(side)})


def test_the_advice_is_given_once_and_suffices_for_all_steps():
    scene = Scene.parse(SMALL_DOMAIN)
    text = " ".join(plain(*scene.plan().printed("load (eV/Å)", 1.0)).split())
    assert "2 of 4 steps can't run" in text
    assert with_advised_domain(scene, text).plan().runs


@pytest.mark.parametrize("radius, longest", [(1e4, 16.0), (3e4, 32.0), (1e5, 64.0)])
@pytest.mark.parametrize("grid", [None, "coarsen = 2", "refine = 2"])
def test_the_advised_domain_suffices(radius, longest, grid):
    """Also where the larger domain has lower points."""
    model = f'model = "continuum", {grid}' if grid else 'model = "atoms"'
    scene = Scene.parse(HARD.format(model, radius, longest))
    assert with_advised_domain(scene, scene.plan().advice).plan().runs


@pytest.mark.parametrize(
    "text, message",
    [
        (HUGE_LOAD, r"\[path\] load of 1e\+12 nN: about .* GB of memory"),
        (LONG_RANGE, r"\[path\] load of 1 to 1000 nN: about .* GB of memory"),
        (LARGE_DOMAIN, r"\[path\] load of 1e\+09 nN: atoms can touch beyond"),
        (
            LARGE_DOMAIN.replace("[1.0, 1e9]", '[-1e5, -1e7], control = "height"')
            + 'interaction = { kind = "hard" }',
            r"\[path\] height of -100000 to -1e\+07 Å: atoms can touch beyond",
        ),
    ],
    ids=["memory", "range", "domain", "height"],
)
def test_runs_that_can_not_end_are_refused_at_once(text, message, tmp_path, capsys):
    file = tmp_path / "large.toml"
    file.write_text(text)
    start = time.perf_counter()
    assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 2
    assert time.perf_counter() - start < 5.0
    assert re.search(message, capsys.readouterr().err)
    assert not (tmp_path / "out").exists()


@pytest.mark.filterwarnings("ignore:the contact has a radius of")
def test_plans_of_any_duration_are_printed(tmp_path, capsys):
    file = tmp_path / "long.toml"
    file.write_text(
        'substrate = { material = "Cu" }\n'
        'path = { control = "penetration", values = [1e30] }'
    )
    assert main(["plan", str(file)]) == 2
    assert re.search("In all about .* years", capsys.readouterr().out)
