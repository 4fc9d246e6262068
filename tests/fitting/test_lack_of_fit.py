"""Fits of curves with forces that are not in the scene, and of curves without noise."""

from dataclasses import replace

import numpy as np
import pytest
from force_curves import sampled

from ase_roughcontact import cantilever_curve
from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.fit import fit_curve
from ase_roughcontact.fitting.least_squares import Trial, solve
from ase_roughcontact.path_kinds.loop.instabilities import AdhesionLoop
from ase_roughcontact.scene import Scene, relax_loop

NN = UNITS["nN"]
BASELINE = ["force_offset", "force_slope"]
SCENE = """
[substrate]
model = "atoms"
spacing = "0.5 nm"
contact_modulus = 70.0
hardness = inf
shape = {shape}
[sphere]
radius = "20 nm"
[interaction]
kind = "{kind}"
work_of_adhesion = {work}
attraction_range = "0.165 nm"
[path]
kind = "loop"
deepest = "0.1 nm"
tolerance = 5e-3
cantilever = 5.0
"""


def scene(kind, work=0.05, shape='"auto"'):
    return Scene.parse(SCENE.format(kind=kind, work=work, shape=shape))


def curve_of(scene, noise=0.1 * NN, capillary=0.0):
    """Curve at equal steps of the base, with a further tension in contact (nN)."""
    loop = relax_loop(scene, validity="ignore")
    branches = (
        tuple(
            replace(s, normal_force=s.normal_force - NN * capillary)
            if s.repulsive_atoms
            else s
            for s in branch
        )
        for branch in (loop.approach, loop.retraction)
    )
    loop = AdhesionLoop(*branches, loop.approach_jumps, loop.retraction_jumps)
    exact = cantilever_curve(loop, scene.cantilever)
    highest = max(exact.approach.distance.max(), exact.retraction.distance.max())
    return sampled(exact, highest + 10.0, 150, noise, zero=30.0)


@pytest.mark.parametrize("kind", ["adhesive", "full"])
def test_a_fit_of_the_right_scene_has_no_warnings(kind):
    found = fit_curve(scene(kind, work=0.06), curve_of(scene(kind)))
    assert found.warnings == ()
    assert abs(found.values[0] - 0.05) < 2.0 * found.errors[0]


def test_a_curve_that_turns_in_tension_has_not_the_wrong_sign():
    stiff = {"path.deepest": "0.05 nm", "path.cantilever": "20 N/m"}
    with pytest.warns(UserWarning, match="is a lower bound"):
        curve = curve_of(scene("adhesive").with_values(stiff))
    nearest = curve.force[np.argmin(curve.base)]
    assert nearest < -0.5 * NN and curve.doubts == []


@pytest.mark.parametrize("baseline", [[], BASELINE])
def test_a_van_der_waals_tail_is_noticed_by_a_wall_of_short_range(baseline):
    free = ["work_of_adhesion", *baseline]
    found = fit_curve(scene("adhesive", work=0.06), curve_of(scene("full")), free)
    text = " ".join(found.warnings)
    assert "the snap-in of the fit is" in text and "--free attraction_range" in text


def test_a_capillary_force_is_noticed_at_the_snap_in():
    found = fit_curve(scene("full", work=0.06), curve_of(scene("full"), capillary=5.0))
    assert found.values[0] > 0.08  # of 0.05: the force acts like adhesion in contact
    (warning,) = found.warnings
    assert "the snap-in of the fit is" in warning and "capillary" in warning


@pytest.mark.parametrize("shape", ["[24, 24]", '"auto"'])
def test_a_fit_of_a_curve_without_noise_converges_on_any_window(shape):
    curve = curve_of(scene("adhesive", shape="[20, 20]"), noise=0.0)
    found = fit_curve(scene("adhesive", work=0.06, shape=shape), curve)
    assert found.converged
    assert found.values[0] == pytest.approx(0.05, rel=0.01)


class Line:
    """Model y = a x of three points, with a parameter b that changes nothing."""

    names, units, reasons = ("a", "b"), ("", ""), ""
    abscissa = ordinate = "y", ""
    noise = error = 1.0
    start = np.array([1.0, 1.0])
    bounds = np.array([[0.0, 0.0], [9.0, 9.0]])
    measured = np.array([1.0, 2.0, 3.0]), np.array([2.0, 4.1, 5.9])

    def values(self, x):
        return x

    def trial(self, x):
        places, heights = self.measured
        jacobian = np.column_stack([places, np.zeros(3)])
        fitted = x[0] * places
        return Trial(x, fitted - heights, jacobian, np.ones(3, bool), fitted)

    def changes(self, trial):
        return {}


def test_the_error_of_a_parameter_that_changes_nothing_is_not_known():
    fit, _, _ = solve(Line(), None)
    places, heights = Line.measured
    slope = places @ heights / (places @ places)
    variance = np.sum((slope * places - heights) ** 2) / (places @ places)
    error = np.sqrt(variance)
    assert abs(fit.values[0] - slope) < 0.1 * error  # where a fit ends
    np.testing.assert_allclose(fit.errors, [error, np.nan], rtol=0.1)
    (warning,) = fit.warnings
    assert warning.startswith("the error of b is not known")
