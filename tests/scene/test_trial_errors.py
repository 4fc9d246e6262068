"""Errors and costs of the trials of a trade-off, from given results of load steps."""

from dataclasses import replace

import pytest

from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.tradeoff import tradeoff

SPACING, MODULUS = 2.5, 1e-19 / 1.602176634e-19  # Å, eV/Å^3
TEXT = """
substrate = {{ spacing = 2.5, contact_modulus = 100.0, shape = [36, 36] }}
sphere = {{ radius = 60.0 }}
path = {{ control = "{control}", values = [0.5, 1.0] }}
solver = {{ accuracy = 1e-2 }}
"""
# Result of the reference.
TRUE = {
    "height": 1.0,
    "penetration": 4.0,
    "normal_force": 80.0,
    "contact_area": 200 * SPACING**2,
    "repulsive_atoms": 200,
    "attractive_atoms": 50,
    "pairs": 30.0,
    "grid": "10x20",
    "memory": 1e9,
    "seconds": 2.0,
    "converged": True,
}
# Force of 0.05 E* on the atoms in contact, the scale of errors of small forces.
PUSH = 0.05 * MODULUS * 200 * SPACING**2

CASES = [
    # control, changes of the reference, of the trial, error of force, of area, of atoms
    ("penetration", {}, {"normal_force": 80.8}, 0.01, 0.0, 0),
    ("penetration", {}, {"normal_force": 79.2}, 0.01, 0.0, 0),
    ("penetration", {"normal_force": -0.1}, {"normal_force": 0.1}, 0.2 / PUSH, 0.0, 0),
    ("height", {}, {"normal_force": 80.8, "height": 3.0}, 0.01, 0.0, 0),
    ("load", {}, {"penetration": 3.96, "normal_force": 99.0}, 0.01, 0.0, 0),
    ("load", {"penetration": 0.5}, {"penetration": 0.55}, 0.05 / SPACING, 0.0, 0),
    ("penetration", {}, {"repulsive_atoms": 203}, 0.0, 0.015, 3),
    ("penetration", {}, {"repulsive_atoms": 197}, 0.0, 0.015, 3),
    ("load", {"repulsive_atoms": 0}, {"repulsive_atoms": 2}, 0.0, 2.0, 2),
]


def study(monkeypatch, control, true=(), found=()):
    """Return a trade-off in which the last step of all trials has given results."""
    scene = Scene.parse(TEXT.format(control=control))
    record = replace(next(scene.relax()), **TRUE | dict(true))

    def relax(scene, steps, **_):
        # only the reference and the check of its error are this accurate
        changes = {} if scene.solver.accuracy < 1e-8 else dict(found)
        return iter([record for _ in steps[1:]] + [replace(record, **changes)])

    monkeypatch.setattr(Scene, "relax", relax)
    return tradeoff(scene, 1e-2)


@pytest.mark.parametrize("control, true, found, force, area, atoms", CASES)
def test_errors_are_the_largest_relative_errors_of_any_step(
    control, true, found, force, area, atoms, monkeypatch
):
    trial = study(monkeypatch, control, true, found).trials[0]
    assert trial.response_error == pytest.approx(force, rel=1e-6, abs=1e-12)
    assert trial.area_error == pytest.approx(area)
    assert trial.atoms == atoms
    assert trial.error == pytest.approx(max(force, area))


def test_costs_are_sums_over_steps_and_the_peak_memory(monkeypatch):
    costs = {"seconds": 9.0, "pairs": 50.0, "grid": "30x20", "memory": 3e9}
    trial = study(monkeypatch, "load", found=costs).trials[0]
    assert trial.pairs == 80.0
    assert trial.work == 30.0 * 200 + 50.0 * 600
    assert trial.seconds == 11.0
    assert trial.memory == 3e9
    assert trial.converged


def test_the_error_is_infinite_if_a_step_did_not_converge(monkeypatch):
    trial = study(monkeypatch, "load", found={"converged": False}).trials[0]
    assert not trial.converged and trial.error == float("inf")


@pytest.mark.parametrize("control, unit", [("load", "nN"), ("height", "Å")])
def test_targets_are_listed_in_the_unit_of_the_file(control, unit, monkeypatch):
    found = study(monkeypatch, control)
    assert found.steps == (f"0.5 {unit}", f"1 {unit}")
    assert found.omitted == 0
