"""Limits of the model: what is outside says so, in every output."""

import csv
import json
import re
import warnings
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from ase.io import read
from ase.units import GPa
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.cli import main
from ase_roughcontact.elasticity import Isotropic, Layer
from ase_roughcontact.elasticity.material import CRYSTALS, HARDNESS, fcc_spacing
from ase_roughcontact.ensemble import product, read_ensemble, run_ensemble
from ase_roughcontact.results.limits import CHECKS, failed_checks
from ase_roughcontact.results.validity import hardness_bound_for, hardness_for
from ase_roughcontact.scene import Scene

GUIDE = Path(__file__).parents[2] / "examples" / "guide" / "validity.md"
SPHERE = rc.RoughSphere(200.0)
SOFT = rc.LennardJones93.repulsive(1.0, 1.0)
# Copper under 20 nN: a contact of some hundred atoms, and 10 GPa.
COPPER = """
[substrate]
material = "Cu"
[sphere]
unit = "a0"
radius = 300.0
[path]
values = [20.0, 30.0]
"""


@dataclass(frozen=True)
class Magnet(rc.Interaction):
    """Wall with tension that its attributes deny."""

    tension: float
    cutoff = 1.5
    contact_distance = 1.0
    work_of_adhesion = attraction_range = 0.0

    def evaluate(self, gap):
        pressure = np.where(gap < 1.0, 1.0 - gap, -self.tension * (gap < 1.5))
        pulled = self.tension * np.minimum(np.maximum(gap, 1.0) - 1.5, 0.0)
        energy = 0.5 * np.maximum(1.0 - gap, 0.0) ** 2 + pulled
        return energy, pressure, 1.0 * (gap < 1.0)


def atoms_on(indenter=SPHERE, wall=SOFT, **options):
    atoms = rc.substrate("Cu", (16, 16), indenter, **{"spacing": 1.0} | options)
    atoms.calc = rc.RoughContact(indenter, 1.0, wall)
    return atoms


def names_after(atoms, depth=1.0, **options):
    """Return the names of the limits that a step exceeds."""
    options = {"window": "auto", "validity": "ignore"} | options
    loads = {"loads": [depth]} if options.pop("loads", False) else {}
    (step,) = rc.load_path(
        atoms, penetrations=None if loads else [depth], **loads, **options
    )
    return {check.name for check in failed_checks(step.validity).values()}


FEW = "atoms in contact"
PRESSURES = {"mean pressure/hardness", "largest pressure/hardness"}


@pytest.mark.parametrize(
    "hardness, names",
    [
        (0.01, PRESSURES),
        (0.04, {"largest pressure/hardness"}),
        (0.1, set()),
        (np.inf, set()),
        (None, set()),  # copper has another spacing and modulus than one
    ],
)
def test_pressures_are_compared_with_the_hardness(hardness, names):
    # Hertz: a/R = sqrt(1/200), mean pressure 0.03 E*, largest 0.045 E*
    validity = rc.Validity("ignore", hardness)
    assert names_after(atoms_on(wall=rc.HardWall()), validity=validity) == names


@pytest.mark.parametrize(
    "stretched, known", [(1.0, True), (1.019, True), (1.03, False)]
)
def test_hardness_of_an_element_is_known_within_two_percent_of_its_spacing(
    stretched, known
):
    spacing = stretched * fcc_spacing("Cu")
    problem = rc.Problem(rc.RoughSphere(300.0), Isotropic(0.8), rc.HardWall(), spacing)
    found = hardness_for(problem, "Cu")
    assert found == HARDNESS["Cu"] * GPa if known else np.isnan(found)


def test_hardness_of_a_crystal_agrees_with_the_table():
    atoms = rc.substrate("Cu", (16, 16), rc.RoughSphere(500.0))
    atoms.calc = rc.RoughContact(rc.RoughSphere(500.0), 0.9)
    assert names_after(atoms, 1.0) == PRESSURES
    assert set(CRYSTALS) <= set(HARDNESS)
    assert Scene.default().hardness == HARDNESS["Si"] * GPa


