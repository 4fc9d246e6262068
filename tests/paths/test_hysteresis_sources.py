"""Energy that patches of adhesion and waves cost, against step and spacing."""

import numpy as np
import pytest

from ase_roughcontact import (
    DugdaleWall,
    HeightMap,
    Heterogeneity,
    RoughContact,
    RoughSphere,
    adhesion_loop,
    substrate,
)

RADIUS, WORK = 100.0, 0.02
UNIT = np.cbrt(WORK**2 * RADIUS)


def patches(x, y):
    return 0.9 * np.cos(2 * np.pi * x / 32.0) * np.cos(2 * np.pi * y / 32.0)


def waves(spacing):
    x = spacing * np.arange(-128, 129)
    return HeightMap(0.2 * np.cos(2 * np.pi * np.hypot(x[:, None], x) / 20.0), spacing)


def lost_energy(step, spacing, rough=None, adhesion=None):
    """Return the energy lost in a loop, in units of (w^5 R^4/E*^2)^(1/3)."""
    sphere = RoughSphere(RADIUS, rough)
    atoms = substrate("Cu", (16, 16), sphere, spacing=spacing)
    wall = DugdaleWall(WORK, 0.8)
    atoms.calc = RoughContact(sphere, 1.0, wall, heterogeneity=adhesion)
    options = {"window": "auto", "validity": "ignore"}
    loop = adhesion_loop(atoms, UNIT, step * UNIT, **options)
    return loop.dissipated_energy / np.cbrt(WORK**5 * RADIUS**4)


@pytest.mark.slow  # loops of up to 75 x 75 atoms
@pytest.mark.parametrize(
    "case, energy", [("smooth", 0.0), ("patches", 0.121), ("waves", 0.532)]
)
def test_lost_energy_converges_with_step_and_spacing(case, energy):
    for step, spacing in ((0.5, 1.0), (0.25, 1.0), (0.5, 0.5)):
        rough = waves(spacing) if case == "waves" else None
        adhesion = Heterogeneity(patches) if case == "patches" else None
        lost = lost_energy(step, spacing, rough, adhesion)
        assert lost == pytest.approx(energy, rel=0.03, abs=0.01)


def test_loop_continues_after_states_in_which_atoms_overlap_with_a_hard_wall():
    sphere = RoughSphere(20.0)
    atoms = substrate("Cu", (16, 16), sphere, spacing=1.0)
    atoms.calc = RoughContact(sphere, 1.0, DugdaleWall(0.05, 0.6))
    options = {"window": "auto", "validity": "ignore", "max_steps": 4}
    loop = adhesion_loop(atoms, 0.2, 0.2, smallest_step=0.1, **options)
    assert not all(state.converged for state in loop.approach)
    assert loop.retraction[-1].repulsive_atoms == 0
