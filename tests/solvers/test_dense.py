"""Dense matrices: positive definite systems, with the same bits on any threads."""

import os
import sys
from subprocess import check_output

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact.elasticity import FreeHalfSpace
from ase_roughcontact.solvers.dense import pressures

BITS = """
import numpy as np
from ase_roughcontact.elasticity import FreeHalfSpace
from ase_roughcontact.solvers.dense import pressures
atoms = np.arange(63) * 3
right = np.random.default_rng(1).random((63, 2))
solution = pressures(FreeHalfSpace((16, 16), 1.0, 1.0), atoms, 0.0 * atoms, right)
print(hash(np.ascontiguousarray(solution).tobytes()))
"""


@pytest.mark.parametrize("size", [1, 2, 63])
def test_pressures_on_some_atoms_and_springs_displace_them_as_asked(rng, size):
    halfspace = FreeHalfSpace((9, 11), 1.5, 2.0)
    atoms = rng.permutation(99)[:size]
    softness, right = rng.random(size), rng.standard_normal((size, 2))
    found = pressures(halfspace, atoms, softness, right)
    for q, expected in zip(found.T, right.T, strict=True):
        pressure = np.zeros(99)
        pressure[atoms] = q
        depth = -halfspace.displacement(pressure.reshape(9, 11)).ravel()[atoms]
        assert_allclose(depth + softness * q, expected, atol=1e-12)


def test_the_threads_of_blas_do_not_change_a_bit():
    bits = {
        check_output(
            (sys.executable, "-c", BITS),
            env=os.environ | {"OPENBLAS_NUM_THREADS": count, "PYTHONHASHSEED": "0"},
        )
        for count in ("1", "2")
    }
    assert len(bits) == 1
