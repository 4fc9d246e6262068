"""A run of a solver: its steps, what it costs, and why it has ended."""

import pytest
from contacts import constant, contact_of, rough_sphere

import ase_roughcontact as rc
from ase_roughcontact.contact import State
from ase_roughcontact.contact.support import Support
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.soft.newton import default_relaxer

WALLS = [rc.HardWall(), rc.LennardJones93.repulsive(1.0, 1.0)]


@pytest.fixture(params=WALLS, ids=["hard", "soft"])
def contact(request):
    return contact_of(rough_sphere((32, 32)), request.param, periodic=True)


def test_a_run_out_of_steps_says_so(contact):
    state = State.flat(Box((0, 0), (32, 32)), contact.first_contact)
    relax = default_relaxer(contact.wall)
    ends = [relax(contact, state, Support(False, 20.0), 1e-9, n) for n in (0, 1, 99)]
    assert [run.iterations for run in ends[:2]] == [0, 1]
    assert [run.message for run in ends[:2]] == [
        "not converged after 0 steps; allow more steps",
        "not converged after 1 steps; allow more steps",
    ]
    assert [run.converged for run in ends] == [False, False, True]
    assert not ends[2].message and ends[2].pairs > ends[1].pairs > 0.0


def test_pairs_agree_with_the_solver_alone(contact):
    def pairs(between):
        found = []
        for state in default_relaxer(contact.wall).solver(
            contact,
            height=0.0,
            external=constant(20.0),
            start=None,
            tolerance=1e-9,
        ):
            found.append(state.pairs)
            between(state)
        return found

    expected = pairs(lambda state: None)
    assert min(expected) > 0.0
    assert pairs(lambda state: contact.halfspace.displacement(state.pressure)) == (
        expected
    )
