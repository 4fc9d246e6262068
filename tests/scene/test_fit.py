"""Fits of force curves: derivatives, recovered parameters, errors."""

import re

import numpy as np
import pytest

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.cli import main
from ase_roughcontact.cli.curves import read_curve
from ase_roughcontact.scene import Scene
from ase_roughcontact.scene.fit import (
    FREE,
    fit_curve,
    forces_and_derivatives,
    smooth_fit,
)
from ase_roughcontact.theory import MaugisDugdale

SCENE = """
[substrate]
spacing = 3.0
shape = [40, 40]
contact_modulus = 30.0
hardness = inf
[sphere]
radius = "15 nm"
[roughness]
rms_slope = 0.05
long_wavelength = 16.0
seed = {seed}
[interaction]
kind = "adhesive"
work_of_adhesion = {work}
[path]
control = "height"
values = [0.0]
"""
DEPTHS = np.linspace(2.5, -0.2, 8)
NOISE = 0.02 * UNITS["nN"]


def scene(work=0.1, seed=1):
    return Scene.parse(SCENE.format(work=work, seed=seed))


def heights_of(made):
    return contact_of(made.atoms()).first_contact - DEPTHS


def test_derivatives_are_those_of_differences():
    heights = heights_of(scene())
    _, derivatives = forces_and_derivatives(scene(), heights, list(FREE))
    for i, (name, value) in enumerate(
        {"work_of_adhesion": 0.1, "contact_modulus": 30.0, "radius": 15.0}.items()
    ):
        key, unit = FREE[name]
        step = 2e-5 * value
        ends = (
            scene().with_values({key: f"{v:.17g} nm" if unit == "nm" else v})
            for v in (value - step, value + step)
        )
        low, high = (forces_and_derivatives(end, heights, [])[0] for end in ends)
        expected = (high - low) / (2 * step)
        size = abs(expected).max()
        np.testing.assert_allclose(derivatives[:, i], expected, atol=2e-4 * size)


@pytest.mark.parametrize("seed", [1])
def test_the_work_of_adhesion_of_a_rough_tip_is_recovered(seed):
    true = scene(work=0.1, seed=seed)
    forces, _ = forces_and_derivatives(true, heights_of(true), [])
    forces += NOISE * np.random.default_rng(seed).normal(size=forces.size)
    shifted = DEPTHS + 0.3  # the zero of the depth is not known
    fit = fit_curve(scene(work=0.07, seed=seed), shifted, forces)
    assert fit.converged
    assert fit.names == ("work_of_adhesion", "height z0")
    assert abs(fit.values[0] - 0.1) < 3 * fit.errors[0] < 0.02
    z0 = contact_of(true.atoms()).first_contact + 0.3
    assert abs(fit.values[1] - z0) < 3 * fit.errors[1] < 0.1
    assert fit.noise == pytest.approx(NOISE, rel=0.6)
    assert abs(fit.correlation[0, 1]) < 1.0 == pytest.approx(fit.correlation[0, 0])
    assert "work_of_adhesion" in str(fit) and "J/m²" in str(fit)


def test_the_fit_of_a_smooth_sphere_is_wrong_for_a_rough_tip():
    true = scene(seed=5).with_values({"roughness.rms_slope": 0.1})
    forces, _ = forces_and_derivatives(true, heights_of(true), [])
    smooth = smooth_fit(true, DEPTHS, forces)
    assert smooth.work_of_adhesion < 0.06
    assert np.abs(smooth.fitted - forces).max() > 10 * NOISE


def test_the_fit_of_a_smooth_sphere_is_that_of_theory():
    made = scene()
    sphere = MaugisDugdale(
        made.radius,
        made.contact_modulus,
        made.wall.work_of_adhesion,
        attraction_range=made.wall.attraction_range,
    )
    depth, force = sphere.curve(40.0)
    stable = slice(int(np.argmin(force)), None, 20)
    order = np.argsort(depth[stable])
    smooth = smooth_fit(made, depth[stable][order] + 0.7, force[stable][order])
    assert smooth.work_of_adhesion == pytest.approx(0.1, rel=1e-2)


def test_the_command_fits_a_table_and_draws_it(tmp_path, capsys):
    true = scene()
    forces, _ = forces_and_derivatives(true, heights_of(true), [])
    rows = zip(DEPTHS / 10, forces / UNITS["nN"], strict=True)
    lines = ["depth (nm),force (nN)", *(f"{d},{f}" for d, f in rows)]
    (tmp_path / "curve.csv").write_text("\n".join(lines))
    (tmp_path / "scene.toml").write_text(SCENE.format(work=0.08, seed=1))
    picture = tmp_path / "fit.png"
    files = [str(tmp_path / name) for name in ("curve.csv", "scene.toml")]
    assert main(["fit", *files, "--picture", str(picture)]) == 0
    text = capsys.readouterr().out
    assert re.search(r"work_of_adhesion +0\.1 ± \S+ J/m²", text)
    assert "smooth sphere: work_of_adhesion 0.0" in text
    assert picture.stat().st_size > 10_000


def test_distance_and_deflection_of_a_cantilever_give_the_depth(tmp_path):
    file = tmp_path / "curve.csv"
    file.write_text(
        "branch,distance (nm),deflection (Å),Force (pN)\n"
        "approach,5,1,300\nretraction,4,-2,-500\nretraction,6,0,0\n"
    )
    depth, force = read_curve(file, "retraction")
    np.testing.assert_allclose(depth, [-38.0, -60.0])
    np.testing.assert_allclose(force, [-0.5 * UNITS["nN"], 0.0])
    file.write_text("depth (nm)\n1.0\n")
    with pytest.raises(ValueError, match=r"needs the columns force \(nN\) and depth"):
        read_curve(file)


@pytest.mark.parametrize(
    "depth, free, message",
    [
        ([1.0, 2.0], ["radius"], "needs .* at least 3 points"),
        (DEPTHS, ["hurst"], "unknown free parameter 'hurst'"),
    ],
)
def test_wrong_fits_are_refused(depth, free, message):
    with pytest.raises(ValueError, match=message):
        fit_curve(scene(), depth, np.zeros(len(depth)), free)
