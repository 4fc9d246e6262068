"""Random roughness with a power spectrum that is given as a table."""

from __future__ import annotations

import math
from dataclasses import KW_ONLY, asdict, dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np

from ase_roughcontact._util.identity import digest
from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import FloatArray, Point, finite_array, positive
from ase_roughcontact.topography.random_waves import IntArray, RandomWaves, half_plane
from ase_roughcontact.topography.self_affine_fit import SelfAffineFit
from ase_roughcontact.topography.spectrum import Statistics
from ase_roughcontact.topography.spectrum_files import read_spectrum

# Points of the table between which moments are integrated.
_MOMENT_POINTS = 4000


@dataclass(frozen=True)
class TabulatedSpectrum(Summarized, RandomWaves):
    r"""One realisation of an isotropic random surface with a measured power spectrum.

    The radially averaged spectrum :math:`C(q)` has

    .. math:: \langle h^2 \rangle = \frac{1}{4\pi^2} \int C(q)\, d^2q .

    Between the rows it is interpolated on logarithmic axes, and it is zero beyond them.
    Phases are random, and heights are Gaussian.

    Parameters
    ----------
    wave_numbers : array_like, shape (k,)
        Wave numbers q, increasing (inverse length).
    density : array_like, shape (k,)
        C(q), positive (length to the fourth power).
    rms_slope : float, optional
        Root mean square slope, to which heights are scaled. By default as the table
        says: the root of the sum over the waves of the period.
    shortest, longest : float, optional
        Wavelengths at which the spectrum is cut (length); by default the ends of the
        table.
    seed, random_amplitudes, normalise
        See `SelfAffine`.
    domain : float, optional
        Period along x and y (length), at least the longest wavelength; by default four
        times the longest wavelength, so that many waves have the spectrum of the table.

    Raises
    ------
    ValueError
        If the table is not increasing or not positive, or a parameter is out of range.

    See Also
    --------
    read : The same from a file. of_scan : from the spectrum of a scan.

    Examples
    --------
    >>> import numpy as np
    >>> from ase_roughcontact import TabulatedSpectrum
    >>> q = np.geomspace(0.1, 1.5, 20)
    >>> rough = TabulatedSpectrum(q, 0.01 * q**-3.6, domain=64.0, seed=1)
    >>> rough.heights((64, 64), spacing=1.0).shape
    (64, 64)
    """

    kind: ClassVar[str] = "spectrum"

    wave_numbers: tuple[float, ...]
    density: tuple[float, ...]
    _: KW_ONLY
    rms_slope: float = None  # type: ignore[assignment]  # set from the table
    shortest: float | None = None
    longest: float | None = None
    seed: int = 0
    random_amplitudes: bool = False
    normalise: Literal["realisation", "ensemble"] = "realisation"
    domain: float | None = None

    def __post_init__(self) -> None:
        """Check the table and the parameters."""
        q = finite_array("wave_numbers", self.wave_numbers)
        density = finite_array("density", self.density)
        increasing = (
            q.ndim == 1 and len(q) > 1 and q[0] > 0.0 and np.all(np.diff(q) > 0)
        )
        if not (increasing and density.shape == q.shape and density.min() > 0.0):
            raise ValueError(
                "a spectrum needs increasing wave numbers and as many positive "
                f"densities, got shapes {q.shape} and {density.shape}"
            )
        object.__setattr__(self, "wave_numbers", tuple(q.tolist()))
        object.__setattr__(self, "density", tuple(density.tolist()))
        lengths = self.check_lengths(shortest=self.shortest, longest=self.longest)
        if self.domain is not None:
            lengths |= self.check_lengths(longest=self.band[1], domain=self.domain)
        self._check_random()
        if self.rms_slope is None:
            object.__setattr__(self, "rms_slope", self._slope_of_table)
        positive(rms_slope=self.rms_slope)
        lengths["rms_slope"] = self.rms_slope
        for name in lengths.keys() & {"shortest", "domain", "rms_slope"}:
            object.__setattr__(self, name, float(getattr(self, name)))

    @classmethod
    def read(
        cls,
        file: str | Path,
        convention: str = "",
        *,
        series: str = "",
        unit: str = "",
        **parameters: Any,
    ) -> TabulatedSpectrum:
        """Return a surface with the spectrum of a file, lengths in Å.

        Parameters
        ----------
        file : path
            Table with a head such as ``q (1/nm), C2D (nm^4)``, or a file .csv or .txt
            of a power spectrum of contact.engineering.
        convention : {"C2D", "q/pi C2D", "C1D", "C1D+"}
            How the density is normalised, see `spectrum_files.CONVENTIONS`; by default
            as the head says. contact.engineering has C1D of profiles, and C2D times
            q/pi of maps. Spectra of profiles are converted to C2D of an isotropic
            surface.
        series, unit
            See `spectrum_files.read_spectrum`.
        **parameters
            Parameters of `TabulatedSpectrum`.

        Raises
        ------
        ValueError
            If the file can't be read, or the convention or the unit is not known.
        """
        table: Any = read_spectrum(str(file), convention, series, unit)
        return cls(*table, **parameters)

    @classmethod
    def of_parameters(cls, **parameters: Any) -> TabulatedSpectrum:
        """Return a surface from the keys of a scene, with lengths in Å."""
        if not parameters.get("file"):
            raise ValueError("give file, a table with the power spectrum")
        names = {"short_wavelength": "shortest", "longest_wavelength": "longest"}
        return cls.read(
            **{names.get(key, key): value for key, value in parameters.items()}
        )

    @classmethod
    def of_scan(cls, scan: Any, **parameters: Any) -> TabulatedSpectrum:
        """Return a surface with the radially averaged spectrum of a map.

        Parameters
        ----------
        scan : HeightMap
            The map. A Hann window is applied unless it is periodic, see
            `spectrum.power_spectrum`. Waves shorter than two pixels are left out.
        **parameters
            Parameters of `TabulatedSpectrum`. `domain` must be given unless four times
            the longest wavelength is a multiple of the spacing.
        """
        q, density = scan.power_spectrum()
        kept = (density > 0.0) & (q > 0.0) & (q <= np.pi / max(scan.spacing))
        return cls(q[kept], density[kept], **parameters)

    def write(self, file: str | Path) -> None:
        """Write the table, with lengths in Å, as a file in nm that `read` reads."""
        table = np.stack([self.wave_numbers, self.density], axis=1) * (10.0, 1e-4)
        head = "q (1/nm), C2D (nm^4)"
        np.savetxt(file, table, "%.10g", ", ", header=head, encoding="utf-8")

    @property
    def band(self) -> Point:
        """Shortest and longest wavelength (length)."""
        ends = 2 * np.pi / self.wave_numbers[-1], 2 * np.pi / self.wave_numbers[0]
        return max(ends[0], self.shortest or 0.0), min(
            ends[1], self.longest or math.inf
        )

    def label(self, unit: float) -> str:
        """Return the spectrum in words, with wavelengths in a unit at the end."""
        short, long = (each / unit for each in self.band)
        return f"tabulated spectrum, wavelengths from {short:.4g} to {long:.4g}"

    def mean_power(self, kx: IntArray, ky: IntArray) -> FloatArray:
        """Return the mean square amplitudes of waves, up to a factor."""
        return self._density_at(2 * np.pi / self.side * np.sqrt(kx**2 + ky**2))

    def _density_at(self, q: FloatArray) -> FloatArray:
        """Return C(q), zero beyond the band."""
        log_q, log_density = np.log([self.wave_numbers, self.density])
        density = np.exp(np.interp(np.log(q), log_q, log_density))
        short, long = self.band
        inside = q * long >= 2 * np.pi * (1 - LENGTH_ROUNDING)
        inside &= q * short <= 2 * np.pi * (1 + LENGTH_ROUNDING)
        return np.where(inside, density, 0.0)

    @property
    def _slope_of_table(self) -> float:
        """Rms slope of waves with the densities of the table."""
        kx, ky = half_plane(self.side / self.band[0] * (1 + LENGTH_ROUNDING))
        square = (2 * np.pi / self.side) ** 2 * (kx**2 + ky**2)
        total = (square * self.mean_power(kx, ky)).sum()
        return math.sqrt(2.0 * total) / self.side

    def _moments(self, shortest: float) -> tuple[float, float, float]:
        """Return mean squares of height, slope and curvature up to a factor."""
        ends = 2 * np.pi / self.band[1], 2 * np.pi / max(self.band[0], shortest)
        q = np.geomspace(*ends, _MOMENT_POINTS)
        density = q**2 * self._density_at(q)  # for each d ln q
        zeroth, second, fourth = (
            float(np.trapezoid(q**power * density, np.log(q))) for power in (0, 2, 4)
        )
        return zeroth, second, fourth

    @property
    def expected_height(self) -> float:
        """Rms height by the spectrum (length)."""
        return self._expected.rms_height

    @cached_property
    def _expected(self) -> Statistics:
        """Root mean squares by the spectrum."""
        height, slope, curvature = np.sqrt(self._moments(0.0)).tolist()
        scale = self.rms_slope / slope
        return Statistics(scale * height, self.rms_slope, scale * curvature)

    @cached_property
    def self_affine(self) -> SelfAffineFit:
        """Self-affine roughness with the statistics of the spectrum, for theory."""
        q, density = np.array(self.wave_numbers), np.array(self.density)
        return SelfAffineFit.of(self._expected, q, density, self.band[1])

    @property
    def hurst(self) -> float:
        """Hurst exponent; see `self_affine`."""
        return self.self_affine.hurst

    @property
    def short_wavelength(self) -> float:
        """Lower end of the self-affine range (length); see `self_affine`."""
        return self.self_affine.short_wavelength

    @property
    def long_wavelength(self) -> float:
        """Upper end of the self-affine range (length); see `self_affine`."""
        return self.self_affine.long_wavelength

    def without_short_waves(self, shortest: float) -> TabulatedSpectrum | None:
        """Return the surface with a spectrum that ends at a longer wavelength."""
        if not self.band[0] < shortest < self.band[1]:
            return self if shortest <= self.band[0] else None
        part = self._moments(shortest)[1] / self._moments(0.0)[1]
        return self.cut_at(shortest, self.rms_slope * math.sqrt(part))

    def cut_at(self, shortest: float, rms_slope: float) -> TabulatedSpectrum:
        """Return the surface with another shortest wavelength and rms slope."""
        return replace(self, rms_slope=rms_slope, shortest=shortest, domain=self.side)

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, with a digest in place of the table."""
        table = np.array([self.wave_numbers, self.density])
        parameters = {"name": "TabulatedSpectrum", **asdict(self), "domain": self.side}
        del parameters["wave_numbers"], parameters["density"]
        return parameters | {"sha256": digest(table.tobytes())}
