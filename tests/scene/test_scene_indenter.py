"""Scenes with an indenter of another shape than a sphere, beside closed forms."""

import json
import math

import numpy as np
import pytest
from ase.io import read

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.cli import main
from ase_roughcontact.scene import Scene
from ase_roughcontact.theory.indenters import INDENTERS, Indenter

NM, GPA, NN = UNITS["nm"], UNITS["GPa"], UNITS["nN"]
TANGENT = math.tan(math.radians(70.0))
TEXT = """
[substrate]
contact_modulus = "1 GPa"
spacing = "1 nm"
hardness = inf
[indenter]
kind = "{kind}"
{keys}
[interaction]
kind = "hard"
[path]
control = "penetration"
values = ["5 nm"]
"""


def scene(kind, keys, text=TEXT):
    return Scene.parse(text.format(kind=kind, keys=keys))


def rounded_cone(depth, radius=10.0):
    """Force over E* (nm^2) and contact radius of Briscoe, by bisection of the depth."""
    begin, (low, high) = radius / TANGENT, (radius / TANGENT, 100.0)

    def at(a):
        root = math.sqrt(a**2 - begin**2)
        angle = math.acos(begin / a)
        deep = a * angle / TANGENT + a * (a - root) / radius
        cap = (2 * a**3 - (2 * a**2 + begin**2) * root) * 2 / 3 / radius
        return deep, (a**2 * angle + begin * root) / TANGENT + cap

    for _ in range(60):
        middle = 0.5 * (low + high)
        low, high = (middle, high) if at(middle)[0] < depth else (low, middle)
    return at(low)[1], low


@pytest.mark.parametrize(
    "kind, keys, force, area",
    [
        # I. N. Sneddon, Int. J. Eng. Sci. 3, 47 (1965)
        (
            "cone",
            "half_angle = 70.0",
            2.0 / math.pi * TANGENT * 25.0,
            math.pi * (2.0 / math.pi * TANGENT * 5.0) ** 2,
        ),
        ("punch", 'punch_radius = "20 nm"', 2.0 * 20.0 * 5.0, math.pi * 400.0),
        (
            "rounded cone",
            'half_angle = "70 deg"\ntip_radius = "10 nm"',
            rounded_cone(5.0)[0],
            math.pi * rounded_cone(5.0)[1] ** 2,
        ),
        # from grids with contacts of up to 900 points, which no table has
        (
            "pyramid",
            "half_angle = 70.0",
            0.73762 * TANGENT * 25.0,
            1.4785 * (TANGENT * 5.0) ** 2,
        ),
    ],
    ids=lambda each: each if isinstance(each, str) and "=" not in each else "",
)
def test_forces_and_areas_are_closed_forms_within_their_errors(kind, keys, force, area):
    (step,) = scene(kind, keys).relax(validity="ignore")
    assert step.converged
    assert abs(step.normal_force / (GPA * NM**2) - force) < 2.0 * step.force_error / (
        GPA * NM**2
    )
    assert abs(step.continuum_area / NM**2 - area) < 2.0 * step.area_error / NM**2
    assert step.force_error < 0.02 * step.normal_force
    assert step.area_error < 0.05 * step.continuum_area


def test_a_truncated_cone_is_between_its_end_and_its_side():
    keys = 'half_angle = 70.0\nend_radius = "10 nm"'
    (step,) = scene("truncated cone", keys).relax()
    punch, cone = 2.0 * 10.0 * 5.0, 2.0 / math.pi * TANGENT * 25.0
    force = step.normal_force / (GPA * NM**2)
    assert max(punch, cone) < force < punch + cone
    theory = scene("truncated cone", keys).bodies.force_at(5.0 * NM)
    assert step.normal_force == pytest.approx(theory, abs=2.0 * step.force_error)


def test_lengths_may_be_multiples_of_the_spacing():
    shape = scene("punch", 'punch_radius = "20 a0"').bodies.shape
    assert shape.punch_radius == pytest.approx(20.0 * NM)


def test_a_grid_without_a_given_spacing_fits_the_contact():
    text = TEXT.replace('spacing = "1 nm"', "")
    small, large = (
        scene("punch", f'punch_radius = "{radius} um"', text) for radius in (1, 10)
    )
    assert 40.0 < 1e3 * NM / small.spacing < 80.0
    assert large.spacing == pytest.approx(10.0 * small.spacing)


@pytest.mark.parametrize(
    "change, message",
    [
        (("[indenter]", '[sphere]\nradius = "9 nm"\n[indenter]'), "leave out one of"),
        (("[indenter]", "[roughness]\n[indenter]"), r"smooth, got \[roughness\]"),
        (("hardness", "periodic = true\nhardness"), "a free half space"),
        (("half_angle = 70.0", ""), r"\[indenter\] kind = 'cone' needs half_angle"),
        (("70.0", "95.0"), "half_angle must be > 0 and < 90 deg, got 95"),
        (("70.0", '"70 nm"'), "unknown unit of half_angle"),
        (('kind = "cone"', 'kind = "core"'), "did you mean 'cone'"),
        (("half_angle", "tip_radius = '2 a0'\nhalf_angle"), "has no tip_radius"),
        (("cone", "sphere"), r"a sphere is the section \[sphere\]"),
    ],
)
def test_wrong_sections_name_the_key(change, message):
    text = TEXT.format(kind="cone", keys="half_angle = 70.0").replace(*change, 1)
    with pytest.raises(ValueError, match=message):
        Scene.parse(text).check()


def test_a_shape_of_ones_own_is_pressed_and_has_no_theory():
    class Ridge(Indenter):
        kind = "ridge of a test"
        parameters = INDENTERS["cone"].parameters

        def __init__(self, half_angle):
            self.half_angle = half_angle

        def profile(self, x, y):
            return np.hypot(x, 3.0 * y) / math.tan(self.half_angle)

        def reach(self, level):
            return level * math.tan(self.half_angle)

    (step,) = scene("ridge of a test", "half_angle = 70.0").relax()
    (cone,) = scene("cone", "half_angle = 70.0").relax()
    assert 0.3 * cone.normal_force < step.normal_force < 0.9 * cone.normal_force
    INDENTERS.pop("ridge of a test")


def test_a_run_names_the_shape_and_draws_its_theory(tmp_path, capsys):
    file, folder = tmp_path / "cone.toml", tmp_path / "out"
    text = TEXT.format(kind="cone", keys='half_angle = "70 deg"\nmaterial = "Si3N4"')
    file.write_text(text)
    assert main(["run", str(file), "--out", str(folder)]) == 0
    printed = " ".join(capsys.readouterr().out.split())
    assert "indenter cone, half angle 70°" in printed
    assert "E* = 0.9966 GPa with Si3N4" in printed
    assert "Sneddon, cone" in printed
    assert (folder / "contact.png").exists()
    assert Scene.of_results(folder).identity == Scene.read(file).identity
    assert main(["plan", str(file), "--json"]) == 0
    assert json.loads(capsys.readouterr().out.splitlines()[0])


def test_a_punch_that_just_touches_has_a_view(tmp_path):
    file, folder = tmp_path / "punch.toml", tmp_path / "out"
    text = TEXT.format(kind="punch", keys='punch_radius = "8 nm"')
    file.write_text(text.replace('["5 nm"]', '[0.0, "1 nm"]'))
    assert main(["run", str(file), "--out", str(folder), "--quiet"]) == 0
    first, second = read(folder / "view.traj", ":")
    assert np.isfinite(first.positions).all()
    assert max(len(first), len(second)) < 10_000  # the sides are not drawn to their end
