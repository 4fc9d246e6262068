"""Adhesion loops: instabilities, energy balance, and smooth spheres against theory.

In units of the contact modulus and the spacing.
"""

from dataclasses import asdict
from functools import cache
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from ase.io import read
from built import atoms_under
from loop_areas import zero_load_area
from scipy.integrate import trapezoid
from scipy.optimize import brentq

import ase_roughcontact as rc
from ase_roughcontact._util.files import table_rows
from ase_roughcontact.path_kinds.loop.instabilities import Jump, interpolated
from ase_roughcontact.paths.restart import read_steps, restart_file
from ase_roughcontact.theory import MaugisDugdale

ROUGH = rc.SelfAffine(0.1, 0.8, short_wavelength=4.0, long_wavelength=32.0, seed=3)


def sphere_above(radius, work, shape, stiffness=1.0, roughness=None, **options):
    """Atoms below a sphere of E* = a0 = 1 with a wall of some work of adhesion."""
    sphere = rc.RoughSphere(radius=radius, roughness=roughness)
    wall = rc.LennardJones93.adhesive(1.0, 1.0, work, stiffness=stiffness)
    return atoms_under(sphere, wall, (shape, shape), **options)


@cache
def repulsive():
    return rc.adhesion_loop(sphere_above(20.0, 0.0, 12), deepest=0.5, step=0.1)


@cache
def adhesive(**options):
    """Loop with a jump on either branch: Maugis parameter 0.7."""
    options = {"step": 0.25, "tolerance": 3e-3, **options}
    return rc.adhesion_loop(sphere_above(50.0, 0.05, 40), deepest=1.2, **options)


@cache
def stiff():
    """Loop on a stiff solid, without a jump: Maugis parameter 0.16."""
    return rc.adhesion_loop(
        sphere_above(50.0, 0.005, 30, stiffness=0.1), deepest=0.4, step=0.1
    )


@cache
def rough():
    atoms = sphere_above(50.0, 0.05, 36, roughness=ROUGH)
    return rc.adhesion_loop(atoms, deepest=1.2, step=0.25, tolerance=3e-3)


def both_branches(loop):
    return (*loop.approach, *loop.retraction)


def jumps(loop):
    return (*loop.approach_jumps, *loop.retraction_jumps)


def forces_at(heights, records):
    """Normal forces interpolated between the states of an approach."""
    known, forces, _ = interpolated(records)
    return np.interp(heights, known[::-1], forces[::-1])


# Without adhesion


def test_repulsive_wall_makes_no_jumps():
    assert jumps(repulsive()) == ()
    assert repulsive().jump_in is None
    assert repulsive().jump_out is None


def test_repulsive_wall_has_equal_forces_on_both_branches():
    loop = repulsive()
    down = forces_at([r.height for r in loop.retraction], loop.approach)
    up = [r.normal_force for r in loop.retraction]
    np.testing.assert_allclose(down, up, atol=3e-3 * max(up))


# Jumps


def test_adhesive_sphere_jumps_in_and_out():
    loop = adhesive()
    jump_in, jump_out = jumps(loop)
    assert loop.jump_in == jump_in.height < loop.jump_out == jump_out.height
    assert jump_in.after.normal_force < 10.0 * jump_in.before.normal_force < 0.0
    assert jump_out.before.normal_force < 0.0 == jump_out.after.normal_force
    for jump in (jump_in, jump_out):
        assert abs(jump.after.height - jump.before.height) <= 0.25 / 256


def test_jump_in_is_the_first_jump_and_jump_out_the_last():
    first, second, third = (
        Jump(SimpleNamespace(height=height), SimpleNamespace(height=height))
        for height in (3.0, 5.0, 6.0)
    )
    loop = rc.AdhesionLoop((), (), (second, first), (first, third))
    assert (loop.jump_in, loop.jump_out) == (5.0, 6.0)


