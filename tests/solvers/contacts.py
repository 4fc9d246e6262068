"""Contacts, loads and relaxations that the tests of the solvers share."""

import numpy as np

from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.optimality import optimality_residuals
from ase_roughcontact.solvers.options import ActiveSetOptions, NewtonKrylovOptions
from ase_roughcontact.solvers.soft.newton import newton_krylov
from ase_roughcontact.topography import RoughSphere, SelfAffine

ROUGH = SelfAffine(0.1, 0.8, 4.0, 64.0, seed=3)


def contact_of(heights, wall, *, periodic=False, spacing=1.0, solid=1.0, adhesion=None):
    kind = PeriodicHalfSpace if periodic else FreeHalfSpace
    return Contact(kind(heights.shape, spacing, solid), heights, wall, adhesion)


def centred(shape, spacing=1.0):
    """Origin of a window with the axis of a sphere in its middle."""
    return tuple(-spacing * (n // 2) for n in shape)


def rough_sphere(shape, radius=200.0, roughness=ROUGH):
    return RoughSphere(radius, roughness).heights(shape, 1.0, centred(shape))


def constant(load):
    """Energy and force of a load on the indenter."""
    return lambda height: (load * height, -load)


def spring(stiffness, rest):
    """Energy and force of a spring to a height."""
    return lambda height: (
        0.5 * stiffness * (height - rest) ** 2,
        -stiffness * (height - rest),
    )


def steps(contact, load=None, height=0.0, start=None, tolerance=1e-6, **options):
    """All states of the solver of a wall under a load or the law of a support."""
    hard = contact.wall.purely_hard
    solver, kind = (
        (active_set, ActiveSetOptions) if hard else (newton_krylov, NewtonKrylovOptions)
    )
    return list(
        solver(
            contact,
            height=height,
            external=load if load is None or callable(load) else constant(load),
            start=start,
            tolerance=tolerance,
            options=kind(**options),
        )
    )


def solve(contact, load=None, height=0.0, start=None, tolerance=1e-6, **options):
    """The last state, which must have converged."""
    last = steps(contact, load, height, start, tolerance, **options)[-1]
    assert last.converged, last.message
    return last


def pairs(states):
    return sum(state.pairs for state in states)


def green(contact):
    """Dense Green's function of the window."""
    shape = contact.heights.shape
    units = np.eye(contact.heights.size).reshape(-1, *shape)
    return -np.array([contact.halfspace.displacement(u).ravel() for u in units]).T


def assert_optimal(contact, state, load=None, gap=1e-6, missing=1e-12):
    """Check the conditions of contact with a hard wall, gaps in spacings."""
    errors = optimality_residuals(contact, state.pressure, state.height, load)
    assert errors.tension == errors.excess == 0.0
    largest = gap * contact.halfspace.spacing
    assert max(errors.gap_in_contact, errors.penetration) <= largest
    assert errors.opening_at_hardness <= largest
    if load is not None:
        assert errors.load_error <= missing * (load or 1.0)
