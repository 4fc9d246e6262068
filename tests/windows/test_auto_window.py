"""Automatic windows: exact, enlarged where needed, never too small without an error."""

import time

import numpy as np
import pytest
from ase.constraints import FixCartesian, Hookean
from ase.io import read
from built import atoms_under
from written_path import written_path

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import problem_of
from ase_roughcontact.atoms.exchange import set_window
from ase_roughcontact.contact.state import TRACTION_DEPTH
from ase_roughcontact.elasticity import Isotropic
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.results.record import size_of
from ase_roughcontact.windows import auto
from ase_roughcontact.windows.footprint import Footprint

HARD = rc.HardWall(), rc.ActiveSet
SOFT = rc.LennardJones93.repulsive(1.0, 1.0), rc.NewtonKrylov
ADHESIVE = rc.LennardJones93.adhesive(1.0, 1.0, 0.05), rc.NewtonKrylov
# The smallest window that is ever chosen.
SMALLEST = 9, 9
REPULSIVE = pytest.mark.parametrize("wall", [HARD, SOFT], ids=["hard", "soft"])


def rough_sphere(seed=1, radius=60.0, domain=64.0, slope=0.3):
    rough = rc.SelfAffine(slope, 0.8, 4.0, 16.0, seed=seed, domain=domain)
    return rc.RoughSphere(radius, rough)


def make_atoms(sphere, wall, shape=(8, 8), **options):
    return atoms_under(sphere, wall[0], shape, **options)


def run(atoms, wall, **options):
    options = {"fmax": 1e-11, "window": "auto", **options}
    return list(written_path(atoms, optimizer=wall[1], **options))


def window_of(atoms):
    return problem_of(atoms)[1]


def contact_of(atoms):
    """Atoms in contact, in spacings from the axis."""
    places = np.argwhere(atoms.calc.state(atoms).contact) + window_of(atoms).start
    return set(map(tuple, places.tolist()))


def same_state(atoms, others, touching=True):
    state, other = atoms.calc.state(atoms), others.calc.state(others)
    assert state.normal_force == pytest.approx(other.normal_force, rel=1e-10, abs=2e-11)
    assert atoms.positions[-1, 2] == pytest.approx(others.positions[-1, 2], abs=1e-10)
    assert contact_of(atoms) == contact_of(others)
    assert not touching or contact_of(atoms)


# Exactness

LOADS, HEIGHTS = {"loads": [1e-3, 1.0, 30.0]}, {"heights": [5.0, 3.0, 1.0, 3.0, 4.0]}


@pytest.mark.parametrize(
    "wall, targets",
    [(HARD, LOADS), (SOFT, LOADS), (ADHESIVE, HEIGHTS)],
    ids=["hard", "soft", "adhesive approach and retraction"],
)
@pytest.mark.parametrize("seed", range(3))
def test_path_in_automatic_windows_equals_that_in_a_large_window(wall, targets, seed):
    sphere, fixed = rough_sphere(seed), targets is HEIGHTS
    atoms, full = (make_atoms(sphere, wall, (n, n), fixed=fixed) for n in (8, 63))
    options = {"optimizer": wall[1], "fmax": 1e-11, **targets}
    paths = (
        written_path(which, window=window, **options)
        for which, window in ((atoms, "auto"), (full, "fixed"))
    )
    for one, other in zip(*paths, strict=True):
        assert one.converged and other.converged
        same_state(atoms, full, touching=wall is not ADHESIVE)
        assert window_of(full).size > window_of(atoms).size