def test_loop_begins_beyond_the_range_and_ends_out_of_contact():
    loop = adhesive()
    for end in (loop.approach[0], loop.retraction[-1]):
        assert end.normal_force == end.repulsive_atoms == end.attractive_atoms == 0
    assert loop.approach[-1] is loop.retraction[0]
    assert loop.approach[-1].penetration == pytest.approx(1.2)
    down = np.diff([r.height for r in loop.approach])
    up = np.diff([r.height for r in loop.retraction])
    assert down.max() < 0.0 < up.min()
    assert max(-down.min(), up.max()) <= 0.25 * (1 + 1e-12)
    assert all(record.converged for record in both_branches(loop))


# Energy


def test_force_is_the_derivative_of_the_energy_without_jumps():
    loop = stiff()
    for way in (loop.approach, loop.retraction):
        largest = max(abs(r.normal_force) for r in way)
        for before, after in pairwise(way):
            force = (after.energy - before.energy) / (before.height - after.height)
            heights, forces, _ = interpolated([before, after])
            mean = trapezoid(forces, heights) / (after.height - before.height)
            assert force == pytest.approx(mean, abs=2e-3 * largest)


@pytest.mark.parametrize("loop", [adhesive, rough])
def test_area_of_the_loop_is_the_energy_lost_in_jumps(loop):
    assert loop().dissipated_energy > 0.1
    lost = loop().energy_lost_in_jumps
    assert loop().dissipated_energy == pytest.approx(lost, rel=0.02)
    error = loop().dissipation_error
    assert abs(loop().dissipated_energy - lost) <= error < 0.1 * lost
    assert all(jump.dissipated_energy > 0.0 for jump in jumps(loop()))


def test_stiff_solid_shows_no_hysteresis():
    loop = stiff()
    assert jumps(loop) == ()
    deepest_well = -min(record.energy for record in loop.approach)
    assert abs(loop.dissipated_energy) <= loop.dissipation_error < 0.05 * deepest_well
    assert abs(loop.dissipated_energy) < 5e-3 * deepest_well


# Independence of step, tolerance, accuracy and window


@pytest.mark.parametrize(
    "options, error",
    [
        ({"step": 0.125}, 5e-3),
        ({"tolerance": 1e-3}, 5e-3),
        ({"accuracy": "fast"}, 5e-3),
        ({"window": "auto"}, 1e-3),
    ],
)
def test_result_does_not_depend_on_step_tolerance_accuracy_and_window(options, error):
    loop, other = adhesive(), adhesive(**options)
    assert other.pull_off_force == pytest.approx(loop.pull_off_force, rel=error)
    assert other.jump_in == pytest.approx(loop.jump_in, abs=2e-3)
    assert other.jump_out == pytest.approx(loop.jump_out, abs=2e-3)
    assert len(jumps(other)) == 2


def test_step_that_does_not_converge_is_halved():
    options = {"fmax": 1e-7, "tolerance": 10.0, "smallest_step": 1e-3}
    whole = rc.adhesion_loop(
        sphere_above(20.0, 1e-4, 12), deepest=0.25, step=0.25, **options
    )
    most = max(record.iterations for record in whole.approach) - 1
    limited = rc.adhesion_loop(
        sphere_above(20.0, 1e-4, 12), deepest=0.25, step=0.25, max_steps=most, **options
    )
    assert len(limited.approach) > len(whole.approach)
    assert max(record.iterations for record in limited.approach) <= most
    assert all(record.converged for record in both_branches(limited))


def test_state_that_does_not_converge_is_marked():
    atoms = sphere_above(20.0, 0.0, 12)
    loop = rc.adhesion_loop(
        atoms,
        deepest=0.2,
        step=0.1,
        smallest_step=0.1,
        fmax=1e-9,
        max_steps=1,
        accuracy=1e-6,
    )
    assert not loop.approach[-1].converged


# Smooth spheres against theory


def dugdale(radius, work, stiffness):
    """Theory of Maugis and Dugdale for a wall of the same work and range."""
    return MaugisDugdale(radius, 1.0, work, np.sqrt(12.0 * work / stiffness))


