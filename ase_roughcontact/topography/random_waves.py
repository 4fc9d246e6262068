"""Base class of random roughness: a periodic sum of plane waves with random phases."""

from __future__ import annotations

import math
from abc import abstractmethod
from dataclasses import asdict
from functools import lru_cache
from itertools import pairwise
from typing import Any, Literal, TypeAlias, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ase_roughcontact._util.rounding import LENGTH_ROUNDING, RATIO_ROUNDING
from ase_roughcontact._util.threads import available_threads
from ase_roughcontact._util.validation import (
    FloatArray,
    Point,
    Shape,
    boolean,
    integer,
    one_of,
    positive,
    window,
)
from ase_roughcontact.topography.spectrum import Statistics
from ase_roughcontact.topography.topography import Topography

IntArray: TypeAlias = NDArray[np.int64]
Modes: TypeAlias = tuple[IntArray, IntArray, NDArray[np.complex128]]
AnyWaves = TypeVar("AnyWaves", bound="RandomWaves")

# Multiple of the longest wavelength that is the default period.
_DEFAULT_PERIODS = 4.0
# Points along the side of a whole period above which its heights are not kept for the
# next window: 34 MB.
_MAX_KEPT_POINTS = 2048
# Ratio of the period and the shortest wavelength above which the waves are not kept for
# the next window: 50 MB.
_MAX_KEPT_WAVES = 1024


