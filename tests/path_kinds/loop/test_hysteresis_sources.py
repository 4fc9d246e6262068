"""Energy that patches of adhesion and waves cost, against step and spacing."""

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc

RADIUS, WORK = 100.0, 0.02
UNIT = np.cbrt(WORK**2 * RADIUS)


def patches(x, y):
    return 0.9 * np.cos(2 * np.pi * x / 32.0) * np.cos(2 * np.pi * y / 32.0)


def waves(spacing):
    x = spacing * np.arange(-128, 129)
    return rc.HeightMap(
        0.2 * np.cos(2 * np.pi * np.hypot(x[:, None], x) / 20.0), spacing
    )


def lost_energy(step, spacing, rough=None, adhesion=None):
    """Return the energy lost in a loop, in units of (w^5 R^4/E*^2)^(1/3)."""
    sphere = rc.RoughSphere(RADIUS, rough)
    wall = rc.DugdaleWall(WORK, 0.8)
    atoms = atoms_under(sphere, wall, (16, 16), heterogeneity=adhesion, spacing=spacing)
    options = {"window": "auto", "validity": "ignore"}
    loop = rc.adhesion_loop(atoms, deepest=UNIT, step=step * UNIT, **options)
    return loop.dissipated_energy / np.cbrt(WORK**5 * RADIUS**4)


@pytest.mark.slow  # loops of up to 75 x 75 atoms
@pytest.mark.parametrize(
    "case, energy", [("smooth", 0.0), ("patches", 0.121), ("waves", 0.532)]
)
def test_lost_energy_converges_with_step_and_spacing(case, energy):
    for step, spacing in ((0.5, 1.0), (0.25, 1.0), (0.5, 0.5)):
        rough = waves(spacing) if case == "waves" else None
        adhesion = rc.Heterogeneity(patches) if case == "patches" else None
        lost = lost_energy(step, spacing, rough, adhesion)
        assert lost == pytest.approx(energy, rel=0.03, abs=0.01)


@pytest.mark.slow  # loops of up to 90 x 90 atoms
def test_random_roughness_pins_the_edge_of_a_contact():
    """Energy is lost all along the way; a smooth sphere jumps in and out once."""
    wall, unit = rc.DugdaleWall(0.1, 0.8), np.cbrt(0.1**2 * 200.0)

    def lost(rough, depth):
        sphere = rc.RoughSphere(200.0, rough)
        atoms = atoms_under(sphere, wall, (16, 16))
        options = {"window": "auto", "validity": "ignore", "tolerance": 3e-3}
        loop = rc.adhesion_loop(atoms, deepest=depth * unit, step=0.5 * unit, **options)
        assert all(state.converged for state in (*loop.approach, *loop.retraction))
        assert loop.dissipated_energy == pytest.approx(
            loop.energy_lost_in_jumps, rel=0.02
        )
        return loop.dissipated_energy / np.cbrt(0.1**5 * 200.0**4)

    smooth = [lost(None, depth) for depth in (0.5, 2.0)]
    assert smooth[1] == pytest.approx(smooth[0], rel=0.005)
    rough = rc.SelfAffine(0.2, 0.8, 12.0, 24.0, seed=1, domain=192.0)
    assert lost(rough, 2.0) > 1.3 * lost(rough, 0.5) > 1.5


@pytest.mark.slow  # 92 states of up to 58 x 58 atoms
def test_states_next_to_instabilities_converge():
    """There the reaction of the wall needs a stiffer augmented Lagrangian."""
    sphere = rc.RoughSphere(RADIUS, rc.SelfAffine(0.1, 0.8, 8.0, 32.0, seed=1))
    atoms = atoms_under(sphere, rc.PowerLawWall(0.05, 0.5), (16, 16))
    unit = np.cbrt(0.05**2 * RADIUS)
    options = {"window": "auto", "validity": "ignore", "tolerance": 3e-3}
    loop = rc.adhesion_loop(atoms, deepest=0.5 * unit, step=0.5 * unit, **options)
    assert all(state.converged for state in (*loop.approach, *loop.retraction))


@pytest.mark.filterwarnings("ignore:the pull-off force")
def test_loop_continues_after_states_in_which_atoms_overlap_with_a_hard_wall():
    sphere = rc.RoughSphere(20.0)
    atoms = atoms_under(sphere, rc.DugdaleWall(0.05, 0.6), (16, 16))
    options = {"window": "auto", "validity": "ignore", "max_steps": 4}
    loop = rc.adhesion_loop(atoms, deepest=0.2, step=0.2, smallest_step=0.1, **options)
    assert not all(state.converged for state in loop.approach)
    assert loop.retraction[-1].repulsive_atoms == 0