def reduced_pull_off(loop, radius, work):
    return loop.pull_off_force / (np.pi * work * radius)


def pushed_area(theory):
    """Area under pressure of a Maugis-Dugdale contact at zero force.

    The pressure is the Hertzian one less the tension of the Dugdale wall,
    D. Maugis, J. Colloid Interface Sci. 150, 243 (1992):
    p = (2 E*/pi R) sqrt(a^2 - r^2) - (2 s/pi) arctan sqrt((c^2 - a^2)/(a^2 - r^2)).
    """
    ratio = brentq(lambda m: theory.state(m)[1], 1.0 + 1e-9, 50.0)
    a = float(theory.contact_radius(0.0))
    stress = theory.work_of_adhesion / theory.attraction_range

    def pressure(r):
        root = np.sqrt(a**2 - r**2)
        tension = stress * np.arctan(a * np.sqrt(ratio**2 - 1.0) / root)
        return 2.0 / np.pi * (root / theory.radius - tension)

    return np.pi * brentq(pressure, 0.0, a * (1.0 - 1e-12)) ** 2


@pytest.mark.parametrize(
    "loop, radius, work, stiffness",
    [(adhesive, 50.0, 0.05, 1.0), (stiff, 50.0, 0.005, 0.1)],
)
def test_pull_off_follows_maugis_and_dugdale(loop, radius, work, stiffness):
    expected = dugdale(radius, work, stiffness).pull_off_force
    assert loop().pull_off_force == pytest.approx(expected, rel=0.02)


@pytest.mark.slow  # three loops on up to 110 x 110 atoms
@pytest.mark.parametrize(
    "radius, work, stiffness, error",
    [(100.0, 0.1, 0.5, 0.035), (100.0, 0.2, 1.0, 0.02), (400.0, 0.05, 1.0, 0.02)],
)
def test_pull_off_and_area_follow_maugis_and_dugdale(radius, work, stiffness, error):
    length = np.cbrt(work**2 * radius)
    atoms = sphere_above(radius, work, 16, stiffness)
    loop = rc.adhesion_loop(
        atoms, deepest=3.0 * length, step=0.5 * length, window="auto"
    )
    theory = dugdale(radius, work, stiffness)
    assert loop.pull_off_force == pytest.approx(theory.pull_off_force, rel=0.02)
    # atoms are in contact where they are repelled; a soft wall adds a rim to them
    expected = pushed_area(theory)
    assert zero_load_area(loop.retraction) == pytest.approx(expected, rel=error)
    assert zero_load_area(loop.approach) == pytest.approx(expected, rel=error)


@pytest.mark.slow  # two hundred states of 56 x 56 atoms
def test_pull_off_approaches_dmt_from_below():
    atoms = sphere_above(100.0, 0.005, 56, stiffness=0.01)
    loop = rc.adhesion_loop(atoms, deepest=1.0, step=0.25)
    assert 1.96 < reduced_pull_off(loop, 100.0, 0.005) < 2.0
    assert jumps(loop) == ()


@pytest.mark.slow  # the contact of JKR is some 200 atoms wide
def test_pull_off_approaches_jkr_from_above():
    atoms = sphere_above(1000.0, 0.05, 16)
    loop = rc.adhesion_loop(
        atoms, deepest=4.0, step=1.0, tolerance=3e-3, accuracy="fast", window="auto"
    )
    assert 1.5 < reduced_pull_off(loop, 1000.0, 0.05) < 1.54


def same_sphere(spacings):
    """Pull-off of one continuum problem with so many spacings to the length E*/k."""
    radius, work = 50.0 * spacings, 0.05 * spacings
    atoms = sphere_above(radius, work, 16, stiffness=1.0 / spacings)
    loop = rc.adhesion_loop(
        atoms, deepest=1.2 * spacings, step=0.25 * spacings, window="auto"
    )
    return reduced_pull_off(loop, radius, work), len(loop.retraction_jumps)


