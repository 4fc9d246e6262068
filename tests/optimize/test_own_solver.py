"""A solver from outside the package: a generator and a subclass, used by load paths."""

from functools import partial

import numpy as np
import pytest
from built import atoms_under

from ase_roughcontact import RoughSphere, load_path
from ase_roughcontact.optimize import ContactOptimizer
from ase_roughcontact.solvers.relaxation import Relaxation
from ase_roughcontact.solvers.status import Status

# The solver, in at most 40 lines.


def gradient_descent(contact, *, height, external, start, tolerance):
    """Lower the error of ``p = p_wall(u(p))`` at a fixed height by damped iteration."""
    if external is not None:
        raise ValueError("gradient_descent needs a fixed indenter")
    halfspace = contact.halfspace
    pressure = np.zeros(halfspace.shape) if start is None else start.copy()
    stiffness = 2.0 * halfspace.contact_modulus / halfspace.spacing
    while True:
        displacement = halfspace.displacement(pressure)
        wall_energy, wall_pressure = contact.evaluate_wall(
            contact.gap(displacement, height)
        )
        residual = wall_pressure - pressure
        error = float(np.abs(residual).max() * halfspace.cell_area)
        elastic_energy = -0.5 * np.sum(displacement * pressure)
        yield Relaxation(
            pressure=pressure,
            height=height,
            energy=float((elastic_energy + wall_energy.sum()) * halfspace.cell_area),
            error=error,
            status=Status.of(error < tolerance),
            pairs=1.0,
        )
        pressure = pressure + residual * stiffness / (stiffness + 20.0)


class GradientDescent(ContactOptimizer):
    """Damped fixed-point iteration for soft walls and a fixed indenter."""

    solver = staticmethod(gradient_descent)
    springs = False


SPHERE = RoughSphere(40.0)


def path(optimizer, **options):
    atoms = atoms_under(SPHERE, shape=(14, 14))
    return list(
        load_path(
            atoms, penetrations=[0.2, 0.4], optimizer=optimizer, fmax=1e-7, **options
        )
    )


@pytest.mark.parametrize("window", ["fixed", "auto"])
@pytest.mark.parametrize(
    "optimizer",
    [GradientDescent, partial(GradientDescent, append_trajectory=False)],
    ids=["class", "partial"],
)
def test_own_solver_relaxes_the_steps_of_a_load_path(optimizer, window):
    records, expected = path(optimizer, window=window), path(None, window=window)
    assert all(record.converged for record in records)
    assert [record.window for record in records] == [
        record.window for record in expected
    ]
    for record, reference in zip(records, expected, strict=True):
        assert record.normal_force == pytest.approx(reference.normal_force, rel=1e-5)
        assert record.iterations == record.pairs > reference.iterations
