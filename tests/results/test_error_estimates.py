"""Estimated errors of area, force and height, against much more accurate results."""

import csv
from collections import defaultdict
from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.contact.support import Support
from ase_roughcontact.elasticity import Isotropic, Layer
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.results.errors import estimated_errors
from ase_roughcontact.solvers.relaxation import Run
from ase_roughcontact.stepping.options import StepOptions
from ase_roughcontact.stepping.relaxed import RelaxedStep
from ase_roughcontact.stepping.step import Stepper
from ase_roughcontact.theory import Hertz

TABLE = "examples/benchmarks/answer_errors.csv"
WALLS = {"hard": rc.HardWall(), "repulsive": rc.LennardJones93.repulsive(1.0, 1.0)}
ADHESIVE = {"adhesive": rc.LennardJones93.adhesive(1.0, 1.0, 0.05)}
RADIUS = 100.0


def relaxed(wall, seed=5, cell=0, fixed=False, smooth=False, **options):
    """Result of one step on a sphere with, by default, a contact of about 10 a0."""
    rough = rc.SelfAffine(0.1, 0.65, 4.0, 16.0, seed=seed, domain=64.0)
    sphere = rc.RoughSphere(RADIUS, None if smooth else rough)
    window = {"shape": 2 * (cell or 8,), "periodic": cell > 0, "fixed": fixed}
    atoms = atoms_under(sphere, (WALLS | ADHESIVE)[wall], **window)
    target = {} if fixed else {"loads": [Hertz(RADIUS, 1.0).force(10.0)]}
    window = "fixed" if cell else "auto"
    (step,) = rc.load_path(atoms, **target, **options, window=window, validity="ignore")
    return step


@pytest.mark.parametrize("wall", WALLS)
def test_error_of_a_loose_tolerance_is_found_to_first_order(wall):
    exact = relaxed(wall, fixed=True, heights=[-4.0], accuracy=1e-11)
    loose = relaxed(wall, fixed=True, heights=[-4.0], accuracy=0.3)
    error = abs(loose.normal_force - exact.normal_force)
    assert 1e-10 < error / exact.normal_force < 0.1
    assert loose.force_error == pytest.approx(error, rel=0.3)
    assert loose.height_error == exact.height_error == 0.0
    assert exact.force_error < 1e-3 * loose.force_error


def test_error_in_tension_without_a_repelled_atom():
    def attracted(**options):
        wall = rc.LennardJones93.adhesive(1.0, 1.0, 0.003)
        atoms = atoms_under(rc.RoughSphere(RADIUS), wall, (30, 30))
        (step,) = rc.load_path(atoms, heights=[1.15], validity="ignore", **options)
        return step

    exact, loose = attracted(accuracy=1e-11), attracted(accuracy=0.3)
    coarse, fine = (attracted(accuracy=1e-8, grid=f"a0/{n}") for n in (1, 2))
    assert exact.normal_force < 0.0 == exact.contact_area == exact.area_error
    error = abs(loose.normal_force - exact.normal_force)
    assert loose.force_error == pytest.approx(error, rel=0.3)
    assert abs(fine.normal_force - coarse.normal_force) < 2.0 * coarse.force_error
    assert coarse.force_error < 0.05 * abs(exact.normal_force)


@pytest.mark.parametrize("wall", WALLS)
def test_error_under_a_load_is_one_of_the_height(wall):
    exact, loose = (relaxed(wall, accuracy=error) for error in (1e-11, 0.3))
    error = abs(loose.height - exact.height)
    assert error <= 2.0 * loose.height_error < 1e-2
    assert loose.force_error < 0.3 * loose.normal_force


def test_force_that_the_indenter_lacks_is_an_error_of_the_height():
    problem = rc.Problem(rc.RoughSphere(RADIUS), Isotropic(1.0), rc.HardWall(), 1.0)
    options = StepOptions(accuracy=1e-8)
    stepper = Stepper(problem, "heights", Box((-16, -16), (32, 32)), options)
    relaxed = stepper.relax(stepper.start, -1.0)
    step = rc.LoadStep.of(relaxed)
    load = Support(fixed=False, load=step.normal_force + 0.1)
    run = Run.of(relaxed.state, relaxed.fields, load)
    contact = {"problem": problem, "contact": relaxed.contact, "run": run}
    errors = estimated_errors(RelaxedStep(**contact, control="loads"))
    assert errors.force == pytest.approx(0.1)
    assert errors.height == pytest.approx(0.1 / step.contact_stiffness, rel=1e-3)


