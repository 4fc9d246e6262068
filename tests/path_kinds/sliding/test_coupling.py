"""Coupling of normal and lateral motion on sliding paths, against exact results."""

from itertools import pairwise

import numpy as np
import pytest
from ase.io import read
from scipy.integrate import quad, trapezoid
from sliding_contacts import (
    MU,
    assert_resumed,
    atoms_on,
    follow,
    followed,
    stepper_of,
)

from ase_roughcontact import (
    Coulomb,
    HeightMap,
    LennardJones93,
    Output,
    PlasticWall,
    Tresca,
    Viscoelastic,
    pressure_of,
    sliding_path,
)
from ase_roughcontact.elasticity import Cubic, Isotropic, cross_kernel, love_kernel
from ase_roughcontact.elasticity.cell_kernels import cerruti_kernel
from ase_roughcontact.elasticity.creep import Creep
from ase_roughcontact.path_kinds.sliding.specification import SlidingSpecification
from ase_roughcontact.path_kinds.sliding.steps import SlidingSteps
from ase_roughcontact.paths import follow as paths

pytestmark = pytest.mark.filterwarnings("ignore::ase_roughcontact.ValidityWarning")

STICKS, SOLVED = Coulomb(1e6), {"coupling": "solved"}
COPPER = Cubic(168.4, 121.4, 75.4)


def coupled(stepper, *args):
    return follow(stepper, *args, **SOLVED)


def punch_of(n, radius, poisson):
    """Flat cylinder, in one step: of proportional tractions, it has no history."""
    i = np.arange(n) - n // 2
    heights = np.where(np.hypot(i[:, None], i) < radius, 0.0, 1e3)
    indenter = HeightMap(heights, spacing=1.0)
    return stepper_of(n, Isotropic(1.0, poisson), indenter=indenter, offset=0.0)


def stick_radius(step):
    """Return the radius of the area that sticks over the radius of the contact."""
    return np.sqrt(step.stick_area / (step.stick_area + step.slip_area))


def adhesive_factor(nu):
    """Stiffness of a punch that sticks over that without friction; Johnson, 3.8."""
    return (1.0 - nu) * np.log(3.0 - 4.0 * nu) / (1.0 - 2.0 * nu)


@pytest.mark.parametrize("poisson", [0.0, 0.3])
def test_load_of_a_punch_that_sticks(poisson):
    ratios = []
    for n in (33, 65):
        loads = [
            follow(punch_of(n, 0.45 * n, poisson), 1.0, STICKS, [0.0], coupling=c)[0]
            for c in ("solved", "neglected")
        ]
        ratios.append(loads[0].normal_force / loads[1].normal_force)
    expected = adhesive_factor(poisson)
    assert ratios[1] == pytest.approx(expected, rel=2e-3)
    assert 2.0 * ratios[1] - ratios[0] == pytest.approx(expected, rel=5e-4)


@pytest.mark.parametrize("poisson", [0.0, pytest.param(0.3, marks=pytest.mark.slow)])
def test_load_of_a_sphere_that_sticks_as_it_is_loaded(poisson):
    # D. A. Spence, Proc. R. Soc. A 305, 55 (1968); F. M. Borodich, L. M. Keer, Proc. R.
    # Soc. A 460, 507 (2004): a^2 = 2 I R delta, and dP/d delta as for a punch
    n, depth, solid = 32, 0.8, Isotropic(1.0, poisson)
    beta = np.log(3.0 - 4.0 * poisson) / (2.0 * np.pi)
    integral, _ = quad(
        lambda t: t * np.cos(beta * np.log((1.0 - t) / (1.0 + t))), 0.0, 1.0
    )
    expected = adhesive_factor(poisson) * np.sqrt(2.0 * integral)
    alone = follow(stepper_of(n, solid), depth, STICKS, [0.0], coupling="neglected")
    loads = []
    for steps in (8, 16):  # the error is linear in their length
        depths = depth * np.arange(1, steps + 1) / steps
        last = coupled(stepper_of(n, solid), depths, STICKS, np.zeros(steps))[-1]
        assert last.converged
        loads.append(last.normal_force / alone[0].normal_force)
    assert 2.0 * loads[1] - loads[0] == pytest.approx(expected, rel=3e-3)


@pytest.mark.parametrize(
    "poisson, mu", [pytest.param(0.0, 0.3, marks=pytest.mark.slow), (0.3, 0.15)]
)
def test_stick_radius_is_constant_under_growing_load(poisson, mu):
    # and the same as for a punch: D. A. Spence, J. Elasticity 5, 297 (1975)
    punch = coupled(punch_of(65, 29.0, poisson), 1.0, Coulomb(mu), [0.0])[0]
    depths = 1.2 * np.geomspace(0.05, 1.0, 15)
    solid = Isotropic(1.0, poisson)
    steps = coupled(stepper_of(48, solid), depths, Coulomb(mu), np.zeros(15))
    radii = [stick_radius(step) for step in steps[-6:]]
    assert np.ptp(radii) < 0.02
    assert np.mean(radii) == pytest.approx(stick_radius(punch), rel=0.06)


