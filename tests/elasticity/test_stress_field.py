"""Stress below the surface against closed forms, integrals and dense solutions."""

import math

import numpy as np
import pytest
from point_forces import hertz_stress
from scipy.linalg import solve
from sliding_sphere import normal_and_trace, on_the_axis, on_the_surface

from ase_roughcontact.elasticity import (
    Creep,
    Cubic,
    FreeHalfSpace,
    Isotropic,
    Layer,
    StressField,
    Viscoelastic,
)
from ase_roughcontact.elasticity.crystals.impedance import elastic_tensor
from ase_roughcontact.elasticity.material import cubic_stiffness
from ase_roughcontact.elasticity.subsurface import Tractions

N = 96
COPPER = 168.4, 121.4, 75.4
CENTRE = (N - 1) / 2


def distance(n=N):
    x = np.arange(n) - (n - 1) / 2
    return np.hypot(x[:, None], x)


def hertz(a=30.0, n=N):
    return np.sqrt(np.maximum(1 - (distance(n) / a) ** 2, 0.0))


def axis_stress(field, depth):
    return field.stress_at([CENTRE], [CENTRE], depth)[:, 0, 0]


def sliding(friction, nu):
    """Field below a sphere that slides along x."""
    pressure = hertz()
    tractions = np.stack([friction * pressure, 0 * pressure])
    return StressField(Isotropic(1.0, nu), 1.0, pressure, tractions)


FRICTION = pytest.mark.parametrize(
    ("friction", "nu"), [(0.0, 0.0), (0.0, 0.3), (0.25, 0.3), (0.5, 0.5)]
)


@FRICTION
@pytest.mark.parametrize("t", [0.2, 0.5, 1.0, 5.0])
def test_sliding_sphere_on_the_axis(friction, nu, t):
    stress = axis_stress(sliding(friction, nu), 30.0 * t)
    expected = on_the_axis(30.0 * t, 30.0, nu, friction)
    np.testing.assert_allclose(stress, expected, atol=1e-4)


@FRICTION
def test_sliding_sphere_on_the_surface(friction, nu):
    field = sliding(friction, nu)
    for x, y in [(3.0, 7.0), (-20.0, 11.0), (-24.0, 0.0), (1.0, -25.0)]:
        found = field.stress_at([CENTRE + x], [CENTRE + y], 0.0)[:, 0, 0]
        expected = on_the_surface(x, y, 30.0, nu, friction)
        np.testing.assert_allclose(found, expected, atol=3e-3)


# all components by an integral over point forces, two also in closed form
@FRICTION
def test_sliding_sphere_anywhere(friction, nu):
    field = sliding(friction, nu)
    for point in [(3.0, 7.0, 6.0), (-20.0, 11.0, 14.0), (27.0, -4.0, 45.0)]:
        x, y, depth = point
        found = field.stress_at([CENTRE + x], [CENTRE + y], depth)[:, 0, 0]
        expected = hertz_stress(point, 30.0, nu, friction)
        np.testing.assert_allclose(found, expected, atol=2e-4)
        closed = normal_and_trace(*point, 30.0, nu, friction)
        np.testing.assert_allclose([found[2], found[:3].sum()], closed, atol=3e-4)


# Hamilton & Goodman, J. Appl. Mech. 33, 371 (1966)
def test_largest_tension_at_the_trailing_edge_of_a_sliding_sphere():
    nu, friction, largest = 0.3, 0.25, []
    for a in (32.0, 128.0):  # the error is proportional to sqrt(spacing/a)
        n = int(2.5 * a)
        pressure = hertz(a, n)
        tractions = np.stack([friction * pressure, 0 * pressure])
        field = StressField(Isotropic(1.0, nu), 1.0, pressure, tractions)
        x = np.arange(int(0.02 * n), int(0.2 * n), 0.25)
        largest.append(field.stress_at(x, [(n - 1) / 2], 0.0)[0].max())
    expected = (1 - 2 * nu) / 3 + friction * math.pi * (4 + nu) / 8
    assert 2 * largest[1] - largest[0] == pytest.approx(expected, rel=0.02)


# Love, Phil. Trans. R. Soc. A 228, 377 (1929)
@pytest.mark.parametrize("depth", [10.0, 20.0, 60.0])
def test_uniform_pressure_on_a_rectangle(depth):
    pressure = np.zeros((N, N))
    pressure[28:68, 36:60] = 1.0  # half sides 20 and 12
    a, b = 20.0, 12.0
    far = math.sqrt(a * a + b * b + depth**2)
    sides = 1 / (a * a + depth**2) + 1 / (b * b + depth**2)
    corner = math.atan(a * b / (depth * far)) + a * b * depth / far * sides
    stress = axis_stress(StressField(Isotropic(1.0, 0.3), 1.0, pressure), depth)
    assert stress[2] == pytest.approx(-2 / math.pi * corner, rel=1e-3)


