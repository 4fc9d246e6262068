"""Extreme parameters: solvers converge over their whole range, and report its limits.

Every relaxation is checked for convergence, finite numbers, an energy that falls in
each step, and a balance of forces by an independent convolution.
"""

import gc
import tracemalloc
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from built import atoms_under
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

import ase_roughcontact as rc
from ase_roughcontact.contact import Contact
from ase_roughcontact.elasticity.halfspace import FreeHalfSpace, PeriodicHalfSpace
from ase_roughcontact.solvers.hard.active_set import active_set
from ase_roughcontact.solvers.optimality import optimality_residuals
from ase_roughcontact.solvers.soft.newton import newton_krylov

EPS = float(np.finfo(float).eps)

WALLS = {
    "repulsive": rc.LennardJones93.repulsive,
    "adhesive": lambda e, a: rc.LennardJones93.adhesive(e, a, 0.02 * e * a),
    "full": lambda e, a: rc.LennardJones93.full(
        distance=a, work_of_adhesion=0.04 * e * a, cutoff=3.0 * a
    ),
    "hard": lambda e, a: rc.HardWall(),
    "plastic": lambda e, a: rc.PlasticWall(0.05 * e),
    "exponential": lambda e, a: rc.ExponentialWall(0.02 * e * a, 0.7 * a, 3.0),
    "power-law": lambda e, a: rc.PowerLawWall(0.02 * e * a, 0.7 * a, 3.0, 3.0),
    "dugdale": lambda e, a: rc.DugdaleWall(0.02 * e * a, 0.7 * a),
}
UNIQUE = ("repulsive", "hard")  # without attraction there is a single minimum
HARD = ("plastic", "exponential", "power-law", "dugdale")  # other hard walls
every_wall = pytest.mark.parametrize(
    "wall",
    [
        *sorted(WALLS.keys() - set(HARD)),
        *(pytest.param(w, marks=pytest.mark.slow) for w in HARD),
    ],
)

# Ends of the ranges of the tests below, in the words of the guide
RANGES = {
    "radius of the sphere": (10.0, 1e8),
    "load": (1e-12, 1e4),
    "rms slope": (1e-6, 1.0),
    "work of adhesion over $E^*$": (0.0, 0.05),
    "stiffness of the wall, in $E^*/a_0$": (1e-3, 1e4),
    "Hurst exponent": (0.01, 0.99),
    "modulus and spacing, in any unit": (1e-30, 1e30),
    "atoms along a side of the window": (1, 4096),
    "overlap with the indenter at the start": (1.0, 1e4),
    "distance of the indenter": (10.0, 1e100),
    "pressure of a random start, in $E^*$": (1e-12, 1e12),
}
PAGE = Path(__file__).parents[1] / "examples" / "guide" / "tested_ranges.md"

bounded = settings(max_examples=30, deadline=None, derandomize=True, database=None)
walls = st.sampled_from(sorted(WALLS))


def decades(first, last):
    return st.floats(np.log10(first), np.log10(last)).map(lambda x: 10.0**x)


RADIUS, LOAD, SLOPE, WORK, STIFFNESS, HURST, UNITS, SIDE, DEPTH, DISTANCE, START = (
    RANGES.values()
)


def rough(slope=0.1, hurst=0.8, short=4.0, long=16.0, spacing=1.0, seed=1):
    return rc.SelfAffine(slope, hurst, short * spacing, long * spacing, seed=seed)


