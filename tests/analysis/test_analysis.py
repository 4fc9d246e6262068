"""Maps, radial averages, patches, first contacts, distributions and fits."""

import numpy as np
import pytest
from ase import Atoms
from ase.units import GPa
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.analysis import (
    ContactMap,
    first_contact,
    gap_distribution,
    patches,
    pressure_distribution,
    radial_average,
)
from ase_roughcontact.theory import Hertz

A0 = 2.5
SPHERE = rc.RoughSphere(radius=20.0 * A0)
MODULUS = 100 * GPa


def map_of(pressure, origin=(0.0, 0.0), spacing=A0, periodic=False, gap=None):
    pressure = np.asarray(pressure, dtype=float)
    return ContactMap(pressure, pressure > 0.0, spacing, origin, periodic, gap)


def drawn(*rows, **options):
    """Map of a drawing, its rows along x; # is contact."""
    return map_of([[letter == "#" for letter in row] for row in rows], **options)


def relaxed_atoms(shape=(12, 10), **options):
    """Under an adhesive wall, so that atoms are pushed, pulled and open."""
    wall = rc.LennardJones93.adhesive(MODULUS, A0, 0.02)
    atoms = atoms_under(
        SPHERE, wall, shape, modulus=MODULUS, spacing=A0, height=1.0, **options
    )
    assert rc.NewtonKrylov(atoms, logfile=None).run(fmax=1e-6)
    return atoms


# Maps


def test_map_of_atoms_is_their_state(periodic):
    atoms = relaxed_atoms(periodic=periodic)
    state, made = atoms.calc.state(atoms), ContactMap.from_atoms(atoms)
    for name in ("pressure", "contact", "gap"):
        np.testing.assert_array_equal(getattr(made, name), getattr(state, name))
    assert made.normal_force == pytest.approx(state.normal_force)
    assert made.contact_area == pytest.approx(state.contact_area)
    assert made.periodic == periodic


def test_map_knows_where_the_axis_is():
    made = ContactMap.from_atoms(relaxed_atoms(center=(A0, -2 * A0)))
    np.testing.assert_allclose(made.x, A0 * (np.arange(12) - 5), atol=1e-9)
    np.testing.assert_allclose(made.y, A0 * (np.arange(10) - 7), atol=1e-9)


def test_gap_of_a_periodic_frame_counts_from_the_mean_plane():
    frame = rc.snapshot(relaxed_atoms(periodic=True))
    made = ContactMap.from_frame(frame, indenter=SPHERE)
    frame.positions[:-1, 2] += 0.7
    lifted = ContactMap.from_frame(frame, indenter=SPHERE)
    np.testing.assert_allclose(lifted.gap, made.gap)


def test_frames_that_make_no_map_are_refused():
    frame = rc.snapshot(relaxed_atoms(periodic=True))
    with pytest.raises(ValueError, match="snapshot"):
        ContactMap.from_frame(rc.substrate("Cu", (4, 4), SPHERE))
    with pytest.raises(ValueError, match="indenter"):
        ContactMap.from_frame(frame[:-1])
    with pytest.raises(ValueError, match="RoughContact"):
        ContactMap.from_atoms(Atoms("CuX"))


@pytest.mark.parametrize(
    "change",
    [
        {"pressure": np.full((2, 3), np.nan)},
        {"pressure": np.zeros(6)},
        {"contact": np.zeros((2, 3))},
        {"contact": np.zeros((3, 2), dtype=bool)},
        {"gap": np.zeros((3, 2))},
        {"spacing": 0.0},
        {"origin": (0.0, np.inf)},
        {"pressure": np.ma.masked_less(np.zeros((2, 3)), 1.0)},
        {"gap": np.ma.masked_less(np.zeros((2, 3)), 1.0)},
    ],
    ids=lambda change: next(iter(change)),
)
def test_bad_fields_of_a_map_are_refused(change):
    fields = {
        "pressure": np.zeros((2, 3)),
        "contact": np.zeros((2, 3), dtype=bool),
        "spacing": 1.0,
        "origin": (0.0, 0.0),
        "periodic": False,
    }
    with pytest.raises(ValueError, match=f"{next(iter(change))}|shape"):
        ContactMap(**{**fields, **change})


