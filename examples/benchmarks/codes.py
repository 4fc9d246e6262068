"""One function for each code: a `Problem` in, an `Answer` out.

Each is written as the code's own documentation has it, with the settings that were
fastest for it. What depends on the grid alone is done before the clock of the solution
starts, and reported as `setup`. A code that is not installed raises ImportError.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from time import perf_counter
from typing import Any

import numpy as np
from problems import TOLERANCE, Answer, Problem

from ase_roughcontact._util.threads import available_threads
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace

Solver = Callable[[Problem], Answer]

# Relative tolerances of the peers that leave a largest gap in contact of about 1e-6 a0.
_ASPHER = 1e-7
_TAMAAS = 1e-6
# Steps of Tamaas' saturated solver, whose answer does not change after the first 100.
_SATURATED_STEPS = 100
# With adhesion, and the number of steps after which it does not end otherwise.
_TAMAAS_ADHESION, _TAMAAS_STEPS = 1e-9, 3000


def timed(function: Callable, *args: Any, **kwargs: Any) -> tuple[float, Any]:
    """Seconds that a call took, and what it returned."""
    start = perf_counter()
    result = function(*args, **kwargs)
    return perf_counter() - start, result


def solve_ours(problem: Problem, press: bool = False) -> Answer:
    """Ours, arrays in and arrays out; `press` puts the load on a soft wall too."""
    from ase_roughcontact.solvers.hard.active_set import active_set
    from ase_roughcontact.solvers.soft.newton import newton_krylov

    def solve() -> tuple[Any, int, float]:
        solver = active_set if problem.hard else newton_krylov
        loaded = problem.hard or press
        steps, pairs = 0, 0.0
        for state in solver(
            contact,
            height=contact.first_contact if loaded else problem.height,
            external=problem.press if loaded else None,
            start=None,
            tolerance=TOLERANCE / 1.122 if problem.hard else TOLERANCE,
        ):
            steps, pairs = steps + 1, pairs + state.pairs
        return state, steps, pairs

    setup, contact = timed(problem.contact)
    seconds, (state, steps, pairs) = timed(solve)
    return Answer(setup, seconds, steps, pairs, pressure=state.pressure)


def solve_ours_ase(problem: Problem) -> Answer:
    """Ours as ASE optimizers: atoms in, relaxed atoms out."""
    from ase_roughcontact import ActiveSet, NewtonKrylov
    from ase_roughcontact.atoms.calculator import contact_of

    def solve() -> Any:
        optimizer = (ActiveSet if problem.hard else NewtonKrylov)(atoms)
        optimizer.run(fmax=TOLERANCE / 1.122 if problem.hard else TOLERANCE)
        return optimizer

    def prepare() -> Any:
        atoms = problem.atoms()
        halfspace = contact_of(atoms).halfspace
        halfspace.displacement(np.zeros(problem.shape))
        return atoms

    setup, atoms = timed(prepare)
    seconds, optimizer = timed(solve)
    answer = partial(Answer, setup, seconds, optimizer.nsteps, optimizer.pairs)
    if problem.wall.hard:
        return answer(pressure=atoms.calc.state(atoms).pressure)
    grid = FreeHalfSpace.padded_shape(problem.shape)
    return answer(displacement=atoms.positions[:-1, 2].reshape(grid))


def solve_contactmechanics(problem: Problem) -> Answer:
    """ContactMechanics: conjugate gradients of Polonsky and Keer."""
    setup, (halfspace, surface) = timed(_contactmechanics, problem)
    from ContactMechanics.PlasticSystemSpecialisations import (
        PlasticNonSmoothContactSystem,
    )
    from ContactMechanics.Systems import NonSmoothContactSystem
    from SurfaceTopography import PlasticTopography

    system = NonSmoothContactSystem(halfspace, surface)
    if problem.plastic:
        surface = PlasticTopography(surface, problem.wall.hardness)
        system = PlasticNonSmoothContactSystem(halfspace, surface)
    seconds, result = timed(
        system.minimize_proxy, external_force=problem.load, pentol=TOLERANCE
    )
    return Answer(setup, seconds, result.nit, result.nfev, pressure=result.jac)


def solve_tamaas(problem: Problem) -> Answer:
    """Tamaas: conjugate gradients after Rey, or saturated after Stanley and Kato."""
    import tamaas as tm

    def prepare() -> Any:
        tm.initialize(available_threads())
        tm.set_log_level(tm.LogLevel.error)
        side = float(problem.n)
        model = tm.ModelFactory.createModel(
            tm.model_type.basic_2d, [side, side], list(problem.shape)
        )
        model.E, model.nu = 1.0, 0.0
        kind = tm.PolonskyKeerRey.pressure
        solver = tm.PolonskyKeerRey(model, -problem.heights, _TAMAAS, kind, kind)
        if problem.plastic:
            pressure = problem.wall.hardness
            solver = tm.KatoSaturated(model, -problem.heights, _TAMAAS, pressure)
        solver.max_iter = _SATURATED_STEPS if problem.plastic else 100_000
        if not problem.periodic:
            tm.ModelFactory.registerNonPeriodic(model, "dcfft")
            solver.setIntegralOperator("dcfft")
        return model, solver

    setup, (model, solver) = timed(prepare)
    seconds, _ = timed(solver.solve, problem.load / problem.n**2)
    return Answer(setup, seconds, pressure=np.array(model.traction))


def solve_tamaas_adhesion(problem: Problem) -> Answer:
    """Tamaas: conjugate gradients after Rey in the gap, with an adhesive functional."""
    import tamaas as tm

    def prepare() -> Any:
        tm.initialize(available_threads())
        tm.set_log_level(tm.LogLevel.error)
        side, surface = float(problem.n), -problem.heights
        model = tm.ModelFactory.createModel(
            tm.model_type.basic_2d, [side, side], list(problem.shape)
        )
        model.E, model.nu = 1.0, 0.0
        kinds = tm.PolonskyKeerRey.gap, tm.PolonskyKeerRey.pressure
        solver = tm.PolonskyKeerRey(model, surface, _TAMAAS_ADHESION, *kinds)
        forms = {
            "exponential": tm.ExponentialAdhesionFunctional,
            "dugdale": tm.MaugisAdhesionFunctional,
        }
        functional = forms[problem.wall.kind](surface)
        functional.parameters = {
            "surface_energy": problem.wall.work_of_adhesion,
            "rho": problem.wall.attraction_range,
        }
        solver.addFunctionalTerm(functional)
        solver.max_iter = _TAMAAS_STEPS
        return model, solver, functional

    setup, (model, solver, _) = timed(prepare)
    seconds, _ = timed(solver.solve, problem.load / problem.n**2)
    return Answer(setup, seconds, pressure=np.array(model.traction))


def solve_aspher(problem: Problem) -> Answer:
    """ASPHER: preconditioned conjugate gradients, FFT convolution."""
    import aspher

    setup, solver = timed(
        aspher.ContactSolver,
        grid_size=problem.n,
        domain_size=float(problem.n),
        E_star=1.0,
        backend="periodic" if problem.periodic else "fft",
    )
    seconds, result = timed(
        solver.solve,
        problem.heights,
        problem.load / problem.n**2,
        tol=_ASPHER,
        precond="fourier-fft",
    )
    return Answer(
        setup,
        seconds,
        result.iterations,
        result.matvec_count,
        pressure=result.pressure,
    )


def solve_aspher_nested(problem: Problem) -> Answer:
    """ASPHER: from coarse to fine grids and floats, operators made on the way."""
    import aspher

    seconds, result = timed(
        aspher.solve_nested,
        problem.n,
        problem.heights,
        problem.load / problem.n**2,
        domain_size=float(problem.n),
        backend="periodic" if problem.periodic else "fft",
        precond_engine="fft",
        precision="float_then_double",
        tol=_ASPHER,
    )
    return Answer(0.0, seconds, result.iterations, pressure=result.pressure)


def solve_adhesion(problem: Problem, method: str) -> Answer:
    """Adhesion's system, minimised by SciPy or NuMPI, with our wall as its potential.

    From the flat surface, displacements of the whole padded grid being the unknowns.
    """
    from adhesion_wall import system
    from NuMPI.Optimization import l_bfgs, tr_newton_bounded
    from scipy.optimize import minimize

    setup, (halfspace, surface) = timed(_contactmechanics, problem)
    contact = system(halfspace, surface, problem.wall)
    energy = contact.objective(-problem.height, gradient=True)
    start = np.zeros((2 * problem.n, 2 * problem.n))
    many = 100_000
    if method == "scipy":
        limits = {"gtol": TOLERANCE, "ftol": 0.0, "maxiter": many, "maxfun": many}
        solve = partial(
            minimize, energy, start.ravel(), jac=True, method="L-BFGS-B", options=limits
        )
    elif method == "numpi":
        solve = partial(l_bfgs, energy, start, jac=True, gtol=TOLERANCE, maxiter=many)
    else:
        product = contact.hessian_product_function(-problem.height)
        solve = partial(
            tr_newton_bounded, energy, start, product, gtol=TOLERANCE, maxiter=many
        )
    seconds, result = timed(solve)
    displacement = -np.reshape(result.x, start.shape)
    return Answer(setup, seconds, result.nit, displacement=displacement)


def solve_adhesion_bounded(problem: Problem) -> Answer:
    """Adhesion's system with bounds, with our wall as its potential, by L-BFGS-B."""
    from Adhesion.System import BoundedSmoothContactSystem
    from adhesion_wall import Wall

    setup, (halfspace, surface) = timed(_contactmechanics, problem)
    system = BoundedSmoothContactSystem(halfspace, Wall(problem.wall), surface)
    many = 100_000
    limits = {"gtol": TOLERANCE, "ftol": 0.0, "maxiter": many, "maxfun": many}
    seconds, result = timed(
        system.minimize_proxy, offset=-problem.height, options=limits
    )
    displacement = -np.reshape(result.x, (2 * problem.n, 2 * problem.n))
    return Answer(setup, seconds, result.nit, displacement=displacement)