def cell_means(function, n=N, points=16):
    """Means of a function of the distance over square cells."""
    x = (np.arange(n * points) + 0.5) / points - n / 2
    values = function(np.hypot(x[:, None], x))
    return values.reshape(n, points, n, points).mean(axis=(1, 3))


# Sneddon, Proc. Camb. Phil. Soc. 42, 29 (1946); Int. J. Eng. Sci. 3, 47 (1965)
@pytest.mark.parametrize("depth", [12.0])
def test_cone_and_punch_on_the_axis(depth):
    a = 24.0
    inside = lambda r: np.maximum(a * a - r * r, 1e-9)  # noqa: E731
    cone = cell_means(lambda r: np.arccosh(np.maximum(a / r, 1.0)))
    punch = cell_means(lambda r: np.where(r < a, a / np.sqrt(inside(r)), 0.0))
    t = depth / a
    expected_cone = 0.5 * math.log(1 + 1 / t**2) + 1 / (1 + t * t)
    expected_punch = (1 + 3 * t * t) / (1 + t * t) ** 2
    solid = Isotropic(1.0, 0.3)
    found = axis_stress(StressField(solid, 1.0, cone), depth)[2]
    assert found == pytest.approx(-expected_cone, rel=2e-3)
    found = axis_stress(StressField(solid, 1.0, punch), depth)[2]
    assert found == pytest.approx(-expected_punch, rel=1e-2)


def one_wave(solid, traction, theta=0.4, q=0.7, depths=(0.0, 0.5, 2.0, 6.0)):
    """Amplitudes of stress and displacement, shape (depths, 9)."""
    qx, qy = np.array([q * math.cos(theta)]), np.array([q * math.sin(theta)])
    tx, ty, tz = (np.array([complex(each)]) for each in traction)
    waves = solid.subsurface(Tractions(qx, qy, tz, tx, ty))
    rows = []
    for depth in depths:
        row = [complex(each[0]) for each in waves.stress(depth)]
        rows.append(row + [complex(each[0]) for each in waves.displacement(depth)])
    return np.array(rows)


def dense_wave(tensor, traction, theta=0.4, q=0.7, depths=(0.0, 0.5, 2.0, 6.0)):
    """The same by Chebyshev collocation of the equations of motion in the depth."""
    k, length = 60, 45.0
    node = np.cos(np.pi * np.arange(k + 1) / k)  # 1 at the surface
    scale = np.where((np.arange(k + 1) % k) == 0, 2.0, 1.0) * (-1.0) ** np.arange(k + 1)
    gap = node[:, None] - node + np.eye(k + 1)
    slope = np.outer(scale, 1 / scale) / gap
    slope -= np.diag(slope.sum(axis=1))
    slope *= 2 / length  # d/dz
    wave = np.array([math.cos(theta), math.sin(theta), 0.0])
    along = np.einsum("j,ijkl,l->ik", wave, tensor, wave)
    mixed = np.einsum("j,ijk->ik", wave, tensor[:, :, :, 2])
    normal = tensor[:, 2, :, 2]
    one = np.eye(k + 1)
    matrix = np.kron(slope @ slope, normal) + 1j * q * np.kron(slope, mixed + mixed.T)
    matrix = matrix - q * q * np.kron(one, along)
    matrix[:3] = np.kron(slope[:1], normal) + 1j * q * np.kron(one[:1], mixed.T)
    matrix[-3:] = np.kron(one[-1:], np.eye(3))
    load = np.zeros(3 * (k + 1), complex)
    load[:3] = traction
    moved = solve(matrix, load).reshape(k + 1, 3)
    height = (node - 1) * length / 2
    fit = [np.polynomial.chebyshev.Chebyshev.fit(height, u, k) for u in moved.T]
    rows = []
    for depth in depths:
        u = np.array([each(-depth) for each in fit])
        gradient = 1j * q * np.outer(u, wave)
        gradient[:, 2] += [each.deriv()(-depth) for each in fit]
        stress = np.einsum("ijkl,kl->ij", tensor, gradient)
        order = (0, 1, 2, 1, 0, 0), (0, 1, 2, 2, 2, 1)
        rows.append([*stress[order], *u])
    return np.array(rows)


