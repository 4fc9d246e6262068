"""A path that stops after every step, and goes on from its restart file, is the same.

All columns are compared bit by bit but wall-clock times. Each step is calculated by
another object than the last one, which knows nothing but the file.
"""

from dataclasses import asdict
from itertools import islice

import numpy as np
import pytest
from ase.optimize import LBFGS
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Cubic, Isotropic, Layer
from ase_roughcontact.scene import Scene

SPHERE = rc.RoughSphere(15.0)
ROUGH = rc.RoughSphere(60.0, rc.SelfAffine(0.1, 0.8, 4.0, 16.0, seed=1))
CREEP = rc.Creep((0.4, 0.7), (0.3, 2.0), flow=0.05)
SOFT, ADHESIVE = None, rc.LennardJones93.adhesive(1.0, 1.0, 0.02)
COULOMB = rc.Coulomb(0.3)
WEAKENING = rc.SlipWeakening(COULOMB, 0.4, 0.4)
RATE_AND_STATE = rc.RateAndState(0.3, 0.02, 0.01, 0.2, 1.0, damping=1e-3)
HARD, DUGDALE = rc.HardWall(), rc.DugdaleWall(0.02, attraction_range=0.8)
FLOWS = rc.PlasticWall(0.1, permanent=True)
SOLIDS = {
    "isotropic": Isotropic(1.0),
    "layer": Layer(0.5, 3.0, 2.0, 0.3, 0.2),
    "cubic": Cubic(1.2, 1.0, 0.4),
}


def steps(wall, control="penetrations", window="auto", solid="isotropic", **options):
    """Loading, unloading and loading again."""
    targets = {
        "penetrations": [0.2, 1.5, 1.0, 0.4, 1.8],
        "heights": [0.9, -0.5, 0.1, 0.6, -0.8],
        "loads": [0.3, 8.0, 4.0, 1.0, 12.0],
    }[control]
    periodic = options.pop("periodic", False)

    def path(output):
        atoms = atoms_under(
            options.get("sphere", SPHERE),
            wall,
            (16, 16),
            solid=SOLIDS[solid],
            periodic=periodic,
            fixed=control != "loads",
        )
        kept = window if not periodic else "fixed"
        more = {k: v for k, v in options.items() if k != "sphere"}
        return rc.load_path(
            atoms,
            **{control: targets},
            window=kept,
            validity="ignore",
            output=output,
            **more,
        )

    return path


def loop(wall):
    """Approach and retraction."""
    return of_scene(f"""
substrate = {{ contact_modulus = 100.0, spacing = 2.5, hardness = inf }}
sphere = {{ unit = "a0", radius = 12.0 }}
interaction = {{ kind = "{wall}", work_of_adhesion = 1.0 }}
path = {{ kind = "loop", deepest = "0.1 nm", step = 1.0, tolerance = 0.05 }}
solver = {{ accuracy = "fast" }}
""")


def time(wall, control="penetrations", periodic=False, solid="isotropic", flows=CREEP):
    """A jump, a dwell, and retraction of the target."""
    targets = {
        "penetrations": rc.Schedule(0.0).step(1.0).hold(0.3).ramp(0.2, time=0.3),
        "heights": rc.Schedule(1.0).ramp(-0.5, time=0.3).hold(0.5),
        "loads": rc.Schedule(0.0).step(5.0).hold(0.5).ramp(2.0, time=0.2),
        "bases": rc.Schedule(1.0).ramp(-3.0, time=0.5).hold(0.3),
    }[control]

    def path(output):
        atoms = atoms_under(
            SPHERE,
            wall,
            (16, 16),
            solid=rc.Viscoelastic(SOLIDS[solid], flows),
            periodic=periodic,
            fixed=control in ("penetrations", "heights"),
        )
        more = {"cantilever": 3.0} if control == "bases" else {}
        return rc.time_path(
            atoms,
            **{control: targets},
            **more,
            tolerance=0.1,
            window="fixed" if periodic else "auto",
            validity="ignore",
            output=output,
        )

    return path


