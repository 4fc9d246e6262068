"""Scenes of paths in time on a viscoelastic solid."""

import math
import re
import time
from contextlib import redirect_stdout
from io import StringIO
from itertools import count, islice
from types import SimpleNamespace

import numpy as np
import pytest

from ase_roughcontact import Creep, Schedule
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.cli.report import StepTable
from ase_roughcontact.ensemble import progress
from ase_roughcontact.ensemble.progress import TimeMeter
from ase_roughcontact.fitting.curve_files import read_curve
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.preview import preview
from ase_roughcontact.scene.reference import reference_for
from ase_roughcontact.scene.solid import label_of
from ase_roughcontact.theory import Hertz
from ase_roughcontact.tradeoff.tradeoff import tradeoff

SOLID = """
[substrate]
model = "atoms"
contact_modulus = 2.0
spacing = "1 nm"
relaxation_moduli = [0.5, 0.3]
relaxation_times = [0.1, 2.0]
"""
PATH = """
[sphere]
radius = "100 nm"
[interaction]
kind = "hard"
[path]
kind = "time"
control = "penetration"
values = [0, "2 nm", 0]
rate = 4.0
dwell = 1.0
"""
TEXT = SOLID + PATH
NM = UNITS["nm"]


def with_path(**keys):
    return Scene.parse(TEXT).with_values({f"path.{k}": v for k, v in keys.items()})


def schedule_of(scene):
    return scene.path.schedule(scene.bodies)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """Folder of a run, beside its scene; its printed text, and its table."""
    folder = tmp_path_factory.mktemp("rubber")
    (folder / "rubber.toml").write_text(TEXT)
    command = ["run", str(folder / "rubber.toml"), "--out", str(folder / "out")]
    with redirect_stdout(StringIO()) as printed:
        assert main(command) == 0
    return command, folder / "out", printed.getvalue()


def test_a_wall_that_only_repels_has_no_pull_off_force(run):
    _, _, printed = run
    assert "largest force" in printed and "pull-off" not in printed


def table_of(folder):
    return np.genfromtxt(folder / "curve.csv", delimiter=",", names=True, dtype=None)


def test_given_moduli_have_a_spacing_that_fits_the_contact():
    default = TEXT.replace('spacing = "1 nm"', "").replace("100 nm", "40 um")
    large = Scene.parse(default)
    assert large.spacing == pytest.approx(50.0)  # 283 nm / 60
    copper = Scene.parse(TEXT.replace('spacing = "1 nm"', ""))
    rough = Scene.parse(default + "[roughness]\nrms_slope = 0.1\n")
    for scene in copper, rough:
        assert scene.spacing == pytest.approx(2.5527, rel=1e-4)
    assert large.warnings == copper.warnings == rough.warnings == []


def test_a_row_is_printed_when_nothing_was_for_ten_seconds(monkeypatch):
    scene = Scene.parse(TEXT)
    reference, steps = reference_for(scene), list(islice(scene.relax(), 8))

    def rows():
        table = StepTable(reference)
        return [bool(table.parts(step)) for step in steps]

    assert not all(rows())
    clock = count(step=10.1)
    monkeypatch.setattr(time, "monotonic", lambda: next(clock))
    assert all(rows())


def test_a_scene_has_a_viscoelastic_solid():
    solid = Scene.parse(TEXT.replace("[0.1, 2.0]", '["100 ms", 2.0]')).solid
    assert solid.contact_modulus == pytest.approx(2.0 * UNITS["GPa"])
    assert solid.relaxed.contact_modulus == pytest.approx(0.4 * UNITS["GPa"])
    assert solid.creep == Creep.of_relaxation([0.5, 0.3], [0.1, 2.0])


def test_an_elastic_tip_creeps_less():
    scene = Scene.parse(TEXT).with_values({"sphere.material": "SiO2"})
    both, creep = scene.solid, scene.solid.creep
    # compliances of substrate and tip add up
    tip = 1.0 / both.contact_modulus - 1.0 / (2.0 * UNITS["GPa"])
    relaxed = tip + 1.0 / (0.4 * UNITS["GPa"])
    assert both.contact_modulus * creep.relaxed == pytest.approx(1.0 / relaxed)


