"""Options of steps: the name of an optimizer, by which paths are resumed."""

from dataclasses import dataclass
from functools import partial

import numpy as np
import pytest
from ase.optimize import FIRE
from built import atoms_under

import ase_roughcontact as rc


class Observer:
    def __call__(self, *arguments):
        pass


class Described:
    def __init__(self, number):
        self.number = number

    def todict(self):
        return {"number": self.number}


@dataclass
class Settings:
    number: float
    observer: Observer


def relaxed(*arguments, **options):
    raise NotImplementedError


def name_of(*arguments, **options):
    return rc.StepOptions(relaxer=partial(relaxed, *arguments, **options)).optimizer


@pytest.mark.parametrize(
    "made",
    [
        Observer,
        object,
        lambda: [Observer()],
        lambda: {"observer": object()},
        lambda: partial(FIRE, observer=Observer()),
        lambda: Settings(0.1, Observer()),
    ],
)
def test_equal_objects_bound_to_an_optimizer_have_one_name(made):
    first, second = made(), made()  # at two addresses
    assert name_of(first) == name_of(second)
    assert name_of(bound=first) == name_of(bound=second)


@pytest.mark.parametrize(
    "one, other",
    [
        (1.0, 2.0),
        ("a", "b"),
        (True, np.bool_(False)),
        ([1], [2]),
        ({"a": 1}, {"a": 2}),
        (np.zeros(2), np.ones(2)),
        (Described(1), Described(2)),
        (Settings(0.1, Observer()), Settings(0.2, Observer())),
        (partial(FIRE, dt=0.1), partial(FIRE, dt=0.2)),
    ],
)
def test_other_values_bound_to_an_optimizer_have_other_names(one, other):
    assert name_of(one) != name_of(other)
    assert name_of(bound=one) != name_of(bound=other)


def test_numbers_and_strings_stand_in_the_name_of_an_optimizer():
    assert name_of(FIRE, dt=0.1, name="a") == "relaxed FIRE dt=0.1 name=a"


def test_steps_that_did_not_converge_are_kept_for_an_equal_optimizer(tmp_path):
    calls = []

    def fire(atoms, logfile=None, **bound):
        calls.append(bound)
        return FIRE(atoms, logfile=logfile)

    def steps():
        path = rc.load_path(
            atoms_under(rc.RoughSphere(radius=50.0), rc.LennardJones93.repulsive(1, 1)),
            penetrations=[0.1, 0.2],
            optimizer=partial(fire, observers=[Observer()], settings=object()),
            max_steps=1,
            output=rc.Output(restart=tmp_path / "a.npz", resume=True),
        )
        return list(path)

    first = steps()
    assert not any(step.converged for step in first) and len(calls) == 2
    assert steps() == first and len(calls) == 2