def sliding(
    wall,
    lateral,
    normal="penetrations",
    coupling="neglected",
    law=COULOMB,
    **options,
):
    """Partial slip, full slip, and its reversal."""
    moves = {
        "displacements": [0.0, 0.05, 0.5, 0.45, 0.2],
        "forces": [0.0, 0.3, 0.6, 0.2],
        "bases": [0.0, 0.3, 2.0, 1.0],
    }[lateral]
    target = {"penetrations": 1.0, "heights": 0.0, "loads": 4.0}[normal]
    periodic, window = options.pop("periodic", False), options.pop("window", "auto")

    def path(output):
        atoms = atoms_under(
            SPHERE,
            wall,
            (16, 16),
            solid=Isotropic(1.0, poisson=0.2),
            periodic=periodic,
            fixed=normal != "loads",
        )
        return rc.sliding_path(
            atoms,
            law,
            **{normal: target, lateral: moves},
            spring=1.0 if lateral == "bases" else None,
            coupling=coupling,
            window="fixed" if periodic else window,
            validity="ignore",
            output=output,
            **options,
        )

    return path


def sliding_in_time(lateral, solid=None, normal="penetrations", **options):
    """A slide, and a hold."""

    def path(output):
        atoms = atoms_under(
            SPHERE,
            HARD,
            (16, 16),
            solid=solid or Isotropic(1.0, poisson=0.2),
            fixed=normal != "loads",
        )
        schedule = rc.Schedule(0.0).ramp(0.3, time=0.1).hold(1.0)
        return rc.sliding_path(
            atoms,
            RATE_AND_STATE,
            **{normal: 1.0, lateral: schedule},
            tolerance=0.05,
            window="auto",
            validity="ignore",
            output=output,
            **options,
        )

    return path


def of_scene(text, **values):
    scene = Scene.parse(text).with_values(values)

    def path(output):
        files = {}
        if output is not None:
            files = {"restart": output.restart, "resume": True}
        return scene.relax(validity="ignore", **files)

    return path


PLASTIC_SCENE = """
substrate = { contact_modulus = 100.0, spacing = 2.5, hardness = 5.0 }
sphere = { unit = "a0", radius = 100.0 }
interaction = { kind = "plastic", permanent = true }
path = { control = "penetration", values = [1.0, 3.0, 1.0, 0.5] }
"""

