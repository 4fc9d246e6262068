"""Exchange of a window in place."""

import numpy as np
import pytest
from built import atoms_under

from ase_roughcontact import NewtonKrylov, RoughContact, RoughSphere
from ase_roughcontact.atoms.calculator import elastic_pressure, grid_of
from ase_roughcontact.atoms.exchange import exchange_window, window_of
from ase_roughcontact.elasticity.lattice import Box

SPHERE = RoughSphere(60.0)
OLD = Box((-6, -6), (12, 12))
NEW = [Box((-9, -7), (20, 17)), Box((-3, -2), (7, 5)), Box((-8, 1), (10, 9))]


@pytest.fixture
def atoms():
    atoms = atoms_under(SPHERE, shape=OLD.shape, height=-0.2)
    assert NewtonKrylov(atoms).run(fmax=1e-6)
    return atoms


def sites(atoms):
    """Lattice indices of the atoms in the window, with their indices."""
    grid, box = grid_of(atoms), window_of(grid_of(atoms))
    i, j = np.indices(box.shape).reshape(2, -1)
    keys = zip(i + box.start[0], j + box.start[1], strict=True)
    return dict(zip(keys, np.flatnonzero(grid.in_window), strict=True))


@pytest.mark.parametrize("new", NEW, ids=["larger", "smaller", "beside"])
def test_arrays_of_atoms_in_both_windows_are_kept(atoms, new, rng):
    count = len(atoms)
    atoms.set_tags(rng.integers(1, 100, count))
    atoms.set_masses(rng.uniform(10.0, 20.0, count))
    atoms.set_array("vectors", rng.normal(size=(count, 2)))
    atoms.set_array("marked", np.ones(count, bool))
    atoms.numbers[sites(atoms)[0, 2]] = 47
    before, old = {k: v.copy() for k, v in atoms.arrays.items()}, sites(atoms)
    exchange_window(atoms, new)
    now = sites(atoms)
    assert len(atoms) == new.size + 1 == len(now) + 1
    assert now.keys() & old.keys()
    for name in ("tags", "masses", "vectors", "marked", "numbers"):
        values = atoms.arrays[name]
        assert values.dtype == before[name].dtype
        np.testing.assert_array_equal(values[-1], before[name][-1])
        for site, index in now.items():
            if site in old:
                np.testing.assert_array_equal(values[index], before[name][old[site]])
    added = [index for site, index in now.items() if site not in old]
    assert not atoms.get_tags()[added].any() and not atoms.arrays["marked"][added].any()
    assert (atoms.numbers[added] == 29).all()
    assert np.allclose(atoms.get_masses()[added], 63.546)


def test_info_and_calculator_are_kept(atoms):
    atoms.info["mark"] = "mine"
    info, calc = dict(atoms.info), atoms.calc
    exchange_window(atoms, NEW[0])
    assert atoms.info == info and atoms.calc is calc


def test_pressure_of_atoms_in_both_windows_is_kept(atoms):
    before = elastic_pressure(atoms)
    exchange_window(atoms, NEW[0])
    after = elastic_pressure(atoms)
    common = OLD.slices_in(NEW[0])
    np.testing.assert_array_equal(after[common], np.where(before > 1e-6, before, 0.0))
    assert np.count_nonzero(after) == np.count_nonzero(after[common]) > 0
    # the pressure that the calculator keeps is that of the displacement
    twin = atoms.copy()
    twin.calc = RoughContact(**atoms.calc.parameters)
    np.testing.assert_allclose(elastic_pressure(twin), after, atol=1e-10)


def test_window_of_a_periodic_half_space_can_not_be_exchanged():
    atoms = atoms_under(SPHERE, periodic=True)
    with pytest.raises(ValueError, match="periodic half space is its cell"):
        exchange_window(atoms, NEW[0])