@pytest.mark.parametrize("traction", [(0, 0, -1), (1, 0.5, 0)])
def test_wave_on_a_cubic_solid_solves_the_equations_of_equilibrium(traction):
    tensor = elastic_tensor(cubic_stiffness(*COPPER))
    expected = dense_wave(tensor, traction)
    found = one_wave(Cubic(*COPPER, x="100"), traction)
    np.testing.assert_allclose(found[:, :6], expected[:, :6], atol=1e-5)
    np.testing.assert_allclose(found[:, 6:], expected[:, 6:], atol=1e-7)


@pytest.mark.parametrize("traction", [(0, 0, -1), (1, 0.5, 0)])
def test_cubic_solid_of_isotropic_constants_is_isotropic(traction):
    lame, shear = 1.2, 0.8
    nu = lame / (2 * (lame + shear))
    cubic = Cubic(lame + 2 * shear, lame, shear)
    isotropic = Isotropic(2 * shear / (1 - nu), nu)
    np.testing.assert_allclose(
        one_wave(cubic, traction), one_wave(isotropic, traction), atol=1e-6
    )


def test_axes_of_a_cubic_solid_turn_with_its_x_direction():
    turned = one_wave(Cubic(*COPPER, x="110"), (0, 0, -1), theta=0.4 - math.pi / 4)
    found = one_wave(Cubic(*COPPER, x="100"), (0, 0, -1), theta=0.4)
    np.testing.assert_allclose(turned[:, 2], found[:, 2], atol=1e-9)  # zz
    trace = found[:, :3].sum(axis=1)
    np.testing.assert_allclose(turned[:, :3].sum(axis=1), trace, atol=1e-9)


SOFT = {"poisson": 0.3, "base_poisson": 0.2}
LAYERS = {
    "bonded": Layer(1.0, 3.0, 5.0, **SOFT),
    "sliding": Layer(1.0, 3.0, 5.0, bonded=False, **SOFT),
    "bonded, rigid": Layer(1.0, 3.0, poisson=0.3),
    "sliding, rigid": Layer(1.0, 3.0, poisson=0.3, bonded=False),
    "stiff": Layer(5.0, 3.0, 1.0, **SOFT),
}


@pytest.mark.parametrize("layer", LAYERS.values(), ids=LAYERS.keys())
def test_surface_of_a_layer_sinks_by_its_compliance(layer):
    sunk = one_wave(layer, (0, 0, -1))[0, 8]
    q = 0.7 * math.cos(0.4), 0.7 * math.sin(0.4)
    assert sunk == pytest.approx(-layer.wave_compliance(*q), rel=1e-9)


@pytest.mark.parametrize("layer", LAYERS.values(), ids=LAYERS.keys())
def test_surface_of_a_layer_carries_the_given_tractions(layer):
    surface = one_wave(layer, (0.3, 0.5, -1))[0]
    np.testing.assert_allclose(surface[[4, 3, 2]], [0.3, 0.5, -1], atol=1e-12)


@pytest.mark.parametrize("bonded", [True, False])
def test_tractions_and_displacement_at_the_interface_of_a_layer(bonded):
    layer = Layer(1.0, 3.0, 5.0, bonded=bonded, **SOFT)
    above, below = one_wave(layer, (0.3, 0.5, -1), depths=(3.0, 3.0 + 1e-9))
    joined = [2, 3, 4, 6, 7, 8] if bonded else [2, 3, 4, 8]
    np.testing.assert_allclose(above[joined], below[joined], atol=1e-7)
    if not bonded:
        np.testing.assert_allclose(above[[3, 4]], 0.0, atol=1e-12)


@pytest.mark.parametrize(
    ("layer", "limit"),
    [
        (Layer(2.0, 3.0, 2.0, 0.3, 0.3), Isotropic(2.0, 0.3)),
        (Layer(7.0, 1e-7, 2.0, 0.4, 0.3), Isotropic(2.0, 0.3)),
        (Layer(2.0, 1e5, 7.0, 0.3, 0.4), Isotropic(2.0, 0.3)),
        (Layer(2.0, 1e5, poisson=0.3), Isotropic(2.0, 0.3)),
    ],
    ids=["equal moduli", "zero thickness", "infinite thickness", "rigid, infinite"],
)
def test_limits_of_a_layer_are_half_spaces(layer, limit):
    load = (0.3, 0.5, -1)
    found = one_wave(layer, load, depths=(0.5, 2.0, 6.0))
    expected = one_wave(limit, load, depths=(0.5, 2.0, 6.0))
    np.testing.assert_allclose(found, expected, atol=1e-6)