@pytest.mark.parametrize(
    "symbol, spacing, wall, hardness, part",
    [
        ("Pb", fcc_spacing("Pb"), rc.HardWall(), None, 0.1026),
        ("Nb", 3.3, rc.HardWall(), None, 0.1026),  # bcc
        ("Pb", 1.0, rc.HardWall(), None, np.nan),  # a model solid
        ("X", 1.0, rc.HardWall(), None, np.nan),
        ("Cu", fcc_spacing("Cu"), rc.HardWall(), None, np.nan),
        ("Pb", fcc_spacing("Pb"), rc.HardWall(), 0.1, np.nan),
        ("Pb", fcc_spacing("Pb"), rc.HardWall(), np.inf, np.nan),
        ("Pb", fcc_spacing("Pb"), rc.PlasticWall(0.1), None, np.nan),
    ],
)
def test_an_element_of_unknown_hardness_bears_a_tenth_of_its_modulus(
    symbol, spacing, wall, hardness, part
):
    problem = rc.Problem(SPHERE, Isotropic(0.8), wall, spacing)
    found = hardness_bound_for(problem, symbol, hardness)
    assert found == pytest.approx(0.8 * part, rel=1e-3, nan_ok=True)


def test_a_layer_on_silicon_bears_a_tenth_of_its_own_modulus():
    layer = Layer(0.05, thickness=50.0, base_modulus=1.0)
    problem = rc.Problem(SPHERE, layer, rc.HardWall(), fcc_spacing("Si"))
    found = hardness_bound_for(problem, "Si")
    assert found == pytest.approx(0.1026 * 0.05, rel=1e-3)


def test_lead_under_a_fifth_of_its_modulus_is_marked():
    sphere = rc.RoughSphere(300.0)
    atoms = rc.substrate("Pb", (16, 16), sphere)
    atoms.calc = rc.RoughContact(sphere, 0.1, rc.HardWall())
    # Hertz: (2/pi) sqrt(depth/R) E*
    bound = "largest pressure/bound of the hardness"
    assert bound not in names_after(atoms, 5.0)
    assert bound in names_after(atoms, 30.0)


def adhesive(stiffness=1.0):
    return rc.LennardJones93.adhesive(1.0, 1.0, 0.003, stiffness=stiffness)


@pytest.mark.parametrize(
    "depth, names, indenter, wall",
    [
        (4.0, set(), rc.RoughSphere(200.0), SOFT),
        (14.0, {"contact radius/R"}, rc.RoughSphere(200.0), SOFT),
        (14.0, set(), rc.RoughSphere(200.0, profile="sphere"), SOFT),
        (0.5, set(), SPHERE, rc.HardWall()),
        (1e-4, {FEW}, SPHERE, rc.HardWall()),
        (1.0, set(), SPHERE, rc.LennardJones93.repulsive(1.0, 1.0, core=0.5)),
        (
            1.0,
            {"smallest gap/core"},
            SPHERE,
            rc.LennardJones93.repulsive(1.0, 1.0, core=0.99),
        ),
        # atoms that are attracted are not in contact; pull-off is 7 % wrong
        (0.1, {FEW, "adhesive zone at the tip/a0"}, rc.RoughSphere(15.0), adhesive()),
        (0.1, set(), rc.RoughSphere(100.0), adhesive()),
        (0.1, {"adhesive zone at the edge/a0"}, rc.RoughSphere(100.0), adhesive(2.0)),
        (0.1, {FEW, "slope"}, rc.RoughSphere(1.1), SOFT),
        (0.1, {FEW, "slope", "R/a0"}, rc.RoughSphere(0.9), SOFT),
    ],
)
def test_limits_of_smooth_spheres(depth, names, indenter, wall):
    assert names_after(atoms_on(indenter, wall), depth) == names


@pytest.mark.parametrize(
    "along, across, outside",
    [
        (0.33, 0.33, False),
        (0.38, 0.38, True),
        (0.15, 0.45, False),
        (0.15, 0.5, True),
        (0.5, 0.15, True),
    ],
)
def test_slope_agrees_with_both_components(along, across, outside):
    """Of a pyramid; on the diagonals of the grid."""
    x = abs(np.arange(16) - 7.5)
    pyramid = rc.HeightMap(along * x[:, None] + across * x, 1.0)
    assert ("slope" in names_after(atoms_on(pyramid), 0.7, window="fixed")) == outside


@pytest.mark.parametrize("tension", [0.0, 1e-3])
def test_tension_of_a_wall_without_adhesion(tension):
    names = names_after(atoms_on(wall=Magnet(tension)), 0.5, max_steps=3)
    assert ("tension/E*" in names) == bool(tension)


def test_tensile_load_on_a_wall_without_adhesion():
    atoms = atoms_on(fixed=False)
    assert names_after(atoms, -1.0, loads=True, max_steps=3) == {"tension/E*"}


