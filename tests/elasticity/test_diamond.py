"""The (100) surface of diamond crystals, with different rows along x and y."""

import numpy as np
import pytest
from ase.build import bulk, diamond100
from ase.optimize import BFGS
from ase.units import GPa
from matscipy.calculators.manybody import Manybody
from matscipy.calculators.manybody.explicit_forms import StillingerWeber
from matscipy.calculators.manybody.explicit_forms.stillinger_weber import (
    Stillinger_Weber_PRB_31_5262_Si,
)
from matscipy.elasticity import fit_elastic_constants
from scipy.sparse.linalg import splu
from spring_crystal import diamond_springs

from ase_roughcontact.elasticity import Crystal, Cubic, PeriodicHalfSpace

A = 5.43


def make(calculator, crystal=None, surface="diamond100", **options):
    options = {"layers": 11, "size": 5, "displacement": 0.0, **options}
    crystal = crystal or bulk("Si", "diamond", a=A)
    return Crystal.from_calculator(calculator, crystal, surface, **options)


def silicon():
    return Manybody(**StillingerWeber(Stillinger_Weber_PRB_31_5262_Si))


@pytest.fixture(scope="module")
def diamond():
    return make(diamond_springs(A)[0])


def test_long_waves_agree_with_moduli_with_displaced_sublattices(diamond):
    continuum = Cubic(*diamond_springs(A)[1])
    assert diamond.contact_modulus == pytest.approx(continuum.contact_modulus, rel=1e-5)
    q = 1e-6 * np.array([[1.0, 0.8, 0.5, 0.0], [0.0, 0.3, 0.5, 1.0]])
    expected = continuum.wave_compliance(*q)
    np.testing.assert_allclose(diamond.wave_compliance(*q), expected, rtol=1e-5)


def response_of_a_slab(calculator, a, size, layers=41):
    """Displacement of the surface by a force on one atom, from the whole slab."""
    slab = diamond100("Si", (1, 1, layers), a=a, vacuum=10.0)
    slab.calc = calculator
    BFGS(slab, logfile=None).run(fmax=1e-8)
    slab = slab[::-1].repeat((*size, 1))
    slab.calc = calculator
    slab.get_forces()
    hessian = calculator.get_hessian(slab, format="sparse").tocsc()
    top = 3 * layers * np.arange(size[0] * size[1]) + 2
    force = np.zeros(hessian.shape[0])
    force[top] = -1.0 / top.size
    force[top[0]] += 1.0  # balanced
    moved = np.zeros_like(force)  # the last atom is held
    moved[:-3] = splu(hessian[:-3, :-3]).solve(force[:-3])
    return (moved[top] - moved[top].mean()).reshape(size)


def response_of_the_crystal(crystal, size):
    half = PeriodicHalfSpace(size, crystal.spacing, crystal)
    pressure = np.zeros(size)
    pressure[0, 0] = -1.0 / crystal.spacing**2
    return half.displacement(pressure)


def test_a_point_force_displaces_the_surface_of_a_thick_slab(diamond):
    expected = response_of_a_slab(diamond_springs(A)[0], A, (5, 4))
    found = response_of_the_crystal(diamond, (5, 4))
    # the neighbour along the bonds of the surface atoms, and the one across
    assert abs(expected[1, 0] - expected[0, 1]) > 0.02 * expected[0, 0]
    np.testing.assert_allclose(found, expected, atol=1e-6 * expected[0, 0])


@pytest.mark.parametrize(
    "options, message",
    [
        ({"surface": "fcc100"}, "surface='diamond100'"),
        ({"crystal": "Si", "surface": "fcc100"}, "surface='diamond100'"),
        ({"crystal": bulk("Cu", a=3.6)}, "surface='fcc100'"),
        ({"crystal": bulk("GaAs", "zincblende", a=A)}, "one element"),
        ({"crystal": "Ti"}, "Cubic"),
    ],
)
def test_crystals_of_another_structure(options, message):
    with pytest.raises(ValueError, match=message):
        make(diamond_springs(A)[0], **options)


@pytest.mark.slow
def test_silicon_of_stillinger_and_weber():
    crystal = make(silicon())
    a = crystal.spacing * np.sqrt(2)
    assert a == pytest.approx(5.431, abs=1e-3)
    assert max(crystal.figures.values()) < 1e-5
    atoms = bulk("Si", cubic=True, a=a)
    atoms.calc = silicon()
    fitted, _ = fit_elastic_constants(
        atoms, symmetry="cubic", delta=1e-4, optimizer=BFGS, fmax=1e-7, verbose=False
    )
    moduli = fitted[0, 0], fitted[0, 1], fitted[3, 3]
    # E. R. Cowley, Phys. Rev. Lett. 60, 2379 (1988)
    np.testing.assert_allclose(np.divide(moduli, GPa), (151.4, 76.4, 56.4), rtol=2e-3)
    expected = Cubic(*moduli).contact_modulus
    assert crystal.contact_modulus == pytest.approx(expected, rel=1e-4)
    expected = response_of_a_slab(silicon(), a, (4, 3))
    found = response_of_the_crystal(crystal, (4, 3))
    np.testing.assert_allclose(found, expected, atol=1e-5 * expected[0, 0])
