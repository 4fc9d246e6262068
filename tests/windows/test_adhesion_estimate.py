"""Contact radius under adhesion: its estimate, and the error if it is too large."""

import re

import numpy as np
import pytest
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.elasticity import Isotropic, Layer, PeriodicHalfSpace
from ase_roughcontact.theory import JKR, Hertz
from ase_roughcontact.windows.adhesion_estimate import AdhesionEstimate
from ase_roughcontact.windows.expected import contact_radius_on

SHORT, LONG = 4.0, 64.0


def wall(work):
    return rc.LennardJones93.adhesive(1.0, 1.0, work)


def sphere(radius):
    rough = rc.SelfAffine(0.1, 0.8, SHORT, LONG, seed=1, domain=512.0)
    return rc.RoughSphere(radius, rough)


def estimate(indenter, work):
    return AdhesionEstimate(indenter, wall(work), Isotropic(1.0), 1.0)


def first_step(indenter, work, **path):
    atoms = atoms_under(indenter, wall(work), fixed="loads" not in path)
    (record,) = rc.load_path(atoms, window="auto", **path)
    return atoms, record


def energy_of_the_spectrum(slope=0.1, hurst=0.8, long=LONG):
    """E*/4 times the mean of |q| C(q), from the mean of q^2 C(q)."""

    def moment(power):  # of |q|^(power + 2 H) C(q), over the plane
        p = power - 2.0 * hurst
        first, last = 2.0 * np.pi / long, 2.0 * np.pi / SHORT
        return (last**p - first**p) / p

    return 0.25 * slope**2 * moment(1.0) / moment(2.0)


def test_effective_work_lacks_the_energy_of_the_spectrum():
    left = estimate(sphere(1e4), 0.05).effective_work
    assert 0.05 - left == pytest.approx(energy_of_the_spectrum(), rel=1e-12)


def test_effective_work_on_other_solids():
    def energy(solid, indenter):
        return 0.05 - AdhesionEstimate(indenter, wall(0.05), solid, 1.0).effective_work

    thick, thin = Layer(4.0, 1e3, 1.0, 0.3, 0.3), Layer(4.0, 1e-3, 1.0, 0.3, 0.3)
    between, rough = Layer(4.0, 2.0, 1.0, 0.3, 0.3), sphere(1e4)
    expected = energy_of_the_spectrum()
    assert energy(thick, rough) == pytest.approx(4.0 * expected, rel=1e-6)
    assert energy(thin, rough) == pytest.approx(expected, rel=1e-3)
    # the same by the transform of the roughness itself, one period of it
    heights = rough.roughness.heights((512, 512), 1.0)
    halfspace = PeriodicHalfSpace((512, 512), 1.0, between)
    pressed = -0.5 * np.mean(halfspace.elastic_pressure(heights) * heights)
    assert energy(between, rough) == pytest.approx(pressed, rel=0.02)


@pytest.mark.parametrize(
    "solid", [Layer(0.25, 8.0, 1.0, 0.3, 0.3), Layer(1.0, 5.0, poisson=0.3)]
)
@pytest.mark.parametrize("attractive", [True, False])
def test_radius_of_a_contact_on_a_layer_before_it_is_calculated(solid, attractive):
    smooth, load = rc.RoughSphere(200.0), 10.0
    form = wall(0.02) if attractive else rc.HardWall()
    atoms = atoms_under(smooth, form, solid=solid, fixed=False)
    (step,) = rc.load_path(atoms, loads=[load], window="auto", validity="ignore")
    if attractive:
        expected = AdhesionEstimate(smooth, form, solid, 1.0).radius(0.0, load)
    else:
        expected = contact_radius_on(
            solid, 1.0, lambda e: float(Hertz(200.0, e).contact_radius(load))
        )
    measured = np.sqrt(step.contact_area / np.pi)
    assert measured == pytest.approx(expected, rel=0.3 if attractive else 0.03)
    homogeneous = Hertz(200.0, solid.contact_modulus).contact_radius(load)
    assert abs(measured - homogeneous) > 0.15 * measured