TIMES = {"rate": None, "dwell": 0.0, "times": [0, 1, 1]}
OSCILLATION = {"amplitude": "1 A", "frequency": 2.0, "cycles": 1}
LOADS = {"control": "load", "values": [0, 10, 5], "rate": 5.0, "dwell": 0.0}


@pytest.mark.parametrize(
    ("keys", "duration", "time", "target"),
    [
        ({}, 2.0, 0.25, 1.0 * NM),
        ({}, 2.0, 1.2, 2.0 * NM),
        ({"rate": "0.24 um/min", "dwell": "500 ms"}, 1.5, 0.25, 1.0 * NM),
        ({"rate": [4.0, "1 nm/s"]}, 3.5, 2.5, 1.0 * NM),
        (TIMES | OSCILLATION, 1.5, 1.125, 1.0),
        (LOADS, 3.0, 2.0, 10.0 * UNITS["nN"]),
    ],
)
def test_targets_over_time_follow_from_rates_times_and_oscillations(
    keys, duration, time, target
):
    schedule = schedule_of(with_path(**keys))
    assert schedule.duration == pytest.approx(duration)
    assert schedule.at(time) == pytest.approx(target)


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"values": None}, "give (loads|penetrations)"),
        ({"times": [0, 1, 2]}, "either times, one for each of .*, or a rate"),
        ({"rate": None, "times": [0, 1]}, "a dwell needs a rate"),
        ({"rate": None, "times": [0, 1], "dwell": 0.0}, "as many as the targets"),
        ({"rate": -1.0}, "rate must be"),
        ({"dwell": -1.0}, "dwell must be"),
        ({"rate": "4 nN/s"}, 'such as "20 nm/s", got .4 nN/s'),
        ({"rate": [4.0]}, "one for each change from a value to the next: 2, got 1"),
        ({"control": "load", "values": [0, "1 nm"]}, "lengths are given as penet"),
        ({"values": [1.0]}, "two values or more"),
        ({"values": [1.0, 1.0]}, "later times"),
        ({"times": "1 s", "rate": None}, "times must be a list of numbers"),
        ({"amplitude": 1.0}, "both amplitude and frequency"),
        ({"control": "base"}, "give its stiffness"),
        ({"cantilever": 1.0}, "leave out its stiffness"),
    ],
)
def test_errors_of_the_path_name_what_is_missing(keys, message):
    with pytest.raises(ValueError, match=message):
        with_path(**keys).check()


LOOP = """
[sphere]
radius = "20 nm"
[interaction]
kind = "adhesive"
work_of_adhesion = 0.1
attraction_range = "1 nm"
[path]
kind = "loop"
deepest = "1 nm"
rate = "20 nm/s"
dwell = "0.5 s"
"""


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_a_loop_at_a_rate_ends_beyond_the_contact():
    scene = Scene.parse(SOLID + LOOP)
    assert scene.path.kind == "time"
    assert Scene.parse(scene.toml).path == scene.path
    steps = list(scene.relax())
    first, last = steps[0], steps[-1]
    assert first.attractive_atoms == last.attractive_atoms == 0
    assert min(s.normal_force for s in steps) < 0.0
    assert max(s.penetration for s in steps) == pytest.approx(1.0 * NM)
    held = [s.time for s in steps if s.penetration == pytest.approx(1.0 * NM)]
    assert held[-1] - held[0] == pytest.approx(0.5)
    descent = (1.0 * NM - first.penetration) / NM / 20.0
    assert held[0] == pytest.approx(descent)


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
@pytest.mark.parametrize(("deepest", "in_tension"), [("8 nm", False), ("-2 A", True)])
def test_a_loop_at_a_rate_reports_force_and_depth_at_the_turn(deepest, in_tension):
    scene = Scene.parse((SOLID + LOOP).replace('1 nm"\nrate', f'{deepest}"\nrate'))
    steps = list(scene.relax())
    turn = min(steps, key=lambda step: abs(step.time - end_of_dwell(scene)))
    summary = scene.path.summary(scene.bodies, steps)
    force, depth = turn.normal_force / UNITS["nN"], turn.penetration / NM
    assert summary["turn"] == f"at {force:.4g} nN and a depth of {depth:.4g} nm"
    warnings = scene.path.warnings(scene.bodies, steps)
    assert [f"by {-force:.4g} nN" in each for each in warnings] == [True] * in_tension