# Radial averages


def hertz_map(radius=9.3, half=12, **options):
    x = A0 * np.arange(-half, half + 1)
    distance = np.hypot(x[:, None], x)
    pressure = Hertz(100.0 * A0, MODULUS).pressure(distance, radius * A0)
    return map_of(pressure, origin=(x[0], x[0]), **options)


@pytest.mark.parametrize("bins", [None, 7, [0.0, 4.0, 5.0, 100.0]])
def test_force_of_the_rings_is_the_normal_force(bins, periodic, rng):
    values = rng.normal(size=(13, 9))
    made = map_of(values, origin=(-5 * A0, 2 * A0), periodic=periodic)
    average = radial_average(made, bins)
    force = np.nansum(average.pressure * average.sites) * made.cell_area
    assert force == pytest.approx(made.normal_force)
    assert average.contacts.sum() * made.cell_area == pytest.approx(made.contact_area)


def test_mean_over_contacts_leaves_open_atoms_out():
    made = map_of([[0.0, 3.0, -1.0], [1.0, 4.0, 0.0], [0.0, 0.0, 8.0]], (-A0, -A0))
    average = radial_average(made, [0.0, 0.5 * A0, 1.2 * A0, 1.5 * A0])
    np.testing.assert_allclose(average.pressure, [4.0, 4.0 / 4, 7.0 / 4])
    np.testing.assert_allclose(average.contact_pressure, [4.0, 4.0 / 2, 8.0])
    np.testing.assert_array_equal(average.sites, [1, 4, 4])
    np.testing.assert_array_equal(average.contacts, [1, 2, 1])
    np.testing.assert_allclose(average.radius, A0 * np.sqrt([0.0, 1.0, 2.0]))


def test_rings_without_contact_have_no_contact_pressure():
    average = radial_average(map_of(np.zeros((3, 3))))
    assert np.isnan(average.contact_pressure).all()
    np.testing.assert_array_equal(average.pressure, 0.0)


def test_small_map_off_the_axis_gives_the_average_of_a_large_one():
    pressure = np.zeros((41, 41))
    pressure[30:33, 8:12] = 1.0
    origin = (-20 * A0, -20 * A0)
    cut = (origin[0] + 30 * A0, origin[1] + 8 * A0)
    edges = A0 * (np.arange(20) + 0.5)
    large = radial_average(map_of(pressure, origin), edges)
    small = radial_average(map_of(pressure[30:33, 8:12], cut), edges)
    np.testing.assert_array_equal(small.sites, large.sites)
    np.testing.assert_allclose(small.pressure, large.pressure)


def test_periodic_average_does_not_depend_on_where_the_cell_is_cut(rng):
    pressure = rng.uniform(size=(8, 6))
    one = radial_average(map_of(pressure, periodic=True))
    moved = np.roll(pressure, (3, -2), axis=(0, 1))
    two = radial_average(map_of(moved, (-3 * A0, 2 * A0), periodic=True))
    np.testing.assert_allclose(two.pressure, one.pressure)
    assert one.sites.sum() == pressure.size


@pytest.mark.parametrize("spacing", [0.1, 2.5527])
def test_sites_at_the_last_edge_are_counted_whatever_the_spacing(spacing):
    positions = spacing * np.arange(-5, 20)
    for number in range(1, 15):
        made = ContactMap(
            pressure=np.ones((25, 25)),
            contact=np.ones((25, 25), dtype=bool),
            spacing=spacing,
            origin=(positions[0], positions[0]),
            periodic=False,
        )
        last = made.x[5 + number]
        sites = radial_average(made, [0.0, last]).sites
        assert sites >= (np.hypot(made.x[:, None], made.y) <= last).sum()


@pytest.mark.parametrize("bins", [0, 2.5, [1.0], [1.0, 1.0], [-1.0, 1.0], [0, np.nan]])
def test_bad_rings_are_refused(bins):
    with pytest.raises(ValueError, match="bins"):
        radial_average(map_of(np.ones((2, 2))), bins)


# Patches