@pytest.mark.parametrize("thickness", [1.0, 5.0])
def test_radius_on_an_incompressible_layer_is_that_for_waves_of_its_size(thickness):
    solid = Layer(1.0, thickness)
    radius = contact_radius_on(
        solid, 1.0, lambda e: float(Hertz(1000.0, e).contact_radius(100.0))
    )
    modulus = float(solid.wave_modulus(np.pi / radius))
    expected = Hertz(1000.0, modulus).contact_radius(100.0)
    assert radius == pytest.approx(expected, rel=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_effective_work_of_a_height_map_lacks_the_energy_of_its_waves(seed):
    heights = rc.SelfAffine(0.1, 0.8, SHORT, LONG, seed=seed, domain=512.0).heights(
        (512, 512), 1.0
    )
    indenter = rc.RoughSphere(1e4, rc.HeightMap(heights, 1.0))
    left = estimate(indenter, 0.05).effective_work
    assert 0.05 - left == pytest.approx(energy_of_the_spectrum(), rel=0.03)


def test_contact_radius_of_a_smooth_sphere_agrees_with_jkr():
    contact = estimate(rc.RoughSphere(1e4), 0.05)
    radius = contact.radius(0.0, 3.0)
    assert radius == pytest.approx(float(JKR(1e4, 1.0, 0.05).contact_radius(3.0)))
    depth = float(JKR(1e4, 1.0, 0.05).penetration(radius))
    assert contact.radius(depth, None) == pytest.approx(radius, rel=1e-9)


def test_weak_adhesion_does_not_extend_a_rough_contact():
    assert estimate(sphere(1e8), 0.005).radius(0.0, 1.0) == 0.0


def test_sphere_above_its_pull_off_has_no_contact():
    assert estimate(rc.RoughSphere(100.0), 0.01).radius(-5.0, None) == 0.0


def test_contact_is_as_large_as_estimated_and_its_window_chosen_at_once():
    indenter = sphere(1500.0)
    atoms, record = first_step(indenter, 0.05, loads=[1e-3])
    assert record.converged
    acting = np.count_nonzero(atoms.calc.state(atoms).pressure)
    radius = estimate(indenter, 0.05).radius(0.0, 1e-3)
    assert np.sqrt(acting / np.pi) == pytest.approx(radius, rel=0.1)
    assert record.pairs < 1000.0


@pytest.mark.parametrize(
    "path", [{"loads": [1e-3]}, {"penetrations": [0.0]}], ids=["load", "height"]
)
def test_contact_too_large_for_the_memory_is_an_error_before_the_calculation(
    path, monkeypatch
):
    monkeypatch.setattr(
        "ase_roughcontact.windows.memory.available_memory", lambda: 16e9
    )
    message = r"adhesion, 0.05, .*radius of about \d{4} .* GB .* smaller load, sphere"
    with pytest.raises(MemoryError, match=message):
        first_step(sphere(1e6), 0.05, **path)


@pytest.mark.parametrize("spacing", [1.0, 2.5])
def test_the_radius_of_a_refused_contact_is_stated_in_spacings(spacing, monkeypatch):
    monkeypatch.setattr("ase_roughcontact.windows.memory.available_memory", lambda: 0.0)
    indenter = rc.RoughSphere(1e4 * spacing)
    atoms = atoms_under(
        indenter,
        rc.LennardJones93.adhesive(1.0, spacing, 0.05 * spacing),
        spacing=spacing,
    )
    with pytest.raises(MemoryError) as refused:
        next(rc.load_path(atoms, penetrations=[0.0], window="auto"))
    radius = int(re.search(r"radius of about (\d+) spacings", str(refused.value))[1])
    jkr = (2.0 * np.pi * 0.05 * 1e8) ** (1.0 / 3.0)  # at a penetration of zero
    assert radius == pytest.approx(jkr, abs=1.0)
