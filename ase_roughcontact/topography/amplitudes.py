"""Self-affine roughness with two of rms height, slope and curvature.

The ratio of two of them follows from the spectrum: a Hurst exponent or a wavelength is
found for which it has the given value.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.optimize import brentq

from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.validation import lookup
from ase_roughcontact.theory.self_affine import (
    angular_mean,
    rms_curvature,
    rms_height,
)
from ase_roughcontact.topography.random_waves import half_plane
from ase_roughcontact.topography.selfaffine import SelfAffine

#: Names of amplitudes, and the moments of the spectrum that are their mean squares.
AMPLITUDES = {"rms_slope": 2, "rms_height": 0, "rms_curvature": 4}
#: Parameters that may follow from two amplitudes.
FREE = "hurst", "short_wavelength", "long_wavelength"
# Least distance of a Hurst exponent from 0 and 1.
_MIN_HURST = 1e-3
# Least ratio of the ends of the self-affine range.
_MIN_RANGE = 1.001
# Largest ratio of the ends of the self-affine range without a bound.
_MAX_RANGE = 1e6
# Wave number, in units of 2 pi/side, up to which waves are added one by one.
_MAX_SUMMED = 128
# Relative change of the free parameter within which the sum over waves has the ratio.
_MAX_CHANGE = 0.25
# Largest relative deviation of the second amplitude.
_MAX_DEVIATION = 0.05
# Tolerance of the logarithm of the free parameter.
_TOLERANCE = 1e-10


def solved(
    rough: SelfAffine,
    free: str,
    given: Mapping[str, float],
    shortest: float = 0.0,
    unit: str = "",
) -> SelfAffine:
    """Return a surface with two given amplitudes.

    Parameters
    ----------
    rough : SelfAffine
        Surface with any value of the free parameter. If it has no domain, the domain
        follows from the value that is found.
    free : {"hurst", "short_wavelength", "long_wavelength"}
        Parameter that follows.
    given : mapping of str to float
        Two of rms_slope, rms_height (length) and rms_curvature (inverse length).
    shortest : float
        Least short wavelength (length).
    unit : str
        Unit of length, for errors.

    Returns
    -------
    SelfAffine
        The root mean squares over all seeds are as given: the first exactly, the second
        within the steps of waves that enter the spectrum one after the other, which a
        larger domain makes smaller. A Hurst exponent has no steps.

    Raises
    ------
    ValueError
        If no value of the free parameter gives these amplitudes, with the possible
        values of the second one, or if the steps are larger than 5 %.
    """
    lookup(free, dict.fromkeys(FREE), "free parameter")
    (first, amplitude), (second, wanted) = given.items()
    low, high = _ends(rough, free, shortest)

    def with_value(logarithm: float) -> SelfAffine:
        change: Any = {free: math.exp(logarithm)}
        return replace(rough, **change)

    def deviation(logarithm: float) -> float:
        """Return by how much the continuous spectrum has a too large ratio."""
        trial = replace(with_value(logarithm), rms_slope=1.0, domain=None)
        values = {
            "rms_slope": 1.0,
            "rms_height": rms_height(trial),
            "rms_curvature": rms_curvature(trial),
        }
        return math.log(values[second] / values[first] * amplitude / wanted)

    ends = deviation(low), deviation(high)
    if ends[0] * ends[1] > 0.0:
        least, largest = sorted(wanted * math.exp(end) for end in ends)
        of_free, of_second = _unit_of(free, unit), _unit_of(second, unit)
        raise ValueError(
            f"no {free} from {math.exp(low):.3g} to {math.exp(high):.3g}{of_free} has "
            f"{second} = {wanted:.4g}{of_second} with {first} = {amplitude:.4g}"
            f"{_unit_of(first, unit)}: {second} can be {least:.4g} to {largest:.4g}"
            f"{of_second}"
        )
    close = brentq(deviation, low, high, xtol=_TOLERANCE)
    rough = replace(rough, domain=rough.domain or with_value(close).side)

    def deviation_of_sum(logarithm: float) -> float:
        squares = mean_squares(with_value(logarithm))
        ratio = squares[AMPLITUDES[second]] / squares[AMPLITUDES[first]]
        return 0.5 * math.log(ratio) + math.log(amplitude / wanted)

    nearest = _nearest(deviation_of_sum, close, low, high)
    missed = math.expm1(abs(deviation_of_sum(nearest)))
    if missed > _MAX_DEVIATION:
        raise ValueError(
            f"{second} = {wanted:.4g}{_unit_of(second, unit)} is missed by "
            f"{100.0 * missed:.2g} %, as the period has few long waves: give a larger "
            f"domain than {rough.side:.4g}{_unit_of('domain', unit)}"
        )
    found = with_value(nearest)
    squares = mean_squares(found)
    slope = amplitude * math.sqrt(squares[2] / squares[AMPLITUDES[first]])
    return replace(found, rms_slope=slope)


def _unit_of(name: str, unit: str) -> str:
    """Return the unit of an amplitude or a free parameter, after a space."""
    if not unit or name in ("rms_slope", "hurst"):
        return ""
    return f" /{unit}" if name == "rms_curvature" else f" {unit}"


def _ends(rough: SelfAffine, free: str, shortest: float) -> tuple[float, float]:
    """Return the logarithms of the smallest and the largest free parameter."""
    if free == "hurst":
        return math.log(_MIN_HURST), math.log1p(-_MIN_HURST)
    if free == "short_wavelength":
        last = rough.long_wavelength / _MIN_RANGE
        return math.log(shortest or last / _MAX_RANGE), math.log(last)
    last = rough.longest_wavelength or math.inf
    last = min(last, (rough.domain or math.inf) / rough.anisotropy)
    last *= 1.0 - LENGTH_ROUNDING
    first = _MIN_RANGE * rough.short_wavelength
    return math.log(first), math.log(min(last, _MAX_RANGE * first))


def _nearest(
    deviation: Callable[[float], float], close: float, low: float, high: float
) -> float:
    """Return where a monotonic function with steps is closest to zero."""
    low, high = max(low, close - _MAX_CHANGE), min(high, close + _MAX_CHANGE)
    sides = deviation(low), deviation(high)
    if sides[0] * sides[1] > 0.0:
        return low if abs(sides[0]) < abs(sides[1]) else high
    while high - low > _TOLERANCE:
        middle = 0.5 * (low + high)
        value = deviation(middle)
        if value * sides[0] > 0.0:
            low, sides = middle, (value, sides[1])
        else:
            high, sides = middle, (sides[0], value)
    return low if abs(sides[0]) < abs(sides[1]) else high


def mean_squares(rough: SelfAffine) -> dict[int, float]:
    """Return mean squares of height (0), slope (2) and curvature (4), up to one factor.

    Waves are added up to a wave number, and the spectrum is integrated beyond.
    """
    short, side = rough.short_wavelength, rough.side
    last = side / short * (1 + LENGTH_ROUNDING)
    kx, ky = half_plane(min(last, _MAX_SUMMED))
    square = kx**2 + ky**2
    number = rough.spectral_wavenumber(kx, ky)
    power = np.where(number <= _MAX_SUMMED, rough.mean_power(kx, ky), 0.0)
    knee = side / rough.long_wavelength
    first = side / (rough.longest_wavelength or rough.long_wavelength)
    found = {}
    for moment in AMPLITUDES.values():
        total = float((square ** (moment / 2) * power).sum())
        tail = _integral(moment, rough.hurst, max(first, _MAX_SUMMED), knee, last)
        mean = angular_mean(moment, rough.anisotropy) / rough.anisotropy
        # of waves of a half plane
        total += np.pi * mean * tail
        found[moment] = total * (2 * np.pi / side) ** moment
    return found


def _integral(
    moment: int, hurst: float, first: float, knee: float, last: float
) -> float:
    """Integrate k^(m + 1) max(k, knee)^(-2 - 2H) over k from first to last."""
    total = 0.0
    if first < min(knee, last):
        top = min(knee, last)
        total += knee ** (-2 - 2 * hurst) * (
            top ** (moment + 2) - first ** (moment + 2)
        )
        total /= moment + 2
    first = max(first, knee)
    if first < last:
        power = moment - 2 * hurst
        total += (
            math.log(last / first)
            if power == 0
            else (last**power - first**power) / power
        )
    return total
