"""Contact area over all loads, the energy of flattening, and the flat reference."""

import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact import SelfAffine, theory

ROOT = Path(__file__).resolve().parents[2]
E, SLOPE, HURST, SHORT, LONG = 1.0, 0.1, 0.8, 4.0, 512.0
R = 1e5
HERTZ = theory.Hertz(R, E)
ROUGH = SelfAffine(SLOPE, HURST, SHORT, LONG)


def hard(load, **options):
    rough = theory.mean_contact_pressure(SLOPE, E)
    return theory.predicted_area(load, R, E, rough, **options)


def test_area_at_small_load_is_of_a_sphere_as_sharp_as_the_first_asperity():
    rho = theory.asperity_radius(ROUGH)
    loads = theory.crossover_load(rho, E, SLOPE) * np.array([1e-9, 1e-3, 0.5])
    first = theory.Hertz(rho, E).contact_area(loads)
    assert_allclose(hard(loads, asperity_radius=rho), first, rtol=1e-12)


def test_area_between_asperity_and_sphere_is_load_over_rough_pressure():
    rho = theory.asperity_radius(ROUGH)
    ends = theory.crossover_load(np.array([rho, R]), E, SLOPE)
    middle = np.sqrt(ends.prod())
    area = hard(middle, asperity_radius=rho)
    assert_allclose(area, middle / (SLOPE * E / 2), rtol=1e-2)


def test_area_at_large_load_agrees_with_hertz():
    load = 1e3 * theory.crossover_load(R, E, SLOPE)
    area = hard(load, asperity_radius=20.0)
    assert_allclose(area, HERTZ.contact_area(load), rtol=1e-12)


def test_area_never_falls_with_the_load():
    loads = np.geomspace(1e-6, 1e12, 2000)
    assert np.all(np.diff(hard(loads, asperity_radius=22.0)) > 0)


def test_first_asperity_blunter_than_the_sphere_gives_hertz():
    area = hard(3.0, asperity_radius=5 * R)
    assert_allclose(area, HERTZ.contact_area(3.0), rtol=1e-12)


def test_adhesive_first_asperity_has_its_area_at_any_small_load():
    loads = np.array([0.0, 1e-9, 1e-3])
    assert_allclose(hard(loads, asperity_area=7.0), 7.0)


def test_area_from_the_error_function_agrees_with_the_formula():
    rough = float(theory.mean_contact_pressure(SLOPE, E))
    loads = theory.crossover_load(R, E, SLOPE) * np.geomspace(1e-3, 1e3, 13)
    area = theory.predicted_area(
        loads, R, E, lambda pressure: theory.contact_fraction(pressure, rough)
    )
    assert_allclose(area, hard(loads), rtol=1e-12)


def test_energy_of_flattening_counts_the_waves_of_the_roll_off():
    rough = SelfAffine(SLOPE, HURST, 4.0, 64.0, longest_wavelength=512.0)
    heights = rough.heights((1024, 1024), 2.0)  # one period
    q = 2 * np.pi * np.fft.fftfreq(1024, 2.0)
    waves = np.abs(np.fft.fft2(heights) / heights.size) ** 2
    energy = E / 4 * (np.hypot(q[:, None], q) * waves).sum()
    closed = theory.flattening_energy(E, rough)
    assert_allclose(closed, energy, rtol=1e-3)
    without = theory.flattening_energy(E, replace(rough, longest_wavelength=None))
    assert_allclose(closed / without, 1.19, rtol=0.01)


def test_energy_of_flattening_is_continuous_at_a_hurst_exponent_of_one_half():
    hursts = 0.5 - 1e-9, 0.5, 0.5 + 1e-9
    near = [theory.flattening_energy(E, replace(ROUGH, hurst=h)) for h in hursts]
    assert_allclose(near, near[1], rtol=1e-7)
    # H = 1/2: (E*/4) h'^2 ln(qs/qL)/(qs - qL)
    high, low = 2 * np.pi / SHORT, 2 * np.pi / LONG
    assert_allclose(near[1], SLOPE**2 / 4 * np.log(high / low) / (high - low))


@pytest.fixture
def flat_reference(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "paper"))
    import flat_reference

    yield flat_reference
    del sys.modules["flat_reference"]


@pytest.fixture
def curves(flat_reference):
    return {w: flat_reference.flat_fraction(w) for w in (0.0, 0.0005, 0.005)}


def test_flat_reference_without_adhesion_has_the_kappa_of_the_paper(curves):
    pressure = np.array([5e-4, 1e-3, 2e-3, 4e-3])
    kappa = curves[0.0](pressure) * SLOPE / pressure
    assert_allclose(kappa, theory.KAPPA_REPULSIVE, rtol=0.15)


def test_flat_reference_with_weak_adhesion_follows_the_renormalised_kappa(curves):
    # Before f bends: 1/kappa_adh = 1/2.9 - 0.04 by the paper.
    pressure = np.array([1e-3, 2e-3, 4e-3])
    kappa = curves[0.0005](pressure) * SLOPE / pressure
    assert_allclose(kappa, 1 / (1 / 2.9 - 0.04), rtol=0.15)


def test_script_makes_a_table_that_is_read(tmp_path, flat_reference):
    file = tmp_path / "flat.csv"
    numbers = {"work": 0.001, "size": 32, "long": 32, "seeds": 4, "points": 4}
    options = [word for key, value in numbers.items() for word in (f"--{key}", value)]
    flat_reference.main([*map(str, options), "--out", str(file)])
    assert "flat_reference.py --work 0.001 --size 32" in file.read_text()
    light, full, beyond = flat_reference.flat_fraction(0.001, file)([0.0, 0.3, 1.0])
    assert light < 0.1 and full == beyond == pytest.approx(1.0)