def end_of_dwell(scene):
    first, second, _ = scene.path.schedule(scene.bodies).parts
    return first.duration + second.duration


MODULI, MODULUS, STEPS = "[0.5, 0.3]", "contact_modulus = 2.0", "[path]\nvalues = [1.0]"


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (LOOP, '"20 nm/s"', "20.0\ncantilever = 2.0", "in place of a loop.*give kind"),
        (LOOP, 'deepest = "1 nm"', "", "for a loop at a rate deepest"),
        (LOOP, 't = "1 nm"', "t = '-5 nm'", "above -.* nm, where.*got -5 nm"),
        (LOOP, MODULI, "[0.5, 0.5]", "give (loads|penetrations)"),
        (LOOP, "[path]", "[path]\nstep = 1.0", 'step need kind = "loop"'),
        (LOOP, "relaxation_", "#", "needs a viscoelastic solid"),
        (LOOP, 'rate = "20 nm/s"', "", "dwell need.*give kind = .time"),
        (
            PATH,
            MODULI,
            "[0.5]",
            "relaxation_moduli and relaxation_times .* same length",
        ),
        (PATH, MODULI, "[-0.5, 0.5]", "relaxation_moduli must be .* > 0, got -0.5"),
        (PATH, MODULI, "[0.9, 0.5]", "relaxation moduli .* sum is at most 1, got 1.4"),
        (PATH, "relaxation_times", "#", "both relaxation_moduli and relaxation_times"),
        (PATH, "relaxation_", "#", "give relaxation_moduli and"),
        (PATH, MODULUS, 'material = "PDMS"', "not instantaneous: give contact_mod"),
        (STEPS, "", "", 'viscoelastic: give kind = "time"'),
        ("[path]\nrate = 1.0\ndwell = 1.0\n", "", "", 'give kind = "time"'),
    ],
)
def test_errors_of_solids_and_loops_say_what_to_give(text, old, new, message):
    with pytest.raises(ValueError, match=message):
        Scene.parse((SOLID + text).replace(old, new)).check()


def test_an_elastic_solid_has_no_path_in_time():
    scene = Scene.parse("[substrate]\ncontact_modulus = 2.0\n" + PATH)
    with pytest.raises(ValueError, match="Viscoelastic"):
        list(scene.relax())


def test_a_preview_of_a_small_path_is_the_path_itself():
    scene = Scene.parse(TEXT)
    assert preview(scene) is scene


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_a_preview_relaxes_on_a_coarse_grid():
    scene = with_path(values=[0, "8 nm"], rate=100.0, dwell=10.0)
    large = scene.with_values({"sphere.radius": "2 um"})
    coarse = preview(large)
    assert coarse.grid_change.coarsen == 4
    forces = [step.normal_force for step in coarse.relax()]
    hertz = Hertz(2000.0 * NM, 0.4 * UNITS["GPa"])
    relaxed = hertz.force(hertz.contact_radius_from_penetration(8.0 * NM))
    assert forces[-1] == pytest.approx(float(relaxed), rel=0.03)


def test_a_plan_of_time_steps_is_an_estimate(tmp_path, capsys):
    file, jumps = tmp_path / "rubber.toml", "snaps in or off: thousands at slow rates"
    for path, attracts in ((PATH, False), (LOOP, True)):
        file.write_text(SOLID + path)
        assert main(["plan", str(file)]) == 0
        text = " ".join(capsys.readouterr().out.split())
        assert "In all about" in text and "at most" not in text
        assert (jumps in text) == attracts


def test_a_plan_counts_time_steps_within_a_factor_of_two():
    scene = Scene.parse(TEXT)
    count = sum(1 for _ in scene.relax(validity="ignore"))
    assert 0.5 < scene.path.expected_count(scene.bodies) / count < 2.0


