"""Numbers: arrays, lists, strings and truth values in their place are refused."""

from dataclasses import asdict
from functools import partial

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact import analysis, theory
from ase_roughcontact.interactions import FullLennardJones93, make_wall
from ase_roughcontact.solvers.options import ActiveSetOptions, NewtonKrylovOptions

SPHERE = rc.RoughSphere(10.0)
ROUGH = rc.SelfAffine(0.1, 0.8, 4.0, 16.0)
FULL = rc.LennardJones93.full(distance=1.0, work_of_adhesion=0.04, cutoff=3.0)


def make_atoms(load=0.0, wall=None, fixed=True):
    return atoms_under(SPHERE, wall, (4, 4), load=load, periodic=True, fixed=fixed)


def energy(**options):
    return make_atoms(**options).get_potential_energy()


def path(**options):
    return list(rc.load_path(make_atoms(), penetrations=[0.1], **options))


def loop(**options):
    wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.05)
    return rc.adhesion_loop(make_atoms(wall=wall), accuracy=1e-2, **options)


def wall_of_a_scene(work_of_adhesion, **lengths):
    parameters = {"work_of_adhesion": work_of_adhesion}
    return make_wall("adhesive", parameters=parameters, **lengths)


def rough_theory(**options):
    return theory.RoughSphereTheory(roughness=ROUGH, **options)


SOLID = {"contact_modulus": 1.0, "spacing": 1.0}
HERTZ = {"radius": 10.0, "contact_modulus": 1.0}
ADHESION = {"work_of_adhesion": 0.05, "attraction_range": 1.0}
FACTORS = {"kappa_repulsive": 2.0, "asperity_factor": 1.0}
# Functions and valid values of all their arguments that are numbers.
FUNCTIONS = {
    "RoughSphere": (rc.RoughSphere, {"radius": 10.0}),
    "SelfAffine": (
        rc.SelfAffine,
        asdict(ROUGH) | {"longest_wavelength": 16.0} | {"domain": 64.0},
    ),
    "heights": (partial(SPHERE.heights, (4, 4)), {"spacing": 1.0}),
    "substrate": (
        partial(rc.substrate, "Cu", (4, 4), SPHERE),
        {"spacing": 1.0, "height": 2.0},
    ),
    "RoughContact": (partial(energy, fixed=False), {"load": 0.1}),
    "modulus": (lambda modulus: rc.RoughContact(SPHERE, modulus), {"modulus": 1.0}),
    "repulsive": (rc.LennardJones93.repulsive, SOLID),
    "adhesive": (rc.LennardJones93.adhesive, SOLID | {"work_of_adhesion": 0.02}),
    "full": (rc.LennardJones93.full, {"distance": 1.0, "work_of_adhesion": 0.04}),
    "FullLennardJones93": (FullLennardJones93, asdict(FULL)),
    "make_wall": (wall_of_a_scene, SOLID | {"work_of_adhesion": 0.1}),
    "load_path": (path, {"fmax": 1e-2, "max_steps": 9}),
    "accuracy": (path, {"accuracy": 1e-2}),
    "adhesion_loop": (
        loop,
        {"deepest": 0.2, "step": 0.4, "smallest_step": 0.4, "tolerance": 0.5},
    ),
    "NewtonKrylovOptions": (NewtonKrylovOptions, asdict(NewtonKrylovOptions())),
    "ActiveSetOptions": (ActiveSetOptions, asdict(ActiveSetOptions())),
    "first_contact": (partial(analysis.first_contact, SPHERE), {"spacing": 1.0}),
    "regime": (theory.regime, {"normal_force": 1.0} | HERTZ | ADHESION | FACTORS),
    "RoughSphereTheory": (rough_theory, HERTZ | ADHESION | FACTORS),
    "Hertz": (theory.Hertz, HERTZ),
    "MaugisDugdale": (theory.MaugisDugdale, HERTZ | ADHESION),
}
TEXT = {"normalise", "random_amplitudes", "seed"}
NO_NUMBERS = [np.array([1.0, 2.0]), np.array([1.0]), [1.0], "1", True, 1j, np.nan]


@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_is_no_number_is_refused_by_name(name):
    function, arguments = FUNCTIONS[name]
    function(**arguments)
    for key in arguments.keys() - TEXT:
        for value in NO_NUMBERS:
            with pytest.raises(ValueError, match=r"must be|got|unknown") as error:
                function(**{**arguments, key: value})
            message = str(error.value)
            assert "ambiguous" not in message and "sequence" not in message, key