@pytest.mark.parametrize(
    "wall", [HARD, SOFT, ADHESIVE], ids=["hard", "soft", "adhesive"]
)
@pytest.mark.parametrize("scale", [0.5, 1.0])
def test_window_for_the_expected_contact_is_enlarged_to_the_actual_one(
    wall, scale, monkeypatch
):
    sphere = rough_sphere(2, radius=200.0, slope=0.05, domain=128.0)
    atoms = make_atoms(sphere, wall, fixed=False)
    full = make_atoms(sphere, wall, (95, 95), fixed=False)
    monkeypatch.setattr(auto, "CONTACT_WINDOW_SIZE", 0)
    monkeypatch.setattr(auto, "CONTACT_WINDOW_SCALE", scale)
    for window, which in (("auto", atoms), ("fixed", full)):
        list(written_path(which, loads=[1.0, 30.0], fmax=1e-11, window=window))
    same_state(atoms, full)


@REPULSIVE
def test_window_for_the_contact_is_smaller_than_the_overlap_of_the_rigid_indenter(
    wall, monkeypatch
):
    sphere = rough_sphere(2, radius=400.0, slope=0.02, domain=256.0)
    atoms = make_atoms(sphere, wall, fixed=False)
    monkeypatch.setattr(auto, "CONTACT_WINDOW_SIZE", 0)
    run(atoms, wall, loads=[200.0])
    level = wall[0].cutoff - atoms.positions[-1, 2]
    overlap = Footprint(sphere, 1.0).box_below(level)
    assert window_of(atoms).size < 0.8 * overlap.size


@REPULSIVE
def test_first_contact_far_from_the_axis_is_found(wall):
    sphere = rough_sphere(seed=6, radius=2000.0, domain=256.0)
    atoms = make_atoms(sphere, wall, fixed=False)
    (record,) = run(atoms, wall, loads=[1e-6])
    heights = sphere.heights((255, 255), 1.0, (-127.0, -127.0))
    lowest = np.array(np.unravel_index(heights.argmin(), heights.shape)) - 127
    assert contact_of(atoms) == {tuple(lowest)}
    assert np.abs(lowest).max() > 16
    assert record.repulsive_atoms == 1
    assert window_of(atoms).shape == SMALLEST


@REPULSIVE
def test_penetrations_count_from_the_first_contact_of_the_whole_indenter(wall):
    sphere = rough_sphere(seed=3, radius=500.0, domain=128.0)
    lowest = sphere.heights((127, 127), 1.0, (-63.0, -63.0)).min()
    atoms = make_atoms(sphere, wall)
    (record,) = run(atoms, wall, penetrations=[0.2])
    first = wall[0].contact_distance - lowest
    assert record.height == pytest.approx(first - 0.2, abs=1e-12)
    assert record.normal_force > 0.0


# Windows along a path


@REPULSIVE
def test_ten_decades_of_load_in_one_path(wall):
    sphere = rough_sphere(radius=100.0, domain=128.0)
    loads = np.geomspace(1e-8, 1e2, 11)
    atoms = make_atoms(sphere, wall, fixed=False)
    sizes = []
    for record, load in zip(
        written_path(atoms, loads=loads, optimizer=wall[1], fmax=1e-11, window="auto"),
        loads,
        strict=True,
    ):
        assert record.converged
        assert record.normal_force == pytest.approx(load, abs=1e-10)
        sizes.append(window_of(atoms).size)
    assert sizes[0] == np.prod(SMALLEST) < 1000 < sizes[-1]
    assert record.repulsive_atoms > 300


@REPULSIVE
def test_window_that_is_predicted_too_small_is_enlarged(wall, monkeypatch):
    sphere = rough_sphere()
    expected = make_atoms(sphere, wall, fixed=False)
    run(expected, wall, loads=[20.0])
    atoms = make_atoms(sphere, wall, fixed=False)
    monkeypatch.setattr("ase_roughcontact.windows.expected.LOAD_FACTOR", 1e3)
    run(atoms, wall, loads=[20.0])
    same_state(atoms, expected)
    assert window_of(atoms).size <= 2 * window_of(expected).size


