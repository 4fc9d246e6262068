"""Fits of scenes with an indenter of another shape than a sphere."""

import math

import numpy as np
import pytest

from ase_roughcontact._util.units import UNITS
from ase_roughcontact.fitting.fit import fit_curve
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.scene import Scene

NM, NN, STIFFNESS = UNITS["nm"], UNITS["nN"], 50.0 * UNITS["N/m"]
CONE = """
[substrate]
contact_modulus = "1.4 GPa"
spacing = "2 nm"
hardness = inf
[indenter]
kind = "cone"
half_angle = 70.0
[interaction]
kind = "hard"
"""


def curve():
    """Approach of a cone to 1 GPa, by Sneddon: N = 2/pi E* tan(theta) d^2."""
    depth = np.linspace(0.0, 4.0, 300)  # nm
    force = 2.0 / math.pi * math.tan(math.radians(70.0)) * depth**2  # nN
    base = np.linspace(4.0, -4.0 - force[-1] / 50.0, 60)
    measured = np.interp(-base, depth + force / 50.0, force)
    return ForceCurve(-base * NM - measured * NN / STIFFNESS, measured * NN, STIFFNESS)


@pytest.mark.slow
def test_the_modulus_under_a_cone_is_fitted():
    fit = fit_curve(Scene.parse(CONE), curve(), ["contact_modulus"])
    assert fit.converged
    assert fit.values[0] == pytest.approx(1.0, rel=0.005)


def test_a_cone_has_no_radius_to_fit():
    with pytest.raises(ValueError, match="can't be fitted: the indenter is a cone"):
        fit_curve(Scene.parse(CONE), curve(), ["radius"])