def errors_on_layer(solid, radius, load):
    """Return true and estimated errors of heights by the grid, and their limit."""
    found, sphere = [], rc.RoughSphere(radius)
    for spacing in (1.0, 0.5, 0.25):
        lattice = {"solid": solid, "spacing": spacing, "fixed": False}
        atoms = atoms_under(sphere, rc.HardWall(), **lattice)
        grid = {"grid": "a0", "accuracy": 1e-5, "window": "auto", "validity": "ignore"}
        (step,) = rc.load_path(atoms, loads=[load], **grid)
        found.append((step.height, step.height_error))
    limit = found[2][0] + (found[2][0] - found[1][0]) / 3.0
    return [(abs(height - limit), error) for height, error in found], limit


@pytest.mark.parametrize("layer", [0.5, 1.0, 4.0])
def test_grid_height_on_an_incompressible_layer_on_a_rigid_base(layer):
    """Also where the layer is thinner than the spacing."""
    errors, limit = errors_on_layer(Layer(1.0, layer), 200.0, 10.0)
    for true, estimate in errors:
        assert true < 2.0 * estimate < 0.5 * abs(limit)


@pytest.mark.parametrize("wall", WALLS)
def test_grid_is_an_error_of_the_continuum_only(wall):
    atoms, coarse = relaxed(wall), relaxed(wall, grid="a0")
    fine = relaxed(wall, grid="a0/4")
    assert coarse.height == pytest.approx(atoms.height, abs=1e-6)
    assert coarse.contact_area == atoms.contact_area
    assert atoms.height_error < 1e-3 * coarse.height_error
    assert atoms.area_error < 1e-3 * coarse.area_error
    error = abs(coarse.height - fine.height)
    assert 0.5 * error < coarse.height_error < 3.0 * error
    assert abs(coarse.continuum_area - fine.continuum_area) < 2.0 * coarse.area_error


def test_grid_height_counts_the_forces_of_attraction():
    coarse, fine = (relaxed("adhesive", grid=f"a0/{n}") for n in (1, 4))
    error = abs(coarse.height - fine.height)
    assert 0.5 * error < coarse.height_error < 3.0 * error


@pytest.mark.parametrize(
    "radius, wall, load",
    [
        (186.7, rc.DugdaleWall(0.0155, 0.353), 1.74),
        (99.07, rc.DugdaleWall(0.01719, 0.507), 16.85),
        (82.76, rc.DugdaleWall(0.013955, 0.3237), 11.85),
    ],
)
def test_end_of_the_attraction_between_points_is_an_error(radius, wall, load):
    """Where tension ends within a spacing, as if points had been counted."""

    def relaxed(refine):
        sphere = rc.RoughSphere(radius)
        atoms = atoms_under(sphere, wall, fixed=False)
        grid = {"grid": f"a0/{refine}", "validity": "ignore"}
        (step,) = rc.load_path(atoms, loads=[load], window="auto", **grid)
        return step

    one, fine = relaxed(1), relaxed(4)
    assert abs(one.height - fine.height) < 2.0 * one.height_error < 0.02
    error = abs(one.continuum_area - fine.continuum_area)
    assert error < 2.0 * one.area_error < 0.06 * fine.continuum_area


@pytest.mark.parametrize("cell", [48, 96])
def test_images_of_a_periodic_cell_shift_the_height_and_take_area(cell):
    free, periodic = (relaxed("repulsive", smooth=True, cell=c) for c in (0, cell))
    shift = periodic.height - free.height
    assert shift == pytest.approx(periodic.height_error, rel=0.05)
    assert abs(periodic.contact_area - free.contact_area) < 2.0 * periodic.area_error
    assert periodic.area_error < 0.06 * free.contact_area


@pytest.mark.parametrize("cell", [56, 72])
def test_images_of_an_adhesive_contact_shift_the_height_by_its_moment(cell):
    wall = ADHESIVE["adhesive"]
    free, periodic = (on_smooth_sphere(wall, [10.0], cell=c)[0] for c in (0, cell))
    shift = periodic.height - free.height
    by_force = 3.9003 * periodic.normal_force / (np.pi * cell)
    assert shift > 1.08 * by_force
    assert periodic.height_error == pytest.approx(shift, rel=0.01)
    assert abs(periodic.contact_area - free.contact_area) < 2.0 * periodic.area_error


def test_the_force_of_a_plastic_flat_at_the_height_of_full_contact_is_not_known():
    rough = rc.SelfAffine(0.012, 0.8, 4.0, 16.0, seed=1, domain=32.0)
    flat = rc.RoughSphere(np.inf, rough)
    window = {"shape": (32, 32), "periodic": True, "fixed": True}
    atoms = atoms_under(flat, rc.PlasticWall(0.4), **window)
    known, step = rc.load_path(atoms, heights=[0.01, 0.0], validity="ignore")
    assert known.force_error < 0.1 * known.normal_force
    assert np.isnan(step.force_error)
    assert "give a load" in step.not_known["force_error"]


