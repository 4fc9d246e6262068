"""Self-affine roughness: a periodic sum of plane waves with random phases.

Lengths are in any one unit.
"""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, asdict, dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from ase_roughcontact._util.threads import available_threads
from ase_roughcontact._util.validation import FloatArray, integer, positive, window
from ase_roughcontact.topography.spectrum import Statistics

IntArray: TypeAlias = NDArray[np.int64]

# Relative slack that keeps rounding from moving a wave over the edge of the band.
_ROUNDING = 1e-9


@dataclass(frozen=True)
class SelfAffine:
    r"""One realisation of a random self-affine surface.

    .. math:: C(q) \propto \max(q, 2\pi/\lambda_L)^{-2-2H}, \qquad
              2\pi/\lambda_{\max} \le q \le 2\pi/\lambda_s,

    and zero outside, with random phases. The realisation is a function of these
    parameters alone, defined everywhere and periodic: windows, spacings and origins
    only choose where it is looked at. Its mean is zero.

    Parameters
    ----------
    rms_slope : float
        Root mean square slope.
    hurst : float
        Hurst exponent H, between 0 and 1.
    short_wavelength, long_wavelength : float
        Ends of the self-affine range, lambda_s and lambda_L.
    longest_wavelength : float, optional
        Constant C(q) from `long_wavelength` up to this wavelength, lambda_max
        (roll-off). Default: no roll-off.
    seed : int
        Seed of the random numbers, not negative.
    random_amplitudes : bool
        Rayleigh distributed amplitudes (a Gaussian random field) in place of fixed
        ones. The phases stay the same.
    normalise : {"realisation", "ensemble"}
        Whether this realisation has exactly `rms_slope`, or the mean square over all
        seeds has. The two differ only for random amplitudes.
    domain : float, optional
        Side of the periodic square on which the surface lives, at least the longest
        wavelength. Default: four times the longest wavelength.

    Raises
    ------
    ValueError
        If a parameter is not finite, out of range, or out of order.

    Notes
    -----
    Every wave has two random numbers of its own, drawn in order of rising wave
    number. Hence the long waves of a seed keep their phases when short ones are added.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001
    (2017), on power spectra; L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108,
    221601 (2016), on the surfaces with sharp cutoffs used here.
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
        """Check the parameters and turn them into plain numbers."""
        rising = "short_wavelength", "long_wavelength", "longest_wavelength", "domain"
        given = {name: getattr(self, name) for name in rising}
        lengths = {name: value for name, value in given.items() if value is not None}
        numbers = {"rms_slope": self.rms_slope, "hurst": self.hurst} | lengths
        positive(**numbers)
        if self.hurst >= 1:
            raise ValueError(f"hurst must lie between 0 and 1, got {self.hurst}")
        for (shorter, least), (longer, length) in pairwise(lengths.items()):
            if length < least * (1 - _ROUNDING):
                raise ValueError(
                    f"{longer} must be at least {shorter} = {least}, got {length}"
                )
        if self.normalise not in ("realisation", "ensemble"):
            raise ValueError(
                f"normalise must be 'realisation' or 'ensemble', got {self.normalise!r}"
            )
        if not isinstance(self.random_amplitudes, bool):
            raise ValueError(
                f"random_amplitudes must be a bool, got {self.random_amplitudes!r}"
            )
        for name, value in numbers.items():
            object.__setattr__(self, name, float(value))
        object.__setattr__(self, "seed", integer("seed", self.seed, least=0))

    @property
    def side(self) -> float:
        """Side of the periodic square: `domain`, or its default."""
        if self.domain is not None:
            return self.domain
        return 4 * (self.longest_wavelength or self.long_wavelength)

    @property
    def extent(self) -> float:
        """Distance from the origin, along x and y, up to which it does not repeat."""
        return self.side / 2

    @property
    def repeats(self) -> bool:
        """Whether the surface goes on beyond its extent."""
        return True

    def lowest(self, spacing: float, origin: tuple[float, float] = (0.0, 0.0)) -> float:
        """Lowest height on a grid over the whole domain.

        Parameters
        ----------
        spacing : float
            Distance between grid points.
        origin : tuple of float
            Position (x, y) of one of them.

        Returns
        -------
        float
        """
        points = self._points_per_side(spacing)
        return _lowest(self, points, *_steps(spacing, origin)[1])

    def heights(
        self,
        shape: tuple[int, int],
        spacing: float,
        origin: tuple[float, float] = (0.0, 0.0),
    ) -> FloatArray:
        """Sample the surface on a grid, exactly.

        Parameters
        ----------
        shape : tuple of int
            Grid points (n, m), at most one period of the surface a side.
        spacing : float
            Distance between grid points: a whole fraction of the period, at most
            half the shortest wavelength.
        origin : tuple of float
            Position (x, y) of grid point (0, 0).

        Returns
        -------
        ndarray, shape (n, m)
            Heights.

        Raises
        ------
        ValueError
            If the grid is too coarse, does not fit the period, or exceeds it.
        """
        shape, spacing, origin = window(shape, spacing, origin)
        points = self._points_per_side(spacing)
        if max(shape) > points:
            raise ValueError(
                f"a window of {shape} points exceeds the periodic domain of "
                f"{points} x {points} points and would see the same roughness twice; "
                f"give the surface a domain of at least {max(shape) * spacing:g}"
            )
        steps, shift = _steps(spacing, origin)
        field = _field(self, points, *shift)
        index = [
            (step + np.arange(n)) % points for step, n in zip(steps, shape, strict=True)
        ]
        return field[np.ix_(*index)]

    def statistics(self) -> Statistics:
        """Return the statistics of this realisation, from its coefficients.

        Returns
        -------
        Statistics
            Exact root mean squares over the periodic domain.
        """
        kx, ky, coefficient = _modes(self)
        square = (2 * np.pi / self.side) ** 2 * (kx**2 + ky**2)
        # Each wave of the half plane stands for itself and its mirror image.
        return Statistics.of_waves(square, 2 * np.abs(coefficient) ** 2)

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, the domain's side among them."""
        return {"name": "SelfAffine", **asdict(self), "domain": self.side}

    def _points_per_side(self, spacing: float) -> int:
        if self.short_wavelength < 2 * spacing * (1 - _ROUNDING):
            raise ValueError(
                f"a spacing of {spacing:g} cannot show short_wavelength = "
                f"{self.short_wavelength:g}, expected at most half of it"
            )
        ratio = self.side / spacing
        points = round(ratio)
        if abs(ratio - points) > 1e-6:
            raise ValueError(
                f"the side of the periodic domain, {self.side!r}, must be a multiple "
                f"of the spacing, got {spacing!r} (ratio {ratio:.9g}); give the "
                f"surface domain={math.ceil(ratio) * spacing!r}"
            )
        return points