@pytest.mark.parametrize("bodies", [{"poisson": 0.5}, {"poisson": 0.2, "dundurs": 0.0}])
def test_incompressible_or_equal_bodies_are_not_coupled(bodies):
    path, solid = [0.0, 0.2, 0.5], Isotropic(1.0, **bodies)
    solved, neglected = (
        follow(stepper_of(32, solid), 0.5, Coulomb(MU), path, coupling=coupling)
        for coupling in ("solved", "neglected")
    )
    for a, b in zip(solved, neglected, strict=True):
        forces = b.normal_force, b.lateral_force_x
        assert (a.normal_force, a.lateral_force_x) == forces
        assert a.alternations == b.alternations == 0


def dense_matrix(n, solid):
    """Return the compliance of tractions along x and y, and of pressure."""
    i, j = (index.ravel() for index in np.indices((n, n)))
    vectors, modulus = (i[:, None] - i, j[:, None] - j, 1.0), solid.contact_modulus
    zz = love_kernel(*vectors, modulus)
    xx, yy, xy = cerruti_kernel(*vectors, modulus, solid.poisson)
    cx, cy = cross_kernel(*vectors, modulus, solid.coupling)
    return np.block([[xx, xy, cx], [xy, yy, cy], [cx.T, cy.T, zz]])


def overlap_of(n, depth):
    i, j = (index.ravel() for index in np.indices((n, n)))
    r2 = (i - n / 2 + 0.5) ** 2 + (j - n / 2 + 0.5) ** 2
    return depth - (r2 - r2.min()) / (2 * 10.0 * n)


def fields(state):
    history = state.history
    return np.stack([history["traction_x"], history["traction_y"], state.pressure])


@pytest.mark.parametrize("depths", [(0.2, 0.25), (0.25, 0.1)])
@pytest.mark.parametrize("control", ["displacements", "forces"])
@pytest.mark.parametrize("poisson, mu", [(-0.5, 1.0), (0.0, MU), (0.3, MU), (0.0, 0.1)])
def test_conditions_of_friction_and_contact_hold_with_dense_matrices(
    poisson, mu, control, depths
):
    n, solid = 12, Isotropic(1.0, poisson)
    stepper, matrix = stepper_of(n, solid, accuracy=1e-8), dense_matrix(n, solid)
    path, state = np.array([[0.0, 0.0], [0.03, 0.02]]), np.zeros((3, n * n))
    law, at = Coulomb(mu), np.zeros(2)
    steps = SlidingSteps(
        stepper, SlidingSpecification(depths, law, path, control, coupling="solved")
    )
    for step, left in paths.follow_states(steps):
        assert step.converged
        old, state = state, fields(left.state).reshape(3, -1)
        before, at = at, np.array([step.lateral_x, step.lateral_y])
        moved = (matrix @ (state - old).ravel()).reshape(3, -1)[:2]
        moved -= (at - before)[:, None]
        depth, pressure = (matrix @ state.ravel())[2 * n * n :], state[2]
        gap, bound = depth - overlap_of(n, step.penetration), mu * pressure
        size = abs(depth).max()
        assert min(gap.min() / size, pressure.min()) > -1e-6
        assert abs(gap[pressure > 0.0]).max() < 1e-6 * size
        traction = np.hypot(*state[:2])
        assert (traction - bound).max() < 1e-9
        slips = np.hypot(*moved) > 1e-6 * size
        slips &= pressure > 0.0
        assert step.slip_area == np.count_nonzero(slips) > 0
        assert step.stick_area == step.contact_area - step.slip_area
        if mu > 0.1 and depths[1] > depths[0]:
            assert step.stick_area > 0.0
        assert traction[slips] == pytest.approx(bound[slips], rel=1e-5)
        work = (moved * state[:2]).sum(axis=0)[slips]  # against the tractions
        lost = -np.hypot(*moved)[slips] * traction[slips]
        assert work == pytest.approx(lost, abs=1e-6 * abs(lost).max())


def test_work_of_a_sphere_that_sticks_is_stored():
    depths = np.linspace(0.02, 0.4, 20)
    stepper = stepper_of(20, Isotropic(1.0, 0.0))
    steps = coupled(stepper, depths, STICKS, np.zeros(20))
    work = trapezoid([step.normal_force for step in steps], depths)
    stored = [step.energy + step.lateral_energy for step in steps]
    assert abs(steps[-1].lateral_energy) > 0.03 * stored[-1]
    assert work == pytest.approx(stored[-1] - stored[0], rel=2e-3)