def test_errors_of_an_adhesive_contact_that_nearly_touches_its_images_are_not_known():
    (free,) = on_smooth_sphere(ADHESIVE["adhesive"], [10.0])
    (close,) = on_smooth_sphere(ADHESIVE["adhesive"], [10.0], cell=36)
    assert close.contact_area < 0.9 * free.contact_area
    assert np.isnan([close.area_error, close.height_error, close.force_error]).all()
    assert close.validity == "adhesive contact/cell = 0.904 > 0.85"
    (repulsive,) = on_smooth_sphere(WALLS["repulsive"], [18.0], cell=40)
    assert repulsive.validity == "" and repulsive.area_error > 0.0


@pytest.mark.parametrize("cell", [32, 48])
def test_force_of_a_small_cell_at_a_height_is_as_wrong_as_estimated(cell):
    free, periodic = (
        relaxed("repulsive", fixed=True, heights=[-0.5], smooth=True, cell=c)
        for c in (0, cell)
    )
    error = periodic.normal_force - free.normal_force
    assert error > 0.5 * free.normal_force
    assert periodic.force_error == pytest.approx(error, rel=0.25)
    area = periodic.contact_area - free.contact_area
    assert periodic.area_error > 0.5 * area


def on_smooth_sphere(wall, loads, radius=RADIUS, cell=0, grid="atoms"):
    """Steps at the loads of contacts of given radii by Hertz."""
    sphere, side = rc.RoughSphere(radius), cell or 8
    atoms = atoms_under(sphere, wall, (side, side), periodic=cell > 0, fixed=False)
    loads = [Hertz(radius, 1.0).force(contact) for contact in loads]
    window = "fixed" if cell else "auto"
    return list(
        rc.load_path(atoms, loads=loads, grid=grid, window=window, validity="ignore")
    )


def test_images_of_a_cell_take_the_area_that_they_bend_away():
    error = estimate = 0.0
    for contact, cell in ((20.0, 64), (20.0, 80), (30.0, 120)):
        free, periodic = (
            on_smooth_sphere(rc.HardWall(), [contact], radius=300.0, cell=side)[0]
            for side in (0, cell)
        )
        error += free.contact_area - periodic.contact_area
        estimate += periodic.area_error
    assert estimate == pytest.approx(error, rel=0.2)


def test_single_atoms_of_a_rough_contact_are_an_error_of_a_cell():
    for seed in range(6):
        free, periodic = (relaxed("hard", seed, cell=side) for side in (0, 64))
        error = abs(free.contact_area - periodic.contact_area)
        assert error <= 2.0 * periodic.area_error


def test_error_of_the_area_is_at_most_the_cell():
    sphere = rc.RoughSphere(RADIUS)
    atoms = atoms_under(sphere, WALLS["repulsive"], (32, 32), periodic=True)
    (full,) = rc.load_path(atoms, penetrations=[1.5], validity="ignore")
    assert full.area_error == full.contact_area == 1024.0


def test_soft_wall_on_a_coarse_grid_is_as_wrong_as_its_stiffness_says():
    wall, contacts = rc.LennardJones93.repulsive(4.0, 1.0), np.arange(6.0, 13.0)
    coarse, fine = (on_smooth_sphere(wall, contacts, grid=f"a0/{n}") for n in (1, 4))
    areas = [sum(step.continuum_area for step in steps) for steps in (coarse, fine)]
    estimate = sum(step.area_error for step in coarse)
    assert estimate == pytest.approx(areas[0] - areas[1], rel=0.3)


def test_cell_of_a_flat_surface_is_no_error():
    rough = rc.SelfAffine(0.1, 0.65, 4.0, 16.0, seed=1, domain=32.0)
    flat = rc.RoughSphere(np.inf, rough)
    atoms = atoms_under(flat, shape=(32, 32), periodic=True, fixed=False)
    (step,) = rc.load_path(atoms, loads=[10.0])
    assert step.height_error < 1e-4 and step.area_error < 1e-3 * step.contact_area


def test_waves_that_a_coarse_grid_loses_are_an_error_of_the_area():
    fine, coarse = (relaxed("hard", grid=f"{n} a0") for n in (2, 4))
    lost = 0.3 * coarse.contact_area
    assert coarse.area_error > fine.area_error + 0.8 * lost


def test_errors_out_of_contact_are_zero():
    step = relaxed("repulsive", fixed=True, heights=[20.0], grid="a0")
    assert (step.area_error, step.force_error, step.height_error) == (0.0, 0.0, 0.0)
    assert 0.0 < step.penetration_error < 0.05