@REPULSIVE
def test_window_shrinks_when_the_indenter_goes_up(wall):
    atoms = make_atoms(rough_sphere(), wall, fixed=False)
    sizes = []
    for _ in written_path(
        atoms, loads=[20.0, 1.0, 0.1], optimizer=wall[1], fmax=1e-11, window="auto"
    ):
        sizes.append(window_of(atoms).size)
    assert sizes[0] > sizes[1] >= sizes[2]
    fresh = make_atoms(rough_sphere(), wall, fixed=False)
    run(fresh, wall, loads=[0.1])
    same_state(atoms, fresh)


# Constraints


def test_constraints_of_the_indenter_are_kept():
    atoms = make_atoms(rc.RoughSphere(60.0), SOFT, fixed=False)
    axis = atoms.positions[-1].copy()
    last = len(atoms) - 1
    spring = Hookean(a1=last, a2=axis - np.array([0.0, 0.0, 3.0]), k=0.5, rt=0.0)
    atoms.set_constraint([FixCartesian([last], (True, True, False)), spring])
    pull = [c.adjust_potential_energy(atoms) for c in atoms.constraints[1:]]
    set_window(atoms, Box((-9, -7), (20, 17)))
    fixed, spring = atoms.constraints
    assert list(fixed.index) == [spring.index] == [len(atoms) - 1]
    assert [spring.adjust_potential_energy(atoms)] == pytest.approx(pull)


def test_constraints_of_surface_atoms_are_an_error():
    atoms = make_atoms(rc.RoughSphere(60.0), SOFT)
    atoms.set_constraint(FixCartesian([0, len(atoms) - 1]))
    with pytest.raises(ValueError, match="other atoms"):
        set_window(atoms, Box((-9, -7), (20, 17)))


# Adhesion


def test_window_is_enlarged_where_atoms_are_lifted_into_the_range_of_the_wall():
    sphere, wall = (
        rc.RoughSphere(40.0),
        (rc.LennardJones93.adhesive(1.0, 1.0, 0.5), SOFT[1]),
    )
    height = 1.5
    atoms, full = (make_atoms(sphere, wall, (n, n), height=height) for n in (8, 65))
    run(atoms, wall, heights=[height])
    run(full, wall, heights=[height], window="fixed")
    touching = Footprint(sphere, 1.0).box_below(wall[0].cutoff - height)
    assert not touching.contains(
        Box.bounding(full.calc.state(full).pressure != 0.0, window_of(full).start)
    )
    same_state(atoms, full)


# Friction


def test_window_is_enlarged_where_tractions_lift_atoms_into_contact():
    solid, options = Isotropic(1.0, 0.0), rc.StepOptions(window="auto")
    problem = rc.Problem(rc.RoughSphere(60.0), solid, rc.HardWall(), spacing=1.0)
    stepper = rc.Stepper(problem, "heights", Box((-4, -4), SMALLEST), options)
    relaxed = stepper.relax(stepper.start, 1.0)
    above = rc.LoadStep.of(relaxed)
    assert above.window == "9x9"
    # the whole window by more than the indenter is above it
    state = relaxed.state.keeping(**{TRACTION_DEPTH: np.full(SMALLEST, -1.0)})
    lifted = rc.LoadStep.of(stepper.relax(state, 0.6))
    reach = np.sqrt(2.0 * 60.0 * (1.0 - 0.6))  # of the indenter, at most
    assert lifted.contact_area > 0.9 * 9.0**2 > above.contact_area
    assert 9 < size_of(lifted.window) ** 0.5 < 2.0 * reach


# Domain of the roughness


@REPULSIVE
@pytest.mark.parametrize("control", ["loads", "heights"])
def test_contact_beyond_the_domain_of_the_roughness_is_an_error(wall, control):
    sphere = rough_sphere(radius=2000.0, domain=32.0)
    atoms = make_atoms(sphere, wall, fixed=control == "heights")
    steps = {"loads": [1e3], "heights": [-3.0]}[control]
    with pytest.raises(ValueError, match=r" 1\.6 nm .* domain of"):
        run(atoms, wall, **{control: steps})