class RandomWaves(Topography):
    """Base class of random surfaces: frozen dataclasses with the fields below.

    A subclass defines the mean power of its waves, and the band of wavelengths. The
    surface is periodic and a function of its parameters alone: it does not depend on
    the window, spacing and origin with which it is sampled. The mean height is zero.

    Parameters
    ----------
    rms_slope, seed, random_amplitudes, normalise, domain
        See `SelfAffine`.

    Notes
    -----
    Each wave has two random numbers, drawn in the order of increasing wave number, so
    that a surface keeps the phases of its long waves if shorter ones are added.
    """

    rms_slope: float
    seed: int
    random_amplitudes: bool
    normalise: Literal["realisation", "ensemble"]
    domain: float | None

    @property
    @abstractmethod
    def band(self) -> Point:
        """Shortest and longest wavelength (length)."""

    @abstractmethod
    def mean_power(self, kx: IntArray, ky: IntArray) -> FloatArray:
        """Return the mean square amplitudes of waves over all seeds, up to a factor.

        Parameters
        ----------
        kx, ky : ndarray of int, shape (k,)
            Wave vectors in units of 2 pi/`side`, not longer than the band allows.

        Returns
        -------
        ndarray, shape (k,)
            Powers, zero for waves that do not belong to the surface.
        """

    @property
    @abstractmethod
    def expected_height(self) -> float:
        """Rms height by the spectrum, without a realisation, which may be large."""

    @abstractmethod
    def without_short_waves(self: AnyWaves, shortest: float) -> AnyWaves | None:
        """Return a surface with a spectrum that ends at a longer wavelength (length).

        Its rms slope follows from the spectrum, not from a realisation, which may be
        large. None if there are no longer waves.
        """

    @abstractmethod
    def cut_at(self: AnyWaves, shortest: float, rms_slope: float) -> AnyWaves:
        """Return the surface with another shortest wavelength and rms slope."""

    @abstractmethod
    def label(self, unit: float) -> str:
        """Return the spectrum in words, with wavelengths in a unit at the end."""

    def spectral_wavenumber(self, kx: IntArray, ky: IntArray) -> FloatArray:
        """Return the wave number on which the power depends, in units of 2 pi/`side`.

        It is at least as large as ``|k|``.
        """
        return np.sqrt(kx**2 + ky**2)

    def _check_random(self) -> None:
        """Check the fields of this class, and convert them to plain numbers."""
        boolean(random_amplitudes=self.random_amplitudes)
        one_of(("realisation", "ensemble"), normalise=self.normalise)
        object.__setattr__(self, "seed", integer("seed", self.seed, least=0))

    @property
    def side(self) -> float:
        """Period along x and y: `domain` or its default (length)."""
        if self.domain is not None:
            return self.domain
        return _DEFAULT_PERIODS * self.band[1]

    @property
    def periods(self) -> Point:
        """Periods along x and y (length)."""
        return self.side, self.side

    @property
    def shortest_wavelength(self) -> float:
        """Shortest wavelength of the heights (length)."""
        return self.band[0]

    @property
    def extent(self) -> float:
        """Half of the period (length)."""
        return self.side / 2

    @property
    def repeats(self) -> bool:
        """Whether the surface is periodic: True."""
        return True

    def lowest(self, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return the lowest height on a grid that covers one period (length).

        `origin` is the position of one of its points.
        """
        points = self._points_per_side(spacing)
        return _lowest(self, points, *_index(spacing, origin)[1])

    def heights(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the surface on a grid; see `Surface.heights`.

        The grid has at most one period along x and y. Its spacing is the period divided
        by a whole number, at most half of the shortest wavelength.

        Raises
        ------
        ValueError
            If the grid is too coarse, does not divide the period, or exceeds it.
        """
        shape, spacing, origin = window(shape, spacing, origin)
        points = self._points_per_side(spacing)
        if max(shape) > points:
            raise ValueError(
                f"a window of {shape} points exceeds the period of {points} x {points} "
                "points, so that the surface would be repeated: choose a domain "
                f"of at least {max(shape)} spacings"
            )
        first, shift = _index(spacing, origin)
        # a whole period has no other part that may be asked for
        used_once = shape == (points, points) and points > _MAX_KEPT_POINTS
        synthesise = _field.__wrapped__ if used_once else _field
        field = synthesise(self, points, *shift)
        if used_once and not any(i % points for i in first):
            return field
        indices = [
            (i + np.arange(n)) % points for i, n in zip(first, shape, strict=True)
        ]
        return field[np.ix_(*indices)]

    def band_limited(self: AnyWaves, shortest: float) -> AnyWaves:
        """Return the surface without its waves shorter than a wavelength.

        It has the same longer waves, and therefore a smaller rms slope.

        Raises
        ------
        ValueError
            If all waves are shorter.
        """
        if shortest <= self.shortest_wavelength * (1 + LENGTH_ROUNDING):
            return self
        kx, ky, coefficient = _modes(self)
        square = kx**2 + ky**2
        power = np.abs(coefficient) ** 2
        if self.normalise == "ensemble":
            power = self.mean_power(kx, ky)
        number = self.spectral_wavenumber(kx, ky)
        kept = number <= self.side / shortest * (1 + LENGTH_ROUNDING)
        slopes = power * square
        part = slopes.sum(where=kept) / slopes.sum()
        if not part:
            longest = self.side / number[power > 0.0].min()
            raise ValueError(
                f"all waves of the roughness are shorter than {shortest:g}: choose at "
                f"most {longest:g}"
            )
        return self.cut_at(shortest, self.rms_slope * math.sqrt(part))

    def statistics(self) -> Statistics:
        """Return the exact rms height, slope and curvature of this realisation."""
        kx, ky, coefficient = _modes(self)
        square = (2 * np.pi / self.side) ** 2 * (kx**2 + ky**2)
        # a wave of the half plane also represents the one with -k
        return Statistics.of_waves(square, 2 * np.abs(coefficient) ** 2)

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, including the default of `domain`."""
        fields: Any = self
        return {"name": type(self).__name__, **asdict(fields), "domain": self.side}

    def check_lengths(self, **lengths: float | None) -> dict[str, float]:
        """Return the lengths that are given, after checks that they are in order."""
        given = {name: value for name, value in lengths.items() if value is not None}
        positive(**given)
        for shorter, longer in pairwise(given):
            if given[longer] < given[shorter] * (1 - LENGTH_ROUNDING):
                raise ValueError(
                    f"{longer} must be at least {shorter} = {given[shorter]:g}, got "
                    f"{given[longer]:g}"
                )
        return given

    def _points_per_side(self, spacing: float) -> int:
        """Return the number of grid points in a period, or raise `ValueError`."""
        if self.shortest_wavelength < 2 * spacing * (1 - LENGTH_ROUNDING):
            raise ValueError(
                f"spacing must be at most half of the shortest wavelength = "
                f"{self.shortest_wavelength:g}, got {spacing:g}"
            )
        ratio = self.side / spacing
        points = round(ratio)
        if abs(ratio - points) > RATIO_ROUNDING:
            raise ValueError(
                f"the period {self.side!r} must be a multiple of the spacing "
                f"{spacing!r}, got a ratio of {ratio:.9g}: choose "
                f"domain={math.ceil(ratio) * spacing!r}"
            )
        return points


def _index(spacing: float, origin: Point) -> tuple[list[int], list[float]]:
    """Return the whole and the fractional part of the indices of the origin."""
    indices = [position / spacing for position in origin]
    whole = [math.floor(index + LENGTH_ROUNDING) for index in indices]
    rest = [round(x - i, 12) for x, i in zip(indices, whole, strict=True)]
    # rounding errors would be other surfaces, and each one would be synthesised
    return whole, [x if x > LENGTH_ROUNDING else 0.0 for x in rest]


def _modes(surface: RandomWaves) -> Modes:
    """Return the integer wave vectors of one half plane and their coefficients."""
    kept = surface.side <= _MAX_KEPT_WAVES * surface.shortest_wavelength
    draw = _drawn_modes if kept else _drawn_modes.__wrapped__
    return draw(surface)


@lru_cache(maxsize=2)
def _drawn_modes(surface: RandomWaves) -> Modes:
    shortest, longest = surface.band
    kx, ky = half_plane(surface.side / shortest * (1 + LENGTH_ROUNDING))
    phase, uniform = np.random.default_rng(surface.seed).random((kx.size, 2)).T

    # Waves that are longer than the spectrum allows are skipped after the draw.
    power = surface.mean_power(kx, ky)
    first = int(np.argmax(power > 0.0)) if power.size else 0
    if not power[first:].any():
        raise ValueError(
            "the domain has no waves between its shortest and its longest wavelength, "
            f"{shortest / surface.side:g} and {longest / surface.side:g} of its side: "
            "choose a larger domain"
        )
    kx, ky, power = kx[first:], ky[first:], power[first:]
    wavenumber = np.sqrt(kx**2 + ky**2)
    # no scalar products here: their rounding depends on the threads of BLAS
    square_slope = (power * wavenumber**2).sum()
    if surface.random_amplitudes:
        power *= -np.log1p(-uniform[first:])
    if surface.normalise == "realisation":
        square_slope = (power * wavenumber**2).sum()
    # factor 2: a wave of the half plane also represents the one with -k
    unit = surface.rms_slope * surface.side / (2 * np.pi * np.sqrt(2 * square_slope))
    return kx, ky, unit * np.sqrt(power) * np.exp(2j * np.pi * phase[first:])


def half_plane(largest: float) -> tuple[IntArray, IntArray]:
    """Return integer wave vectors up to a length, in order; one of each pair +-k."""
    k = np.arange(-int(largest), int(largest) + 1)
    kx, ky = k[:, None], k[None, k >= 0]
    kx, ky = (kx**2 + ky**2 <= largest**2).nonzero()
    kx -= int(largest)
    half = (ky > 0) | (kx > 0)
    kx, ky = kx[half], ky[half]
    order = np.argsort(kx**2 + ky**2, kind="stable")
    return kx[order], ky[order]


@lru_cache(maxsize=2)
def _field(surface: RandomWaves, points: int, x: float, y: float) -> FloatArray:
    """Return the heights of one period on a grid shifted by (x, y) steps.

    They are kept for other windows, which are copies of parts of them.
    """
    kx, ky, coefficient = _modes(surface)
    if x or y:
        coefficient = coefficient * np.exp(2j * np.pi / points * (kx * x + ky * y))
    # columns beyond the shortest wave are zero and need no transform along x
    spectrum = np.zeros((points, ky.max() + 1), dtype=complex)
    spectrum[kx % points, ky] = coefficient
    # the columns ky = 0 and ky = points/2 of a real transform contain k and -k
    both = (ky == 0) | (2 * ky == points)
    spectrum[-kx[both] % points, ky[both]] += coefficient[both].conj()
    options: dict[str, Any] = {"norm": "forward", "workers": available_threads()}
    rows = fft.ifft(spectrum, axis=0, overwrite_x=True, **options)
    return fft.irfft(rows, n=points, axis=1, **options)


@lru_cache(maxsize=16)
def _lowest(surface: RandomWaves, points: int, x: float, y: float) -> float:
    """Return the lowest height of `_field`."""
    return float(_field(surface, points, x, y).min())
