"""Errors of steps that optimizers of ASE relax, and tolerances for wanted errors."""

from functools import partial

import numpy as np
import pytest
from ase.constraints import FixAtoms
from ase.optimize import FIRE, FIRE2, LBFGS, MDMin
from ase.optimize.sciopt import SciPyFminCG
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import contact_of

SPACING, MODULUS = 2.5, 0.9  # as of copper, so that fmax in eV/Å is what users give
WALLS = {
    "repulsive": rc.LennardJones93.repulsive(MODULUS, SPACING),
    "adhesive": rc.LennardJones93.adhesive(MODULUS, SPACING, 0.01 * MODULUS * SPACING),
}


def atoms_of(seed, wall="repulsive", n=32, fixed=True, roughness=0.05):
    rough = rc.SelfAffine(roughness, 0.8, 4 * SPACING, 16 * SPACING, seed=seed)
    lattice = {"spacing": SPACING, "modulus": MODULUS, "fixed": fixed}
    return atoms_under(rc.RoughSphere(250.0, rough), WALLS[wall], (n, n), **lattice)


def with_defaults(optimizer, atoms, **options):
    """Optimizer with the defaults of ASE."""
    return optimizer(atoms, **options)


def on_modes(optimizer, atoms, **options):
    modes = rc.FourierModes(atoms)
    if optimizer in (FIRE, FIRE2, MDMin):
        options["maxstep"] = modes.maxstep
    if optimizer is LBFGS:
        options["alpha"] = 1.0
    return optimizer(modes, **options)


def step(atoms, optimizer=None, **options):
    """Result of a step, by default of a reference with other algorithms."""
    options = {"validity": "ignore", "window": "unchecked", **options}
    if optimizer is None:
        options["fmax"] = 1e-8
        optimizer = partial(on_modes, LBFGS)
    (relaxed,) = rc.load_path(atoms, optimizer=optimizer, **options)
    return relaxed


# Errors


@pytest.mark.parametrize(
    "seed, optimizer, fmax",
    [
        (1, partial(with_defaults, FIRE), 0.01),
        (1, partial(on_modes, FIRE2), 1e-3),
        (2, partial(on_modes, FIRE), 0.01),
        (3, partial(on_modes, FIRE2), 1e-3),
        (1, rc.NewtonKrylov, 0.01),
    ],
)
def test_force_and_area_are_as_wrong_as_estimated(seed, optimizer, fmax):
    exact = step(atoms_of(seed), penetrations=[1.5])
    loose = step(atoms_of(seed), optimizer, fmax=fmax, penetrations=[1.5])
    error = abs(loose.normal_force - exact.normal_force)
    assert loose.converged and error > 1e-5
    assert loose.force_error == pytest.approx(error, rel=0.1)
    error = abs(loose.contact_area - exact.contact_area)
    assert loose.area_error == pytest.approx(error, abs=0.1 * SPACING**2)


def test_height_under_a_load_is_as_wrong_as_estimated():
    exact = step(atoms_of(1, n=24, fixed=False), loads=[20.0])
    fire = partial(on_modes, FIRE)
    loose = step(atoms_of(1, n=24, fixed=False), fire, fmax=0.02, loads=[20.0])
    error = abs(loose.height - exact.height)
    assert error > 1e-3
    assert loose.height_error == pytest.approx(error, rel=0.1)


def test_errors_are_not_known_if_atoms_are_held():
    atoms = atoms_of(1, n=12)
    atoms.set_constraint([*atoms.constraints, FixAtoms([6 * 24 + 6])])
    held = step(atoms, LBFGS, fmax=1e-3, penetrations=[0.5])
    assert held.converged
    assert np.isnan([held.force_error, held.area_error]).all()
    assert "constraints" in held.unknown_errors


def test_an_atom_about_to_touch_a_soft_wall_is_an_error_of_the_area():
    def atoms_in_contact(depth, **options):
        atoms = atoms_of(1, n=12)
        return step(atoms, rc.NewtonKrylov, penetrations=[depth], **options)

    shallow, deep = 0.4, 0.6
    few, many = (
        atoms_in_contact(depth, accuracy=1e-11).repulsive_atoms
        for depth in (shallow, deep)
    )
    assert few < many
    while deep - shallow > 1e-8:
        middle = 0.5 * (shallow + deep)
        if atoms_in_contact(middle, accuracy=1e-11).repulsive_atoms == few:
            shallow = middle
        else:
            deep = middle
    undecided, decided = (
        atoms_in_contact(depth, accuracy=1e-3) for depth in (deep, deep + 0.01)
    )
    assert undecided.area_error >= SPACING**2
    assert decided.area_error < 0.1 * SPACING**2


OPTIMIZERS = {
    "FIRE": partial(with_defaults, FIRE),
    "FIRE on modes": partial(on_modes, FIRE),
    "FIRE2": partial(with_defaults, FIRE2, use_abc=True),
    "FIRE2 on modes": partial(on_modes, FIRE2),
    "LBFGS": partial(with_defaults, LBFGS),
    "LBFGS on modes": partial(on_modes, LBFGS),
    "MDMin on modes": partial(on_modes, MDMin),
    "SciPyFminCG": SciPyFminCG,
    "SciPyFminCG on modes": partial(on_modes, SciPyFminCG),
}