def rough_loads(periodic=True, n=48):
    """Pressure and tractions of a random contact, zero where nothing touches."""
    x, random = np.arange(n), np.random.default_rng(3)
    heights = np.zeros((n, n))
    for k in range(1, 4):
        for m in range(4):
            phase = 2 * np.pi * (k * x[:, None] + m * x) / n + random.uniform(0, 7)
            heights += np.cos(phase) / (k + m)
    pressure = np.maximum(heights - 0.6, 0.0) ** 2
    if not periodic:
        pressure *= np.maximum(1 - (distance(n) / 20) ** 2, 0.0) ** 2
    return pressure, np.stack([0.3 * pressure, -0.2 * pressure])


SOLIDS = {
    "isotropic": Isotropic(1.0, 0.3),
    "cubic": Cubic(*COPPER),
    "layer": Layer(1.0, 7.0, 5.0, **SOFT),
}


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS.keys())
def test_stress_of_a_rough_contact_is_in_equilibrium(solid, periodic):
    pressure, tractions = rough_loads(periodic)
    field = StressField(solid, 1.0, pressure, tractions, periodic)
    (x, y, z), step = (24.3, 20.8, 4.4), 1e-2
    along = [field.stress_at([x + s], [y], z)[:, 0, 0] for s in (step, -step)]
    across = [field.stress_at([x], [y + s], z)[:, 0, 0] for s in (step, -step)]
    up = [field.stress_at([x], [y], z - s)[:, 0, 0] for s in (step, -step)]
    dx, dy, dz = ((a - b) / (2 * step) for a, b in (along, across, up))
    rows = [(0, 5, 4), (5, 1, 3), (4, 3, 2)]
    divergence = [dx[i] + dy[j] + dz[k] for i, j, k in rows]
    assert abs(dz).max() > 1e-3
    np.testing.assert_allclose(divergence, 0.0, atol=2e-5)


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("solid", SOLIDS.values(), ids=SOLIDS.keys())
def test_surface_outside_of_a_rough_contact_is_free_of_traction(solid, periodic):
    pressure, tractions = rough_loads(periodic)
    field = StressField(solid, 1.0, pressure, tractions, periodic)
    _, _, zz, yz, xz, _ = field.stress(0.0)
    largest = pressure.max()
    for found, load in ((zz, -pressure), (xz, tractions[0]), (yz, tractions[1])):
        np.testing.assert_allclose(found, load, atol=2e-3 * largest)


def test_displacement_at_the_surface_is_the_displacement_of_the_half_space():
    for solid in SOLIDS.values():
        pressure = hertz(15.0, 48)
        expected = FreeHalfSpace((48, 48), 1.0, solid).displacement(pressure)
        found = StressField(solid, 1.0, pressure).displacement(0.0)[2]
        np.testing.assert_allclose(found, expected, atol=3e-3 * abs(expected).max())


def test_mean_pressure_of_a_periodic_cell_is_uniaxial_strain():
    for solid, ratio in (
        (Isotropic(1.0, 0.3), 0.3 / 0.7),
        (Cubic(*COPPER, x="100"), COPPER[1] / COPPER[0]),
    ):
        stress = StressField(solid, 1.0, np.ones((8, 8)), periodic=True).stress(5.0)
        expected = [-ratio, -ratio, -1, 0, 0, 0]
        np.testing.assert_allclose(stress[:, 3, 4], expected, atol=1e-12)


def test_stress_of_a_viscoelastic_solid_follows_from_the_tractions_of_today():
    creep = Creep.standard_solid(relaxed=0.1, time=1.0)
    solid = Viscoelastic(Isotropic(1.0, 0.3), creep)
    field = StressField(solid, 1.0, hertz(15.0, 48))
    elastic = StressField(Isotropic(7.0, 0.3), 1.0, hertz(15.0, 48))
    np.testing.assert_allclose(field.stress(5.0), elastic.stress(5.0), atol=1e-12)
    with pytest.raises(ValueError, match="depends on the past"):
        field.displacement(5.0)


def test_stress_needs_the_poisson_ratio():
    with pytest.raises(NotImplementedError, match=r"poisson=0\.3"):
        StressField(Isotropic(1.0), 1.0, hertz()).stress(1.0)


def test_points_are_on_the_planes():
    pressure, tractions = rough_loads(periodic=False)
    for periodic in (True, False):
        field = StressField(Isotropic(1.0, 0.3), 1.0, pressure, tractions, periodic)
        plane = field.stress(4.0)
        found = field.stress_at(np.arange(3, 9), np.arange(20, 22), 4.0)
        np.testing.assert_allclose(found, plane[:, 3:9, 20:22], atol=1e-9)


