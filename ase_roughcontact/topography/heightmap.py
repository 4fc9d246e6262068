"""Height maps, such as measured topographies."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ase_roughcontact._util.identity import digest
from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.validation import (
    FloatArray,
    Point,
    Shape,
    boolean,
    height_array,
    integer,
    nonnegative,
    window,
)
from ase_roughcontact.topography.interpolation import (
    interpolated,
    spline_coefficients,
)
from ase_roughcontact.topography.measurement import Measurement, ScanWarning
from ase_roughcontact.topography.pressed_scan import highest, pressed_scan
from ase_roughcontact.topography.realisation import realised_heights
from ase_roughcontact.topography.scan import Length, position, scan_in_angstrom
from ase_roughcontact.topography.self_affine_fit import SelfAffineFit
from ase_roughcontact.topography.spectrum import (
    Statistics,
    axis_spacings,
    has_edge_step,
    power_spectrum,
    pressed_statistics,
    smooth_component,
)
from ase_roughcontact.topography.tip_fit import TipFit
from ase_roughcontact.topography.topography import Topography

# Distance, in steps of the map, of the farthest coefficient that contributes to the
# spline at a place, also near an edge.
_SPLINE_SUPPORT = 4


class HeightMap(Topography):
    """Surface given by its heights on a grid.

    Between the points of the map heights are interpolated by a cubic spline, with
    not-a-knot or periodic boundary conditions. The map is the lower side of an
    indenter: its lowest points touch first. In scans of a microscope the highest points
    touch first; they are converted by `from_topography`.

    Parameters
    ----------
    heights : array_like, shape (n, m)
        Heights, positive upward, away from the substrate (length).
    spacing : float or (float, float)
        Distance between the points of the map, or one each along x and y (length).
    periodic : bool
        Whether the map is periodic, with the periods n and m times the spacing.
    center : (float, float), optional
        Position (x, y) on the axis of the indenter, counted from element (0, 0)
        (length). By default the position of element (n//2, m//2).

    Attributes
    ----------
    measurement : Measurement or None
        Noise, missing points and outliers of a scan, see `from_topography`.

    Raises
    ------
    ValueError
        If the heights are not a real, finite, two-dimensional array, the spacing is
        not positive, or the center is not on the map.

    Examples
    --------
    >>> import numpy as np
    >>> from ase_roughcontact import HeightMap, RoughSphere
    >>> heights = 0.1 * np.cos(np.arange(32.0))[:, None] * np.ones(32)  # lower side, Å
    >>> tip = RoughSphere(radius=100.0, roughness=HeightMap(heights, spacing=2.0))
    >>> tip.heights((4, 4), spacing=2.0).shape
    (4, 4)
    """

    def __init__(
        self,
        heights: ArrayLike,
        spacing: float | Point,
        periodic: bool = False,
        center: Point | None = None,
    ) -> None:
        boolean(periodic=periodic)
        self._values = height_array(heights)
        self.spacing = axis_spacings(spacing)
        self.periodic = bool(periodic)
        self.measurement: Measurement | None = None
        middle = [n // 2 * step for n, step in self._axes]
        x, y = middle if center is None else position(center, 1.0)
        self.center = float(x), float(y)
        for name, place, (n, step) in zip("xy", self.center, self._axes, strict=True):
            last = n if self.periodic else n - 1
            if not (-LENGTH_ROUNDING <= place / step <= last + LENGTH_ROUNDING):
                raise ValueError(
                    f"center must be on the map, which spans {name} = 0 to "
                    f"{last * step:g}, got {place:g}"
                )

    @classmethod
    def from_topography(
        cls,
        topography: Any,
        role: str,
        *,
        spacing: Length | tuple[Length, Length] | None = None,
        unit: str | None = None,
        detrend: str | None = None,
        center: str | tuple[Length, Length] = "middle",
        margin: Length = 0.0,
        periodic: bool | None = None,
        channel: int | str | None = None,
        transpose: bool = False,
        noise: Length | None = None,
        cutoff_wavelength: Length = 0.0,
        remove_outliers: bool = False,
        remove_bad_lines: bool = False,
        extrude: bool = False,
    ) -> HeightMap:
        """Return the lower side of an indenter for a scan of a surface.

        Missing points, which are masked or NaN, are interpolated. Lengths are numbers
        or strings with a unit, such as ``"20 nm"``.

        Parameters
        ----------
        topography : path, array_like or SurfaceTopography object
            The scan, with heights that are positive outside of the body, as microscopes
            show them: its highest points touch first. The first index of an array is
            along x. Of text files with a matrix each line is a line of the scan
            (constant y); see `scan_text`. Other formats are read by the package
            SurfaceTopography.
        role : {"indenter", "substrate"}
            Scanned body. A substrate stays in place, ``h(x, y) = -z(x, y)``.
            An indenter is turned over around the y axis of the scan, ``h(x, y) =
            -z(-x, y)``.
        spacing : float or (float, float), optional
            Distance between points, or one each along x and y (`unit`). Required for
            arrays and files that do not contain it.
        unit : str, optional
            Unit of all lengths: m, mm, µm, nm, Å, A or pm. By default the unit of the
            scan. It is also the unit of a scan that has none; of an array by default Å.
        detrend : {"plane", "mean", "curvature", "lines", "medians", "none"}
            Subtracted trend: the plane that fits best, the mean, a polynomial of
            second degree in x and y, a straight line from each line of the scan
            (drift), or offsets of lines by the medians of the steps between them, and a
            plane. By default the plane; of a periodic scan, which has no tilt, the
            mean. Missing points and removed points do not count.
        center : {"middle", "highest"} or (float, float)
            Place on the axis of the indenter: the middle of the scan, its highest point
            after detrending, or a position (x, y) from its first point (`unit`).
        margin : float
            Distance from the edges of the scan within which no highest point is sought,
            for `center` and for the apex of a tip (`unit`).
        periodic : bool, optional
            Whether the scan is periodic; by default whether the object says so.
        channel : int or str, optional
            Number (from 0) or name of the channel of a file with several; by default
            the only one that is a height.
        transpose : bool
            Whether the indices of an array, or of the matrix in a file, are exchanged
            before anything else: the first index of ``.npy`` is then along y.
        noise : float, optional
            Standard deviation of the heights by noise (`unit`). By default it is
            estimated, with the noise of the offsets of lines; see `Noise`.
        cutoff_wavelength : float
            Cutoff of a Gaussian low-pass filter (`unit`), which halves waves of this
            length (ISO 16610-61); zero for none.
        remove_outliers : bool
            Whether single points that are outliers are interpolated.
        remove_bad_lines : bool
            Whether lines that were not recorded, that repeat the one before or are
            offset from both neighbours, and scars are interpolated, and the rest of a
            scan that was aborted is left out; see `bad_lines`. Places are then counted
            from the first line that is left.
        extrude : bool
            Whether the file is a line profile along x, of a surface with the same
            heights at all y: long ridges, in two-dimensional contact. Noise of the
            profile is part of it.

        Returns
        -------
        HeightMap
            The lower side of the indenter, with lengths in Å.

        Raises
        ------
        ValueError
            If the scan can't be read, its spacing or unit are not known, all its points
            are missing, or a parameter is not valid.
        ImportError
            If the format needs SurfaceTopography, which is not installed.

        Warns
        -----
        ScanWarning
            If lines of the scan are bad and are not removed, or heights are clipped.

        Notes
        -----
        Errors of the steps of a scene include the errors by the scan; see
        `ase_roughcontact.results.scan_errors`. Errors of `load_path` do not.

        Examples
        --------
        A bump of a substrate, 3 nm high, is pressed first:

        >>> import numpy as np
        >>> x, y = np.ogrid[:7, :9]
        >>> scan = 3.0 - 0.1 * ((x - 2) ** 2 + (y - 6) ** 2)
        >>> bump = HeightMap.from_topography(
        ...     scan, "substrate", spacing=1.0, unit="nm", detrend="none",
        ...     center="highest")
        >>> bump.center, float(bump.heights((1, 1), 1.0)[0, 0])
        ((20.0, 60.0), -30.0)
        """
        scan, factor = scan_in_angstrom(
            topography,
            spacing=spacing,
            unit=unit,
            channel=channel,
            transpose=transpose,
            extrude=extrude,
        )
        if extrude:
            if noise is not None:
                raise ValueError("noise of an extruded profile can't be given")
            noise = 0.0
        measured, place = pressed_scan(
            scan,
            role,
            factor,
            detrend=detrend,
            center=center,
            margin=margin,
            periodic=periodic,
            noise=noise,
            cutoff_wavelength=cutoff_wavelength,
            remove_outliers=remove_outliers,
            remove_bad_lines=remove_bad_lines,
        )
        for doubt in measured.doubts:
            warnings.warn(doubt, ScanWarning, stacklevel=2)
        surface = cls(measured.pressed, measured.spacing, measured.periodic, place)
        surface.measurement = measured
        return surface

    def copies(self) -> dict[str, list[HeightMap]]:
        """Return copies of a scan that show its errors; see `Measurement.copies`."""
        groups = self.measurement.copies() if self.measurement else {}
        return {
            kind: [self._copy(each) for each in group] for kind, group in groups.items()
        }

    def _copy(self, measured: Measurement) -> HeightMap:
        """Return the map of another measurement, with the same place on the axis."""
        return HeightMap(measured.pressed, measured.spacing, self.periodic, self.center)

    @property
    def pixel(self) -> float:
        """Distance between the points of a scan; NaN for any other map (length)."""
        return max(self.spacing) if self.measurement else math.nan

    @property
    def shape(self) -> Shape:
        """Number of points along x and y."""
        n, m = self._values.shape
        return n, m

    def heights(
        self, shape: Shape, spacing: float, origin: Point = (0.0, 0.0)
    ) -> FloatArray:
        """Sample the map on a grid around its center; see `Surface.heights`.

        The spacing of the grid may differ from the spacing of the map.

        Raises
        ------
        ValueError
            If the window extends beyond the map, or exceeds its period.
        """
        shape, spacing, origin = window(shape, spacing, origin)
        values = self._values
        for axis in (0, 1):
            places = origin[axis] + spacing * np.arange(shape[axis])
            self._check(axis, places, spacing)
            indices = (places + self.center[axis]) / self.spacing[axis]
            values = interpolated(values, indices, axis, self.periodic)
        return np.ascontiguousarray(values)

    @property
    def _axes(self) -> tuple[tuple[int, float], tuple[int, float]]:
        """Number of points and their distance along x and y."""
        (n, m), (x, y) = self.shape, self.spacing
        return (n, x), (m, y)

    @property
    def periods(self) -> Point:
        """Periods along x and y; infinity unless the map is periodic (length)."""
        x, y = (n * step if self.periodic else math.inf for n, step in self._axes)
        return x, y

    @property
    def extent(self) -> float:
        """Distance from the axis up to which heights are known; half of a period."""
        sides = [n * step for n, step in self._axes]
        if self.periodic:
            return min(sides) / 2
        ends = zip(self.center, sides, self.spacing, strict=True)
        return min(min(x, side - step - x) for x, side, step in ends)

    @property
    def middle_extent(self) -> float:
        """The extent if the middle of the map is on the axis (length)."""
        return min((n - 1) // 2 * step for n, step in self._axes)

    @property
    def repeats(self) -> bool:
        """Whether the map is periodic."""
        return self.periodic

    def lowest(self, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return a lower bound of the heights on a grid.

        It is the lowest height of the map if all grid points are points of the map,
        else the lowest B-spline coefficient, a lower bound of the spline (length).
        `origin` is the position of a grid point relative to `center`.
        """
        offset = np.add(origin, self.center)
        steps = np.array([[spacing, spacing], offset]) / self.spacing
        if np.abs(steps - np.rint(steps)).max() <= LENGTH_ROUNDING:
            return float(self._values.min())
        return float(self._coefficients.min())

    def reach(self, level: float, spacing: float, origin: Point = (0.0, 0.0)) -> float:
        """Return an upper bound, from the spline; see `BoundedSurface.reach`.

        Raises
        ------
        ValueError
            If the map is periodic.
        """
        if self.periodic:
            raise ValueError(
                "automatic windows need a sphere of finite radius, or the scan of a "
                f"whole tip, got {self!r}: choose a fixed window"
            )
        low = self._coefficients < level
        if not low.any():
            return 0.0
        distances = []
        for middle, (n, step) in zip(self.center, self._axes, strict=True):
            inside = np.abs(np.arange(n) * step - middle)
            distances.append(inside + _SPLINE_SUPPORT * step)
        x, y = distances
        return float(np.hypot(x[:, None], y[None, :])[low].max())

    @cached_property
    def tip(self) -> TipFit:
        """Paraboloid around the lowest point of the map, with the margin of a scan."""
        margin = self.measurement.margin if self.measurement else 0.0
        return TipFit.of(self._values, self.spacing, margin)

    @property
    def turned(self) -> HeightMap:
        """The same map with the heights reversed."""
        return HeightMap(-self._values, self.spacing, self.periodic)

    @cached_property
    def _coefficients(self) -> FloatArray:
        """Coefficients of the B-splines, between which the spline is everywhere."""
        return spline_coefficients(self._values, self.periodic)

    def centered(self, center: Point) -> HeightMap:
        """Return the same map with another place on the axis; see `HeightMap`."""
        other = HeightMap(self._values, self.spacing, self.periodic, center)
        other.measurement = self.measurement
        return other

    def made_periodic(self, strain: float = 0.0) -> HeightMap:
        """Return the map without steps between opposite edges, its middle on the axis.

        A `smooth_component` is subtracted, unless the map is periodic. Distances along
        y are increased by a relative strain; see `SquareGrid`.
        """
        spacing = self.spacing[0], self.spacing[1] * (1.0 + strain)
        measured = self.measurement
        heights = self._values if measured is None else measured.heights
        smooth = 0.0 if self.periodic else smooth_component(heights)
        heights = heights - smooth
        if measured is not None:
            measured = replace(
                measured,
                heights=heights,
                spacing=spacing,
                periodic=True,
                strain=strain,
            )
            heights = measured.pressed  # as the filter goes on over the edges
        found = HeightMap(heights, spacing, periodic=True)
        found.measurement, found.edge_change = measured, float(np.std(smooth))
        return found

    def realisation(self, seed: int) -> HeightMap:
        """Return another random surface like this one, which is periodic.

        Each wave has the amplitude of the map, or, if the map is not periodic, of the
        map without the steps between its edges (`made_periodic`), and another phase.
        The distribution of heights is about the same, also where it is not Gaussian.

        Parameters
        ----------
        seed : int
            Seed of the random numbers, not negative.

        Returns
        -------
        HeightMap
            Map of the same size, with the same place on the axis. It is a function of
            the map and the seed alone. Of a scan noise and filter are kept.

        References
        ----------
        T. Schreiber, A. Schmitz, Phys. Rev. Lett. 77, 635 (1996): amplitudes and
        heights are adjusted in turn, amplitudes last. F. Pérez-Ràfols, A. Almqvist,
        Tribol. Int. 131, 591 (2019).

        Examples
        --------
        >>> import numpy as np
        >>> heights = np.random.default_rng(0).exponential(size=(32, 32))
        >>> scan = HeightMap(heights, spacing=1.0, periodic=True)
        >>> other = scan.realisation(seed=1)
        >>> bool(np.isclose(other.statistics().rms_height, heights.std()))
        True
        """
        seed = integer("seed", seed, 0)
        periodic = self.made_periodic()
        measured = periodic.measurement
        heights = periodic._values if measured is None else measured.heights
        heights = realised_heights(heights, seed)
        if measured is not None:
            measured = replace(measured, heights=heights)
            heights = measured.pressed
        found = HeightMap(heights, self.spacing, True, self.center)
        found.measurement = measured
        return found

    @property
    def lowest_place(self) -> Point:
        """Position (x, y) of the lowest point, from element (0, 0) (length)."""
        return highest(-self._values, self.spacing, 0.0)

    def places(
        self, n: int, m: int, margin: float = 0.0
    ) -> tuple[FloatArray, FloatArray]:
        """Return a grid of n x m places on the map, for `centered`.

        Positions x and y, shapes (n,) and (m,), are counted from element (0, 0), and
        the outer places are a margin from the edges of the map (length).

        Raises
        ------
        ValueError
            If the margin leaves no places.
        """
        nonnegative(margin=margin)
        ends = [(count - 1) * step - margin for count, step in self._axes]
        if min(ends) < margin:
            raise ValueError(
                f"a margin of {margin / 10:g} nm leaves no places on the scan, which "
                f"spans {(min(ends) + margin) / 10:g} nm: give a smaller one"
            )
        x = np.linspace(margin, ends[0], integer("number of places", n, 1))
        y = np.linspace(margin, ends[1], integer("number of places", m, 1))
        return x, y

    @property
    def mean_height(self) -> float:
        """Mean of the heights of the map (length)."""
        return float(self._values.mean())

    def statistics(self) -> Statistics:
        """Return the rms height, slope and curvature as they are pressed.

        See `pressed_statistics`. For the measured points alone see
        `spectrum.statistics`.
        """
        return self._statistics

    @cached_property
    def _statistics(self) -> Statistics:
        if self.measurement is not None:
            return self.measurement.statistics
        return pressed_statistics(self._values, self.spacing, self.periodic)

    def power_spectrum(self) -> tuple[FloatArray, FloatArray]:
        """Return q and C(q), radially averaged; see `spectrum.power_spectrum`."""
        seamless = self.periodic and not has_edge_step(self._values)
        return power_spectrum(self._values, self.spacing, seamless)

    @cached_property
    def self_affine(self) -> SelfAffineFit:
        """Self-affine roughness with the statistics of the map, for theory."""
        longest = max(n * step for n, step in self._axes)
        return SelfAffineFit.of(self.statistics(), *self.power_spectrum(), longest)

    @property
    def rms_slope(self) -> float:
        """Rms slope of the map."""
        return self.self_affine.rms_slope

    @property
    def hurst(self) -> float:
        """Hurst exponent; see `self_affine`."""
        return self.self_affine.hurst

    @property
    def short_wavelength(self) -> float:
        """Shortest wavelength (length); see `self_affine`. NaN if the map is flat."""
        constant = np.ptp(self._values) == 0.0
        return math.nan if constant else self.self_affine.short_wavelength

    @property
    def shortest_wavelength(self) -> float:
        """Shortest wavelength (length); see `short_wavelength`."""
        return self.short_wavelength

    @property
    def long_wavelength(self) -> float:
        """Upper end of the self-affine range (length); see `self_affine`."""
        return self.self_affine.long_wavelength

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, with a digest instead of the heights."""
        return {
            "name": "HeightMap",
            "shape": self._values.shape,
            "spacing": self.spacing,
            "periodic": self.periodic,
            "center": self.center,
            "sha256": self._digest,
        }

    @cached_property
    def _digest(self) -> str:
        return digest(self._values.tobytes())

    def __repr__(self) -> str:
        """Return shape, spacing and periodicity."""
        (n, m), (x, y) = self.shape, self.spacing
        spacing = f"{x:g}" if x == y else f"({x:g}, {y:g})"
        return f"HeightMap({n} x {m}, {spacing}, periodic={self.periodic})"

    def __eq__(self, other: object) -> bool:
        """Return whether two maps describe the same surface."""
        return isinstance(other, HeightMap) and self.todict() == other.todict()

    def __hash__(self) -> int:
        """Return a hash of the heights."""
        return hash(self._digest)

    def _check(self, axis: int, places: NDArray[Any], step: float) -> None:
        """Raise `ValueError` unless a window lies on the map, or within its period."""
        name, (n, own_step) = "xy"[axis], self._axes[axis]
        extent, period = len(places) * step, n * own_step
        if self.periodic and extent > period * (1 + LENGTH_ROUNDING):
            raise ValueError(
                f"a window of {extent:g} along {name} exceeds the period {period:g} of "
                "the map, so that it would be repeated: choose a smaller window"
            )
        left = 0.0 - self.center[axis]
        right = left + period - own_step
        outside = max(left - places[0], places[-1] - right)
        if not self.periodic and outside > LENGTH_ROUNDING * own_step:
            raise ValueError(
                f"the window spans {name} = {places[0]:g} to {places[-1]:g}, but the "
                f"map only {left:g} to {right:g}: choose a smaller window, or a center "
                "further inside (margin)"
            )
