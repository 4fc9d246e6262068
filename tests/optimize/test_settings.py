"""Settings of ASE's optimizers, refusals of those that can't work, and divergence."""

from functools import partial

import numpy as np
import pytest
from ase.optimize import (
    BFGS,
    FIRE,
    FIRE2,
    LBFGS,
    BFGSLineSearch,
    CellAwareBFGS,
    GoodOldQuasiNewton,
    GPMin,
)
from ase.optimize.optimize import Optimizer
from ase.optimize.precon import PreconFIRE, PreconLBFGS, PreconODE12r
from ase.optimize.sciopt import SciPyFmin, SciPyFminBFGS, SciPyFminCG, SciPyFminPowell
from built import atoms_under
from numpy.testing import assert_allclose

import ase_roughcontact as rc

SPACING, MODULUS = 2.5, 0.9
# BFGS, and RFO of ASE 3.29
BFGS_KINDS = [
    BFGS,
    *(kind for kind in BFGS.__subclasses__() if kind is not CellAwareBFGS),
]
WALLS = {
    "repulsive": rc.LennardJones93.repulsive(MODULUS, SPACING),
    "adhesive": rc.LennardJones93.adhesive(MODULUS, SPACING, 0.01 * MODULUS * SPACING),
}
CONTROLS = {"fixed": {"penetrations": [1.0]}, "load": {"loads": [10.0]}}


def atoms_of(wall="repulsive", control="fixed", n=14, modulus=MODULUS):
    rough = rc.SelfAffine(0.05, 0.8, 4 * SPACING, 16 * SPACING, seed=1)
    options = {"spacing": SPACING, "modulus": modulus, "fixed": control == "fixed"}
    return atoms_under(rc.RoughSphere(250.0, rough), WALLS[wall], (n, n), **options)


def step(optimizer=None, wall="repulsive", control="fixed", atoms=None, **options):
    atoms = atoms or atoms_of(wall, control)
    options = {"accuracy": 0.01, "validity": "ignore", **CONTROLS[control], **options}
    (found,) = rc.load_path(atoms, optimizer=optimizer, **options, window="unchecked")
    return found


@pytest.mark.filterwarnings("ignore:Armijo linesearch failed")
@pytest.mark.parametrize("control", CONTROLS)
@pytest.mark.parametrize("wall", WALLS)
@pytest.mark.parametrize("optimizer", [FIRE, FIRE2, LBFGS, PreconLBFGS])
def test_classes_of_ase_relax_atoms_with_their_settings(optimizer, wall, control):
    found, exact = (
        step(each, wall, control, max_steps=1500) for each in (optimizer, None)
    )
    assert found.converged
    assert abs(found.repulsive_atoms - exact.repulsive_atoms) <= 1
    assert_allclose(found.height, exact.height, atol=0.02)
    assert_allclose(found.energy, exact.energy, atol=2e-3 * abs(exact.energy))


def test_settings_follow_the_stiffness_of_solid_and_wall():
    soft, stiff = (
        rc.settings_for(LBFGS, atoms_of(modulus=modulus)) for modulus in (1.0, 9.0)
    )
    wall = 3.0 * SPACING**2 * WALLS["repulsive"].stiffness_at_contact
    assert (stiff["alpha"] - wall) / (soft["alpha"] - wall) == pytest.approx(9.0)
    slow, fast = (
        rc.settings_for(FIRE, atoms_of(modulus=modulus))["dtmax"]
        for modulus in (9.0, 1.0)
    )
    assert fast / slow == pytest.approx((stiff["alpha"] / soft["alpha"]) ** 0.5)


def test_an_indenter_under_a_load_needs_smaller_time_steps():
    atoms = atoms_of(control="load")
    atoms.calc.set(load=10.0)
    contacts = step(control="load").repulsive_atoms
    fixed, free = (
        rc.settings_for(FIRE2, each)["dtmax"] for each in (atoms_of(), atoms)
    )
    wall = 3.0 * SPACING**2 * WALLS["repulsive"].stiffness_at_contact
    assert free == pytest.approx((wall * contacts) ** -0.5, rel=0.02)
    assert free < 0.3 * fixed


def test_own_settings_come_first():
    settings = rc.settings_for(partial(LBFGS, memory=7), atoms_of())
    assert settings["memory"] == 7 and settings["alpha"] > 1.0
    modes = rc.FourierModes(atoms_of())
    assert rc.settings_for(FIRE, modes) == {"maxstep": modes.maxstep}


# Optimizers that can't work


