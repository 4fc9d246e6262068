"""Positions that are rounded, as in text files, or displaced by finite differences."""

import numpy as np
import pytest
from ase.calculators.fd import calculate_numerical_forces

import ase_roughcontact as rc
from ase_roughcontact.atoms.grid import SurfaceGrid

A0 = 2.5526554800834365
SPHERE = rc.RoughSphere(
    40.0 * A0, rc.SelfAffine(0.1, 0.8, 4.0 * A0, 16.0 * A0, domain=128.0 * A0, seed=1)
)


def make_atoms(shape=(20, 17), periodic=False, padding=True, offset=0.0):
    atoms = rc.substrate("Cu", shape, SPHERE, spacing=A0, periodic=periodic, height=0.0)
    if not padding:
        in_window = np.append(SurfaceGrid.of(atoms).in_window, True)
        atoms = atoms[in_window]
    atoms.positions[:, :2] += offset
    return atoms


def energy_and_forces(atoms):
    atoms.calc = rc.RoughContact(SPHERE, 1.0)
    assert rc.NewtonKrylov(atoms).run(fmax=1e-6)
    return atoms.get_potential_energy(), atoms.calc.state(atoms).normal_force


@pytest.mark.parametrize("decimals", [8, 6, 5])
@pytest.mark.parametrize("offset", [0.0, 1.23456789], ids=["origin", "elsewhere"])
@pytest.mark.parametrize("padding", [True, False], ids=["padded", "window"])
def test_rounded_positions_give_the_same_results(decimals, offset, padding, periodic):
    atoms = make_atoms(periodic=periodic, padding=padding, offset=offset)
    expected = energy_and_forces(atoms.copy())
    atoms.positions = atoms.positions.round(decimals)
    found = energy_and_forces(atoms)
    np.testing.assert_allclose(found, expected, rtol=10 * 10.0**-decimals)


def test_spacing_is_exact_where_the_positions_are_not():
    atoms = make_atoms((300, 8), periodic=True)
    assert SurfaceGrid.of(atoms).spacing == A0
    atoms.positions[:, :2] = atoms.positions[:, :2].round(5)
    assert SurfaceGrid.of(atoms).spacing == pytest.approx(A0, rel=1e-15)


def test_noise_of_a_ten_thousandth_spacing_is_accepted_and_more_is_not(rng):
    exact = make_atoms((30, 30), periodic=True)
    grid = SurfaceGrid.of(exact)
    noise = rng.uniform(-1.0, 1.0, (len(exact) - 1, 2))
    noise *= 0.5e-4 * A0  # two atoms are compared
    atoms = exact.copy()
    atoms.positions[:-1, :2] += noise
    found = SurfaceGrid.of(atoms)
    assert (found.window, found.spacing) == (grid.window, pytest.approx(A0, rel=1e-15))
    atoms.positions[:-1, :2] += 20 * noise
    with pytest.raises(ValueError, match="square grid"):
        SurfaceGrid.of(atoms)


@pytest.mark.parametrize("index", [0, 1, 17, 40])
def test_lateral_finite_differences_of_surface_atoms_are_accepted(index):
    atoms = make_atoms(periodic=True)
    atoms.calc = rc.RoughContact(SPHERE, 1.0)
    rc.NewtonKrylov(atoms).run(fmax=1e-3)
    (numerical,) = calculate_numerical_forces(atoms, eps=1e-5, iatoms=[index])
    assert numerical[2] == pytest.approx(atoms.get_forces()[index, 2], abs=1e-5)
    if index:  # the position of the first atom is the origin of the grid
        assert not numerical[:2].any()