def missing_energy(steps):
    """Return the work on the indenter that is neither stored nor dissipated."""
    turn = 0.4 * np.sin(np.linspace(0.0, 5.0, steps))
    depths = np.linspace(0.3, 0.6, steps)
    stepper = stepper_of(24, Isotropic(1.0, 0.1))
    found = coupled(stepper, depths, Coulomb(MU), turn)
    work = 0.0
    for a, b in pairwise(found):
        along, down = b.lateral_x - a.lateral_x, b.penetration - a.penetration
        work += 0.5 * (a.lateral_force_x + b.lateral_force_x) * along
        work += 0.5 * (a.normal_force + b.normal_force) * down
    first, last = found[0], found[-1]
    for name in ("energy", "lateral_energy", "dissipated_energy"):
        work -= getattr(last, name) - getattr(first, name)
    return work / last.dissipated_energy


def test_work_on_the_indenter_is_stored_or_dissipated():
    # up to an error that decreases with the length of the steps, as without coupling
    long, short = missing_energy(15), missing_energy(30)
    assert abs(short) < min(0.03, 0.6 * abs(long))


WALLS = {
    "soft": LennardJones93.repulsive(1.0, 1.0),
    "adhesive": LennardJones93.adhesive(1.0, 1.0, 0.01),
    "plastic": PlasticWall(0.05, permanent=True),
}


@pytest.mark.parametrize("wall", WALLS)
def test_all_walls_are_coupled(wall):
    path, solid, law = [0.0, 0.1, 0.3], Isotropic(1.0, 0.0), Coulomb(MU)
    solved, neglected = (
        follow(stepper_of(24, solid, WALLS[wall]), 0.6, law, path, coupling=coupling)
        for coupling in ("solved", "neglected")
    )
    for a, b in zip(solved, neglected, strict=True):
        assert a.converged
        assert a.alternations > 1
        assert a.normal_force == pytest.approx(b.normal_force, rel=0.1)
    # tractions outward from the axis lift the surface
    assert solved[0].normal_force > 1.02 * neglected[0].normal_force


@pytest.mark.parametrize("solid", [Isotropic(1.0, 0.1), COPPER])
def test_periodic_and_anisotropic_solids_are_coupled(solid):
    for periodic in (False, True):
        stepper = stepper_of(32, solid, periodic=periodic)
        ((first, left),) = followed(stepper, 0.1, Coulomb(MU), [0.0], **SOLVED)
        assert first.converged
        assert first.lateral_energy < 0.0
        x, y = (left.state.history[f"displacement_{axis}"] for axis in "xy")
        i, j = np.indices((32, 32)) - 15.5
        assert (x * i + y * j).sum() < 0.0  # towards the contact
        assert x == pytest.approx(-x[::-1], abs=1e-6 * abs(x).max())


def test_bodies_exchanged_have_opposite_coupling_and_the_same_contact():
    # mirrored, tractions and displacements change their sign
    found = []
    for beta in (0.3, -0.3):
        stepper = stepper_of(32, Isotropic(1.0, 0.1, beta))
        ((_, left),) = followed(stepper, 0.5, Coulomb(MU), [0.0], **SOLVED)
        found.append(fields(left.state))
    assert found[1][2] == pytest.approx(found[0][2], abs=1e-6)
    assert found[1][:2] == pytest.approx(-found[0][:2], abs=1e-6)


@pytest.mark.parametrize("size", [32, 48])
def test_automatic_windows_give_the_results_of_fixed_ones(size):
    depths, path = [0.2, 0.4, 0.5, 0.1], [0.0, 0.1, 0.2, 0.2]
    fixed, automatic = (
        coupled(stepper_of(size, window=window), depths, Coulomb(MU), path)
        for window in ("fixed", "auto")
    )
    for a, b in zip(fixed, automatic, strict=True):
        assert b.converged
        assert b.normal_force == pytest.approx(a.normal_force, rel=1e-4)
        largest = fixed[-1].lateral_force_x
        assert b.lateral_force_x == pytest.approx(a.lateral_force_x, abs=1e-3 * largest)


PATH = np.array([0.0, 0.2, 0.5, 0.3, -0.2])
DEPTHS = np.array([1.0, 1.5, 2.0, 1.8, 1.0])
SOLID = Isotropic(0.8, 0.1)