@pytest.mark.parametrize(
    "reach, deviation, outside",
    [(0.3, 0.0, True), (0.5, 0.0, False), (0.5, 0.7, True)],  # zones: 3.5, 9.8, 5.8 a0
)
def test_adhesive_zone_of_a_hard_wall_agrees_with_the_largest_local_work(
    reach, deviation, outside
):
    atoms = atoms_on(rc.RoughSphere(100.0), rc.DugdaleWall(0.02, reach))
    stripes = rc.Heterogeneity(lambda x, y: deviation * np.cos(x / 4.0) + 0.0 * y)
    atoms.calc.set(heterogeneity=stripes)
    assert names_after(atoms, 0.1) == (
        {"adhesive zone at the edge/a0"} if outside else set()
    )


@pytest.mark.parametrize("thickness, outside", [(0.1, False), (1000.0, True)])
def test_adhesive_zone_on_a_layer_has_the_modulus_at_the_surface(thickness, outside):
    layer = Layer(0.2, thickness, base_modulus=1.0)  # zones: 9.8 and 2.0 a0
    wall = rc.DugdaleWall(0.02, 0.5)
    atoms = atoms_under(rc.RoughSphere(100.0), wall, (16, 16), solid=layer, fixed=True)
    names = names_after(atoms, 0.1)
    assert ("adhesive zone at the edge/a0" in names) == outside


@cache
def pull_off_force(radius, spacing, centre=0.0):
    """Return the pull-off force for a work of 0.003 E* a0, the axis beside an atom."""
    sphere = rc.RoughSphere(radius)
    atoms = rc.substrate("Cu", (8, 8), sphere, spacing=spacing)
    atoms.positions[-1, :2] += centre * spacing
    atoms.calc = rc.RoughContact(
        sphere, 1.0, rc.LennardJones93.adhesive(1.0, 1.0, 0.003)
    )
    options = {"window": "auto", "validity": "ignore", "tolerance": 2e-3}
    return rc.adhesion_loop(atoms, deepest=0.04, step=0.1, **options).pull_off_force


@pytest.mark.slow
@pytest.mark.parametrize("radius, error", [(15.0, 0.07), (25.0, 0.05), (100.0, 0.01)])
def test_pull_off_force_is_right_if_the_zone_at_the_tip_is_resolved(radius, error):
    exact = pull_off_force(radius, 0.25)
    errors = [abs(pull_off_force(radius, 1.0, c) / exact - 1.0) for c in (0.0, 0.5)]
    assert 0.5 * error < max(errors) < 1.1 * error


# Reports


def path(validity, **options):
    """Path with largest pressures of 0.032, 0.045 and 0.055 E*, means of two thirds."""
    atoms = atoms_on(wall=rc.HardWall())
    return rc.load_path(
        atoms, penetrations=[0.5, 1.0, 1.5], window="auto", validity=validity, **options
    )


def test_each_limit_is_warned_of_once():
    with pytest.warns(rc.ValidityWarning) as caught:
        steps = list(path(rc.Validity(hardness=0.025)))
    assert [bool(step.validity) for step in steps] == [True] * 3
    texts = [str(each.message) for each in caught]
    assert len(texts) == 2  # the mean pressure exceeds the limit later
    assert texts[0].startswith("step 0 is outside") and "largest pressure" in texts[0]
    assert "mean pressure" in texts[1] and "largest pressure" not in texts[1]
    assert caught[0].filename == __file__


def test_nothing_is_warned_of_within_the_limits_or_if_ignored():
    with warnings.catch_warnings():
        warnings.simplefilter("error", rc.ValidityWarning)
        list(path(rc.Validity(hardness=1.0)))
        list(path(rc.Validity("ignore", 0.01)))
        with pytest.raises(rc.ValidityWarning, match="plastically"):
            list(path(rc.Validity(hardness=0.01)))


def test_strict_paths_stop_after_the_step_is_written(tmp_path):
    table = tmp_path / "curve.csv"
    strict = path(rc.Validity("raise", 0.04), output=rc.Output(csv=table))
    assert next(strict).validity == ""
    with pytest.raises(RuntimeError, match=r"step 1 .* = 1\.\d+ > 1"):
        next(strict)
    assert len(table.read_text().splitlines()) == 3


def test_restored_steps_are_reported(tmp_path):
    file = tmp_path / "path.traj"
    list(path(rc.Validity("ignore", 0.01), output=rc.Output(trajectory=file)))
    with pytest.raises(RuntimeError, match="step 0"):
        again = rc.Output(trajectory=file, resume=True)
        next(path(rc.Validity("raise", 0.01), output=again))


@pytest.mark.parametrize(
    "arguments, message",
    [(("maybe",), "'ignore', got 'maybe'"), (("warn", -1.0), "> 0")],
)
def test_unknown_actions_and_hardnesses_are_errors(arguments, message):
    with pytest.raises(ValueError, match=message):
        path(rc.Validity(*arguments))


