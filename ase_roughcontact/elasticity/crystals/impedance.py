r"""Compliance of the surface of an anisotropic half space, for plane waves.

The surface impedance of an anisotropic half space gives the compliance of a plane wave
of pressure that runs in the direction :math:`\theta`,

.. math:: G(q) = \frac{[L^{-1}(\theta)]_{zz}}{|q|} = \frac{2}{E^*(\theta) |q|}, \qquad
          L = \frac{1}{\pi} \int_0^\pi \left(Q - R T^{-1} R^T\right) d\omega,

where :math:`Q_{ik} = m_j C_{ijkl} m_l`, :math:`R_{ik} = m_j C_{ijkl} n_l` and
:math:`T_{ik} = n_j C_{ijkl} n_l`, and :math:`m` and :math:`n` are the wave's direction
and the surface normal, both turned by :math:`\omega` in their plane. The displacement
by a point force F in the direction :math:`\phi` is
:math:`F/[\pi r E^*(\phi + \pi/2)]`. In the same way, the lateral components of
:math:`L^{-1}` give the response to lateral tractions. Lateral displacements by pressure
are imaginary: the compliance is :math:`L^{-1} + i S L^{-1}`, with
:math:`S = -\frac{1}{\pi} \int_0^\pi T^{-1} R^T d\omega`.
"""

from __future__ import annotations

from functools import partial

import numpy as np

# Index in Voigt's notation of each pair of coordinates.
_VOIGT = np.array([[0, 5, 4], [5, 1, 3], [4, 3, 2]])
# Number of rotation angles in the sum for the integral of the surface impedance. The
# integrand is periodic, so that the sum converges exponentially.
_ROTATIONS = 256


def elastic_tensor(stiffness: np.ndarray) -> np.ndarray:
    """Return elastic constants in Voigt's notation as a tensor (3, 3, 3, 3)."""
    tensor = np.asarray(stiffness, dtype=float)
    if tensor.ndim == 2:
        tensor = tensor[_VOIGT[:, :, None, None], _VOIGT]
    return tensor


def surface_compliance(stiffness: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return the compliance of plane waves on an anisotropic half space, times ``|q|``.

    Parameters
    ----------
    stiffness : ndarray, shape (6, 6) or (3, 3, 3, 3)
        Elastic constants in Voigt's notation, or for a solid under stress the moduli
        ``A_iJkL`` of the nominal stress (pressure). The surface normal is z.
    angles : ndarray, shape (n,)
        Angles between the wave vectors and the x axis (rad).

    Returns
    -------
    ndarray of complex, shape (n, 3, 3)
        Compliances (1/pressure). Displacements along z by lateral tractions, and
        lateral displacements by pressure, are imaginary.

    References
    ----------
    D. M. Barnett, J. Lothe, Phys. Norv. 7, 13 (1973); T. C. T. Ting, Anisotropic
    Elasticity (1996), Ch. 7; J. J. Vlassak, W. D. Nix, J. Mech. Phys. Solids 42, 1223
    (1994).
    """
    tensor = elastic_tensor(stiffness)
    rotation = np.pi * np.arange(_ROTATIONS) / _ROTATIONS
    wave = np.stack([np.cos(angles), np.sin(angles), np.zeros_like(angles)], -1)
    normal = np.array([0.0, 0.0, 1.0])
    cosine, sine = np.cos(rotation)[:, None, None], np.sin(rotation)[:, None, None]
    m, n = cosine * wave + sine * normal, cosine * normal - sine * wave
    contracted = partial(np.einsum, "abj,ijkl,abl->abik", optimize=True)
    q = contracted(m, tensor, m)
    r = contracted(m, tensor, n)
    t = contracted(n, tensor, n)
    coupled = np.linalg.solve(t, r.swapaxes(-1, -2))
    compliance = np.linalg.inv((q - r @ coupled).mean(axis=0))
    return compliance - 1j * coupled.mean(axis=0) @ compliance


def surface_modulus(stiffness: np.ndarray, angles: np.ndarray) -> np.ndarray:
    """Return the modulus of plane waves of pressure on an anisotropic half space.

    See `surface_compliance` for the parameters.

    Returns
    -------
    ndarray, shape (n,)
        Moduli ``E*(theta)`` (pressure); the compliance is ``2/(E* |q|)``.
    """
    return 2.0 / surface_compliance(stiffness, angles)[:, 2, 2].real
