"""Default options of optimizers, residuals."""

import numpy as np
import pytest
from ase.optimize import LBFGS
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.scene import Scene

SPHERE = rc.RoughSphere(200.0)
SCENE = """
[substrate]
model = "atoms"
spacing = {spacing}
contact_modulus = {modulus}
shape = {shape}
periodic = {periodic}
[sphere]
unit = "a0"
radius = 60.0
[path]
control = "height"
values = [{height}]
"""


def make_scene(optimizer=None, spacing=2.5, modulus=100.0, shape=(24, 20), **options):
    given = {"periodic": "false", "height": 0.0} | options
    text = SCENE.format(spacing=spacing, modulus=modulus, shape=list(shape), **given)
    return Scene.parse(
        text + (f'[solver]\noptimizer = "{optimizer}"\n' if optimizer else "")
    )


def rms(values):
    return np.sqrt(np.mean(np.square(values)))


# Limit of the step length


@pytest.mark.parametrize("shape", [(12, 10), (40, 64)], ids=str)
@pytest.mark.parametrize("spacing, modulus", [(1.0, 100.0), (4.0, 100.0), (1.0, 1.0)])
def test_the_step_limit_of_modes_is_a_displacement_of_a_tenth_of_a_spacing(
    spacing, modulus, shape, periodic, rng
):
    scene = make_scene(
        spacing=spacing, modulus=modulus, shape=shape, periodic=str(periodic).lower()
    )
    atoms = scene.atoms()
    modes = rc.FourierModes(atoms)
    step = rng.normal(size=modes.ndofs())
    step[-1] = 0.0
    modes.set_x(modes.get_x() + step * modes.maxstep / np.linalg.norm(step))
    # a random step: not all modes move the atoms of a free half space equally
    assert 0.03 * spacing < rms(atoms.positions[:-1, 2]) < 0.2 * spacing


@pytest.mark.parametrize("name", ["FIRE", "FIRE2"])
def test_fire_in_scenes_has_the_step_limit_of_the_modes(name):
    scene = make_scene(name)
    atoms = scene.atoms()
    atoms.positions[-1, 2] = 1.0
    dynamics = scene.optimizer(atoms, logfile=None)
    assert dynamics.maxstep == rc.FourierModes(atoms).maxstep
    modes, places = dynamics.optimizable, []
    dynamics.attach(lambda: places.append(modes.get_x()))
    assert dynamics.run(fmax=1e-3, steps=500)
    steps = np.linalg.norm(np.diff(places, axis=0), axis=1)
    assert 0.1 < steps.max() / modes.maxstep < 1.0001


def test_lbfgs_in_scenes_has_the_curvature_of_the_modes_and_twenty_vectors():
    def relaxed(optimizer):
        atoms = make_scene(shape=(16, 14)).atoms()
        atoms.positions[-1, 2] = 1.0
        dynamics = optimizer(atoms)
        assert dynamics.run(fmax=1e-6, steps=1000)
        return dynamics.nsteps, atoms.positions[-2, 2]

    def on_modes(**options):
        return relaxed(
            lambda atoms: LBFGS(rc.FourierModes(atoms), None, None, **options)
        )

    scene = make_scene("LBFGS")
    usual = relaxed(lambda atoms: scene.optimizer(atoms, logfile=None))
    assert usual == on_modes(alpha=1.0, memory=20)
    assert usual != on_modes(alpha=1.0) and usual != on_modes(memory=20)


# Default optimizers


@pytest.mark.parametrize(
    "wall, solver, other",
    [
        (rc.HardWall(), rc.ActiveSet, rc.NewtonKrylov),
        (None, rc.NewtonKrylov, rc.ActiveSet),
    ],
    ids=["hard", "soft"],
)
def test_the_default_optimizer_depends_on_the_wall(wall, solver, other):
    def iterations(optimizer):
        atoms = atoms_under(SPHERE, wall, (24, 24))
        (record,) = rc.load_path(
            atoms, heights=[0.3], optimizer=optimizer, window="unchecked"
        )
        assert record.converged
        return record.iterations, record.pairs

    assert iterations(None) == iterations(solver)
    with pytest.raises(ValueError, match="wall"):
        iterations(other)


# Residuals of the optimality conditions of a hard wall


@pytest.mark.filterwarnings("ignore:the load of")
@pytest.mark.parametrize("fixed", [False, True], ids=["free", "fixed"])
def test_a_missing_load_is_a_residual_only_of_a_free_indenter(fixed):
    atoms = atoms_under(SPHERE, rc.HardWall(), (24, 24), load=5.0, fixed=fixed)
    atoms.positions[-1, 2] = -0.2
    optimizer = rc.ActiveSet(atoms, logfile=None)
    assert optimizer.run(fmax=1e-9)
    assert optimizer.optimality_residuals.load_error < 1e-9
    atoms.calc.set(load=6.0)
    error = optimizer.optimality_residuals.load_error
    assert error == pytest.approx(0.0 if fixed else 1.0, abs=1e-9)
