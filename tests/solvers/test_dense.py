"""Dense matrices: positive definite systems, with the same bits on any threads."""

import os
import sys
from subprocess import check_output

import numpy as np
import pytest
from numpy.testing import assert_allclose

from ase_roughcontact.solvers.dense import solve_positive

BITS = """
import numpy as np
from ase_roughcontact.solvers.dense import solve_positive
rng = np.random.default_rng(1)
for size in (3, 63, 64, 88, 90, 97, 180, 300):
    a = rng.standard_normal((size, size))
    matrix = np.einsum('ij,kj', a, a) / size + np.eye(size)
    solution = solve_positive(matrix, rng.random((size, 2)))
    print(hash(np.ascontiguousarray(solution).tobytes()))
"""


@pytest.mark.parametrize("size", [1, 2, 63, 64, 97, 150, 301])
def test_solution_of_a_positive_definite_system(rng, size):
    a = rng.standard_normal((size, size))
    matrix, right = a @ a.T + np.eye(size), rng.standard_normal((size, 2))
    expected = np.linalg.solve(matrix, right)
    assert_allclose(solve_positive(matrix.copy(), right), expected, rtol=1e-7)


@pytest.mark.parametrize(("size", "place"), [(3, 2), (150, 0), (150, 60), (150, 149)])
def test_indefinite_systems_have_no_solution(size, place):
    matrix = np.eye(size)
    matrix[place, place] = -1.0
    assert solve_positive(matrix, np.ones((size, 1))) is None


def test_the_threads_of_blas_do_not_change_a_bit():
    bits = {
        check_output(
            (sys.executable, "-c", BITS),
            env=os.environ | {"OPENBLAS_NUM_THREADS": count, "PYTHONHASHSEED": "0"},
        )
        for count in ("1", "2")
    }
    assert len(bits) == 1
