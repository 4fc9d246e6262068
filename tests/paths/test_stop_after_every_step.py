"""Paths that stop after any step and are resumed from their file.

What the surface keeps of a step, its plastic shape, creep or friction, must be in the
frame of this step, also if it is the first one.
"""

import pytest
from ase.io import read
from built import atoms_under
from numpy.testing import assert_allclose

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.scene import Scene

SPHERE = rc.RoughSphere(15.0)
CREEP = rc.Creep.standard_solid(relaxed=0.5, time=1.0)
TIGHT = {"fmax": 1e-9, "validity": "ignore"}


def plastic(periodic, output):
    """A step that stays elastic, the first one that flows, and unloading."""
    wall = rc.PlasticWall(0.1, permanent=True)
    atoms = atoms_under(SPHERE, wall, (16, 16), periodic=periodic)
    return rc.load_path(atoms, [0.2, 1.5, 1.0, 0.5], output=output, **TIGHT)


def creeping(periodic, output):
    solid = rc.Viscoelastic(1.0, CREEP)
    atoms = atoms_under(SPHERE, rc.HardWall(), (16, 16), solid=solid, periodic=periodic)
    dwell = rc.Schedule(0.0).step(1.0).hold(0.5)
    return rc.time_path(atoms, dwell, tolerance=0.5, output=output, **TIGHT)


def sliding(periodic, output):
    """Partial slip, full slip and its reversal."""
    solid = Isotropic(1.0, poisson=0.3)
    atoms = atoms_under(SPHERE, rc.HardWall(), (16, 16), solid=solid, periodic=periodic)
    moves = {"displacements": [0.0, 0.05, 0.5, 0.45]}
    return rc.sliding_path(atoms, rc.Coulomb(0.3), 1.0, **moves, output=output, **TIGHT)


SCENE = Scene.parse("""
substrate = { contact_modulus = 100.0, spacing = 2.5, hardness = 5.0 }
sphere = { radius = 100.0 }
interaction = { kind = "plastic", permanent = true }
path = { control = "penetration", values = [1.0, 3.0, 1.0, 0.5] }
""")


def of_scene(model):
    scene = SCENE.with_values({"substrate.model": model})

    def path(_, output):
        files = {"trajectory": output.trajectory, "resume": True} if output else {}
        return scene.relax(validity="ignore", **files)

    return path


PATHS = {
    "plastic": plastic,
    "creep": creeping,
    "slip": sliding,
    "scene of atoms": of_scene("atoms"),
    "scene of the continuum": of_scene("continuum"),
}
CASES = [
    *(
        (name, periodic)
        for name in ("plastic", "creep", "slip")
        for periodic in (False, True)
    ),
    ("scene of atoms", False),
    ("scene of the continuum", False),
]


@pytest.mark.parametrize("name, periodic", CASES)
def test_a_path_that_is_resumed_after_any_step_is_the_uninterrupted_one(
    tmp_path, name, periodic
):
    path = PATHS[name]
    whole = list(path(periodic, None))
    for count in range(1, len(whole)):
        output = rc.Output(trajectory=tmp_path / f"{count}.traj", resume=True)
        stopped = path(periodic, output)
        for _ in range(count):
            next(stopped)
        stopped.close()
        assert len(read(output.trajectory, ":")) == count
        again = list(path(periodic, output))
        for key in ("normal_force", "energy", "plastic_depth", "lateral_force_x"):
            expected = [getattr(step, key, 0.0) for step in whole]
            found = [getattr(step, key, 0.0) for step in again]
            largest = abs(max(expected, key=abs))
            assert_allclose(
                found, expected, atol=1e-7 * largest, err_msg=f"{count} {key}"
            )


def test_atoms_after_a_plastic_step_keep_its_shape_when_the_indenter_is_lifted():
    wall = rc.PlasticWall(0.1, permanent=True)
    atoms = atoms_under(SPHERE, wall, (16, 16), periodic=True)
    list(rc.load_path(atoms, [1.5], **TIGHT))
    copy = atoms.copy()
    copy.calc = rc.RoughContact(**atoms.calc.parameters)
    for each in (atoms, copy):
        each.positions[-1, 2] += 0.5
    gap, again = (each.calc.state(each).gap for each in (atoms, copy))
    assert_allclose(gap, again, atol=1e-12)
    assert gap[8, 8] == pytest.approx(0.5)  # where it has flowed