@pytest.mark.parametrize(
    "optimizer, n, advice",
    [
        (CellAwareBFGS, 4, "LBFGS"),
        (GPMin, 4, "LBFGS"),
        (SciPyFmin, 4, "LBFGS"),
        (SciPyFminPowell, 4, "LBFGS"),
        *(
            (matrix, 32, "matrix")
            for matrix in (
                *BFGS_KINDS,
                BFGSLineSearch,
                GoodOldQuasiNewton,
                SciPyFminBFGS,
            )
        ),
        (lambda atoms, **k: PreconLBFGS(atoms, **k), 32, "HalfSpacePrecon"),
        (lambda atoms, **k: GPMin(rc.FourierModes(atoms), **k), 8, "LBFGS"),
        (lambda atoms, **k: PreconLBFGS(rc.FourierModes(atoms), **k), 8, "LBFGS"),
    ],
)
def test_what_cannot_work_is_refused_with_what_to_use(optimizer, n, advice):
    atoms = atoms_of(n=n)
    before = atoms.positions.copy()
    with pytest.raises(ValueError, match=advice):
        step(optimizer, atoms=atoms)
    assert np.array_equal(atoms.positions, before)


@pytest.mark.parametrize("optimizer", [PreconFIRE, PreconLBFGS, PreconODE12r])
def test_preconditioned_optimizers_need_atoms(optimizer):
    with pytest.raises(ValueError, match="HalfSpacePrecon"):
        rc.settings_for(optimizer, rc.FourierModes(atoms_of()))


@pytest.mark.parametrize("optimizer", [CellAwareBFGS, GPMin, PreconLBFGS])
def test_modes_say_what_to_use_if_an_optimizer_needs_atoms(optimizer):
    with pytest.raises((AttributeError, TypeError), match="use LBFGS"):
        optimizer(rc.FourierModes(atoms_of()), logfile=None)


def test_a_function_has_no_settings():
    with pytest.raises(ValueError, match="class of ASE"):
        rc.settings_for(lambda atoms: FIRE(atoms), atoms_of())


# Divergence


class Overshooting(Optimizer):
    """Steepest descent with steps that are ten times too long."""

    def step(self, forces=None):
        x, gradient = self.optimizable.get_x(), self.optimizable.get_gradient()
        self.optimizable.set_x(x - 2.0 * gradient)


@pytest.mark.parametrize("control", CONTROLS)
def test_an_optimizer_that_diverges_says_so_and_leaves_the_surface_as_it_was(control):
    atoms = atoms_of(control=control)
    first = step(None, control=control, atoms=atoms)
    surface = atoms.positions[:-1].copy()
    diverged = step(
        Overshooting,
        atoms=atoms,
        max_steps=5,
        control=control,
        **{
            key: [2.0 * value for value in CONTROLS[control][key]]
            for key in CONTROLS[control]
        },
    )
    assert not diverged.converged
    assert "energy has risen" in diverged.message and "shape" not in diverged.message
    assert_allclose(atoms.positions[:-1], surface, rtol=0, atol=1e-9)
    assert first.converged


def test_an_error_leaves_the_atoms_as_they_were():
    def failing(atoms, **options):
        optimizer = LBFGS(atoms, **options)
        optimizer.attach(lambda: 1 / 0, interval=5)
        return optimizer

    atoms = atoms_of()
    before = atoms.positions.copy()
    with pytest.raises(ZeroDivisionError):
        step(failing, atoms=atoms)
    assert np.array_equal(atoms.positions, before)


def test_a_contact_at_the_edge_is_no_error_before_it_has_converged():
    atoms = atoms_of(n=8)
    options = {"accuracy": 1e-4, "validity": "ignore", "max_steps": 3}
    (found,) = rc.load_path(atoms, penetrations=[2.0], optimizer=LBFGS, **options)
    assert not found.converged and "3 steps" in found.message
    with pytest.raises(RuntimeError, match="shape"):
        list(
            rc.load_path(
                atoms,
                penetrations=[2.0],
                optimizer=LBFGS,
                accuracy=1e-4,
                validity="ignore",
            )
        )


def test_an_optimizer_of_scipy_that_stops_has_a_message():
    found = step(SciPyFminCG, max_steps=2)
    assert not found.converged and found.message


def test_other_optimizers_need_no_settings():
    assert rc.settings_for(SciPyFminCG, atoms_of()) == {}
    modes = rc.FourierModes(atoms_of())
    assert rc.settings_for(BFGSLineSearch, modes) == {"alpha": 1.0}