def contact_of(indenter, wall, shape=(24, 24), modulus=1.0, spacing=1.0, **options):
    periodic = options.pop("periodic", False)
    kind = PeriodicHalfSpace if periodic else FreeHalfSpace
    halfspace = kind(shape, spacing, modulus, **options)
    if isinstance(wall, str):
        wall = WALLS[wall](modulus, spacing)
    corner = tuple(-spacing * (n // 2) for n in shape)
    return Contact(halfspace, indenter.heights(shape, spacing, corner), wall)


def contact_on(heights, wall, periodic=False):
    kind = PeriodicHalfSpace if periodic else FreeHalfSpace
    return Contact(kind(heights.shape, 1.0, 1.0), heights, WALLS[wall](1.0, 1.0))


def steps(contact, load=None, height=None, start=None, tolerance=1e-9):
    """All steps of a relaxation; loads and tolerances in units of E* a0^2."""
    halfspace = contact.halfspace
    unit = halfspace.contact_modulus * halfspace.cell_area
    constrained = contact.wall.hard and not contact.wall.attractive
    external = None
    if load is not None:
        load = bearable(contact, load)
        external = lambda z: (load * unit * z, -load * unit)  # noqa: E731
    return list(
        (active_set if constrained else newton_krylov)(
            contact,
            height=contact.first_contact if height is None else height,
            external=external,
            start=start,
            tolerance=tolerance * unit,
        )
    )


def bearable(contact, load):
    """Return a load, at most 0.9 of what the hardness bears."""
    hardness = contact.wall.hardness / contact.halfspace.contact_modulus
    return min(load, 0.9 * hardness * contact.heights.size)


def relaxed(contact, load=None, tolerance=1e-9, **options):
    """Last state of a relaxation that passes all checks."""
    states = steps(contact, load, tolerance=tolerance, **options)
    halfspace, last = contact.halfspace, states[-1]
    unit = halfspace.contact_modulus * halfspace.cell_area
    assert last.converged and not last.message, last.message
    assert np.isfinite(last.pressure).all() and np.isfinite(last.height)
    assert_energy_falls(contact, states, load)
    assert largest_force(contact, last, load) <= 1.001 * tolerance * unit + 8 * EPS * (
        halfspace.cell_area * abs(last.pressure).sum()
    )
    return last


def assert_energy_falls(contact, states, load):
    energies = np.array([minimised(contact, state, load) for state in states])
    assert np.isfinite(energies).all()
    wall = contact.wall
    # updates of the reaction, and whole steps with the inverse of a wall, may raise it
    if not (wall.hard and wall.attractive) and not wall.invertible:
        # rounding errors of the terms of the energy, which are larger at the start
        assert (np.diff(energies) <= 1e-12 * abs(energies).max()).all()


def minimised(contact, state, load):
    """Energy that is minimised: for a hard wall under a load without the load's."""
    if not contact.wall.hard:
        return state.energy
    area = contact.halfspace.cell_area
    undeformed = contact.heights + (state.height if load is None else 0.0)
    stored = 0.5 * (state.pressure * -contact.halfspace.displacement(state.pressure))
    return area * float((stored + state.pressure * undeformed).sum())


def largest_force(contact, state, load):
    """Largest force on an atom or the indenter."""
    halfspace, pressure, wall = contact.halfspace, state.pressure, contact.wall
    area = halfspace.cell_area
    wanted = bearable(contact, load or 0.0) * halfspace.contact_modulus * area
    if wall.hard and wall.attractive:
        return largest_force_of_attraction(contact, state, load, wanted)
    if wall.hard:
        errors = optimality_residuals(contact, pressure, state.height, wanted)
        gap = max(errors.gap_in_contact, errors.penetration)
        assert gap <= 1e-6 * halfspace.spacing and errors.tension == 0.0
        missing = 0.0 if load is None else errors.load_error
        return max(gap * area / halfspace.self_compliance, missing)
    gap = state.height + contact.heights - halfspace.displacement(pressure)
    repulsion = contact.evaluate_wall(gap)[1]
    missing = 0.0 if load is None else abs(area * repulsion.sum() - wanted)
    return max(area * float(abs(repulsion - pressure).max()), missing)


def largest_force_of_attraction(contact, state, load, wanted):
    """Largest force, or gap in units of it, at a hard wall with attraction."""
    halfspace, pressure = contact.halfspace, state.pressure
    area, spacing = halfspace.cell_area, halfspace.spacing
    gap = state.height + contact.heights - halfspace.displacement(pressure)
    reaction = pressure - contact.evaluate_wall(np.maximum(gap, 0.0))[1]
    touching = gap <= 1e-6 * spacing
    assert gap.min() >= -2e-6 * spacing
    missing = 0.0 if load is None else abs(area * pressure.sum() - wanted)
    open_force = area * abs(reaction[~touching]).max(initial=0.0)
    pulled = area * max(-reaction[touching].min(initial=0.0), 0.0)
    return max(open_force, pulled, missing)


# Ranges of the parameters of a scene


@settings(bounded, max_examples=60)
@given(
    radius=decades(*RADIUS),
    slope=decades(*SLOPE),
    hurst=st.floats(*HURST),
    load=decades(*LOAD),
    wall=walls,
    seed=st.integers(0, 9),
    flat=st.booleans(),
)
def test_any_radius_and_roughness_carry_any_load(
    radius, slope, hurst, load, wall, seed, flat
):
    indenter = rough(slope, hurst, long=12.0, seed=seed)
    if not flat:
        indenter = rc.RoughSphere(radius, indenter)
    contact = contact_of(indenter, wall, periodic=flat)
    relaxed(contact, load, max(1e-9 * load, 1e-12))


@bounded
@given(work=st.floats(*WORK), stiffness=decades(*STIFFNESS), load=decades(1e-6, 1e2))
def test_walls_of_any_stiffness_and_work_of_adhesion_relax(work, stiffness, load):
    wall = rc.LennardJones93.adhesive(1.0, 1.0, work, stiffness=stiffness)
    contact = contact_of(rc.RoughSphere(100.0, rough(long=12.0)), wall)
    # the rounding of a gap times the wall's stiffness is a force
    relaxed(contact, load, max(1e-9 * load, 1e-12 + 8 * EPS * stiffness))


@pytest.mark.parametrize("wall", UNIQUE)
def test_automatic_windows_work_for_a_radius_of_a_hundred_million_atoms(wall):
    sphere = rc.RoughSphere(1e8)
    atoms = atoms_under(sphere, WALLS[wall](1.0, 1.0), fixed=False)
    loads = [1e-9, 1e-6, 1e-5]
    records = list(rc.load_path(atoms, loads=loads, window="auto"))
    assert all(record.converged for record in records)
    assert_allclose([r.normal_force for r in records], loads, rtol=1e-6)
    hertz = np.pi * (0.75e8 * loads[-1]) ** (2.0 / 3.0)
    assert records[-1].contact_area == pytest.approx(hertz, rel=0.15)


def test_ranges_in_the_guide_agree_with_these_tests():
    table = PAGE.read_text().partition("| from | to |\n")[2].partition("\n\n")[0]
    shown = [line.strip("| ").split(" | ") for line in table.splitlines()[1:]]
    ends = {quantity: (float(first), float(last)) for quantity, first, last in shown}
    assert ends == RANGES


# Scaling


@every_wall
@pytest.mark.parametrize("modulus", UNITS)
@pytest.mark.parametrize("spacing", [UNITS[0], 1.0, UNITS[1]])
def test_pressures_scale_with_the_modulus_and_lengths_with_the_spacing(
    wall, periodic, spacing, modulus
):
    def state(spacing, modulus):
        surface = rough(spacing=spacing, long=12.0)
        surface = surface if periodic else rc.RoughSphere(100.0 * spacing, surface)
        contact = contact_of(
            surface, wall, modulus=modulus, spacing=spacing, periodic=periodic
        )
        return relaxed(contact, 2.0, 1e-11)

    scaled, plain = state(spacing, modulus), state(1.0, 1.0)
    largest = plain.pressure.max()
    tolerance = 1e-12 if spacing == 1.0 else 1e-10
    if wall in ("adhesive", "full"):  # near an instability, and so less well determined
        tolerance *= 100.0
    assert abs(scaled.pressure / modulus - plain.pressure).max() < tolerance * largest
    assert scaled.height / spacing == pytest.approx(plain.height, rel=tolerance)


# Windows


@every_wall
@pytest.mark.parametrize(
    "shape", [(1, 1), (1, 2), (2, 1), (1, 17), (31, 37), (1, SIDE[1]), (3, 512)]
)
def test_windows_of_any_shape_carry_any_load(shape, wall, periodic):
    heights = np.random.default_rng(7).uniform(0.0, 2.0, shape)
    contact = contact_on(heights, wall, periodic)
    for load in (1e-12, 1.0, 100.0):
        relaxed(contact, load, max(1e-9 * load, 1e-12))


@every_wall
def test_a_window_may_be_in_full_contact(wall):
    if wall == "plastic":
        pytest.skip("the load of full contact is above the hardness")
    contact = contact_of(rc.RoughSphere(100.0, rough()), wall)
    state = relaxed(contact, LOAD[1], 1e-5)
    assert (state.pressure > 0.0).all()


@pytest.mark.parametrize("wall", ["repulsive", "adhesive", "full"])
def test_full_contact_of_a_periodic_surface_is_solved_to_eleven_digits(wall):
    contact = contact_of(rough(), wall, (32, 32), periodic=True)
    pressure = relaxed(contact, height=-10.0, tolerance=7e-8).pressure
    assert pressure.min() > 0.999 * pressure.mean() > 1e4


# Indenters


@every_wall
@pytest.mark.parametrize("height", [DISTANCE[0], 1e3, 1e6, 1e12, DISTANCE[1]])
def test_an_indenter_out_of_range_causes_no_pressure(wall, height):
    contact = contact_of(rc.RoughSphere(100.0, rough()), wall)
    state = relaxed(contact, height=contact.first_contact + height)
    assert state.energy == 0.0
    assert not state.pressure.any()


@every_wall
@pytest.mark.parametrize("depth", [DEPTH[0], 1e2, DEPTH[1]])
def test_an_indenter_may_overlap_by_many_core_lengths(wall, depth):
    contact = contact_of(rc.RoughSphere(100.0, rough()), wall)
    relaxed(contact, height=contact.first_contact - depth, tolerance=1e-9 * depth)


@pytest.mark.parametrize("wall", ["repulsive", "adhesive", "full"])
def test_a_flat_indenter_relaxes_where_pieces_of_the_potential_join(wall):
    contact = contact_on(np.zeros((8, 8)), wall)
    law = contact.wall
    onset = getattr(law, "onset", law.distance)
    for joint in (law.core, law.contact_distance, onset, law.cutoff):
        for height in (np.nextafter(joint, 0.0), joint, np.nextafter(joint, 9.0)):
            relaxed(contact, height=float(height), tolerance=1e-11)


@every_wall
def test_a_perfectly_flat_indenter_carries_any_load(wall, periodic):
    contact = contact_on(np.zeros((9, 12)), wall, periodic)
    for load in (1e-9, 1.0, 1e3):
        state = relaxed(contact, load, max(1e-10 * load, 1e-12))
        if periodic:
            mean = bearable(contact, load) / 108.0
            assert_allclose(state.pressure, mean, rtol=1e-8, atol=1e-13)


# Starts


@every_wall
@pytest.mark.parametrize("size", [START[0], 1e-3, 1.0, 1e3, 1e6, START[1]])
def test_a_random_start_of_any_size_relaxes(wall, size):
    contact = contact_of(rc.RoughSphere(100.0, rough()), wall)
    start = size * np.random.default_rng(3).normal(size=contact.heights.shape)
    height = contact.first_contact - 0.5
    options = ({"load": 2.0}, {"height": height})
    for option in options:
        states = steps(contact, start=start, **option)
        assert states[-1].converged
        assert_energy_falls(contact, states, option.get("load"))


# Laws


@pytest.mark.parametrize("wall", UNIQUE)
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_area_and_depth_grow_with_the_load(wall, periodic, seed):
    surface = rough(seed=seed)
    surface = surface if periodic else rc.RoughSphere(100.0, surface)
    contact = contact_of(surface, wall, periodic=periodic)
    areas, heights = [], []
    for load in np.geomspace(1e-6, 1e3, 19):
        state = relaxed(contact, load, 1e-10 * load + 1e-14)
        areas.append(np.count_nonzero(state.pressure > 1e-9 * state.pressure.max()))
        heights.append(state.height)
    assert (np.diff(areas) >= 0).all() and areas[0] < areas[-1]
    assert (np.diff(heights) < 2e-7).all()  # remaining gaps in full contact


# Limits, and how they are reported


@pytest.mark.parametrize("wall", ["repulsive", "adhesive", "hard"])
def test_single_precision_reports_its_limit(wall, periodic):
    surface = rough() if periodic else rc.RoughSphere(100.0, rough())
    contact = contact_of(surface, wall, periodic=periodic, dtype="float32")
    assert steps(contact, 2.0, tolerance=1e-5)[-1].converged
    last = steps(contact, 2.0, tolerance=1e-10)[-1]
    assert not last.converged and last.error < 1e-4
    assert "single precision" in last.message and "float64" in last.message


@pytest.mark.parametrize("offset", [1e4, 1e8])
def test_a_load_below_rounding_errors_of_the_height_is_reported(offset):
    contact = contact_of(rc.RoughSphere(100.0, rough()), "repulsive")
    far = Contact(contact.halfspace, contact.heights + offset, contact.wall)
    rounding = EPS * offset  # a force, since the wall's stiffness is one
    assert steps(far, 1.0, tolerance=100.0 * rounding)[-1].converged
    last = steps(far, 1e-3 * rounding, tolerance=1e-6 * rounding)[-1]
    assert not last.converged
    assert "rounding errors" in last.message


@pytest.mark.parametrize(
    "count",
    [256, pytest.param(8192, marks=pytest.mark.slow)],  # 4 GB at 8192
)
def test_rounding_error_of_a_convolution_does_not_grow_with_the_grid(count):
    halfspace = PeriodicHalfSpace((count, count), 1.0, 1.0)
    i, j = np.ogrid[:count, :count]
    q = 2.0 * np.pi / count
    pressure = np.cos(q * (i + 2 * j))  # as soft as a wave can be
    depth = 2.0 / (q * 5.0**0.5)
    error = abs(halfspace.displacement(pressure) + depth * pressure).max()
    assert error < 20.0 * EPS * depth


# Long paths


# Without tables of the library of transforms, which grow once, by megabytes.
OWN_MEMORY = [tracemalloc.Filter(False, "*/fft_backends.py")]


@pytest.mark.parametrize(
    "turns",
    [25, pytest.param(500, marks=pytest.mark.slow)],  # seconds
)
def test_a_path_up_and_down_is_reversible_and_needs_no_more_memory(turns):
    sphere = rc.RoughSphere(100.0, rough(long=12.0))
    atoms = atoms_under(sphere, shape=(24, 24), height=1.0)
    down = np.linspace(0.1, 1.0, turns)
    records, sizes = [], []
    tracemalloc.start()
    for record in rc.load_path(atoms, penetrations=[*down, *down[::-1]], fmax=1e-10):
        records.append(replace(record, seconds=0.0))
        if len(records) in (turns, 2 * turns):
            gc.collect()
            traces = tracemalloc.take_snapshot().filter_traces(OWN_MEMORY)
            sizes.append(sum(trace.size for trace in traces.traces))
    tracemalloc.stop()
    assert all(record.converged for record in records)
    forces = np.array([record.normal_force for record in records])
    areas = np.array([record.contact_area for record in records])
    assert_allclose(forces[::-1], forces, atol=1e-8)
    assert (areas[::-1] == areas).all()
    assert sizes[1] - sizes[0] < 3000 * turns  # a record is less than that


@pytest.mark.parametrize("wall", ["repulsive", "adhesive", "full"])
@pytest.mark.parametrize("load, carried", [(3e-12, True), (1e-14, False)])
def test_a_load_below_rounding_errors_is_not_converged(wall, load, carried):
    sphere = rc.RoughSphere(100.0, rough())
    atoms = atoms_under(sphere, WALLS[wall](1.0, 1.0), (24, 24), fixed=False)
    (record,) = rc.load_path(atoms, loads=[load], window="unchecked")
    assert record.converged == carried
    assert ("below the rounding" in record.message) != carried
