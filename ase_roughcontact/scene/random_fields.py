"""Fields over the surface that scene files describe: roughness and local adhesion."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from scipy.fft import next_fast_len

from ase_roughcontact._util.rounding import RATIO_ROUNDING
from ase_roughcontact._util.validation import (
    integer,
    lookup,
    nonnegative_array,
    positive,
)
from ase_roughcontact.scene.section import KindSection, Section, lengths
from ase_roughcontact.theory.self_affine import numbers_of
from ase_roughcontact.topography import (
    ROUGHNESSES,
    HeightMap,
    Heterogeneity,
    Inverted,
    SelfAffine,
    Topography,
)
from ase_roughcontact.windows.memory import check_roughness

#: Keys of the amplitude of a roughness; one of them is given.
AMPLITUDES = "rms_slope", "rms_height", "rms_curvature"
#: Rms slope of a roughness without a given amplitude.
DEFAULT_SLOPE = 0.1
#: Keys of lengths of a random field.
LENGTH_KEYS = "short_wavelength", "long_wavelength", "longest_wavelength", "domain"
# Number that is added to the seed of a substrate.
_SUBSTRATE_SEED = 2**32


@dataclass(frozen=True)
class RandomFieldConfig(Section):
    """Keys of random fields: lengths in units of the spacing if no unit is given."""

    hurst: float = 0.8
    short_wavelength: float | str = 4.0
    long_wavelength: float | str = 512.0
    longest_wavelength: float | str | None = None
    unit: str = "a0"
    seed: int = 0
    random_amplitudes: bool = False
    domain: float | str | None = None


@dataclass(frozen=True)
class RoughnessConfig(KindSection, RandomFieldConfig):
    """``[roughness]``: wavelengths in units of the spacing if no unit is given.

    Without a kind the roughness is self-affine, and one of rms slope, height and
    curvature is given; the others follow from the spectrum. A user-defined roughness
    has a kind, and may have further keys, see `Topography`.
    """

    title = "roughness"
    kinds = ROUGHNESSES

    rms_slope: float | None = None
    rms_height: float | str | None = None
    rms_curvature: float | str | None = None
    normalise: str = "realisation"
    kind: str | None = None
    parameters: Mapping[str, float | str] = field(default_factory=dict, hash=False)

    def surface(self, spacing: float) -> Topography:
        """Return the roughness in Å.

        Parameters
        ----------
        spacing : float
            Atomic spacing a0 (Å).

        Raises
        ------
        ValueError
            If a key is unknown, missing or out of range, the spacing does not resolve
            the roughness, or its statistics are not known to theory.
        """
        if self.kind is None:
            if self.parameters:
                raise ValueError(f"{', '.join(self.parameters)} needs kind")
            return self._self_affine(spacing)
        kind = ROUGHNESSES.find(self.kind)
        values = {}
        for key, value in self.contents().items():
            is_chosen = key in self.given and key != "kind"
            if value is not None and (is_chosen or key in kind.parameters):
                values[key] = value
        surface = kind.of_parameters(**kind.converted_parameters(values, spacing))
        numbers_of(surface)
        return surface

    def contents(self) -> dict[str, Any]:
        """Return the values by key for comparison; see `Section.contents`."""
        entries = super().contents()
        if all(entries[key] is None for key in AMPLITUDES):
            entries["rms_slope"] = DEFAULT_SLOPE
        return entries

    def changed(self, name: str, value: Any) -> RoughnessConfig:
        """Return the section with another value; one amplitude replaces another."""
        section = self
        if name in AMPLITUDES and value is not None:
            section = replace(self, rms_slope=None, rms_height=None, rms_curvature=None)
        return super(RoughnessConfig, section).changed(name, value)

    def _self_affine(self, spacing: float) -> SelfAffine:
        """Return self-affine roughness (Å) with the amplitude that is given.

        Rms height and curvature are relative to the same waves with unit slope. With
        ``normalise = "ensemble"`` they are root mean squares over all seeds, as without
        random amplitudes.
        """
        name, value = self._amplitude(spacing)
        rough = random_field(self, spacing, rms_slope=1.0)
        if name == "rms_slope":
            return replace(rough, rms_slope=value)
        positive(**{name: value})
        random = rough.random_amplitudes and rough.normalise == "realisation"
        statistics = replace(rough, random_amplitudes=random).statistics()
        return replace(rough, rms_slope=value / getattr(statistics, name))

    def _amplitude(self, spacing: float) -> tuple[str, float]:
        """Return the name and the value of the amplitude (Å, 1, 1/Å)."""
        given = [name for name in AMPLITUDES if getattr(self, name) is not None]
        if len(given) > 1:
            raise ValueError(
                f"give one of {', '.join(AMPLITUDES)}, from which the others follow, "
                f"got {' and '.join(given)}"
            )
        if self.rms_slope is not None or not given:
            slope = DEFAULT_SLOPE if self.rms_slope is None else self.rms_slope
            return "rms_slope", slope
        units, unit = lengths(spacing), self.unit
        lookup(unit, units, "unit")
        if given == ["rms_curvature"]:
            inverse = {f"/{k}": 1.0 / value for k, value in units.items()}
            inverse |= {f"{k}^-1": 1.0 / value for k, value in units.items()}
            units, unit = inverse, f"/{unit}"
        plain = getattr(self.plain(given, units, unit), given[0])
        return given[0], plain * units[unit]


class TipRoughnessConfig(RoughnessConfig):
    """``[tip.roughness]``: roughness of the indenter, as in ``[roughness]``."""

    title = "tip.roughness"


class SubstrateRoughnessConfig(RoughnessConfig):
    """``[substrate.roughness]``: roughness of the substrate, as in ``[roughness]``.

    Heights are positive out of the substrate. The seed is another one than of a tip
    with the same number, so that both surfaces are independent.
    """

    title = "substrate.roughness"

    def surface(self, spacing: float) -> Topography:
        """Return the roughness as the lower side of an indenter (Å)."""
        seed = integer("seed", self.seed, least=0) + _SUBSTRATE_SEED
        heights = RoughnessConfig.surface(replace(self, seed=seed), spacing)
        return Inverted(heights)


@dataclass(frozen=True)
class HeterogeneityConfig(RandomFieldConfig):
    """``[heterogeneity]``: lengths in units of the spacing if no unit is given.

    A random field with root mean square `rms`, or the map of a file.
    """

    title = "heterogeneity"
    file_keys = ("file",)

    long_wavelength: float | str = 32.0
    rms: float | None = None
    file: str = ""
    spacing: float | str = 1.0
    periodic: bool = True


def random_field(
    section: RandomFieldConfig, spacing: float, least_domain: float = 0.0, **more: Any
) -> SelfAffine:
    """Return a random field in Å.

    Parameters
    ----------
    section : RandomFieldConfig
        Section with the spectrum and the seed of the field.
    spacing : float
        Atomic spacing a0 (Å).
    least_domain : float
        Least period of the field if the section gives none (Å): the default of
        `SelfAffine` is doubled until it is at least as large.
    **more
        Parameters that are not in the section.

    Raises
    ------
    ValueError
        If a value is out of range, or the spacing does not resolve the field.
    """
    # lengths are converted last: errors show them in the unit of the section
    unit, units = section.unit, lengths(spacing)
    scale = lookup(unit, units, "unit")
    entries = section.plain(LENGTH_KEYS, units, unit).entries()
    names = entries.keys() & SelfAffine.__dataclass_fields__.keys() - more.keys()
    rough = SelfAffine(**{name: entries[name] for name in names}, **more)
    entries["domain"] = _domain(rough, spacing / scale, unit, least_domain / scale)
    in_angstrom = {key: entries[key] * scale for key in LENGTH_KEYS if entries[key]}
    return replace(rough, **in_angstrom)


def local_adhesion(
    section: HeterogeneityConfig, spacing: float, least_domain: float
) -> Heterogeneity:
    """Return the relative work of adhesion that a section describes.

    Parameters
    ----------
    section : HeterogeneityConfig
    spacing : float
        Atomic spacing a0 (Å).
    least_domain : float
        See `random_field`.

    Raises
    ------
    ValueError
        If neither or both of a random field and a file are given, or a value is not
        valid.
    MemoryError
        If the random field needs more memory than is free.
    """
    if (section.rms is None) == (not section.file):
        raise ValueError("give rms, of a random field, or file, a map of adhesion")
    if section.rms is not None:
        field = random_field(section, spacing, least_domain, rms_slope=1.0)
        check_roughness(round(field.side / spacing) ** 2)
        return Heterogeneity(field, section.rms)
    values = _matrix(section.file)
    step = section.plain(["spacing"], lengths(spacing), "Å", section.unit)
    deviation = values / values.mean() - 1.0
    return Heterogeneity(HeightMap(deviation, step.spacing, section.periodic))


def _matrix(file: str) -> np.ndarray:
    """Return the works of adhesion of a text file, or of NumPy's .npy."""
    try:
        values = np.load(file) if file.endswith(".npy") else np.loadtxt(file, ndmin=2)
    except (EOFError, OSError, ValueError) as error:
        raise ValueError(f"cannot read a matrix from {file!r}: {error}") from error
    values = nonnegative_array("work of adhesion", values)
    if values.ndim != 2 or not values.any():
        raise ValueError(
            f"{file!r} must have a matrix of works of adhesion, not all of them zero, "
            f"got the shape {values.shape}"
        )
    return values


def _domain(rough: SelfAffine, spacing: float, unit: str, least: float) -> float | None:
    """Return the domain: the given one, or a whole number of spacings."""
    if rough.short_wavelength < (2.0 - RATIO_ROUNDING) * spacing:
        raise ValueError(
            f"short_wavelength must be at least {2 * spacing:.4g} {unit}, two spacings "
            f"of the atoms, got {rough.short_wavelength:g} {unit}"
        )
    side = rough.side / spacing
    if rough.domain is None and least > rough.side:
        side *= 2 ** math.ceil(math.log2(least / rough.side))
        return next_fast_len(math.ceil(side - RATIO_ROUNDING)) * spacing
    if abs(side - round(side)) <= RATIO_ROUNDING:
        return rough.domain
    points = math.ceil(side)
    if rough.domain is not None:
        raise ValueError(
            f"domain must be a multiple of the spacing, {spacing:.4g} {unit}, got "
            f'{rough.domain:g} {unit}: give "{points} a0"'
        )
    return next_fast_len(points) * spacing
