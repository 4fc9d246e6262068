"""Self-affine roughness: a random surface with a power law as its spectrum."""

from __future__ import annotations

from dataclasses import KW_ONLY, dataclass, replace
from typing import Any, ClassVar, Literal

import numpy as np

from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.validation import FloatArray, Point, finite, positive
from ase_roughcontact.theory.self_affine import rms_height
from ase_roughcontact.topography.random_waves import IntArray, RandomWaves


@dataclass(frozen=True)
class SelfAffine(RandomWaves):
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
    anisotropy : float
        Ratio of all wavelengths along `direction` and across it, at least one. The
        wavelengths above are those across; the longest wave of the surface is this
        times longer.
    direction : float
        Direction of the long waves, counted from x to y (degrees).

    Raises
    ------
    ValueError
        If a parameter is not finite or out of range, or the lengths are not in
        increasing order.

    Notes
    -----
    Each wave has two random numbers, drawn in the order of increasing wave number, so
    that a surface keeps the phases of its long waves if shorter ones are added.

    With the anisotropy g, C depends on :math:`(g^2 q_\parallel^2 + q_\perp^2)^{1/2}` in
    place of q, with the components of the wave vector along the direction and across:
    an isotropic surface is stretched. g is the ratio of correlation lengths, one over
    the texture aspect ratio Str of ISO 25178, and the direction is the texture
    direction Std. The rms slope is :math:`\langle |\nabla h|^2 \rangle^{1/2}`.

    References
    ----------
    T. D. B. Jacobs, T. Junge, L. Pastewka, Surf. Topogr.: Metrol. Prop. 5, 013001
    (2017): power spectra. L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601
    (2016): this spectrum. N. Patir, Wear 47, 263 (1978): ratio of correlation lengths.

    Examples
    --------
    >>> from ase_roughcontact import SelfAffine
    >>> rough = SelfAffine(0.1, 0.8, short_wavelength=4.0, long_wavelength=16.0, seed=1)
    >>> heights = rough.heights((64, 64), spacing=1.0)
    >>> heights.shape, bool(abs(heights.mean()) < 1e-12)
    ((64, 64), True)
    """

    kind: ClassVar[str] = "self-affine"

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
    anisotropy: float = 1.0
    direction: float = 0.0

    def __post_init__(self) -> None:
        """Check the parameters and convert them to plain numbers."""
        numbers = {"rms_slope": self.rms_slope, "hurst": self.hurst}
        positive(**numbers, anisotropy=self.anisotropy)
        finite(direction=self.direction)
        if self.hurst >= 1:
            raise ValueError(f"hurst must lie between 0 and 1, got {self.hurst}")
        if self.anisotropy < 1:
            raise ValueError(
                f"anisotropy must be at least 1, got {self.anisotropy}: turn the "
                f"direction by 90 degrees and give {1 / self.anisotropy:g}"
            )
        numbers |= self.check_lengths(
            short_wavelength=self.short_wavelength,
            long_wavelength=self.long_wavelength,
            longest_wavelength=self.longest_wavelength,
            domain=self.domain,
        )
        self._check_random()
        numbers |= {"anisotropy": self.anisotropy, "direction": self.direction}
        for name, value in numbers.items():
            object.__setattr__(self, name, float(value))
        if self.domain is not None:
            self.check_lengths(longest_wave=self.band[1], domain=self.domain)

    @property
    def band(self) -> Point:
        """Shortest and longest wavelength (length)."""
        longest = self.longest_wavelength or self.long_wavelength
        return self.short_wavelength, self.anisotropy * longest

    def label(self, unit: float) -> str:
        """Return the spectrum in words, with wavelengths in a unit at the end."""
        words = f"Hurst exponent {self.hurst:.3g}, "
        if self.anisotropy != 1.0:
            words += f"anisotropy {self.anisotropy:.4g} at {self.direction:.4g} deg, "
        short, long = self.short_wavelength / unit, self.long_wavelength / unit
        words += f"wavelengths from {short:.4g} to {long:.4g}"
        if self.longest_wavelength is not None:
            words += f", roll-off to {self.longest_wavelength / unit:.4g}"
        return words

    def spectral_wavenumber(self, kx: IntArray, ky: IntArray) -> FloatArray:
        """Return the wave number on which the power depends, in units of 2 pi/`side`.

        It is the wave number before the surface is stretched along `direction`.
        """
        if self.anisotropy == 1.0:
            return super().spectral_wavenumber(kx, ky)
        angle = np.deg2rad(self.direction)
        along = np.cos(angle) * kx + np.sin(angle) * ky
        across = np.cos(angle) * ky - np.sin(angle) * kx
        return np.hypot(self.anisotropy * along, across)

    def mean_power(self, kx: IntArray, ky: IntArray) -> FloatArray:
        """Return the mean square amplitudes of waves, up to a factor."""
        number = self.spectral_wavenumber(kx, ky)
        longest = self.longest_wavelength or self.long_wavelength
        first = self.side / longest * (1 - LENGTH_ROUNDING)
        last = self.side / self.short_wavelength * (1 + LENGTH_ROUNDING)
        knee = self.side / self.long_wavelength
        power = np.maximum(number, knee) ** (-2 - 2 * self.hurst)
        power[(number < first) | (number > last)] = 0.0
        return power

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters; see `RandomWaves.todict`.

        An isotropic surface has no anisotropy and no direction.
        """
        parameters = super().todict()
        if self.anisotropy == 1.0:
            del parameters["anisotropy"], parameters["direction"]
        return parameters

    @property
    def expected_height(self) -> float:
        """Rms height by the spectrum (length)."""
        return rms_height(self)

    def without_short_waves(self, shortest: float) -> SelfAffine | None:
        """Return a surface with a longer shortest wavelength (length).

        It has the same mean square height of the spectrum; see `RandomWaves`.
        """
        shortest = max(self.short_wavelength, shortest)
        if not shortest < self.long_wavelength:
            return None
        longer = replace(self, short_wavelength=shortest)
        slope = self.rms_slope * rms_height(self) / rms_height(longer)
        return replace(longer, rms_slope=slope)

    def cut_at(self, shortest: float, rms_slope: float) -> SelfAffine:
        """Return the surface with another shortest wavelength and rms slope."""
        return replace(
            self, rms_slope=rms_slope, short_wavelength=shortest, domain=self.side
        )
