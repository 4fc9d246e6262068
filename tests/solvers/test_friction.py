"""Tractions of contacts with friction, against dense and exact solutions."""

import numpy as np
import pytest

from ase_roughcontact.contact.support import LateralSupport
from ase_roughcontact.elasticity import Isotropic, cerruti_kernel
from ase_roughcontact.elasticity.lateral import LateralHalfSpace
from ase_roughcontact.solvers.lateral.friction import (
    FrictionOptions,
    solve_friction,
)
from ase_roughcontact.solvers.lateral.friction_problem import balancing_shift, bounded


def random_problem(rng, largest, nu):
    """Half space of a random shape, and its dense Green's function."""
    n, m = rng.integers(2, largest, 2)
    half = LateralHalfSpace((n, m), 1.0, Isotropic(1.0, nu))
    i, j = (index.ravel() for index in np.indices((n, m)))
    xx, yy, xy = cerruti_kernel(i[:, None] - i, j[:, None] - j, 1.0, 1.0, nu)
    return half, np.block([[xx, xy], [xy, yy]]), (n, m)


def dense_tractions(matrix, bound, imposed):
    """Minimise by accelerated projected gradients, with restarts."""
    step = 1.0 / np.linalg.eigvalsh(matrix)[-1]
    t = y = np.zeros_like(imposed)
    weight = 1.0
    for _ in range(50_000):
        gradient = (matrix @ y.ravel()).reshape(y.shape) - imposed
        new = bounded(y - step * gradient, bound)
        if (gradient * (new - t)).sum() > 0.0:
            weight = 1.0
        elif abs(new - t).max() < 1e-14:
            return new
        following = 0.5 * (1.0 + np.sqrt(1.0 + 4.0 * weight**2))
        y, t = new + (weight - 1.0) / following * (new - t), new
        weight = following
    return t


@pytest.mark.parametrize("seed", range(30))
def test_random_problems_have_the_dense_solution(seed):
    rng = np.random.default_rng(seed)
    for _ in range(10):
        nu = float(rng.uniform(-0.3, 0.5))
        half, matrix, (n, m) = random_problem(rng, 7, nu)
        bound = rng.uniform(0.1, 1.0, (n, m)) * (rng.uniform(size=(n, m)) < 0.8)
        imposed = rng.normal(size=2)[:, None, None] + rng.normal(size=(2, n, m))
        found = solve_friction(
            half, bound, imposed, options=FrictionOptions(tolerance=1e-10)
        )
        assert found.converged
        expected = dense_tractions(matrix, bound, imposed)
        assert found.tractions == pytest.approx(expected, abs=1e-8)


def hertz(n, radius):
    x = np.arange(n) - (n - 1) / 2
    r2 = np.add.outer(x**2, x**2)
    return np.sqrt(np.maximum(1.0 - r2 / radius**2, 0.0)), radius


def test_displacement_agrees_with_cattaneo_and_mindlin():
    n, mu, modulus = 128, 0.3, 1.0
    shape, a = hertz(n, 50.3)
    bound = mu * shape
    half = LateralHalfSpace((n, n), 1.0, Isotropic(modulus, 0.0))
    full = bound.sum()
    for part in (0.2, 0.7, 0.95):
        found = solve_friction(
            half, bound, np.zeros((2, n, n)), support=LateralSupport((part * full, 0.0))
        )
        assert found.converged
        shear = 0.5 * modulus
        expected = 3.0 * full * 2.0 / (16.0 * shear * a)
        expected *= 1.0 - (1.0 - part) ** (2.0 / 3.0)
        assert found.shift[0] == pytest.approx(expected, rel=2e-3)
        stick = np.sqrt(((bound > 0.0) & ~found.slipping).sum() / np.pi)
        assert stick == pytest.approx(a * (1.0 - part) ** (1.0 / 3.0), abs=1.0)


LARGEST = "the lateral load is the largest friction"


