"""Self-affine roughness: a periodic sum of plane waves with random phases."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, asdict, dataclass, replace
from functools import lru_cache
from itertools import pairwise
from typing import Any, Literal, TypeAlias

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

# Points along the side of a whole period above which its heights are not kept for the
# next window: 34 MB.
_MAX_KEPT_POINTS = 2048
# Ratio of the period and the shortest wavelength above which the waves are not kept for
# the next window: 50 MB.
_MAX_KEPT_WAVES = 1024


@dataclass(frozen=True)
class SelfAffine(Topography):
    r"""One realisation of a random self-affine surface.

    The power spectrum is

    .. math:: C(q) \propto \max(q, 2\pi/\lambda_L)^{-2-2H}, \qquad
              2\pi/\lambda_{\max} \le q \le 2\pi/\lambda_s,

    and zero at other wave numbers; phases are random, and the mean height is zero. The
    surface is periodic and a function of these parameters alone: it does not depend on
    the window, spacing and origin with which it is sampled.

    Parameters
    ----------
    rms_slope : float
        Root mean square slope.
    hurst : float
        Hurst exponent H, between 0 and 1.
    short_wavelength, long_wavelength : float
        Ends of the self-affine range, lambda_s and lambda_L (length).
    longest_wavelength : float, optional
        lambda_max (length), up to which C(q) is constant beyond `long_wavelength`
        (roll-off); by default there is no roll-off.
    seed : int
        Seed of the random numbers, not negative.
    random_amplitudes : bool
        Whether amplitudes are Rayleigh distributed (a Gaussian random field) instead of
        fixed. The phases are the same.
    normalise : {"realisation", "ensemble"}
        Whether this realisation has exactly `rms_slope`, or the mean square over all
        seeds does. This makes a difference for random amplitudes only.
    domain : float, optional
        Period along x and y (length), at least the longest wavelength; by default four
        times the longest wavelength.

    Raises
    ------
    ValueError
        If a parameter is not finite or out of range, or the lengths are not in
        increasing order.

    Notes
    -----
    Each wave has two random numbers, drawn in the order of increasing wave number, so
    that a surface keeps the phases of its long waves if shorter ones are added.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001
    (2017): power spectra. L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601
    (2016): this spectrum.

    Examples
    --------
    >>> from ase_roughcontact import SelfAffine
    >>> rough = SelfAffine(0.1, 0.8, short_wavelength=4.0, long_wavelength=16.0, seed=1)
    >>> heights = rough.heights((64, 64), spacing=1.0)
    >>> heights.shape, bool(abs(heights.mean()) < 1e-12)
    ((64, 64), True)
    """

    rms_slope: float
    hurst: float
    short_wavelength: float
    long_wavelength: float
    _: KW_ONLY
    longest_wavelength: float | None = None
    seed: int = 0
    random_amplitudes: bool = False
    normalise: Literal["realisation", "ensemble"] = "realisation"
    domain: float | None = None

    def __post_init__(self) -> None:
        """Check the parameters and convert them to plain numbers."""
        ordered = "short_wavelength", "long_wavelength", "longest_wavelength", "domain"
        values = {name: getattr(self, name) for name in ordered}
        lengths = {name: value for name, value in values.items() if value is not None}
        numbers = {"rms_slope": self.rms_slope, "hurst": self.hurst, **lengths}
        positive(**numbers)
        boolean(random_amplitudes=self.random_amplitudes)
        if self.hurst >= 1:
            raise ValueError(f"hurst must lie between 0 and 1, got {self.hurst}")
        for (shorter, least), (longer, length) in pairwise(lengths.items()):
            if length < least * (1 - LENGTH_ROUNDING):
                raise ValueError(
                    f"{longer} must be at least {shorter} = {least}, got {length}"
                )
        one_of(("realisation", "ensemble"), normalise=self.normalise)
        for name, value in numbers.items():
            object.__setattr__(self, name, float(value))
        object.__setattr__(self, "seed", integer("seed", self.seed, least=0))

    @property
    def side(self) -> float:
        """Period along x and y: `domain` or its default (length)."""
        if self.domain is not None:
            return self.domain
        return 4 * (self.longest_wavelength or self.long_wavelength)

    @property
    def periods(self) -> Point:
        """Periods along x and y (length)."""
        return self.side, self.side

    @property
    def shortest_wavelength(self) -> float:
        """Lower end of the self-affine range, `short_wavelength` (length)."""
        return self.short_wavelength

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

    def band_limited(self, shortest: float) -> SelfAffine:
        """Return the surface without its waves shorter than a wavelength.

        It has the same longer waves, and therefore a smaller rms slope.

        Raises
        ------
        ValueError
            If all waves are shorter.
        """
        if shortest <= self.short_wavelength * (1 + LENGTH_ROUNDING):
            return self
        kx, ky, coefficient = _modes(self)
        square = kx**2 + ky**2
        power = np.abs(coefficient) ** 2
        if self.normalise == "ensemble":
            power = _mean_power(self, np.sqrt(square))
        kept = square <= (self.side / shortest * (1 + LENGTH_ROUNDING)) ** 2
        if not kept.any():
            raise ValueError(
                f"all waves of the roughness are shorter than {shortest:g}: choose at "
                f"most {self.side / math.sqrt(square.min()):g}"
            )
        slopes = power * square
        part = slopes.sum(where=kept) / slopes.sum()
        return replace(
            self,
            rms_slope=self.rms_slope * math.sqrt(part),
            short_wavelength=shortest,
            domain=self.side,
        )

    def statistics(self) -> Statistics:
        """Return the exact rms height, slope and curvature of this realisation."""
        kx, ky, coefficient = _modes(self)
        square = (2 * np.pi / self.side) ** 2 * (kx**2 + ky**2)
        # a wave of the half plane also represents the one with -k
        return Statistics.of_waves(square, 2 * np.abs(coefficient) ** 2)

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, including the default of `domain`."""
        return {"name": "SelfAffine", **asdict(self), "domain": self.side}

    def _points_per_side(self, spacing: float) -> int:
        """Return the number of grid points in a period, or raise `ValueError`."""
        if self.short_wavelength < 2 * spacing * (1 - LENGTH_ROUNDING):
            raise ValueError(
                f"spacing must be at most half of short_wavelength = "
                f"{self.short_wavelength:g}, got {spacing:g}"
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


def _modes(surface: SelfAffine) -> Modes:
    """Return the integer wave vectors of one half plane and their coefficients."""
    kept = surface.side <= _MAX_KEPT_WAVES * surface.short_wavelength
    draw = _drawn_modes if kept else _drawn_modes.__wrapped__
    return draw(surface)


@lru_cache(maxsize=2)
def _drawn_modes(surface: SelfAffine) -> Modes:
    kx, ky = _half_plane(
        surface.side / surface.short_wavelength * (1 + LENGTH_ROUNDING)
    )
    phase, uniform = np.random.default_rng(surface.seed).random((kx.size, 2)).T

    # Waves that are longer than the spectrum allows are skipped after the draw.
    wavenumber = np.sqrt(kx**2 + ky**2)
    longest = surface.longest_wavelength or surface.long_wavelength
    first = np.searchsorted(wavenumber, surface.side / longest * (1 - LENGTH_ROUNDING))
    kx, ky, wavenumber = kx[first:], ky[first:], wavenumber[first:]
    if not kx.size:
        raise ValueError(
            "the domain has no waves between its shortest and its longest wavelength, "
            f"{surface.short_wavelength / surface.side:g} and "
            f"{longest / surface.side:g} of its side: choose a larger domain"
        )

    power = _mean_power(surface, wavenumber)
    # no scalar products here: their rounding depends on the threads of BLAS
    square_slope = (power * wavenumber**2).sum()
    if surface.random_amplitudes:
        power *= -np.log1p(-uniform[first:])
    if surface.normalise == "realisation":
        square_slope = (power * wavenumber**2).sum()
    # factor 2: a wave of the half plane also represents the one with -k
    unit = surface.rms_slope * surface.side / (2 * np.pi * np.sqrt(2 * square_slope))
    return kx, ky, unit * np.sqrt(power) * np.exp(2j * np.pi * phase[first:])


def _mean_power(surface: SelfAffine, wavenumber: FloatArray) -> FloatArray:
    """Return the mean power of waves, up to a factor; wave numbers in 2 pi / side."""
    knee = surface.side / surface.long_wavelength
    return np.maximum(wavenumber, knee) ** (-2 - 2 * surface.hurst)


def _half_plane(largest: float) -> tuple[IntArray, IntArray]:
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
def _field(surface: SelfAffine, points: int, x: float, y: float) -> FloatArray:
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
def _lowest(surface: SelfAffine, points: int, x: float, y: float) -> float:
    """Return the lowest height of `_field`."""
    return float(_field(surface, points, x, y).min())
