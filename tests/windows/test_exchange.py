"""Exchange of a window in place."""

import numpy as np
import pytest
from built import atoms_under

from ase_roughcontact import NewtonKrylov, RoughContact, RoughSphere
from ase_roughcontact.atoms.calculator import model_of
from ase_roughcontact.atoms.exchange import set_window
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.loading.path_atoms import PathAtoms

SPHERE = RoughSphere(60.0)
OLD = Box((-6, -6), (12, 12))
NEW = Box((-9, -7), (20, 17))


@pytest.fixture
def atoms():
    atoms = atoms_under(SPHERE, shape=OLD.shape, height=-0.2)
    assert NewtonKrylov(atoms).run(fmax=1e-6)
    return atoms


def test_info_and_calculator_are_kept(atoms):
    atoms.info["mark"] = "mine"
    info, calc = dict(atoms.info), atoms.calc
    set_window(atoms, NEW)
    assert atoms.info == info and atoms.calc is calc


def test_pressure_of_atoms_in_both_windows_is_kept(atoms):
    before, path_atoms = model_of(atoms).elastic_pressure(atoms), PathAtoms(atoms)
    state = path_atoms.first_state().on(NEW)
    path_atoms.place(path_atoms.problem.contact(NEW), state)
    after = model_of(atoms).elastic_pressure(atoms)
    common = OLD.slices_in(NEW)
    np.testing.assert_array_equal(after[common], np.where(before > 1e-6, before, 0.0))
    assert np.count_nonzero(after) == np.count_nonzero(after[common]) > 0
    # the pressure that the calculator keeps belongs to the displacement
    twin = atoms.copy()
    twin.calc = RoughContact(**atoms.calc.parameters)
    np.testing.assert_allclose(model_of(twin).elastic_pressure(twin), after, atol=1e-10)


def test_window_of_a_periodic_half_space_can_not_be_exchanged():
    atoms = atoms_under(SPHERE, periodic=True)
    with pytest.raises(ValueError, match="periodic"):
        set_window(atoms, NEW)
