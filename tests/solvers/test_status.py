"""Status of solutions: kinds, and texts with numbers, units and advice."""

import pytest
from contacts import contact_of, rough_sphere

import ase_roughcontact as rc
from ase_roughcontact.contact.support import Support
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.solvers.relaxation import SolverRelaxer
from ase_roughcontact.solvers.soft.newton import newton_krylov
from ase_roughcontact.solvers.status import (
    CONVERGED,
    ENDED,
    STEP_LIMIT,
    UNFINISHED,
    Status,
    StatusKind,
)

STALLED = StatusKind("stalled at {force:.2g}{force_unit}", "lower it")


@pytest.mark.parametrize(
    ("kind", "converged", "final"),
    [
        (CONVERGED, True, True),
        (UNFINISHED, False, False),
        (STEP_LIMIT, False, True),
        (STALLED, False, True),
    ],
)
def test_only_an_unfinished_solution_has_a_further_step(kind, converged, final):
    status = Status(kind, {"force": 1.0, "steps": 1})
    assert (status.converged, status.final) == (converged, final)
    assert bool(status.message) == (final and not converged)


def test_text_has_numbers_units_and_advice():
    status = Status(STALLED, {"force": 0.0123})
    assert status.message == "stalled at 0.012; lower it"
    assert status.text("eV/Å") == "stalled at 0.012 eV/Å; lower it"


def test_advice_for_a_solution_replaces_the_advice_of_its_kind():
    status = Status(STALLED, {"force": 1.0}, "use double precision")
    assert status.message == "stalled at 1; use double precision"


def run(solver, max_steps=50):
    wall = rc.LennardJones93.repulsive(1.0, 1.0)
    contact = contact_of(rough_sphere((16, 16)), wall, periodic=True)
    state = rc.State.flat(Box((0, 0), (16, 16)), -1.0)
    return SolverRelaxer(solver)(contact, state, Support(True), 1e-6, max_steps)


def test_a_relaxation_that_is_stopped_has_reached_the_limit_of_steps():
    status = run(newton_krylov, 1).status
    assert (status.kind, status.numbers) == (STEP_LIMIT, {"steps": 1})


def test_a_solver_that_gives_up_without_a_reason_has_ended():
    def nothing(contact, *, height, external, start, tolerance):
        yield from ()

    assert run(nothing).status.kind == ENDED
