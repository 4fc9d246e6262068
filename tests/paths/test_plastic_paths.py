"""Paths with a plastic wall: flow, kept shape, windows, files and validity."""

import math

import numpy as np
import pytest
from ase.io import read, write
from built import atoms_under
from numpy.testing import assert_allclose, assert_array_equal
from written_path import written_path

import ase_roughcontact as rc
from ase_roughcontact.analysis import ContactMap
from ase_roughcontact.analysis.map_files import fields_of
from ase_roughcontact.analysis.view import with_columns
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.atoms.history import set_history

HARDNESS = 0.05
SPHERE = rc.RoughSphere(200.0, rc.SelfAffine(0.1, 0.8, 4.0, 16.0, seed=1))
UP_AND_DOWN = [0.5, 1.0, 0.7, 0.3, 1.0, 1.2]


def atoms_of(wall, shape=(48, 48), *, fixed=True, sphere=SPHERE, load=0.0):
    return atoms_under(sphere, wall, shape, load=load, fixed=fixed)


def steps_of(wall, path=UP_AND_DOWN, control="penetrations", **options):
    atoms = atoms_of(wall, fixed=control != "loads")
    steps = written_path(atoms, **{control: path}, accuracy="high", **options)
    return atoms, list(steps)


def loaded_step(surface, n, hardness, load, periodic, **options):
    """A step under a load, relative to the largest one that the window carries."""
    atoms = atoms_under(
        surface, rc.PlasticWall(hardness), (n, n), periodic=periodic, fixed=False
    )
    options |= {"loads": [load * hardness * n * n], "validity": "ignore"}
    (step,) = written_path(atoms, window="unchecked", **options)
    return step


@pytest.fixture(scope="module")
def unloading():
    return steps_of(rc.PlasticWall(HARDNESS, permanent=True))


# One step


@pytest.mark.slow
def test_converged_steps_carry_the_load_on_random_surfaces():
    for seed in range(3000):
        rng = np.random.default_rng(seed)
        n = int(rng.choice([8, 8, 8, 12, 16, 24, 32, 48]))
        hardness, slope = 10 ** rng.uniform(-3, 0), 10 ** rng.uniform(-2, 0)
        load, periodic = rng.uniform(0.01, 0.99), rng.random() < 0.6
        longest = n if n <= 8 else rng.choice([8, n])
        roughness = int(rng.integers(1 << 30))
        rough = rc.SelfAffine(slope, 0.8, 4, longest, domain=n, seed=roughness)
        surface = rough if periodic else rc.RoughSphere(10 ** rng.uniform(1, 3), rough)
        load *= 1.0 if periodic else 0.5
        for tolerance in ({}, {"accuracy": 1e-8}):
            step = loaded_step(surface, n, hardness, load, periodic, **tolerance)
            assert step.converged and step.max_force <= step.tolerance
            assert_allclose(step.normal_force, load * hardness * n * n, rtol=1e-5)


def test_atoms_in_plastic_contact_are_counted_apart():
    atoms, (step,) = steps_of(rc.PlasticWall(HARDNESS), [1.0])
    state = atoms.calc.state(atoms)
    assert 0 < step.plastic_atoms < step.repulsive_atoms
    assert step.plastic_atoms == state.plastic.sum() == (state.pressure == 0.05).sum()
    assert_allclose(state.plastic_depth[state.plastic], -state.gap[state.plastic])
    assert (state.plastic_depth[~state.plastic] == 0.0).all()
    assert step.plastic_depth == pytest.approx(state.plastic_depth.max())
    # the surface does not keep this depth, nor does its frame
    frame = rc.snapshot(atoms)
    seen = ContactMap.from_frame(frame, SPHERE)
    assert_allclose(seen.plastic_depth, state.plastic_depth)
    assert_allclose(seen.gap, state.gap, atol=1e-9)
    assert step.plastic_depth > 0.0
    assert step.largest_pressure == HARDNESS and step.converged
    assert step.gap_error < 1e-6