def errors_of_case(seed, optimizer):
    """Pairs of true and estimated errors of a random case, relative to their units."""
    random = np.random.default_rng([seed, 7])
    wall, fixed = random.choice(list(WALLS)), bool(random.integers(2))
    options = {"fmax": random.choice([0.05, 0.01, 0.003, 0.001]), "max_steps": 1000}
    target = {"penetrations": [random.uniform(0.5, 2.0)]}
    if not fixed:
        target = {"loads": [random.uniform(5.0, 40.0)]}
    loose, exact = (
        step(atoms_of(seed, wall, n=16, fixed=fixed), each, **target, **given)
        for each, given in ((optimizer, options), (rc.NewtonKrylov, {"accuracy": 1e-9}))
    )
    force = abs(loose.normal_force - exact.normal_force), loose.force_error
    height = abs(loose.height - exact.height), loose.height_error
    area = abs(loose.contact_area - exact.contact_area), loose.area_error
    return [force if fixed else height, area]


@pytest.mark.slow
def test_nine_of_ten_errors_of_optimizers_are_within_twice_the_estimate():
    cases = [
        np.transpose(errors_of_case(seed, optimizer))
        for seed in range(1, 9)
        for optimizer in OPTIMIZERS.values()
    ]
    true, estimates = np.stack(cases, axis=-1)
    known = np.isfinite(estimates)
    assert known.mean() > 0.95
    within = true <= 2.0 * estimates + 1e-9
    for quantity in (0, 1):
        assert within[quantity][known[quantity]].mean() >= 0.9
        wrong = known[quantity] & (true[quantity] > 1e-6)
        ratios = estimates[quantity][wrong] / true[quantity][wrong]
        assert ratios.size >= 5 and np.median(ratios) <= 5.0


# Tolerance


def penetrated(wall="repulsive", n=24, depth=1.5):
    """Atoms, and the height of their indenter at a penetration."""
    atoms = atoms_of(1, wall, n=n)
    atoms.positions[-1, 2] = contact_of(atoms).first_contact - depth
    return atoms, float(atoms.positions[-1, 2])


@pytest.mark.parametrize("error", [0.1, 1e-3])
def test_tolerance_is_a_quarter_of_the_error_of_the_mean_force_in_contact(error):
    atoms, height = penetrated()
    before = atoms.positions.copy()
    fmax = rc.fmax_for(atoms, error)
    assert np.array_equal(atoms.positions, before)
    exact = step(atoms, heights=[height])
    mean = exact.normal_force / exact.repulsive_atoms
    assert fmax == pytest.approx(0.25 * error * mean, rel=error)


def test_tolerance_under_a_load_is_the_same_as_at_its_height():
    free, (fixed, height) = atoms_of(1, n=24, fixed=False), penetrated()
    force = step(fixed, rc.NewtonKrylov, heights=[height]).normal_force
    free.calc.set(load=force)
    assert rc.fmax_for(free) == pytest.approx(rc.fmax_for(fixed), rel=1e-3)


@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("optimizer", OPTIMIZERS)
def test_force_and_area_have_the_wanted_error_at_the_tolerance(optimizer, wall):
    error, height = 0.01, penetrated(wall, n=16, depth=1.0)[1]
    atoms = penetrated(wall, n=16, depth=1.0)[0]
    exact = step(atoms_of(1, wall, n=16), rc.NewtonKrylov, fmax=1e-9, heights=[height])
    fmax = rc.fmax_for(atoms, error)
    loose = step(atoms, OPTIMIZERS[optimizer], fmax=fmax, heights=[height])
    assert loose.converged
    forces = exact.repulsive_atoms * exact.mean_pressure * SPACING**2
    assert abs(loose.normal_force - exact.normal_force) <= error * forces
    atoms = abs(loose.repulsive_atoms - exact.repulsive_atoms)
    assert atoms <= 1 + error * exact.repulsive_atoms


def test_a_tolerance_needs_a_contact():
    with pytest.raises(ValueError, match="lower the indenter"):
        rc.fmax_for(penetrated(depth=-1.0)[0])


def test_a_loose_tolerance_given_by_hand_is_marked():
    def mark(optimizer, **options):
        options = {"validity": "warn", "penetrations": [1.5], **options}
        return step(atoms_of(1, n=24), optimizer, **options).validity

    with pytest.warns(rc.ValidityWarning, match="fmax_for"):
        assert "error by fmax = 0." in mark(partial(with_defaults, FIRE), fmax=0.05)
    for precise in ({"fmax": 2e-4}, {"accuracy": 0.01}, {"accuracy": 0.3}):
        assert mark(partial(on_modes, LBFGS), **precise) == ""
    assert mark(rc.NewtonKrylov, fmax=0.05) == ""
