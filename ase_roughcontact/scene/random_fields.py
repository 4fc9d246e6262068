"""Fields over the surface that scene files describe: roughness and local adhesion."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, fields, replace
from itertools import pairwise
from typing import Any, ClassVar

import numpy as np
from scipy.fft import next_fast_len

from ase_roughcontact._util.rounding import LENGTH_ROUNDING, RATIO_ROUNDING
from ase_roughcontact._util.units import ANGLES, LENGTHS, QUANTITY
from ase_roughcontact._util.validation import (
    integer,
    nonnegative_array,
    positive,
    shown,
)
from ase_roughcontact.scene.section import (
    SUBSTRATE_SEED,
    KindSection,
    LengthSection,
    Problems,
    inverse_lengths,
    lengths,
)
from ase_roughcontact.theory.self_affine import numbers_of
from ase_roughcontact.topography import (
    ROUGHNESSES,
    HeightMap,
    Heterogeneity,
    Inverted,
    RandomWaves,
    SelfAffine,
    TabulatedSpectrum,
)
from ase_roughcontact.topography.amplitudes import AMPLITUDES, FREE, solved
from ase_roughcontact.windows.memory import check_roughness

#: Value of a key that follows from two amplitudes.
FREE_VALUE = "free"
#: Default values of self-affine roughness.
DEFAULTS = {"hurst": 0.8, "short_wavelength": "4 a0", "long_wavelength": "512 a0"}
#: Rms slope of a roughness without a given amplitude.
DEFAULT_SLOPE = 0.1
#: Keys of lengths of a random field.
LENGTH_KEYS = "short_wavelength", "long_wavelength", "longest_wavelength", "domain"
# Keys of the kinds "spectrum" and "self-affine" alone.
_OF_TABLES = "file", "convention", "series"
_OF_SELF_AFFINE = "hurst", "long_wavelength", "anisotropy", "direction"
# Advice on names that other programs and papers have, in lower case.
_HEIGHT = "rms_height, the root mean square height"
_SLOPE = "rms_slope, the root mean square of the gradient"
_ROLL_OFF = (
    "long_wavelength, where the roll-off begins, and longest_wavelength, where it ends"
)
_SPECTRUM = 'kind = "spectrum" and file, a table with its convention'
_HINTS = {
    **dict.fromkeys(("rms", "amplitude"), "rms_height, rms_slope or rms_curvature"),
    **dict.fromkeys(("sq", "rq", "hrms", "h_rms", "sigma"), _HEIGHT),
    **dict.fromkeys(("sa", "ra"), f"{_HEIGHT}, about 1.25 times the mean deviation"),
    **dict.fromkeys(("sdq", "rdq", "slope"), _SLOPE),
    **dict.fromkeys(("curvature", "kappa"), "rms_curvature"),
    **dict.fromkeys(("h", "hurst_exponent"), "hurst"),
    **dict.fromkeys(("fractal_dimension", "d_f"), "hurst = 3 - fractal dimension"),
    **dict.fromkeys(("cutoff", "lambda_s", "cutoff_wavelength"), "short_wavelength"),
    **dict.fromkeys(("roll_off", "rolloff", "correlation_length", "sal"), _ROLL_OFF),
    **dict.fromkeys(("lambda_l", "lambda_r"), _ROLL_OFF),
    **dict.fromkeys(("psd", "power_spectrum", "spectrum", "c1d", "c2d"), _SPECTRUM),
    **dict.fromkeys(("str", "aspect_ratio", "gamma"), "anisotropy = 1/Str"),
    **dict.fromkeys(("std", "angle", "lay"), "direction (degrees)"),
    **dict.fromkeys(("size", "period", "length"), "domain, the period"),
}


@dataclass(frozen=True)
class RandomFieldConfig(LengthSection):
    """Keys of random fields."""

    length_keys: ClassVar[tuple[str, ...]] = LENGTH_KEYS

    hurst: float = 0.8
    short_wavelength: float | str = "4 a0"
    long_wavelength: float | str = "512 a0"
    longest_wavelength: float | str | None = None
    unit: str = ""
    seed: int = 0
    random_amplitudes: bool = False
    domain: float | str | None = None
    anisotropy: float = 1.0
    direction: float | str = 0.0


@dataclass(frozen=True)
class RoughnessConfig(KindSection, RandomFieldConfig):
    """``[roughness]``: spectrum and amplitude of random roughness.

    By default the roughness is self-affine. One of rms slope, height and curvature is
    given, and the others follow from the spectrum; or two of them, and one of `FREE` is
    ``"free"`` and follows. Of the kind "spectrum" the spectrum is the table of a file.
    A user-defined roughness has a kind, and may have further keys, see `Topography`.
    """

    title = "roughness"
    kinds = ROUGHNESSES
    file_keys = ("file",)
    hints = _HINTS
    length_keys = (*LENGTH_KEYS, "rms_height")

    hurst: float | str | None = None  # type: ignore[assignment]
    short_wavelength: float | str | None = None  # type: ignore[assignment]
    long_wavelength: float | str | None = None  # type: ignore[assignment]
    rms_slope: float | None = None
    rms_height: float | str | None = None
    rms_curvature: float | str | None = None
    normalise: str = "realisation"
    file: str = ""
    convention: str = ""
    series: str = ""
    kind: str = SelfAffine.kind
    parameters: Mapping[str, float | str] = field(default_factory=dict, hash=False)

    @classmethod
    def _check_value(cls, name: str, value: Any, types: tuple[Any, ...]) -> None:
        """Raise `ValueError` for a value that no key of these types can have."""
        if name in FREE and value == FREE_VALUE:
            return
        if name == "hurst" and isinstance(value, str):
            raise ValueError(
                f'hurst must be a number, or "{FREE_VALUE}", got {shown(value)}'
            )
        super()._check_value(name, value, types)

    def _check_values(self, problems: Problems) -> None:
        """Collect unknown units, and lengths and curvatures without one."""
        super()._check_values(problems)
        with problems.of(self.title):
            units = inverse_lengths(1.0)
            self._check_unit("rms_curvature", self.rms_curvature, units, per="/")

    def surface(self, spacing: float) -> Any:
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
        kind: Any = ROUGHNESSES.find(self.kind)
        if kind is SelfAffine:
            self._check_keys(_OF_TABLES, TabulatedSpectrum.kind)
            return self._self_affine(spacing)
        if issubclass(kind, RandomWaves):
            self._check_keys(_OF_SELF_AFFINE, SelfAffine.kind)
            return self._waves(kind, spacing)
        values, filled = {}, self._filled.contents()
        for key, value in filled.items():
            parameter = kind.parameters.get(key)
            required = parameter is not None and parameter.required
            is_chosen = key in self.given and key not in ("kind", "unit")
            is_length = parameter is not None and parameter.unit == "a0"
            if is_length and isinstance(value, (int, float)) and self.unit:
                value = f"{value!r} {self.unit}"
            if value is not None and (is_chosen or required):
                values[key] = value
        surface: Any = kind.of_parameters(**kind.converted_parameters(values, spacing))
        numbers_of(surface)
        return surface

    @property
    def _filled(self) -> RoughnessConfig:
        """The section with the defaults of self-affine roughness."""
        missing: Any = {k: v for k, v in DEFAULTS.items() if getattr(self, k) is None}
        return replace(self, **missing)

    def contents(self) -> dict[str, Any]:
        """Return the values by key for comparison; see `Section.contents`."""
        if self.kind == TabulatedSpectrum.kind:
            return super().contents()
        entries = super(RoughnessConfig, self._filled).contents()
        if all(entries[key] is None for key in AMPLITUDES):
            entries["rms_slope"] = DEFAULT_SLOPE
        return entries

    def changed(self, name: str, value: Any) -> RoughnessConfig:
        """Return the section with another value.

        If one amplitude is given, another one replaces it.
        """
        section = self
        if name in AMPLITUDES and value is not None and not self.free:
            section = replace(self, rms_slope=None, rms_height=None, rms_curvature=None)
        return super(RoughnessConfig, section).changed(name, value)

    @property
    def free(self) -> str:
        """Key that follows from two amplitudes; empty for none."""
        found = [key for key in FREE if getattr(self, key) == FREE_VALUE]
        if len(found) > 1:
            raise ValueError(
                f'only one key can be "{FREE_VALUE}", got {" and ".join(found)}'
            )
        return found[0] if found else ""

    def _check_keys(self, foreign: Iterable[str], other: str) -> None:
        """Raise `ValueError` for keys of another kind."""
        if self.parameters:
            raise ValueError(f"{', '.join(self.parameters)} needs kind")
        usual = type(self)()
        found = [key for key in foreign if getattr(self, key) != getattr(usual, key)]
        if found:
            raise ValueError(
                f"kind = {self.kind!r} has no {', '.join(found)}: omit it, or give "
                f"kind = {other!r}"
            )

    def _waves(self, kind: type[RandomWaves], spacing: float) -> RandomWaves:
        """Return random roughness (Å) that is described by a file."""
        units = lengths(spacing)
        keys = "short_wavelength", "longest_wavelength", "domain"
        _check_order(self, keys, units)
        section = self.plain(keys, units, "Å", self.unit)
        names = (*keys, "file", "convention", "series", "seed", "random_amplitudes")
        values = {name: getattr(section, name) for name in (*names, "normalise")}
        unit = "" if self.unit == "a0" else self.unit
        rough: Any = kind.of_parameters(**values, unit=unit)
        rough = replace(
            rough, domain=_domain(rough, spacing / units["nm"], "nm", units)
        )
        given = self._amplitudes(spacing)
        if len(given) > 1:
            raise ValueError(f"give one of {', '.join(given)}, or none, as in the file")
        for name, value in given.items():
            rough = _scaled(rough, name, value)
        return rough

    def _self_affine(self, spacing: float) -> SelfAffine:
        """Return self-affine roughness (Å) with the amplitudes that are given."""
        given, free = self._amplitudes(spacing), self.free
        if free:
            return self._solved(free, given, spacing)
        if len(given) > 1:
            raise ValueError(
                f"give one of {', '.join(AMPLITUDES)}, from which the others follow, "
                f"got {' and '.join(given)}; or hurst, short_wavelength or "
                f'long_wavelength = "{FREE_VALUE}"'
            )
        ((name, value),) = (given or {"rms_slope": DEFAULT_SLOPE}).items()
        return _scaled(random_field(self._filled, spacing, rms_slope=1.0), name, value)

    def _solved(
        self, free: str, given: Mapping[str, float], spacing: float
    ) -> SelfAffine:
        """Return self-affine roughness (Å) with two amplitudes."""
        if len(given) != 2:
            raise ValueError(
                f'{free} = "{FREE_VALUE}" needs two of {", ".join(AMPLITUDES)}, got '
                f"{' and '.join(given) or 'none'}"
            )
        # any value within the others
        usual: Any = DEFAULTS["hurst"]
        if free == "short_wavelength":
            usual = f"{2.0 * spacing:.17g} Å"
        if free == "long_wavelength":
            usual = self._filled.longest_wavelength or self._filled.short_wavelength
        section = replace(self._filled, **{free: usual})
        nm = LENGTHS["nm"]
        rough = _stretched(random_field(section, spacing, rms_slope=1.0), 1.0 / nm)
        powers = {"rms_slope": 0, "rms_height": -1, "rms_curvature": 1}
        in_nm = {name: value * nm ** powers[name] for name, value in given.items()}
        if free == "long_wavelength" and not (self.longest_wavelength or self.domain):
            rough = solved(replace(rough, domain=None), free, in_nm, unit="nm")
            points = next_fast_len(math.ceil(rough.side * nm / spacing))
            rough = replace(rough, domain=points * spacing / nm)
        rough = solved(rough, free, in_nm, 2.0 * spacing / nm, "nm")
        return _stretched(rough, nm)

    def _amplitudes(self, spacing: float) -> dict[str, float]:
        """Return the amplitudes that are given (1, Å, 1/Å)."""
        units, found = lengths(spacing), {}
        for name in AMPLITUDES:
            if getattr(self, name) is None:
                continue
            known, unit = {"1": 1.0}, "1"
            if name == "rms_height":
                known, unit = units, self.unit or "a0"
            if name == "rms_curvature":
                known, unit = inverse_lengths(spacing), f"/{self.unit or 'a0'}"
            plain = getattr(self.plain([name], known, unit), name)
            positive(**{name: plain})
            found[name] = plain * known[unit]
        return found


def _stretched(rough: SelfAffine, factor: float) -> SelfAffine:
    """Return roughness with all lengths in another unit."""
    values = {name: getattr(rough, name) for name in LENGTH_KEYS}
    return replace(
        rough, **{name: value * factor for name, value in values.items() if value}
    )


def _scaled(rough: Any, name: str, value: float) -> Any:
    """Return random roughness with a given rms slope, height or curvature.

    With ``normalise = "ensemble"`` height and curvature are root mean squares over all
    seeds, as without random amplitudes.
    """
    if name == "rms_slope":
        return replace(rough, rms_slope=value)
    random = rough.random_amplitudes and rough.normalise == "realisation"
    statistics = replace(rough, random_amplitudes=random).statistics()
    return replace(rough, rms_slope=rough.rms_slope * value / getattr(statistics, name))


class TipRoughnessConfig(RoughnessConfig):
    """``[tip.roughness]``: roughness of the indenter, as in ``[roughness]``."""

    title = "tip.roughness"


class SubstrateRoughnessConfig(RoughnessConfig):
    """``[substrate.roughness]``: roughness of the substrate, as in ``[roughness]``.

    Heights are positive out of the substrate. The seed is another one than of a tip
    with the same number, so that both surfaces are independent.
    """

    title = "substrate.roughness"

    def surface(self, spacing: float) -> Inverted:
        """Return the roughness as the lower side of an indenter (Å)."""
        seed = integer("seed", self.seed, least=0) + SUBSTRATE_SEED
        heights = RoughnessConfig.surface(replace(self, seed=seed), spacing)
        return Inverted(heights)


@dataclass(frozen=True)
class HeterogeneityConfig(RandomFieldConfig):
    """``[heterogeneity]``: a local work of adhesion.

    A random field with root mean square `rms`, or the map of a file.
    """

    title = "heterogeneity"
    file_keys = ("file",)
    length_keys = (*LENGTH_KEYS, "spacing")

    long_wavelength: float | str = "32 a0"
    rms: float | None = None
    file: str = ""
    spacing: float | str = "1 a0"
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
    unit, units = section.unit or "a0", lengths(spacing)
    scale = units[unit]
    _check_order(section, LENGTH_KEYS, units)
    section = section.plain(["direction"], ANGLES, "deg")
    entries = section.plain(LENGTH_KEYS, units, unit).entries()
    names = entries.keys() & {each.name for each in fields(SelfAffine)} - more.keys()
    rough = SelfAffine(**{name: entries[name] for name in names}, **more)
    least = least_domain / scale
    entries["domain"] = _domain(rough, spacing / scale, unit, least=least)
    in_angstrom = {key: entries[key] * scale for key in LENGTH_KEYS if entries[key]}
    return replace(rough, **in_angstrom)


def _check_order(
    section: RandomFieldConfig, keys: Iterable[str], units: Mapping[str, float]
) -> None:
    """Raise `ValueError` unless lengths increase in the order of their keys.

    Both lengths are shown in the unit of the length that is too small.
    """
    usual = section.unit or "a0"
    plain = section.plain(keys, units, "Å", usual)
    given = {key: getattr(plain, key) for key in keys if getattr(plain, key)}
    for shorter, longer in pairwise(given):
        if 0.0 < given[longer] < given[shorter] * (1 - LENGTH_ROUNDING):
            found = QUANTITY.fullmatch(str(getattr(section, longer)))
            unit = found[2] if found else usual
            least, length = (given[key] / units[unit] for key in (shorter, longer))
            raise ValueError(
                f"{longer} must be at least {shorter} = {least:.4g} {unit}, got "
                f"{length:.4g} {unit}"
            )


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


def _domain(
    rough: RandomWaves,
    spacing: float,
    unit: str,
    units: Mapping[str, float] | None = None,
    least: float = 0.0,
) -> float | None:
    """Return the domain: the given one, or a whole number of spacings.

    `spacing` and `least` are in a unit; `units` has its value if the roughness is in Å.
    """
    scale = units[unit] if units else 1.0
    shortest, side = rough.band[0] / scale, rough.side / scale
    if shortest < (2.0 - RATIO_ROUNDING) * spacing:
        raise ValueError(
            f"short_wavelength must be at least {2 * spacing:.4g} {unit}, two spacings "
            f"of the atoms, got {shortest:g} {unit}"
        )
    ratio = side / spacing
    if rough.domain is None and least > side:
        ratio *= 2 ** math.ceil(math.log2(least / side))
        return next_fast_len(math.ceil(ratio - RATIO_ROUNDING)) * spacing * scale
    if abs(ratio - round(ratio)) <= RATIO_ROUNDING:
        return rough.domain
    points = math.ceil(ratio)
    if rough.domain is not None:
        raise ValueError(
            f"domain must be a multiple of the spacing, {spacing:.4g} {unit}, got "
            f'{side:g} {unit}: give "{points} a0"'
        )
    return next_fast_len(points) * spacing * scale