def test_a_contact_that_flows_everywhere_has_a_force_but_no_height():
    wall, ball = rc.PlasticWall(1e-4), rc.RoughSphere(20.0)
    for control, target in (("penetrations", 0.3), ("loads", 37e-4)):
        atoms = atoms_of(wall, (12, 12), fixed=control != "loads", sphere=ball)
        (step,) = written_path(atoms, **{control: [target]}, validity="ignore")
        assert step.plastic_atoms == step.repulsive_atoms == 37
        assert step.contact_stiffness == 0.0 and step.force_error < 1e-9
        assert step.height_error == (math.inf if control == "loads" else 0.0)


def test_elastic_walls_have_no_plastic_contact():
    for wall in (None, rc.HardWall(), rc.PlasticWall(math.inf)):
        atoms, (step,) = steps_of(wall, [1.0])
        assert {"plastic_atoms", "plastic_depth"} <= step.not_known.keys()
        assert ContactMap.from_atoms(atoms).plastic_depth is None


def test_reaction_follows_from_the_positions():
    for periodic in (False, True):
        atoms = rc.substrate("Cu", (32, 32), SPHERE, spacing=1.0, periodic=periodic)
        atoms.positions[-1, 2] -= 2.0
        atoms.calc = rc.RoughContact(SPHERE, 1.0, rc.PlasticWall(HARDNESS))
        assert rc.ActiveSet(atoms, logfile=None).run(fmax=1e-9)
        expected = atoms.calc.state(atoms)
        copy = atoms.copy()
        copy.calc = rc.RoughContact(SPHERE, 1.0, rc.PlasticWall(HARDNESS))
        state = copy.calc.state(copy)
        assert state.plastic_atoms == expected.plastic_atoms > 0
        assert_allclose(state.pressure, expected.pressure, atol=1e-8)
        assert_allclose(copy.get_potential_energy(), atoms.get_potential_energy())
        if not periodic:
            copy.positions[:-1, 2] = 0.0
            with pytest.raises(ValueError, match="overlap"):
                copy.get_potential_energy()


def test_pressures_at_the_hardness_are_within_the_validity():
    limited = {"validity": rc.Validity("ignore", 0.01)}
    _, (step,) = steps_of(rc.PlasticWall(HARDNESS), [1.0], **limited)
    assert not step.validity
    _, (step,) = steps_of(rc.HardWall(), [1.0], **limited)
    assert "largest pressure/hardness" in step.validity


def test_stiffness_agrees_with_further_loading():
    _, (low, middle, high) = steps_of(rc.PlasticWall(HARDNESS), [0.999, 1.0, 1.001])
    slope = (high.normal_force - low.normal_force) / 0.002
    assert_allclose(middle.contact_stiffness, slope, rtol=2e-3)


def test_load_above_the_hardness_times_the_area():
    with pytest.raises(ValueError, match=r"load 200 .* hardness 0\.05 times .* 115\.2"):
        steps_of(rc.PlasticWall(HARDNESS), [200.0], "loads")


# The kept shape


def test_at_the_largest_load_again_the_same_atoms_are_in_plastic_contact():
    path = [3.0, 1.5, 3.0, 2.97, 3.0]
    _, (first, *again) = steps_of(rc.PlasticWall(0.02, permanent=True), path, "loads")
    assert first.plastic_atoms > 100
    assert [s.plastic_atoms for s in again] == [0, first.plastic_atoms] * 2


def test_unloading_is_elastic(unloading):
    _, steps = unloading
    loading, deepest, *lifted, again, deeper = steps
    assert all(step.plastic_atoms == 0 for step in lifted)
    assert all(step.plastic_depth == deepest.plastic_depth for step in lifted)
    assert lifted[1].normal_force < loading.normal_force / 2
    assert_allclose(again.normal_force, deepest.normal_force, rtol=1e-6)
    assert_allclose(again.energy, deepest.energy, rtol=1e-6)
    assert deeper.plastic_depth > again.plastic_depth


