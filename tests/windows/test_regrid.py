"""Finer and coarser grids under the same indenter."""

import numpy as np
import pytest
from ase.constraints import FixAtoms
from built import atoms_under

import ase_roughcontact as rc
from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.atoms.exchange import regrid
from ase_roughcontact.atoms.grid import SurfaceGrid
from ase_roughcontact.windows.regrid import GridChange, lost_slope

ROUGH = rc.SelfAffine(0.1, 0.8, 4.0, 16.0, seed=1, domain=64.0)
SPHERE = rc.RoughSphere(100.0, ROUGH)


def make_atoms(surface=SPHERE, shape=(12, 16), **options):
    return atoms_under(surface, shape=shape, **options)


@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("refine, coarsen", [(2, 1), (3, 1), (1, 2)])
def test_grid_changes_and_nothing_else(periodic, refine, coarsen):
    atoms = make_atoms(periodic=periodic)
    atoms.calc.set(load=0.5)
    before, grid = contact_of(atoms), SurfaceGrid.of(atoms)
    axis, cell = atoms.positions[-1].copy(), atoms.cell.copy()
    assert regrid(atoms, GridChange(refine, coarsen)) == 0.0
    after, new = contact_of(atoms), SurfaceGrid.of(atoms)
    assert new.spacing == coarsen / refine
    assert new.window == (12 * refine // coarsen, 16 * refine // coarsen)
    assert new.origin == grid.origin and new.periodic == grid.periodic
    np.testing.assert_array_equal(atoms.positions[-1], axis)
    np.testing.assert_array_equal(atoms.cell, cell)
    assert after.wall == before.wall == rc.LennardJones93.repulsive(1.0, 1.0)
    assert atoms.calc.parameters["load"] == 0.5
    (constraint,) = atoms.constraints
    assert isinstance(constraint, FixAtoms)
    assert list(constraint.index) == [len(atoms) - 1]
    coarse, fine = before.heights, after.heights
    if refine == 1:
        coarse, fine = fine, coarse
    step = max(refine, coarsen)
    np.testing.assert_allclose(fine[::step, ::step], coarse, atol=1e-12)


def test_grid_that_is_not_relative_to_the_atoms_is_an_error():
    with pytest.raises(ValueError, match=r"'a0/2' .* got '0\.5 a0'"):
        rc.load_path(make_atoms(), penetrations=[0.1], grid="0.5 a0")


def test_smoother_indenter_of_a_coarse_grid_has_the_same_long_waves():
    smooth = ROUGH.band_limited(8.0)
    assert (smooth.short_wavelength, smooth.side) == (8.0, ROUGH.side)
    heights, smoother = (np.fft.fft2(s.heights((64, 64), 1.0)) for s in (ROUGH, smooth))
    k = 64 * np.fft.fftfreq(64)
    kept = np.hypot(*np.meshgrid(k, k)) <= 8.0 + 1e-9
    np.testing.assert_allclose(smoother[kept], heights[kept], atol=1e-9)
    np.testing.assert_allclose(smoother[~kept], 0.0, atol=1e-9)
    assert ROUGH.band_limited(4.0) is ROUGH


def test_mean_power_of_an_ensemble_is_kept_by_smoothing():
    rough = rc.SelfAffine(
        *(0.1, 0.8, 4.0, 16.0),
        **{"random_amplitudes": True, "normalise": "ensemble", "domain": 64.0},
    )
    smooth = rough.band_limited(8.0)
    waves, kept = (
        np.fft.fft2(s.heights((64, 64), 1.0))[0, :9] for s in (rough, smooth)
    )
    np.testing.assert_allclose(kept, waves, atol=1e-9)


def test_lost_slope_agrees_with_the_waves_left_out():
    atoms = make_atoms()
    lost = regrid(atoms, GridChange(coarsen=4))
    smooth = atoms.calc.parameters["indenter"]
    assert smooth.roughness == ROUGH.band_limited(8.0)
    assert lost == lost_slope(SPHERE, smooth) == pytest.approx(0.335, abs=0.001)
    atoms.get_forces()  # the atoms know that they have another indenter


def test_path_on_another_grid_agrees_with_atoms_on_this_grid(recwarn):
    wall = rc.LennardJones93.repulsive(1.0, 1.0)
    built = atoms_under(SPHERE, wall, (48, 64), spacing=0.5)
    (expected,) = rc.load_path(built, heights=[1.0], fmax=1e-10)
    (step,) = rc.load_path(
        make_atoms(shape=(24, 32)), heights=[1.0], grid="a0/2", fmax=1e-10
    )
    assert not recwarn.list
    assert step.normal_force == pytest.approx(expected.normal_force, rel=1e-9)
    assert step.contact_area == expected.contact_area > 0.0


@pytest.mark.parametrize("shape", [(12, 12), (16, 14)])
def test_automatic_windows_fit_a_coarse_grid_from_any_first_window(shape):
    sphere = rc.RoughSphere(100.0)
    atoms = atoms_under(sphere, rc.HardWall(), shape)
    (step,) = rc.load_path(atoms, penetrations=[2.0], window="auto", grid="3 a0")
    theory = rc.theory.Hertz(100.0, 1.0)
    assert step.normal_force == pytest.approx(theory.force(np.sqrt(200.0)), rel=0.01)


def test_loss_is_a_warning_of_a_path():
    with pytest.warns(UserWarning, match=r"4 times .* 34 %"):
        rc.load_path(make_atoms(), heights=[1.0], grid="4 a0").close()


def test_hardness_of_the_crystal_is_known_on_a_finer_grid():
    sphere = rc.RoughSphere(20.0)
    atoms = rc.substrate("Cu", (16, 16), sphere)
    atoms.calc = rc.RoughContact(sphere, 1.0)
    (step,) = rc.load_path(atoms, penetrations=[0.5], grid="a0/2", validity="ignore")
    assert "hardness" in step.validity


@pytest.mark.parametrize(
    "surface, grid, message",
    [
        (SPHERE, "a0/0", "refine must be an integer >= 1, got 0"),
        (SPHERE, "2 a0/2", "got 2 and 2"),
        (SPHERE, "5 a0", r"must divide .*\(12, 16\)"),
        (
            rc.RoughSphere(50.0, rc.HeightMap(np.zeros((32, 32)), 1.0)),
            "2 a0",
            "method band_limited",
        ),
    ],
)
def test_impossible_grids_are_rejected(surface, grid, message):
    with pytest.raises(ValueError, match=message):
        rc.load_path(make_atoms(surface), heights=[1.0], grid=grid)
