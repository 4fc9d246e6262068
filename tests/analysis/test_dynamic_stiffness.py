"""Stiffness of a contact on a viscoelastic solid under a small oscillation."""

from types import SimpleNamespace

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.analysis import dynamic_stiffness


@pytest.mark.parametrize("frequency", [0.02, 0.2, 2.0])
@pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")
def test_stiffness_follows_from_the_complex_modulus(frequency):
    creep = rc.Creep.standard_solid(relaxed=0.3, time=1.0)
    sphere = rc.RoughSphere(radius=400.0)
    atoms = atoms_under(
        sphere, rc.HardWall(), (40, 40), solid=rc.Viscoelastic(1.0, creep)
    )
    path = rc.Schedule(0.0).ramp(0.5, time=1.0).hold(40.0)
    path = path.oscillate(0.002, frequency, cycles=3)
    steps = list(rc.time_path(atoms, penetrations=path, tolerance=1e-4))
    # of a fixed contact 2 a E*, with the radius a of Hertz's theory
    expected = 2.0 * np.sqrt(400.0 * 0.5) * creep.modulus(2.0 * np.pi * frequency)
    found = dynamic_stiffness(steps, frequency)
    assert abs(found - expected) < 0.03 * abs(expected)


def test_phase_is_positive_if_the_force_is_ahead_of_the_penetration():
    times = np.linspace(0.0, 4.0, 101)
    steps = [
        SimpleNamespace(
            time=t,
            penetration=3.0 + 0.1 * np.sin(2 * np.pi * t) + 0.01 * t,
            normal_force=1.0 + 0.5 * np.sin(2 * np.pi * t + 0.4) - 0.02 * t,
        )
        for t in times
    ]
    assert dynamic_stiffness(steps, 1.0) == pytest.approx(5.0 * np.exp(0.4j))


def test_errors_say_what_is_missing():
    steps = [SimpleNamespace(time=t, penetration=1.0, normal_force=1.0) for t in (0, 1)]
    with pytest.raises(ValueError, match="2 cycles"):
        dynamic_stiffness(steps, 1.0)