def test_work_is_stored_or_spent_on_flow():
    """Up and down in small steps: dE = -N dZ, and the rest is H times the depth."""
    down = np.linspace(0.0, 1.0, 17)
    path = [*down, *down[-2::-1]]
    atoms, steps = steps_of(rc.PlasticWall(HARDNESS, permanent=True), path)
    z, force, energy = np.transpose(
        [(s.height, s.normal_force, s.energy) for s in steps]
    )
    work = -np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(z))
    assert_allclose(energy[1:] - energy[0], work, atol=0.01 * work.max())
    assert steps[-1].repulsive_atoms == 0
    flow = HARDNESS * atoms.calc.state(atoms).plastic_depth.sum()
    assert_allclose(energy[-1], flow, rtol=1e-6)


def test_flow_does_not_change_energy_and_forces():
    atoms, _ = steps_of(rc.PlasticWall(HARDNESS), [1.0])
    energy, forces = atoms.get_potential_energy(), atoms.get_forces()
    depth = atoms.calc.state(atoms).plastic_depth
    set_history(atoms, SurfaceGrid.of(atoms), {"plastic_depth": depth})
    state = atoms.calc.state(atoms)
    assert_allclose(atoms.get_potential_energy(), energy, rtol=1e-12)
    assert_allclose(atoms.get_forces(), forces, atol=1e-12)
    assert_allclose(state.plastic_depth, depth, atol=1e-12)
    assert_allclose(state.gap[depth > 0], 0.0, atol=1e-12)


def test_a_single_loading_does_not_depend_on_the_steps():
    """In small steps nothing but rounding differs from one large step."""
    path = [0.2, 0.4, 0.6, 0.8, 1.0]
    _, many = steps_of(rc.PlasticWall(HARDNESS, permanent=True), path)
    _, (one,) = steps_of(rc.PlasticWall(HARDNESS), [1.0])
    assert_allclose(many[-1].normal_force, one.normal_force, rtol=1e-4)
    assert_allclose(many[-1].contact_area, one.contact_area, rtol=5e-3)


@pytest.mark.parametrize("control", ["penetrations", "loads"])
def test_automatic_windows_keep_the_shape(control):
    path = UP_AND_DOWN if control == "penetrations" else [5.0, 20.0, 8.0, 0.0, 20.0]
    wall = rc.PlasticWall(HARDNESS, permanent=True)
    _, fixed = steps_of(wall, path, control)
    _, auto = steps_of(wall, path, control, window="auto")
    assert len({step.window for step in auto}) > 1
    for a, b in zip(fixed, auto, strict=True):
        assert_allclose(b.normal_force, a.normal_force, rtol=1e-4, atol=1e-9)
        assert_allclose(b.height, a.height, atol=1e-4)
        assert b.contact_area == pytest.approx(a.contact_area, rel=0.01, abs=2.0)


def test_small_windows_contain_the_dents():
    """A smaller window, which unloading would allow, would forget most of them."""
    sphere, path = rc.RoughSphere(200.0), [2.0, 0.0, 1.8]
    forces = []
    for window in ("fixed", "auto"):
        wall = rc.PlasticWall(0.02, permanent=True)
        atoms = atoms_of(wall, (72, 72), sphere=sphere)
        steps = written_path(atoms, path, window=window, validity="ignore")
        forces.append([step.normal_force for step in steps])
    assert_allclose(*forces, rtol=1e-4)


def test_window_of_a_load_carries_it():
    """The plastic contact is larger than the elastic one that a window is made for."""
    sphere = rc.RoughSphere(50.0)
    atoms = atoms_of(rc.PlasticWall(1e-3), (8, 8), fixed=False, sphere=sphere)
    (step,) = written_path(atoms, loads=[1.0], window="auto", validity="ignore")
    assert step.converged
    assert_allclose(step.contact_area, 1.0 / 1e-3, rtol=0.05)