def test_contact_at_the_height_of_the_first_one_has_the_errors_under_a_sphere():
    # where loops and fits pass this height, an atom may have a force of rounding
    sphere, solid = rc.RoughSphere(RADIUS), Isotropic(1.0, 0.0)
    problem = rc.Problem(sphere, solid, rc.HardWall(), spacing=1.0)
    options = StepOptions(continuum=True, window="unchecked")
    box = Box((-9, -9), (18, 18))
    stepper = Stepper(problem, "heights", box, options)
    step = stepper.relax(stepper.start, -0.2)
    expected, run = estimated_errors(step), step.run
    for height in (0.0, 0.1):
        moved = replace(run, state=replace(run.state, height=height))
        found = estimated_errors(replace(step, run=moved))
        assert found[:4] == pytest.approx(expected[:4], rel=0.1)


@pytest.mark.parametrize("refine", [1, 2])
def test_error_at_a_penetration_counts_the_lowest_point_of_the_grid(refine):
    at_depth, exact = (
        relaxed("hard", fixed=True, penetrations=[1.0], grid=f"a0/{n}")
        for n in (refine, 8)
    )
    error = abs(at_depth.normal_force - exact.normal_force)
    assert error < 2.0 * at_depth.force_error < 0.1 * exact.normal_force
    grid = f"a0/{refine}"
    at_height = relaxed("hard", fixed=True, heights=[at_depth.height], grid=grid)
    assert at_height.force_error < at_depth.force_error


# Coverage


def share_within_twice(errors):
    true, estimate = np.transpose(errors)
    return np.mean(true <= 2.0 * estimate)


def test_nine_of_ten_measured_errors_are_within_twice_the_estimate():
    """Seeds and Hurst exponents from which no estimate follows."""
    with open(TABLE, newline="") as file:
        rows = list(csv.DictReader(file))
    exact = {tuple(row.values())[:7]: row for row in rows if row["setting"] == "exact"}
    found = defaultdict(list)
    for row in rows:
        truth = exact.get(tuple(row.values())[:7])
        if truth is None or truth is row:
            continue
        for name in ("area", "height", "area_at_height", "force"):
            error = abs(float(row[name]) - float(truth[name]))
            estimate = float(row[f"{name}_error"])
            if np.isfinite(estimate):
                found[row["study"], name].append((error, estimate))
    assert len(found) == 10
    for errors in found.values():
        assert len(errors) >= 48
        assert share_within_twice(errors) >= 0.9


@pytest.mark.slow
def test_nine_of_ten_heights_on_random_layers_are_within_twice_the_estimate():
    """Incompressible or not, on a rigid base, down to a third of the spacing."""
    errors = []
    for seed in range(30):
        random = np.random.default_rng([seed, 11])
        thickness = float(np.exp(random.uniform(np.log(0.3), np.log(6.0))))
        solid = Layer(1.0, thickness, poisson=float(random.choice([0.3, 0.5])))
        radius, load = random.uniform(50.0, 300.0), random.uniform(2, 20)
        errors += errors_on_layer(solid, radius, load)[0][:2]
    assert share_within_twice(errors) >= 0.9


@pytest.mark.parametrize(
    "column, grid", [("contact_area", "atoms"), ("continuum_area", "a0")]
)
def test_error_and_mean_pressure_agree_with_the_area_asked_for(column, grid):
    step = relaxed("hard", smooth=True, grid=grid)
    area = getattr(step, column)
    assert step.area_column == column
    assert step.mean_pressure == pytest.approx(step.normal_force / area, rel=1e-6)
    assert abs(step.contact_area / step.continuum_area - 1.0) > 0.02
    assert (step.area_error < 1e-3 * area) == (column == "contact_area")


@cache
def on_fine_grid(seed):
    return relaxed("hard", seed, grid="a0/8")


@pytest.mark.parametrize("refine", [1, 2])
def test_zero_of_the_penetration_is_an_error_of_the_continuum(refine):
    error = estimate = 0.0
    for seed in range(5, 11):
        step, exact = relaxed("hard", seed, grid=f"a0/{refine}"), on_fine_grid(seed)
        depth = exact.penetration - step.penetration
        assert abs(depth) < 2.0 * step.penetration_error
        error += depth - (step.height - exact.height)
        estimate += step.penetration_error - step.height_error
    assert 0.5 * error < estimate < 3.0 * error
    atoms = relaxed("hard")
    assert atoms.penetration_error == atoms.height_error


def test_error_of_the_area_is_at_most_the_area_where_attraction_cancels_reaction():
    tip = rc.RoughSphere(0.5)
    for work in (0.005, 0.01, 0.02):  # what is left of pressure and force is rounding
        wall = rc.ExponentialWall(work, 0.005)
        atoms = atoms_under(tip, wall, (9, 9), fixed=False)
        for load in (0.003, 0.01):
            _, step = rc.load_path(atoms, loads=[load, 0.0], validity="ignore")
            assert 0.0 < step.area_error <= step.contact_area == 1.0
            assert abs(step.mean_pressure) < 1e-12