def test_patches_have_area_perimeter_and_centroid():
    found = patches(drawn("##....", "##..#.", ".#....", origin=(10.0, -20.0)))
    np.testing.assert_allclose(found.area / A0**2, [5, 1])
    np.testing.assert_allclose(found.perimeter / A0, [10, 4])
    place = (found.centroid - (10.0, -20.0)) / A0
    np.testing.assert_allclose(place, [[0.8, 0.6], [1.0, 4.0]])
    np.testing.assert_array_equal(
        found.labels, [[1, 1, 0, 0, 0, 0], [1, 1, 0, 0, 2, 0], [0, 1, 0, 0, 0, 0]]
    )


def test_hole_adds_to_the_perimeter():
    assert patches(drawn("###", "#.#", "###")).perimeter == pytest.approx([16 * A0])


@pytest.mark.parametrize(("diagonal", "count"), [(False, 2), (True, 1)])
def test_diagonal_neighbours_connect_on_demand(diagonal, count):
    found = patches(drawn("#.", ".#"), diagonal)
    assert len(found) == count
    assert found.perimeter.sum() == pytest.approx(8 * A0)


def test_no_contact_has_no_patches(periodic):
    found = patches(map_of(np.zeros((3, 4)), periodic=periodic))
    assert len(found) == 0
    assert found.centroid.shape == (0, 2)


CORNERS = ("#...#", ".....", "..#..", "#...#")


def test_patch_around_the_corner_is_one_only_if_periodic():
    whole = patches(drawn(*CORNERS, periodic=True))
    np.testing.assert_allclose(whole.area / A0**2, [4, 1])
    np.testing.assert_allclose(whole.perimeter / A0, [8, 4])
    # sites 3 and 4 along x, 4 and 5 along y: a corner between four sites
    np.testing.assert_allclose(whole.centroid[0] / A0, [-0.5, -0.5])
    assert len(patches(drawn(*CORNERS))) == 5


def test_diagonal_neighbours_connect_across_the_corners_of_the_cell():
    one, other = ("#...", "....", "...#"), ("...#", "....", "#...")
    for rows in (one, other):
        made = drawn(*rows, periodic=True)
        assert len(patches(made)) == 2
        assert len(patches(made, diagonal=True)) == 1


def test_patch_longer_than_half_the_cell_has_its_true_centroid():
    made = drawn("##.#########", "............", periodic=True)
    found = patches(made)
    # sites 3 to 13, the middle one being 8, an image of -4
    np.testing.assert_allclose(found.centroid / A0, [[0.0, -4.0]])


def test_stairs_that_pass_themselves_are_unwrapped():
    # 45 degrees, longer than the cell, and an atom less than going around
    mask = np.zeros((8, 8))
    steps = np.arange(7)
    mask[steps, steps] = mask[steps, steps + 1] = 1.0
    mask = np.roll(mask, (5, 3), axis=(0, 1))
    found = patches(map_of(mask, periodic=True))
    expected = np.array([3.0 + 5, 3.5 + 3]) - 8 * np.array([1, 1])
    np.testing.assert_allclose(found.centroid / A0, [expected])


@pytest.mark.parametrize(
    ("rows", "around"),
    [
        (("....", "####", "...."), (False, True)),
        ((".#..", ".#..", ".#.."), (True, False)),
        (("##..", ".##.", "..##", "#..#"), (True, True)),
        (("###", "###", "###"), (True, True)),
        (("#",), (True, True)),
    ],
)
def test_patch_around_the_cell_has_no_centroid_along_that_direction(rows, around):
    found = patches(drawn(*rows, periodic=True))
    np.testing.assert_array_equal(np.isnan(found.centroid), [around])


@pytest.mark.parametrize("diagonal", [False, True])
def test_periodic_patches_do_not_depend_on_where_the_cell_is_cut(diagonal, rng):
    mask = rng.uniform(size=(17, 12)) < (0.3 if diagonal else 0.5)

    def facts(shift):
        moved = np.roll(mask, shift, axis=(0, 1))
        origin = (-shift[0] * A0, -shift[1] * A0)
        found = patches(map_of(moved, origin, periodic=True), diagonal)
        period = A0 * np.array(mask.shape)
        place = np.nan_to_num((found.centroid + 1e-6) % period, nan=-1.0).round(5)
        rows = np.column_stack((found.area, found.perimeter, place)).round(5)
        return rows[np.lexsort(rows.T)]

    expected = facts((0, 0))
    assert len(expected) > 5
    for shift in rng.integers(-20, 20, size=(20, 2)):
        np.testing.assert_allclose(facts(tuple(shift)), expected)