@pytest.mark.parametrize(("x", "depth"), [(-1.0, 5.0), (96.0, 5.0), (3.0, -1.0)])
def test_points_outside_of_the_window_or_above_the_surface_are_refused(x, depth):
    field = StressField(Isotropic(1.0, 0.3), 1.0, hertz())
    with pytest.raises(ValueError, match=r"-1|95"):
        field.stress_at([x], [3.0], depth)


def test_array_for_the_result_must_have_the_shape_of_the_window():
    field = StressField(Isotropic(1.0, 0.3), 1.0, hertz())
    with pytest.raises(ValueError, match="96"):
        field.stress(5.0, np.empty((6, 3, 3)))


def test_fewer_points_have_the_same_stress_at_depth():
    field = StressField(Isotropic(1.0, 0.3), 1.0, hertz())
    stress, (step, _) = field.coarse_stress(20.0, 6.0)
    assert stress.shape[1] <= 24
    x = step * np.arange(stress.shape[1])
    np.testing.assert_allclose(stress, field.stress_at(x, x, 20.0), atol=1e-4)


@pytest.mark.parametrize("periodic", [True, False])
def test_field_of_the_tractions_around_a_point_has_no_others(periodic):
    pressure, tractions = rough_loads(periodic)
    inside = np.zeros((48, 48), bool)
    inside[30:46, 12:28] = True
    alone = np.where(inside, pressure, 0.0), np.where(inside, tractions, 0.0)
    solid = Isotropic(1.0, 0.3)
    expected = StressField(solid, 1.0, *alone).stress_at([37.0], [19.0], 3.0)
    field = StressField(solid, 1.0, pressure, tractions, periodic)
    near, corner = field.around(38.0, 20.0, 16)
    assert corner == (30, 12)
    found = near.stress_at([7.0], [7.0], 3.0)
    np.testing.assert_allclose(found, expected, atol=1e-4 * pressure.max())


def test_six_components_take_the_time_of_few_transforms():
    field = StressField(Isotropic(1.0, 0.3), 1.0, np.ones((512, 512)), periodic=True)
    field.stress(8.0)
    assert field.pairs <= 3.5


@pytest.mark.parametrize("solid", ["isotropic", "cubic"])
def test_uniform_tractions_of_a_periodic_cell_strain_it_by_hookes_law(solid):
    lame, shear = 1.2, 0.8
    longitudinal = lame + 2 * shear
    nu = lame / (2 * (lame + shear))
    solid = {
        "isotropic": Isotropic(2 * shear / (1 - nu), nu),
        "cubic": Cubic(longitudinal, lame, shear),
    }[solid]
    one = np.ones((8, 8))
    field = StressField(solid, 1.0, 0.4 * one, [0.3 * one, 0.2 * one], periodic=True)
    found = field.displacement(5.0)[:, 2, 3]
    expected = [-5 * 0.3 / shear, -5 * 0.2 / shear, 5 * 0.4 / longitudinal]
    np.testing.assert_allclose(found, expected, rtol=1e-9)


def test_uniform_pressure_on_a_layer_in_a_periodic_cell():
    layer, one = Layer(1.0, 3.0, 5.0, poisson=0.3, base_poisson=0.2), np.ones((8, 8))
    field = StressField(layer, 1.0, one, periodic=True)
    for depth, nu in ((2.0, 0.3), (4.0, 0.2)):
        expected = [-nu / (1 - nu), -nu / (1 - nu), -1, 0, 0, 0]
        np.testing.assert_allclose(field.stress(depth)[:, 2, 3], expected, atol=1e-12)
    # thickness over the longitudinal modulus E* (1 - nu)^2/(1 - 2 nu)
    soft, stiff = 1.0 * 0.7**2 / 0.4, 5.0 * 0.8**2 / 0.6
    for depth, expected in ((2.0, 2 / soft), (5.0, 3 / soft + 2 / stiff)):
        found = field.displacement(depth)[2, 2, 3]
        assert found == pytest.approx(expected, rel=1e-9)


def test_relaxed_viscoelastic_solid_has_the_displacement_of_a_softer_one():
    solid = Viscoelastic(Isotropic(1.0, 0.3), Creep.standard_solid(0.1, 1.0)).relaxed
    for periodic in (True, False):
        field, expected = (
            StressField(each, 1.0, hertz(15.0, 48), periodic=periodic)
            for each in (solid, Isotropic(0.1, 0.3))
        )
        found = field.displacement(5.0)
        np.testing.assert_allclose(found, expected.displacement(5.0), rtol=1e-9)
        np.testing.assert_allclose(field.stress(5.0), expected.stress(5.0), atol=1e-12)