def test_a_plan_of_a_cantilever_has_the_force_that_it_can_exert():
    keys = {"control": "base", "cantilever": 1.0, "values": ["5 nm", "-1 um"]}
    soft = with_path(**keys, rate=100.0, dwell=0.0)
    assert soft.planned.path.control == "load"
    assert soft.planned.path.values[0] == pytest.approx(1000.0, rel=1e-3)
    soft.with_values({"interaction.kind": "repulsive"}).check_path()
    stiff = with_path(**{**keys, "cantilever": 1e4, "values": ["5 nm", "-1 nm"]})
    hertz = 4.0 / 3.0 * 2.0e9 * (100e-9 * (1e-9) ** 3) ** 0.5 * 1e9
    assert stiff.planned.path.values[0] == pytest.approx(hertz, rel=1e-3)


def test_a_plan_counts_steps_and_the_files_of_a_run(run, capsys):
    command, folder, _ = run
    files = sum(each.stat().st_size for each in folder.iterdir())
    steps = len((folder / "curve.csv").read_text().splitlines()) - 1
    assert main(["plan", command[1]]) == 0
    planned = " ".join(capsys.readouterr().out.split())
    assert "Path of 2 s" in planned
    [(count, size)] = re.findall(r"for (\d+) steps, ([\d.]+) MB of files", planned)
    assert 1 / 1.3 < int(count) / steps < 1.3
    assert 1 / 1.3 < 1e6 * float(size) / files < 1.3


def test_a_run_is_printed_drawn_and_continued(run):
    command, folder, printed = run
    assert "relaxing to E* = 0.4 GPa" in printed
    assert "dissipated energy" in printed
    table = table_of(folder)
    assert table["time_s"][-1] == pytest.approx(2.0)
    assert math.isclose(table["penetration_Å"].max(), 20.0)
    assert (folder / "time.png").stat().st_size > 10_000
    before = (folder / "curve.csv").read_text()
    assert main([*command, "--quiet"]) == 0
    assert (folder / "curve.csv").read_text() == before


def test_a_tradeoff_is_advised_of_the_deepest_elastic_state():
    advice = 'control = "penetration", values = .20., without relaxation_moduli'
    with pytest.raises(ValueError, match=advice):
        tradeoff(Scene.parse(TEXT))


def test_a_fluid_is_named_one():
    scene = Scene.parse(TEXT.replace("[0.5, 0.3]", "[0.5, 0.5]"))
    assert label_of(scene.substrate, scene.solid).endswith("a fluid in the end")
    assert list(scene.bodies.sphere_limits) == ["instantaneous"]


def test_maps_are_those_at_the_times(run, capsys):
    folder = run[1]
    times = ["--times", "500 ms,1.5"]
    assert main(["maps", str(folder), "--format", "npz", *times]) == 0
    written = sorted((folder / "maps").glob("*.npz"))
    steps = [int(each.stem[-4:]) for each in written]
    assert table_of(folder)["time_s"][steps] == pytest.approx([0.5, 1.5])
    first, last = (np.load(each)["pressure"] for each in written)
    assert first.max() > 1.2 * last.max()  # GPa, relaxes at the same depth
    capsys.readouterr()
    assert main(["figure", str(folder), *times]) == 0
    assert "contact.png" in capsys.readouterr().out
    for wrong, message in (("9", "between 0 and the 2 s"), ("1 m", "unit of --times")):
        assert main(["maps", str(folder), "--times", wrong]) == 2
        assert message in capsys.readouterr().err


def test_each_state_is_of_a_part_of_the_path():
    scene = with_path(amplitude="1 A", frequency=2.0)
    times = [0.0, 0.5, 0.6, 1.5, 1.6, 2.0, 2.1]
    states = [SimpleNamespace(time=time) for time in times]
    branches = ["approach"] * 2 + ["dwell"] * 2 + ["retraction"] * 2 + ["oscillation"]
    assert scene.path.branch_names(scene.bodies, states) == branches
    raised = with_path(control="height", values=[0, -10, 0], rate=1.0, dwell=0.0)
    states = [SimpleNamespace(time=time) for time in (0.5, 1.5)]
    assert raised.path.branch_names(raised.bodies, states) == ["approach", "retraction"]