def test_perimeter_of_a_disc_is_four_over_pi_of_its_circumference():
    made = map_of(np.maximum(60.2**2 - hertz_map(half=64).distance ** 2 / A0**2, 0.0))
    circle = 2 * np.pi * 60.2 * A0
    (perimeter,) = patches(made).perimeter
    assert perimeter / circle == pytest.approx(4 / np.pi, rel=0.01)


# First contact


def test_smooth_sphere_touches_on_its_axis():
    found = first_contact(SPHERE, A0)
    assert found.position == (0.0, 0.0)
    assert found.distance == found.height == 0.0


def test_rough_sphere_touches_at_its_lowest_site():
    rough = rc.SelfAffine(
        rms_slope=0.1, hurst=0.8, short_wavelength=4.0, long_wavelength=64.0, seed=3
    )
    sphere = rc.RoughSphere(radius=500.0, roughness=rough)
    heights = sphere.heights((201, 201), 1.0, (-100.0, -100.0))
    i, j = np.unravel_index(heights.argmin(), heights.shape)
    found = first_contact(sphere, 1.0)
    assert found.position == (i - 100, j - 100)
    assert found.distance == pytest.approx(np.hypot(i - 100, j - 100))
    assert found.distance > 5.0
    assert found.height == pytest.approx(heights.min())


LOW = rc.HeightMap(np.where(np.arange(81).reshape(9, 9), 0.0, -5.0), 1.0)


@pytest.mark.parametrize(
    "indenter, message",
    [
        # the sphere rises by 5 at a distance of 32
        (rc.RoughSphere(radius=100.0, roughness=LOW), "defined up to"),
        (rc.SelfAffine(0.1, 0.8, 4.0, 64.0), "a method reach"),
    ],
)
def test_indenters_of_unknown_first_contact_are_refused(indenter, message):
    with pytest.raises(ValueError, match=message):
        first_contact(indenter, 1.0)


# Distributions


def test_densities_integrate_to_one(rng):
    pressure, gap = rng.normal(size=(2, 50, 40))
    gap[0] = np.nan
    made = map_of(pressure, gap=gap)
    for found in (pressure_distribution(made, 13), gap_distribution(made)):
        assert (found.density * np.diff(found.edges)).sum() == pytest.approx(1.0)


def test_distribution_of_hertz_pressure_is_a_straight_line():
    # p^2 = p0^2 (1 - r^2/a^2), so that P(p) = 2 p/p0^2
    made = hertz_map(radius=100.3, half=102)
    largest = made.pressure.max()
    found = pressure_distribution(made, np.linspace(0.0, largest, 9) + 1e-12)
    np.testing.assert_allclose(
        found.density, 2 * found.value / largest**2, rtol=0.03, atol=0.02 / largest
    )


def test_bins_that_cover_a_part_hold_that_part():
    made = map_of([[1.0, 2.0, 3.0, 4.0, 0.0]])
    found = pressure_distribution(made, [0.5, 1.5, 3.5])
    np.testing.assert_allclose(found.density, [0.25, 0.25])
    np.testing.assert_allclose(found.value, [1.0, 2.5])


def test_gaps_are_of_open_atoms():
    made = map_of([[1.0, 0.0, -1.0, 0.0]], gap=np.array([[0.1, 1.0, 3.0, np.nan]]))
    found = gap_distribution(made, [0.0, 2.0, 4.0, 6.0])
    np.testing.assert_allclose(found.density, [0.25, 0.25, 0.0])


def test_distributions_of_nothing_are_refused():
    with pytest.raises(ValueError, match="no atom is in contact"):
        pressure_distribution(map_of(np.zeros((2, 2))))
    with pytest.raises(ValueError, match="no gap"):
        gap_distribution(map_of(np.zeros((2, 2))))
    with pytest.raises(ValueError, match="all atoms are in contact"):
        gap_distribution(map_of(np.ones((2, 2)), gap=np.ones((2, 2))))
    with pytest.raises(ValueError, match="bins"):
        pressure_distribution(map_of(np.ones((2, 2))), [2.0, 1.0])