@pytest.mark.parametrize(
    "part, message",
    [
        (1.1, "friction does not carry 9.09 % of the lateral load"),
        *((part, LARGEST) for part in (1.0 - 1e-7, 1.0 - 1e-12, 1.0, 1.0 + 1e-12)),
    ],
)
def test_a_force_of_the_largest_friction_or_more_makes_the_contact_slide(part, message):
    shape, _ = hertz(16, 6.0)
    half = LateralHalfSpace((16, 16), 1.0, Isotropic(1.0, 0.3))
    found = solve_friction(
        half,
        shape,
        np.zeros((2, 16, 16)),
        support=LateralSupport((part * shape.sum(), 0.0)),
    )
    assert not found.converged
    assert found.message.startswith(f"the contact slides: {message}")
    assert found.slipping[shape > 0.0].all()
    assert not found.shift.any()


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("stiffness", [0.0, 1e-3, 3.0])
def test_random_problems_under_a_force_are_solved(seed, stiffness):
    """Tractions within bounds of all sizes carry forces of up to the limit.

    The problem is convex: its conditions, with a dense matrix, imply the solution.
    """
    rng = np.random.default_rng(seed)
    for _ in range(15):
        half, matrix, (n, m) = random_problem(rng, 9, rng.uniform(0.0, 0.5))
        bound = 10.0 ** rng.uniform(-3, 3) * rng.uniform(size=(n, m))
        if rng.integers(2):  # as of a shear strength
            bound = np.minimum(bound, 0.5 * bound.max())
        angle, part = rng.uniform(0.0, 6.3), rng.choice([1e-6, 0.5, 0.9, 0.999999])
        force = part * bound.sum() * np.array([np.cos(angle), np.sin(angle)])
        support = LateralSupport((force[0], force[1]), stiffness)
        found = solve_friction(half, bound, np.zeros((2, n, m)), support=support)
        assert found.converged, found.message
        t = found.tractions
        gap = found.shift[:, None, None] - (matrix @ t.ravel()).reshape(t.shape)
        change = bounded(t + gap / half.self_compliance, bound) - t
        assert abs(change).max() < 2e-7 * abs(t).max()
        carried = t.sum(axis=(1, 2)) + stiffness * found.shift
        assert carried == pytest.approx(force, abs=1e-6 * np.hypot(*force))


def slips(half, matrix, bound, imposed):
    """Return the slip of atoms along their tractions, over G_0 and the largest one."""
    t = dense_tractions(matrix, bound, imposed)
    gap = imposed - (matrix @ t.ravel()).reshape(t.shape)
    size = np.hypot(*t)
    return (gap * t).sum(axis=0) / (
        half.self_compliance * size.max() * size.clip(1e-99)
    )


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("outward", [0.0, 3.0])
def test_atoms_that_slip_agree_with_the_dense_solution(seed, outward):
    """A force moves the indenter over a surface that the pressure draws outward.

    The displacement found is given to the dense problem.
    """
    rng = np.random.default_rng(seed)
    for _ in range(5):
        half, matrix, (n, m) = random_problem(rng, 9, rng.uniform(0.0, 0.5))
        i, j = np.indices((n, m))
        bound = rng.uniform(0.2, 1.0, (n, m)) * (rng.uniform(size=(n, m)) < 0.8)
        bound[0, 0] = 1.0
        imposed = outward * np.stack([i - n / 2, j - m / 2])
        angle, part = rng.uniform(0.0, 6.3), rng.choice([0.1, 0.5, 0.9])
        x, y = part * bound.sum() * np.array([np.cos(angle), np.sin(angle)])
        found = solve_friction(half, bound, imposed, support=LateralSupport((x, y)))
        assert found.converged
        slip = slips(half, matrix, bound, imposed + found.shift[:, None, None])
        decided = (bound > 0.0) & ((slip > 1e-5) | (abs(slip) < 1e-8))
        assert decided.sum() >= 0.98 * (bound > 0.0).sum()
        assert (found.slipping == (slip > 1e-5))[decided].all()
        assert not found.slipping[bound == 0.0].any()


def test_atoms_that_have_slipped_stick_if_nothing_moves():
    bound = hertz(16, 6.0)[0]
    half = LateralHalfSpace((16, 16), 1.0, Isotropic(1.0, 0.3))
    moved = np.full((2, 16, 16), 10.0)
    first = solve_friction(half, bound, moved)
    assert first.slipping[bound > 0.0].all()
    held = solve_friction(half, bound, first.displacement, first.tractions)
    assert not held.slipping.any()


def test_few_fft_pairs_are_needed():
    n, mu = 128, 0.3
    shape, a = hertz(n, 50.3)
    half = LateralHalfSpace((n, n), 1.0, Isotropic(1.0, 0.3))
    full = 3.0 * mu * shape.sum() * 1.7 / (16.0 * 0.35 * a)
    for part in (0.2, 0.6, 0.95):
        imposed = np.zeros((2, n, n))
        imposed[0] = part * full
        found = solve_friction(half, mu * shape, imposed)
        assert found.converged
        assert found.pairs < 90
    driven = solve_friction(
        half,
        mu * shape,
        np.zeros((2, n, n)),
        support=LateralSupport((0.9 * mu * shape.sum(), 0.0)),
    )
    assert driven.converged
    assert driven.pairs < 100


@pytest.mark.parametrize("seed", range(20))
def test_atoms_that_all_slip_one_way_are_turned_to_the_other(seed):
    # the slope of the sum along x is zero but for rounding
    rng = np.random.default_rng(seed)
    bound = rng.uniform(1e-4, 1.0, rng.integers(10, 3000))
    values = np.stack([-rng.uniform(2.0, 40.0) * bound ** rng.uniform(), 0.0 * bound])
    total = np.array([0.3, 0.0]) * bound.sum()
    shift = balancing_shift(values, bound, total, 0.0, np.zeros(2))
    found = bounded(values + shift[:, None], bound).sum(axis=1)
    assert found == pytest.approx(total, abs=1e-9 * bound.sum())