SLOW = "time, heights, adhesive", "time, bases, hard adhesive"
PATHS = {
    "soft, penetrations": steps(SOFT),
    "soft, heights, periodic": steps(SOFT, "heights", periodic=True),
    "soft, loads": steps(SOFT, "loads"),
    "soft, fixed window": steps(SOFT, window="unchecked"),
    "soft, rough, loads": steps(SOFT, "loads", sphere=ROUGH),
    "soft, layer": steps(SOFT, solid="layer"),
    "soft, cubic, loads": steps(SOFT, "loads", solid="cubic"),
    "adhesive, heights": steps(ADHESIVE, "heights"),
    "adhesive, loads, fixed window": steps(ADHESIVE, "loads", "unchecked"),
    "hard, penetrations": steps(HARD),
    "hard, loads, rough": steps(HARD, "loads", sphere=ROUGH),
    "hard, layer, loads, periodic": steps(HARD, "loads", solid="layer", periodic=True),
    "hard, cubic": steps(HARD, solid="cubic"),
    "hard adhesive, penetrations": steps(DUGDALE),
    "hard adhesive, loads, periodic": steps(DUGDALE, "loads", periodic=True),
    "plastic, penetrations": steps(FLOWS),
    "plastic, loads": steps(FLOWS, "loads"),
    "plastic, heights, periodic": steps(FLOWS, "heights", periodic=True),
    "plastic, rough": steps(FLOWS, sphere=ROUGH),
    "optimizer of ASE": steps(SOFT, window="unchecked", optimizer=LBFGS, fmax=0.02),
    "grid of the continuum": steps(HARD, grid="a0/2"),
    "plastic scene": of_scene(PLASTIC_SCENE),
    "plastic scene of atoms": of_scene(PLASTIC_SCENE, **{"substrate.model": "atoms"}),
    "loop, soft": loop("adhesive"),
    "loop, hard": loop("dugdale"),
    "time, penetrations": time(HARD),
    "time, heights, adhesive": time(ADHESIVE, "heights"),
    "time, loads": time(HARD, "loads"),
    "time, loads, periodic": time(HARD, "loads", periodic=True),
    "time, bases, hard adhesive": time(DUGDALE, "bases"),
    "time, layer": time(HARD, solid="layer"),
    "time, plastic": time(FLOWS),
    "sliding, displacements": sliding(HARD, "displacements"),
    "sliding, forces, loads": sliding(HARD, "forces", "loads"),
    "sliding, bases, heights": sliding(SOFT, "bases", "heights"),
    "sliding, coupled": sliding(HARD, "displacements", coupling="solved"),
    "sliding, coupled, periodic": sliding(
        HARD, "displacements", coupling="solved", periodic=True
    ),
    "sliding, plastic": sliding(FLOWS, "displacements"),
    "sliding, weakening": sliding(HARD, "displacements", law=WEAKENING),
    "sliding, in time": sliding_in_time("displacements"),
    "sliding, in time, bases": sliding_in_time("bases", spring=1.0),
    "sliding, in time, creeps": sliding_in_time(
        "displacements", rc.Viscoelastic(Isotropic(1.0, 0.2), CREEP), "loads"
    ),
    "sliding, weakening, forces": sliding(HARD, "forces", law=WEAKENING),
    "sliding, weakening, bases": sliding(HARD, "bases", law=WEAKENING),
    "sliding, weakening, periodic": sliding(
        HARD, "displacements", periodic=True, law=WEAKENING
    ),
    "sliding, fixed window": sliding(HARD, "displacements", window="fixed"),
}


def columns(step):
    """All columns as text that is the same only if all bits are."""
    values = {k: v for k, v in asdict(step).items() if k != "seconds"}
    return {k: float(v).hex() if isinstance(v, float) else v for k, v in values.items()}


def stopping(path, file):
    """The steps of a path that stops after each of them."""
    found = []
    while True:
        again = path(rc.Output(restart=file, resume=True))
        restored = [columns(step) for step in islice(again, len(found))]
        assert restored == found
        step = next(again, None)
        again.close()
        if step is None:
            return found
        found.append(columns(step))


NAMES = [pytest.param(k, marks=pytest.mark.slow) if k in SLOW else k for k in PATHS]


@pytest.mark.parametrize("name", NAMES)
def test_a_path_that_stops_after_every_step_is_the_uninterrupted_one(name, tmp_path):
    whole = [columns(step) for step in PATHS[name](None)]
    assert len(whole) >= 4
    found = stopping(PATHS[name], tmp_path / "path.npz")
    for number, (expected, step) in enumerate(zip(whole, found, strict=True)):
        differ = {k: (v, step[k]) for k, v in expected.items() if step[k] != v}
        assert not differ, f"step {number}"


def test_atoms_after_a_plastic_step_keep_its_shape_when_the_indenter_is_lifted():
    wall = rc.PlasticWall(0.1, permanent=True)
    atoms = atoms_under(SPHERE, wall, (16, 16), periodic=True)
    list(rc.load_path(atoms, penetrations=[1.5], fmax=1e-9, validity="ignore"))
    copy = atoms.copy()
    copy.calc = rc.RoughContact(**atoms.calc.parameters)
    for each in (atoms, copy):
        each.positions[-1, 2] += 0.5
    gap, again = (each.calc.state(each).gap for each in (atoms, copy))
    np.testing.assert_allclose(gap, again, atol=1e-12)
    assert gap[8, 8] == pytest.approx(0.5)  # where it has flowed