def test_a_killed_path_is_resumed(tmp_path):
    names = "normal_force", "lateral_force_x", "dissipated_energy"
    options = {"bases": PATH, "spring": 3.0}
    assert_resumed(tmp_path, SOLID, DEPTHS, "all", names, **options, **SOLVED)
    files = Output(trajectory=tmp_path / "p.traj", resume=True)
    with pytest.raises(ValueError, match="coupling"):
        list(
            sliding_path(
                atoms_on(SOLID),
                Coulomb(MU),
                penetrations=DEPTHS,
                **options,
                output=files,
            )
        )


def test_frames_have_the_displacements_by_pressure_and_tractions(tmp_path):
    output = Output(trajectory=tmp_path / "p.traj")
    options = {"displacements": [0.0, 0.3], "coupling": "solved"}
    law, atoms = Coulomb(MU), atoms_on(SOLID)
    last = list(sliding_path(atoms, law, penetrations=1.0, **options, output=output))[
        -1
    ]
    frame = read(tmp_path / "p.traj")
    origin = np.array(frame.info["lattice"]["origin"])[:, None]
    x, y = origin + 2.5 * np.indices((32, 32)).reshape(2, -1)
    touching = pressure_of(frame).ravel() > 0.0
    heights = frame.positions[-1, 2] + (x**2 + y**2) / 400.0
    gap = heights - frame.positions[:-1, 2]
    assert abs(gap[touching]).max() < 1e-4
    assert gap[~touching].min() > 0.0
    force = [last.lateral_force_x, last.lateral_force_y]
    assert atoms.calc.get_property("lateral_force", atoms) == pytest.approx(
        force, abs=1e-9
    )
    assert atoms.get_potential_energy() == pytest.approx(last.energy)


def test_coupling_that_does_not_converge_is_reported(monkeypatch):
    monkeypatch.setattr("ase_roughcontact.path_kinds.sliding.steps.MAX_ALTERNATIONS", 2)
    (step,) = coupled(stepper_of(32, Isotropic(1.0, 0.0)), 0.5, Coulomb(MU), [0.0])
    assert not step.converged
    assert "normal and lateral motion do not agree after 2 alternations" in step.message


def test_bounds_that_jump_may_have_no_solution():
    # atoms in contact touch no longer when they carry tractions
    stepper = stepper_of(32, Isotropic(1.0, 0.0), WALLS["soft"])
    (step,) = coupled(stepper, 0.6, Tresca(0.01), [0.0])
    assert not step.converged
    assert "a bound that jumps" in step.message
    assert "give a friction coefficient, too" in step.message


def test_coupled_atoms_go_on_with_coupling():
    atoms, law = atoms_on(SOLID), Coulomb(MU)
    list(
        sliding_path(
            atoms, law, penetrations=1.0, displacements=[0.0, 0.3], coupling="solved"
        )
    )
    with pytest.raises(ValueError, match="give the same coupling"):
        list(sliding_path(atoms, law, penetrations=1.0, displacements=[0.0]))
    options = {"displacements": [0.0], "coupling": "solved"}
    (step,) = sliding_path(atoms, law, penetrations=1.0, **options)
    assert step.lateral_force_x > 0.0


def test_choices_and_solids_without_coupling_are_refused():
    law = Coulomb(MU)
    with pytest.raises(ValueError, match="neglected"):
        sliding_path(
            atoms_on(SOLID), law, penetrations=1.0, displacements=PATH, coupling="solve"
        )
    creeping = Viscoelastic(Isotropic(1.0, 0.3), Creep([1.0], [1.0]))
    with pytest.raises(ValueError, match="path in time"):
        coupled(stepper_of(16, creeping), 1.0, law, [0.0])


@pytest.mark.parametrize("solid", [Isotropic(1.0, 0.0), COPPER])
def test_coupling_is_a_limit_if_it_is_neglected(solid):
    found = [
        follow(stepper_of(24, solid), 0.3, Coulomb(0.6), [0.0, 20.0], coupling=coupling)
        for coupling in ("neglected", "solved")
    ]
    value = f"coupling by friction = {0.6 * solid.coupling:.3g} > 0.1"
    assert value in found[0][-1].validity
    assert "coupling" not in found[1][-1].validity


@pytest.mark.parametrize("poisson", [0.0, 0.5])
def test_area_that_comes_into_contact_in_a_coupled_step_is_a_limit(poisson):
    stepper, depths = stepper_of(32, Isotropic(1.0, poisson)), [0.2, 0.6, 0.62, 0.62]
    steps = coupled(stepper, depths, Coulomb(MU), np.zeros(4))
    marked = ["new area/contact area" in step.validity for step in steps]
    assert marked == ([True, True, False, False] if poisson == 0.0 else [False] * 4)
    if poisson == 0.0:
        areas = [step.stick_area + step.slip_area for step in steps]
        part = f"new area/contact area = {1.0 - areas[0] / areas[1]:.3g} > 0.1"
        assert part in steps[1].validity