def _contactmechanics(problem: Problem) -> tuple[Any, Any]:
    from ContactMechanics import FreeFFTElasticHalfSpace, PeriodicFFTElasticHalfSpace
    from SurfaceTopography import Topography

    sides = (float(problem.n), float(problem.n))
    kind = PeriodicFFTElasticHalfSpace if problem.periodic else FreeFFTElasticHalfSpace
    surface = Topography(-problem.heights, sides, periodic=problem.periodic)
    return kind(problem.shape, 1.0, sides), surface


PLASTIC: dict[str, Solver] = {
    "ours": solve_ours,
    "ours-ase": solve_ours_ase,
    "tamaas": solve_tamaas,
    "contactmechanics": solve_contactmechanics,
}
HARD: dict[str, Solver] = {
    "ours": solve_ours,
    "ours-ase": solve_ours_ase,
    "aspher": solve_aspher,
    "aspher-nested": solve_aspher_nested,
    "tamaas": solve_tamaas,
    "contactmechanics": solve_contactmechanics,
}
SOFT: dict[str, Solver] = {
    "ours": solve_ours,
    "ours-load": partial(solve_ours, press=True),
    "ours-ase": solve_ours_ase,
    "adhesion-scipy": partial(solve_adhesion, method="scipy"),
    "adhesion-numpi": partial(solve_adhesion, method="numpi"),
    "adhesion-newton": partial(solve_adhesion, method="newton"),
}
ADHESIVE: dict[str, Solver] = {
    "ours": solve_ours,
    "ours-ase": solve_ours_ase,
    "adhesion-bounded": solve_adhesion_bounded,
}
ADHESIVE_PERIODIC: dict[str, Solver] = {
    "ours": solve_ours,
    "ours-ase": solve_ours_ase,
    "tamaas-adhesion": solve_tamaas_adhesion,
}
SOLVERS = {
    "hard": HARD,
    "plastic": PLASTIC,
    "adhesive": ADHESIVE,
    "adhesive-periodic": ADHESIVE_PERIODIC,
    "soft": SOFT,
}
