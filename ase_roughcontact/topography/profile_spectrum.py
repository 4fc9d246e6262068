r"""From the power spectrum of line profiles to the spectrum of an isotropic surface.

With :math:`\langle h^2 \rangle = \pi^{-1} \int_0^\infty C^\text{1D} dq` and
:math:`\langle h^2 \rangle = (2\pi)^{-1} \int_0^\infty q\, C^\text{2D} dq`,

.. math:: C^\text{1D}(q_x) = \frac{1}{\pi} \int_{q_x}^\infty
          \frac{q\, C^\text{2D}(q)}{(q^2 - q_x^2)^{1/2}} dq .

References
----------
T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001 (2017).
"""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import nnls

from ase_roughcontact._util.validation import FloatArray

# Nodes for each decade of the wave number, at most as many as there are rows.
_NODES_PER_DECADE = 15
# Points of the quadrature along q.
_QUADRATURE_POINTS = 400
# Ratio up to which the spectrum goes on beyond the table, as a power of q.
_EXTENSION = 100.0
# Least ratio of the wave numbers from which this power follows.
_MIN_END_RATIO = 2.0
# Largest power of q with which a spectrum of profiles goes on.
_MAX_END_POWER = -1.1
# Least ratio of both spectra, which a logarithm needs where noise allows for none.
_MIN_FACTOR = 1e-3
# Weight of the curvature of the ratio of both spectra, relative to the residual.
_SMOOTHNESS = 0.02


def isotropic_density(q: FloatArray, profile_density: FloatArray) -> FloatArray:
    r"""Return the spectrum of an isotropic surface with a spectrum of its profiles.

    It is :math:`C^\text{2D} = c\, C^\text{1D}/q`. The factor c, at least 0.001 and
    constant for a power law, is piecewise linear over log q; it is fitted to the
    relative deviation of the spectrum of profiles. Beyond the table both spectra go on
    as powers of q: a profile is also made of waves that are longer along it than on the
    surface.

    Parameters
    ----------
    q, profile_density : ndarray, shape (k,)
        Increasing wave numbers (inverse length), and positive densities C1D (length to
        the third power).

    Returns
    -------
    ndarray, shape (k,)
        C2D (length to the fourth power).
    """
    log_q, log_density = np.log(q), np.log(profile_density)
    at_end = log_q >= min(log_q[-1] - math.log(_MIN_END_RATIO), log_q[-2])
    power = np.polyfit(log_q[at_end], log_density[at_end], 1)[0]
    power = min(float(power), _MAX_END_POWER)

    def extended(x: FloatArray) -> FloatArray:
        """Return C1D/q at ln q = x."""
        beyond = power * np.maximum(x - log_q[-1], 0.0)
        return np.exp(np.interp(x, log_q, log_density) + beyond - x)

    decades = (log_q[-1] - log_q[0]) / math.log(10.0)
    count = max(2, min(len(q), math.ceil(_NODES_PER_DECADE * decades)))
    nodes = np.linspace(log_q[0], log_q[-1], count)
    matrix = np.empty((len(q), count))
    for row, value in enumerate(q):
        # q = q_x cosh v removes the square root
        end = math.acosh(_EXTENSION * q[-1] / value)
        width = end / _QUADRATURE_POINTS
        v = width * (np.arange(_QUADRATURE_POINTS) + 0.5)
        x = math.log(value) + np.log(np.cosh(v))
        weights = width * value * np.cosh(v) * extended(x) / math.pi
        position = np.interp(x, nodes, np.arange(count))
        below = np.minimum(position.astype(int), count - 2)
        share = position - below
        matrix[row] = np.bincount(below, weights * (1.0 - share), count)
        matrix[row] += np.bincount(below + 1, weights * share, count)
    matrix /= profile_density[:, None]
    bend = _SMOOTHNESS * np.diff(np.eye(count), 2, axis=0)
    wanted = np.append(np.ones(len(q)), np.zeros(len(bend)))
    equations = np.vstack([matrix, bend])
    above, _ = nnls(equations, wanted - _MIN_FACTOR * equations.sum(axis=1))
    return np.interp(log_q, nodes, _MIN_FACTOR + above) * profile_density / q