def test_loop_dissipates_the_work_of_the_flow():
    sphere, hardness = rc.RoughSphere(100.0), 0.02
    atoms = atoms_of(rc.PlasticWall(hardness, permanent=True), (24, 24), sphere=sphere)
    loop = rc.adhesion_loop(atoms, deepest=0.5, step=0.1, validity="ignore")
    flow = hardness * atoms.calc.state(atoms).plastic_depth.sum()
    assert_allclose(loop.dissipated_energy, flow, rtol=0.02)
    assert not loop.approach_jumps and not loop.retraction_jumps


# Files


@pytest.mark.parametrize("window", ["fixed", "auto"])
def test_path_is_resumed_in_its_plastic_shape(tmp_path, unloading, window):
    file, wall = tmp_path / "path.traj", rc.PlasticWall(HARDNESS, permanent=True)
    options = {"trajectory": file, "window": window}
    steps_of(wall, UP_AND_DOWN[:3], **options)
    _, steps = steps_of(wall, UP_AND_DOWN, resume=True, **options)
    for a, b in zip(unloading[1], steps, strict=True):
        assert_allclose(b.normal_force, a.normal_force, rtol=1e-5)
    with pytest.raises(ValueError, match=r"hardness was 0.05, is 0.06"):
        steps_of(rc.PlasticWall(0.06, permanent=True), resume=True, **options)


@pytest.mark.parametrize("suffix", ["traj", "extxyz"])
def test_frames_keep_the_plastic_depth(tmp_path, unloading, suffix):
    atoms, _ = unloading
    file = tmp_path / f"frame.{suffix}"
    write(file, rc.snapshot(atoms))
    frame, state = read(file), atoms.calc.state(atoms)
    assert_array_equal(ContactMap.from_frame(frame).plastic_depth, state.plastic_depth)
    restored = rc.restore(frame, 1.0)
    restored.calc = rc.RoughContact(
        SPHERE, 1.0, rc.PlasticWall(HARDNESS, permanent=True)
    )
    again = restored.calc.state(restored)
    assert_allclose(again.plastic_depth, state.plastic_depth, atol=1e-7)
    assert_allclose(again.normal_force, state.normal_force, rtol=1e-4)


def test_maps_and_views_show_the_plastic_depth(unloading):
    atoms, _ = unloading
    state, frame = atoms.calc.state(atoms), rc.snapshot(atoms)
    depth = state.plastic_depth
    for each in (ContactMap.from_atoms(atoms), ContactMap.from_frame(frame, SPHERE)):
        assert_allclose(each.plastic_depth, depth)
        assert_allclose(each.gap, state.gap, atol=1e-12)
    assert_allclose(fields_of(each)["plastic_depth"], depth / 10.0)
    view = with_columns(frame, SPHERE)
    assert_allclose(view.arrays["plastic_depth"][:-1], depth.ravel())
    assert_allclose(view.arrays["gap"][:-1], state.gap.ravel(), atol=1e-12)
    tags = frame.get_tags()[:-1].reshape(depth.shape)
    assert_array_equal(tags == 4, state.plastic)


def test_a_changed_depth_changes_the_results(unloading):
    atoms, _ = unloading
    changed = atoms.copy()
    changed.calc = rc.RoughContact(SPHERE, 1.0, rc.PlasticWall(HARDNESS))
    gap = changed.calc.state(changed).gap.copy()
    changed.arrays["plastic_depth"] += 0.5
    assert_allclose(changed.calc.state(changed).gap, gap + 0.5)
    del changed.arrays["plastic_depth"]
    with pytest.raises(ValueError, match="start from new atoms"):
        changed.calc.state(changed)
    changed.set_tags(0)  # on purpose
    changed.positions[-1, 2] += 5.0
    changed.positions[:-1, 2] = 0.0
    flat = changed.calc.state(changed)
    assert_allclose(flat.gap.min(), changed.positions[-1, 2] + SPHERE_LOWEST)


SPHERE_LOWEST = float(SPHERE.heights((48, 48), 1.0, (-24.0, -24.0)).min())