@pytest.mark.filterwarnings("ignore:the pull-off force")
def test_adhesion_loops_report_the_states_that_they_keep():
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.003)
    atoms = atoms_on(rc.RoughSphere(15.0), wall)
    with pytest.warns(rc.ValidityWarning, match="at the tip") as caught:
        loop = rc.adhesion_loop(
            atoms, deepest=-0.1, step=0.05, smallest_step=0.05, window="auto"
        )
    assert all("at the tip" in state.validity for state in loop.approach)
    assert {each.filename for each in caught} == {__file__}


# Scenes and commands


@pytest.fixture
def scene(tmp_path):
    file = tmp_path / "copper.toml"
    file.write_text(COPPER)
    return file


@pytest.mark.usefixtures("no_pictures")
def test_limits_are_in_table_csv_trajectory_and_json(scene, tmp_path, capsys):
    out = tmp_path / "out"
    assert main(["run", str(scene), "--out", str(out)]) == 0
    text = capsys.readouterr().out
    assert "hardness 0.369 GPa" in text
    entry = r"mean pressure/hardness = \d+\.\d+ > 1"
    rows = [line for line in text.splitlines() if re.match(" *[01]/1", line)]
    assert len(rows) == 2 and all(row.endswith(" *") for row in rows)
    names = "* LIMITS: mean pressure/hardness, largest pressure/hardness\n"
    assert text.count(names) == 1
    assert re.search(r"mean pressure/hardness > 1 +in 2 of 2 steps: the contact", text)
    with open(out / "curve.csv", newline="") as file:
        assert all(re.match(entry, row["validity"]) for row in csv.DictReader(file))
    frame = read(out / "sweep.traj")
    assert re.match(entry, frame.info["load_step"]["validity"])
    assert main(["run", str(scene), "--out", str(out), "--json"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert all(re.match(entry, json.loads(line)["validity"]) for line in lines)


def test_strict_runs_are_errors(scene, tmp_path, capsys):
    command = ["run", str(scene), "--strict", "--quiet", "--out"]
    assert main([*command, str(tmp_path / "out")]) == 2
    assert "step 0 is outside of the validity" in capsys.readouterr().err
    assert main(["figure", str(tmp_path / "out")]) == 0  # its scene is written
    scene.write_text(COPPER.replace("[sphere]", "hardness = inf\n[sphere]"))
    assert main([*command, str(tmp_path / "elastic")]) == 0


def test_ensembles_have_the_column_and_do_not_warn(tmp_path):
    database = tmp_path / "all.db"
    with warnings.catch_warnings():
        warnings.simplefilter("error", rc.ValidityWarning)
        scenes = product(Scene.parse(COPPER), {"substrate.hardness": [None, np.inf]})
        list(run_ensemble(scenes, database, workers=1))
    table = read_ensemble(database)
    marked = ["mean pressure/hardness = " in text for text in table["validity"]]
    assert sorted(marked) == [False, False, True, True]


def test_the_built_in_scene_is_within_all_limits():
    steps = list(Scene.default().relax(validity="raise"))
    assert len(steps) == len(Scene.default().targets)


PERIOD = "cell/period of the roughness"


@pytest.mark.parametrize("radius, touches", [(1e6, True), (10.0, False)])
@pytest.mark.parametrize("side, missing", [(16, False), (12, True)])
def test_a_jump_at_the_edges_of_a_periodic_cell_is_marked(
    radius, touches, side, missing
):
    surface = rc.RoughSphere(radius, rc.SelfAffine(0.1, 0.8, 4.0, 8.0, domain=16.0))
    atoms = atoms_under(surface, shape=(side, side), periodic=True)
    # pressed flat, or touched in one place only
    names = names_after(atoms, 1.0 if touches else 1e-4, window="fixed")
    assert (PERIOD in names) == (missing and touches)


def test_no_jump_is_marked_in_a_window_of_free_boundary():
    surface = rc.SelfAffine(0.1, 0.8, 4.0, 8.0, domain=32.0)
    names = names_after(atoms_on(surface), window="unchecked")
    assert PERIOD not in names


def test_the_guide_has_a_row_for_each_limit():
    rows = re.findall(
        r"^\| `(.*?)` \| ([<>] [\d.]+) \| (.*) \|$", GUIDE.read_text(), re.M
    )
    limits = [(f"{name} {limit}", reason) for name, limit, reason in rows]
    assert limits == [(check.condition, check.reason) for check in CHECKS]