@REPULSIVE
def test_contact_may_fill_the_domain(wall):
    sphere = rough_sphere(radius=40.0, domain=32.0)
    atoms = make_atoms(sphere, wall, fixed=False)
    records = run(atoms, wall, loads=np.geomspace(1.0, 25.0, 8))
    assert all(record.converged for record in records)
    assert max(window_of(atoms).shape) >= 30
    assert Footprint(sphere, 1.0).domain.contains(window_of(atoms))


def test_height_map_must_cover_the_possible_contact():
    values = np.random.default_rng(1).uniform(-0.5, 0.5, (21, 21))
    small, large = (rc.HeightMap(np.pad(values, n), 1.0) for n in (0, 10))
    height = 0.2
    atoms = make_atoms(rc.RoughSphere(50.0, large), SOFT)
    (record,) = run(atoms, SOFT, heights=[height])
    assert record.converged
    atoms = make_atoms(rc.RoughSphere(50.0, small), SOFT)
    with pytest.raises(ValueError, match="larger map"):
        run(atoms, SOFT, heights=[height])


# Files


@pytest.mark.parametrize("done", [1, 3])
def test_path_with_windows_of_different_sizes_is_resumed(tmp_path, done):
    movie, loads = tmp_path / "sweep.traj", np.geomspace(1e-4, 20.0, 4)
    options = {"loads": loads, "optimizer": rc.NewtonKrylov, "fmax": 1e-11}
    options |= {"window": "auto", "trajectory": movie}
    atoms = make_atoms(rough_sphere(), SOFT, fixed=False)
    path = written_path(atoms, **options)
    before = [next(path) for _ in range(done)]
    path.close()
    again = make_atoms(rough_sphere(), SOFT, (12, 10), fixed=False)
    records = list(written_path(again, **options, resume=True))
    assert records[:done] == before
    whole = make_atoms(rough_sphere(), SOFT, fixed=False)
    run(whole, SOFT, loads=loads)
    same_state(again, whole)
    assert len(read(movie, ":")) == 4


def test_frames_of_different_sizes_can_be_read_and_restored(tmp_path):
    movie = tmp_path / "sweep.traj"
    atoms = make_atoms(rough_sphere(), SOFT, fixed=False)
    records = run(atoms, SOFT, loads=[1e-4, 20.0], trajectory=movie)
    frames = read(movie, ":")
    assert len(frames[0]) < len(frames[1])
    for frame, record in zip(frames, records, strict=True):
        assert np.count_nonzero(frame.get_tags() == 1) == record.repulsive_atoms
        restored = rc.restore(frame, 1.0)
        restored.calc = rc.RoughContact(rough_sphere(), 1.0, SOFT[0], load=0.0)
        state = restored.calc.state(restored)
        # in single precision
        assert state.normal_force == pytest.approx(record.normal_force, rel=1e-4)


def test_unknown_window_is_an_error():
    with pytest.raises(ValueError, match="'fixed', 'unchecked' or 'auto'"):
        written_path(make_atoms(rc.RoughSphere(60.0), SOFT), [0.1], window="moving")


def test_a_load_far_too_large_for_a_rough_sphere_is_refused_at_once():
    a0 = 2.5
    waves = {"short_wavelength": 4 * a0, "long_wavelength": 16 * a0}
    sphere = rc.RoughSphere(50 * a0, rc.SelfAffine(0.05, 0.8, **waves, seed=2))
    atoms = rc.substrate("Si", (8, 8), sphere, spacing=a0, fixed=False)
    atoms.calc = rc.RoughContact(sphere, 1.0, rc.LennardJones93.repulsive(1.0, a0))
    start = time.perf_counter()
    with pytest.raises(ValueError, match="smaller load or depth"):
        next(written_path(atoms, loads=[1e12], window="auto"))
    assert time.perf_counter() - start < 5.0
