"""Other realisations of measured heights: same spectrum and distribution of heights.

Phases of a spectrum are drawn at random, and adjusted until the heights also have the
distribution of the measured ones. In turn, heights are replaced by the measured ones in
the order of their sizes, and amplitudes by the measured ones.

References
----------
T. Schreiber, A. Schmitz, Phys. Rev. Lett. 77, 635 (1996). F. Pérez-Ràfols, A. Almqvist,
Tribol. Int. 131, 591 (2019): rough surfaces.
"""

from __future__ import annotations

import math

import numpy as np
from scipy import fft

from ase_roughcontact._util.validation import FloatArray

# Largest number of adjustments of heights and amplitudes.
_MAX_ADJUSTMENTS = 60
# Rms deviation of heights from their distribution, relative to the rms height, at which
# adjustments end.
_MAX_DEVIATION = 2e-3
# Adjustments also end if one of them reduces the deviation by a smaller part.
_MIN_PROGRESS = 0.01


def realised_heights(heights: FloatArray, seed: int) -> FloatArray:
    """Return random periodic heights with the spectrum of periodic heights.

    Parameters
    ----------
    heights : ndarray, shape (n, m)
        Heights of one period (length).
    seed : int
        Seed of the random numbers, not negative.

    Returns
    -------
    ndarray, shape (n, m)
        Heights with the same amplitude of each wave and the same mean, and a
        distribution as close as the iteration comes, see `distribution_error`.
    """
    amplitude = np.abs(fft.rfft2(heights))
    amplitude[0, 0] = 0.0  # the mean
    noise = np.random.default_rng(seed).standard_normal(heights.shape)
    ordered = np.sort(heights - heights.mean(), axis=None)
    least = _MAX_DEVIATION * float(ordered.std())
    current, deviation = _with_amplitude(noise, amplitude), math.inf
    for _ in range(_MAX_ADJUSTMENTS):
        adjusted = _in_order(current, ordered)
        before, deviation = deviation, float(np.std(adjusted - current))
        if deviation <= least or deviation > (1.0 - _MIN_PROGRESS) * before:
            break
        current = _with_amplitude(adjusted, amplitude)
    return current + heights.mean()


def distribution_error(heights: FloatArray, other: FloatArray) -> float:
    """Return the rms difference of two sorted samples of heights over the rms height.

    It is the distance of their distributions; both have the same number of heights.
    """
    ordered = (np.sort(each - each.mean(), axis=None) for each in (heights, other))
    first, second = ordered
    scale = float(first.std())
    return float(np.std(first - second)) / scale if scale else 0.0


def _with_amplitude(heights: FloatArray, amplitude: FloatArray) -> FloatArray:
    """Return heights with the phases of some heights, and given amplitudes."""
    spectrum = fft.rfft2(heights)
    size = np.abs(spectrum)
    size[size == 0.0] = 1.0
    spectrum *= amplitude / size
    return fft.irfft2(spectrum, s=heights.shape)


def _in_order(heights: FloatArray, ordered: FloatArray) -> FloatArray:
    """Return sorted values in the order of the sizes of heights."""
    found = np.empty(heights.size)
    found[np.argsort(heights, axis=None, kind="stable")] = ordered
    return found.reshape(heights.shape)