def test_the_printed_table_has_a_part_of_the_steps_and_the_turns(run):
    _, folder, text = run
    rows = [words for words in map(str.split, text.splitlines()) if words]
    rows = [words for words in rows if words[0].isdigit()]
    assert 20 < len(rows) < 50 < len(table_of(folder))
    times = [float(row[1]) for row in rows]
    assert {0.0, 0.5, 1.5, 2.0} <= set(times)


@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_the_force_of_a_cantilever_is_its_stiffness_times_its_deflection(tmp_path):
    text = TEXT.replace('"hard"', '"repulsive"').replace('"penetration"', '"base"')
    text = text.replace('[0, "2 nm", 0]', '["1 nm", "-2 nm", "1 nm"]')
    file, folder = tmp_path / "rubber.toml", tmp_path / "out"
    file.write_text(text.replace("100 nm", "20 nm") + "cantilever = 5.0\n")
    assert main(["run", str(file), "--out", str(folder), "--quiet"]) == 0
    table = table_of(folder)
    stiffness = 5.0 * UNITS["N/m"]
    assert table["base_Å"].min() == pytest.approx(-2.0 * NM)
    force = stiffness * table["deflection_Å"]
    assert table["normal_force_eVÅ"] == pytest.approx(force, abs=1e-3 * force.max())
    curve = read_curve(folder / "cantilever.csv", "retraction")
    assert curve.stiffness == pytest.approx(stiffness, rel=1e-3)
    assert len(curve.force) < len(table)


def test_results_in_time_are_drawn_again(run):
    folder = run[1]
    (folder / "time.png").unlink()
    assert main(["figure", str(folder)]) == main(["report", str(folder)]) == 0
    assert (folder / "time.png").exists()
    page = (folder / "report.html").read_text()
    heads = re.findall(r'<th title="[^"]+">([a-z ]+)', page)
    assert heads[:2] == ["step", "time"] and "dissipation" in heads


def elapse(monkeypatch, seconds):
    """Let an amount of time pass at each call of the clock of progress."""
    clock = count(0.0, seconds)
    monkeypatch.setattr(progress, "perf_counter", lambda: next(clock))


def test_the_time_left_of_a_path_agrees_with_its_steps_to_a_factor_of_four(
    run, monkeypatch
):
    scene = Scene.parse(TEXT)
    elapse(monkeypatch, 1.0)  # each step takes a second
    timer = TimeMeter(schedule_of(scene), scene.path.expected_counts(scene.bodies))
    times, ratios = table_of(run[1])["time_s"].tolist(), []
    for number, moment in enumerate(times, 1):
        timer.finish(moment)
        if len(times) // 10 < number < 0.95 * len(times):
            ratios.append(timer.left / (len(times) - number))
    assert min(ratios) > 0.25 and max(ratios) < 4.0 and timer.left == 0.0


def test_the_time_left_of_a_path_grows_where_its_steps_stay_short(monkeypatch):
    schedule = Schedule(0.0).ramp(1.0, time=1.0)
    elapse(monkeypatch, 1.0)
    timer = TimeMeter(schedule, [90.0])
    for moment in np.linspace(0.0, 0.5, 20):
        timer.finish(moment)
    before = timer.left
    for moment in np.linspace(0.5, 0.51, 1000):
        timer.finish(moment)
    # 1 % of the time has taken 1000 s: the other 49 % take 49 000 s
    assert before < 50.0 and timer.left == pytest.approx(49e3, rel=0.3)


def test_restored_steps_do_not_count_for_the_time_left(monkeypatch):
    elapse(monkeypatch, 1.0)
    timer = TimeMeter(Schedule(0.0).ramp(1.0, time=1.0), [90.0])
    for moment in np.linspace(0.0, 0.5, 20):
        timer.restart(moment)
    assert math.isnan(timer.left) and str(timer) == "0.5 of 1 s"
    elapse(monkeypatch, 100.0)
    timer.restart(0.5)
    timer.finish(0.75)
    assert timer.left == pytest.approx(100.0, rel=0.5)
    assert str(timer).startswith("0.75 of 1 s, roughly 0:01:")
