r"""Generalised conjugate residuals: a Krylov method with a variable preconditioner.

To solve :math:`A x = b` with an approximate inverse :math:`M` of :math:`A`, start from
:math:`r = b` and repeat for :math:`k = 0, 1, \ldots`

1. :math:`v_k = M r, \quad w_k = A v_k`
2. Make :math:`w_k` orthogonal to :math:`w_0, \ldots, w_{k-1}` and normalise it. With
   the coefficients :math:`R_{ik}`, :math:`A V = W R`.
3. :math:`\alpha_k = w_k \cdot r, \quad r \leftarrow r - \alpha_k w_k`

until :math:`|r|` is small enough. The solution is :math:`x = V R^{-1} \alpha`.

References
----------
S. C. Eisenstat, H. C. Elman, M. H. Schultz, SIAM J. Numer. Anal. 20, 345 (1983).
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from scipy.linalg.blas import dtrsv

from ase_roughcontact._util.kernels import (
    dot,
    linear_combination,
    norm,
    subtract_and_dot,
)


def gcr(
    apply: Callable[[np.ndarray], np.ndarray],
    precondition: Callable[[np.ndarray], np.ndarray],
    residual: np.ndarray,
    tolerance: float,
    max_steps: int,
) -> np.ndarray | float:
    """Solve a linear system by generalised conjugate residuals.

    Parameters
    ----------
    apply : callable
        Linear operator ``A``, which returns a new array; this array is overwritten.
    precondition : callable
        Approximate inverse of the operator, which may vary from call to call.
    residual : ndarray
        Right-hand side, which is overwritten by the residual of the solution.
    tolerance : float
        Norm of the residual at which to stop.
    max_steps : int
        Largest number of steps.

    Returns
    -------
    ndarray or float
        Solution; 0.0 if no step was made.
    """
    directions: list[np.ndarray] = []
    images: list[np.ndarray] = []  # orthonormal
    triangle, lengths = np.zeros((max_steps, max_steps)), np.zeros(max_steps)
    residual_norm = norm(residual)
    while residual_norm > tolerance and len(images) < max_steps:
        k = len(images)
        direction = precondition(residual)
        image = apply(direction)
        # each pass subtracts one component and returns the product with the next image
        chain = [*images, image]
        product = dot(image, chain[0])
        for i, earlier in enumerate(images):
            triangle[i, k] = product
            product = subtract_and_dot(image, product, earlier, chain[i + 1])
        size = triangle[k, k] = product**0.5
        if not size > 0.0:
            break
        linear_combination([(1.0 / size, image)], out=image)
        lengths[k] = dot(image, residual)
        square = subtract_and_dot(residual, float(lengths[k]), image, residual)
        residual_norm = square**0.5
        directions.append(direction)
        images.append(image)
    if not images:
        return 0.0
    k = len(images)
    weights = dtrsv(triangle[:k, :k], lengths[:k]).tolist()  # dtrtrs starts threads
    return linear_combination(list(zip(weights, directions, strict=True)))