def _steps(
    spacing: float, origin: tuple[float, float]
) -> tuple[list[int], list[float]]:
    """Whole steps, which wrap indices, and what is left over, which moves the waves."""
    places = [round(position / spacing, 12) for position in origin]
    steps = [math.floor(place) for place in places]
    rest = [round(place - step, 12) for place, step in zip(places, steps, strict=True)]
    return steps, rest


@lru_cache(maxsize=2)
def _modes(
    surface: SelfAffine,
) -> tuple[IntArray, IntArray, NDArray[np.complex128]]:
    """Integer wave vectors of one half plane, and the coefficients of their waves."""
    kx, ky = _half_plane(surface.side / surface.short_wavelength * (1 + _ROUNDING))
    phase, chance = np.random.default_rng(surface.seed).random((kx.size, 2)).T

    # Waves too long for the band take part in the draw, and only there.
    wavenumber = np.sqrt(kx**2 + ky**2)
    longest = surface.longest_wavelength or surface.long_wavelength
    first = np.searchsorted(wavenumber, surface.side / longest * (1 - _ROUNDING))
    kx, ky, wavenumber = kx[first:], ky[first:], wavenumber[first:]
    if not kx.size:
        raise ValueError(
            f"no wave of a domain of side {surface.side:g} has a wavelength between "
            f"{surface.short_wavelength:g} and {longest:g}; choose a larger domain"
        )

    knee = surface.side / surface.long_wavelength
    power = np.maximum(wavenumber, knee) ** (-2 - 2 * surface.hurst)
    square_slope = power @ wavenumber**2
    if surface.random_amplitudes:
        power *= -np.log1p(-chance[first:])
    if surface.normalise == "realisation":
        square_slope = power @ wavenumber**2
    # Each wave of the half plane stands for itself and its mirror image.
    unit = surface.rms_slope * surface.side / (2 * np.pi * np.sqrt(2 * square_slope))
    return kx, ky, unit * np.sqrt(power) * np.exp(2j * np.pi * phase[first:])


def _half_plane(reach: float) -> tuple[IntArray, IntArray]:
    """Integer wave vectors up to a length, one of each pair +-k, by rising length."""
    k = np.arange(-int(reach), int(reach) + 1)
    kx, ky = k[:, None], k[None, k >= 0]
    kx, ky = (kx**2 + ky**2 <= reach**2).nonzero()
    kx -= int(reach)
    half = (ky > 0) | (kx > 0)
    kx, ky = kx[half], ky[half]
    order = np.argsort(kx**2 + ky**2, kind="stable")
    return kx[order], ky[order]


@lru_cache(maxsize=2)
def _field(surface: SelfAffine, points: int, x: float, y: float) -> FloatArray:
    """Heights on the whole domain, (x, y) steps off the grid; read-only."""
    kx, ky, coefficient = _modes(surface)
    if x or y:
        coefficient = coefficient * np.exp(2j * np.pi / points * (kx * x + ky * y))
    # Columns beyond the shortest wave are zero and never transformed along x.
    spectrum = np.zeros((points, ky.max() + 1), dtype=complex)
    spectrum[kx % points, ky] = coefficient
    # These columns hold both halves of the plane, and at the edge of the grid's
    # range a wave falls on its own mirror image.
    own = (ky == 0) | (2 * ky == points)
    spectrum[-kx[own] % points, ky[own]] += coefficient[own].conj()
    options: dict[str, Any] = {"norm": "forward", "workers": available_threads()}
    rows = fft.ifft(spectrum, axis=0, overwrite_x=True, **options)
    field = fft.irfft(rows, n=points, axis=1, **options)
    field.flags.writeable = False
    return field


@lru_cache(maxsize=16)
def _lowest(surface: SelfAffine, points: int, x: float, y: float) -> float:
    """Lowest height of `_field`."""
    return float(_field(surface, points, x, y).min())
