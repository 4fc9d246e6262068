"""Arguments of another kind are refused by an error that names them."""

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.foundation import (
    ElasticFoundation,
    FoundationPrecon,
    add_indenter,
    crystal_slab,
)

SPHERE, SOLID, WALL = rc.RoughSphere(60.0), Isotropic(1.0, poisson=0.3), rc.HardWall()
PROBLEM = rc.Problem(SPHERE, SOLID, WALL, spacing=1.0)
WINDOW = Box((-4, -4), (8, 8))


def atoms():
    return atoms_under(SPHERE, WALL, solid=SOLID)


def followed(path, *arguments, **options):
    return list(path(*arguments, **options))


CREEP = rc.Creep.standard_solid(relaxed=0.5, time=1.0)
VISCOELASTIC = rc.Viscoelastic(1.0, CREEP)
SCHEDULE = rc.Schedule(0.0).step(0.1)
# Name of an argument, and a call in which it is the only one that is wrong.
CALLS = [
    ("atoms", lambda wrong: rc.snapshot(wrong)),
    ("atoms", lambda wrong: rc.release(wrong)),
    ("atoms", lambda wrong: rc.stick(wrong, rc.Tresca(1.0))),
    ("atoms", lambda wrong: followed(rc.load_path, wrong, penetrations=[0.1])),
    ("atoms", lambda wrong: followed(rc.time_path, wrong, penetrations=SCHEDULE)),
    ("atoms", lambda wrong: rc.adhesion_loop(wrong, deepest=0.1, step=0.1)),
    ("atoms", lambda wrong: rc.ActiveSet(wrong)),
    ("atoms", lambda wrong: rc.FourierModes(wrong)),
    ("atoms", lambda wrong: rc.HalfSpacePrecon(wrong)),
    ("atoms", lambda wrong: add_indenter(wrong, SPHERE)),
    ("frame", lambda wrong: rc.restore(wrong, 1.0)),
    ("frame", lambda wrong: rc.pressure_of(wrong)),
    (
        "validity",
        lambda wrong: followed(
            rc.load_path, atoms(), penetrations=[0.1], validity=wrong
        ),
    ),
    (
        "output",
        lambda wrong: followed(rc.load_path, atoms(), penetrations=[0.1], output=wrong),
    ),
    ("solid", lambda wrong: rc.Problem(SPHERE, wrong, WALL, 1.0)),
    ("wall", lambda wrong: rc.Problem(SPHERE, SOLID, wrong, 1.0)),
    ("fft", lambda wrong: rc.Problem(SPHERE, SOLID, WALL, 1.0, fft=wrong)),
    ("periodic", lambda wrong: rc.Problem(SPHERE, SOLID, WALL, 1.0, periodic=wrong)),
    ("problem", lambda wrong: rc.Stepper(wrong, "loads", WINDOW)),
    ("start", lambda wrong: rc.Stepper(PROBLEM, "loads", wrong)),
    ("options", lambda wrong: rc.Stepper(PROBLEM, "loads", WINDOW, wrong)),
    ("springs", lambda wrong: rc.Stepper(PROBLEM, "loads", WINDOW, springs=wrong)),
    ("window", lambda wrong: rc.State(wrong, 0.0, np.zeros((8, 8)))),
    ("pressure", lambda wrong: rc.State(WINDOW, 0.0, wrong)),
    ("creep", lambda wrong: rc.Viscoelastic(1.0, wrong)),
    ("compliances", lambda wrong: rc.Creep(wrong, [1.0])),
    ("record", lambda wrong: rc.Output(record=wrong)),
    ("csv", lambda wrong: rc.Output(csv=wrong)),
    ("trajectory", lambda wrong: rc.Output(trajectory=wrong)),
    ("hardness", lambda wrong: rc.Validity("warn", hardness=wrong)),
    ("permanent", lambda wrong: rc.PlasticWall(1.0, permanent=wrong)),
    ("periodic", lambda wrong: rc.substrate("Cu", (8, 8), SPHERE, periodic=wrong)),
    ("fixed", lambda wrong: rc.substrate("Cu", (8, 8), SPHERE, fixed=wrong)),
    (
        "callback",
        lambda wrong: rc.adhesion_loop(atoms(), deepest=0.1, step=0.1, callback=wrong),
    ),
    ("scenes", lambda wrong: rc.ensemble.run_ensemble([wrong], "e.db")),
    ("symbol", lambda wrong: crystal_slab(wrong, (2, 2), 2, None)),
    ("surface", lambda wrong: ElasticFoundation(None, wrong, atoms())),
    ("foundation", lambda wrong: FoundationPrecon(atoms(), wrong)),
]


@pytest.mark.parametrize(
    "name, call",
    CALLS,
    ids=[f"{number}-{name}" for number, (name, _) in enumerate(CALLS)],
)
def test_an_argument_of_another_kind_is_named(name, call):
    class Anything:
        pass

    switch = name in ("periodic", "permanent", "fixed")
    error = ValueError if switch else TypeError
    with pytest.raises(error, match=f"^{name} must be .*, got .*Anything"):
        call(Anything())


@pytest.mark.parametrize("key", ["penetrations", "loads"])
def test_masked_targets_are_refused(key):
    masked = np.ma.array([0.1, 99.0], mask=[False, True])
    pressed = atoms_under(SPHERE, WALL, fixed=key == "penetrations")
    with pytest.raises(ValueError, match=f"{key} must be"):
        followed(rc.load_path, pressed, **{key: masked})
