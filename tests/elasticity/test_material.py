"""Contact moduli from elastic constants."""

import numpy as np
import pytest

from ase_roughcontact.elasticity.material import (
    CRYSTALS,
    contact_modulus,
    crystal_modulus,
)


def isotropic(young, poisson):
    lame = young * poisson / ((1 + poisson) * (1 - 2 * poisson))
    shear = young / (2 * (1 + poisson))
    return lame + 2 * shear, lame, shear


@pytest.mark.parametrize("poisson", [0.0, 0.25, 0.34, 0.49])
def test_an_isotropic_solid_has_e_over_one_minus_nu_squared(poisson):
    modulus = contact_modulus(isotropic(130.0, poisson))
    assert modulus == pytest.approx(130.0 / (1 - poisson**2), rel=1e-12)


def test_the_average_lies_between_the_bounds_of_voigt_and_reuss():
    c11, c12, c44 = CRYSTALS["Cu"]
    bulk = (c11 + 2 * c12) / 3
    voigt = (c11 - c12 + 3 * c44) / 5
    reuss = 5 * (c11 - c12) * c44 / (4 * c44 + 3 * (c11 - c12))

    def modulus(shear):
        young = 9 * bulk * shear / (3 * bulk + shear)
        return young / (1 - (young / (2 * shear) - 1) ** 2)

    hill = modulus((voigt + reuss) / 2)
    assert modulus(reuss) < hill < modulus(voigt)
    assert crystal_modulus("Cu") == pytest.approx(hill, rel=1e-12)


def test_polycrystalline_copper_agrees_with_the_handbook():
    # E = 129.8 GPa, nu = 0.343: Kaye and Laby, Tables of Physical Constants
    assert crystal_modulus("Cu") == pytest.approx(129.8 / (1 - 0.343**2), rel=0.02)


def test_three_constants_and_the_full_matrix_agree():
    c11, c12, c44 = CRYSTALS["Si"]
    matrix = np.diag([c11 - c12] * 3 + [c44] * 3)
    matrix[:3, :3] += c12
    assert contact_modulus(matrix) == pytest.approx(crystal_modulus("Si"), rel=1e-14)


@pytest.mark.parametrize(
    "constants, message",
    [
        ((1.0, 2.0), r"shape \(2,\)"),
        ((100.0, 150.0, 50.0), "stable"),
        ((np.nan, 1.0, 1.0), "finite"),
        ("stiff", "elastic_constants"),
    ],
)
def test_constants_of_no_crystal_are_refused(constants, message):
    with pytest.raises(ValueError, match=message):
        contact_modulus(constants)


def test_a_crystal_that_is_not_in_the_table_is_refused_by_name():
    with pytest.raises(ValueError, match=r"'Cn' .* Ag, Al"):
        crystal_modulus("Cn")