@pytest.mark.slow  # the finest of three grids has 70 x 70 atoms
def test_spacing_equal_to_modulus_over_stiffness_resolves_the_wall():
    coarse, bulk_matched, fine = map(same_sphere, (0.5, 1.0, 2.0))
    assert bulk_matched[0] == pytest.approx(fine[0], rel=2e-3)
    assert bulk_matched[1] == fine[1] == 1
    assert coarse[0] > 1.05 * fine[0]
    assert coarse[1] > 1


# Area at zero load


def test_zero_load_areas_of_both_branches_agree():
    loop = adhesive(step=0.05)  # areas between states are on straight lines
    down, up = zero_load_area(loop.approach), zero_load_area(loop.retraction)
    assert down > 100.0
    assert up == pytest.approx(down, rel=0.02)


# Files


def test_all_states_are_written(tmp_path):
    table, movie = tmp_path / "loop.csv", tmp_path / "loop.traj"
    atoms = sphere_above(20.0, 0.0, 8)
    loop = rc.adhesion_loop(
        atoms, deepest=0.1, step=0.1, output=rc.Output(csv=table, trajectory=movie)
    )
    records = [*loop.approach, *loop.retraction[1:]]
    with open(table, newline="") as file:
        rows = list(table_rows(file))
    assert rows == [{k: str(v) for k, v in asdict(r).items()} for r in records]
    frames = read(movie, ":")
    assert read_steps(restart_file(movie)) == records
    assert [frame.positions[-1, 2] for frame in frames] == [r.height for r in records]


# Invalid input


@pytest.mark.parametrize(
    "arguments, message",
    [
        ({"step": 0.0}, "step must be .* > 0"),
        ({"step": np.nan}, "step must be .* nan"),
        ({"tolerance": -1.0}, "tolerance must be .* > 0"),
        ({"smallest_step": 0.0}, "smallest_step must be .* > 0"),
        ({"smallest_step": 0.2}, "smallest_step must not be larger than step"),
        ({"deepest": np.inf}, "deepest must be a finite number"),
        ({"deepest": -1.0}, "deepest .* above -0.77"),
        ({"window": "large"}, "window must be"),
    ],
)
def test_invalid_arguments_are_errors_before_anything_moves(arguments, message):
    atoms = sphere_above(50.0, 0.05, 8)
    positions = atoms.positions.copy()
    with pytest.raises(ValueError, match=message):
        rc.adhesion_loop(atoms, **{"deepest": 0.5, "step": 0.1, **arguments})
    np.testing.assert_array_equal(atoms.positions, positions)


def test_free_or_loaded_indenter_is_an_error():
    with pytest.raises(ValueError, match="fixed indenter"):
        rc.adhesion_loop(
            sphere_above(50.0, 0.05, 8, fixed=False), deepest=0.5, step=0.1
        )
    atoms = sphere_above(50.0, 0.05, 8)
    atoms.calc.set(load=1.0)
    with pytest.raises(ValueError, match="load=0"):
        rc.adhesion_loop(atoms, deepest=0.5, step=0.1)


def test_wall_of_infinite_range_is_an_error():
    atoms = sphere_above(50.0, 0.05, 8)
    wall = rc.LennardJones93.full(distance=1.0, work_of_adhesion=0.05, cutoff=3.0)
    object.__setattr__(wall, "cutoff", np.inf)
    atoms.calc.set(wall=wall)
    with pytest.raises(ValueError, match="finite cutoff, got inf"):
        rc.adhesion_loop(atoms, deepest=0.5, step=0.1)


def test_steps_below_the_rounding_of_heights_are_refused():
    with pytest.raises(ValueError, match=r"must be above 1\.\de-12.* 1e-14"):
        rc.adhesion_loop(
            sphere_above(20.0, 0.05, 12), deepest=0.5, step=0.1, smallest_step=1e-14
        )
