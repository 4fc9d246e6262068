"""Map of a contact: pressure, contact and gap on a rectangle of lattice sites."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from ase import Atoms
from ase.units import GPa

from ase_roughcontact.checks import FloatArray, finite_array, positive, surface, window
from ase_roughcontact.substrate import TAG_CONTACT, snapshot
from ase_roughcontact.topography import Surface

# Lateral positions may be off the sites of the lattice by this part of the spacing.
_OFF_SITE = 1e-3


@dataclass(frozen=True)
class ContactMap:
    """Pressure and contact on a rectangle of lattice sites.

    Attributes
    ----------
    pressure : ndarray, shape (n, m)
        Positive where the wall repels, zero at sites without an atom (eV/Å^3).
    contact : ndarray of bool, shape (n, m)
        Which atoms feel a repulsive force.
    spacing : float
        Distance of neighbouring sites (Å).
    origin : (float, float)
        Position of site (0, 0) relative to the indenter's axis (Å).
    periodic : bool
        Whether the map repeats. Else all sites beyond it are open.
    gap : ndarray, shape (n, m), optional
        Distance to the indenter, nan at sites without an atom (Å).

    Raises
    ------
    ValueError
        If arrays are not two-dimensional and of one shape, the mask is not of bools,
        a pressure is not finite, or the spacing is not positive.
    """

    pressure: np.ndarray
    contact: np.ndarray
    spacing: float
    origin: tuple[float, float]
    periodic: bool
    gap: np.ndarray | None = None

    def __post_init__(self) -> None:
        """Check the fields."""
        finite_array("pressure", self.pressure)
        window(self.pressure.shape, self.spacing, self.origin)
        if self.contact.dtype != bool:
            raise ValueError(f"contact must be bools, got {self.contact.dtype}")
        for name, field in (("contact", self.contact), ("gap", self.gap)):
            if field is not None and field.shape != self.pressure.shape:
                raise ValueError(
                    f"{name} must have the shape {self.pressure.shape} of the "
                    f"pressure, got {field.shape}"
                )

    @classmethod
    def from_frame(
        cls,
        frame: Atoms,
        spacing: float | None = None,
        indenter: Surface | None = None,
    ) -> ContactMap:
        """Map of a frame of a trajectory.

        Parameters
        ----------
        frame : Atoms
            As `snapshot` made it, also read back from a file. The atoms may be any
            sites of a square lattice.
        spacing : float, optional
            Distance of neighbouring sites (Å); by default the smallest distance of two
            rows or columns of atoms.
        indenter : Surface, optional
            The frame's indenter, from whose heights the gap follows.

        Returns
        -------
        ContactMap
            With `gap` if the indenter is given.

        Raises
        ------
        ValueError
            If the frame was not made by `snapshot`, its atoms are not on different
            sites of a lattice, or a periodic cell is not full.
        """
        if not frame.has("initial_charges") or frame.numbers[-1] != 0:
            raise ValueError(
                "the frame has no pressures, or its last atom is not the indenter "
                "(symbol X): it was not made by snapshot()"
            )
        tags, pressure = frame.get_tags()[:-1], frame.get_initial_charges()[:-1] * GPa
        lattice = _Lattice.of(frame, spacing)
        gap = None if indenter is None else lattice.gap(frame, indenter)
        return lattice.map(pressure, tags == TAG_CONTACT, gap)

    @classmethod
    def from_atoms(cls, atoms: Atoms, spacing: float | None = None) -> ContactMap:
        """Map of atoms as they are.

        Parameters
        ----------
        atoms : Atoms
            With a `RoughContact` calculator.
        spacing : float, optional
            As in `from_frame` (Å).

        Returns
        -------
        ContactMap
            With `gap`.

        Raises
        ------
        ValueError
            If the atoms have no `RoughContact` calculator, or are not on a lattice.
        """
        lattice = _Lattice.of(snapshot(atoms), spacing)
        state = atoms.calc.state(atoms)
        return lattice.map(
            state.pressure.ravel(), state.contact.ravel(), state.gap.ravel()
        )

    @property
    def x(self) -> np.ndarray:
        """Positions of the rows relative to the indenter's axis, shape (n,) (Å)."""
        return self.origin[0] + self.spacing * np.arange(self.contact.shape[0])

    @property
    def y(self) -> np.ndarray:
        """Positions of the columns relative to the indenter's axis, shape (m,) (Å)."""
        return self.origin[1] + self.spacing * np.arange(self.contact.shape[1])

    @property
    def distance(self) -> FloatArray:
        """Distance from the (nearest) indenter's axis, shape (n, m) (Å)."""
        x, y = self.x, self.y
        if self.periodic:
            x, y = (nearest_image(c, len(c) * self.spacing) for c in (x, y))
        return np.hypot(x[:, None], y)

    @property
    def cell_area(self) -> float:
        """Area of a site (Å^2)."""
        return self.spacing**2

    @property
    def normal_force(self) -> float:
        """Sum of the pressures times the area of a site (eV/Å)."""
        return float(self.pressure.sum() * self.cell_area)

    @property
    def contact_area(self) -> float:
        """Number of atoms in contact times the area of a site (Å^2)."""
        return float(np.count_nonzero(self.contact) * self.cell_area)


@dataclass(frozen=True)
class _Lattice:
    """Sites of the atoms of a frame, within their bounding box."""

    sites: tuple[np.ndarray, np.ndarray]
    shape: tuple[int, int]
    spacing: float
    origin: tuple[float, float]
    periodic: bool

    @classmethod
    def of(cls, frame: Atoms, spacing: float | None) -> _Lattice:
        xy = frame.positions[:-1, :2]
        a0 = _spacing_of(xy) if spacing is None else spacing
        positive(spacing=a0)
        steps = (xy - xy.min(axis=0)) / a0
        sites = np.rint(steps).astype(int)
        off = float(np.abs(steps - sites).max())
        n, m = (int(last) + 1 for last in sites.max(axis=0))
        if off > _OFF_SITE:
            raise ValueError(
                f"atoms are off a square lattice of spacing {a0:g} by up to {off:.3g} "
                "spacings: give the right spacing, and atoms that move along z only"
            )
        if np.bincount(sites[:, 0] * m + sites[:, 1]).max() > 1:
            raise ValueError("several atoms are on one site of the lattice")
        full = np.diag(frame.cell.array)[:2] / a0
        if frame.pbc[:2].any() and (
            not frame.pbc[:2].all()
            or len(sites) != n * m
            or np.abs(full - (n, m)).max() > 0.5
        ):
            raise ValueError(
                "a periodic half space must be periodic along x and y and have an atom "
                f"at all sites of its cell, got pbc {frame.pbc.tolist()} and "
                f"{len(sites)} atoms for {full.tolist()} spacings"
            )
        x, y = xy.min(axis=0) - frame.positions[-1, :2]
        return cls(
            (sites[:, 0], sites[:, 1]),
            (n, m),
            float(a0),
            (float(x), float(y)),
            bool(frame.pbc[0]),
        )

    def gap(self, frame: Atoms, indenter: Surface) -> FloatArray:
        """Gap of the atoms."""
        surface(indenter=indenter)
        heights = indenter.heights(self.shape, self.spacing, self.origin)[self.sites]
        u = frame.positions[:-1, 2]
        return frame.positions[-1, 2] + heights - (u - u.mean() * self.periodic)

    def map(
        self, pressure: np.ndarray, contact: np.ndarray, gap: np.ndarray | None
    ) -> ContactMap:
        """Map of values of the atoms."""
        return ContactMap(
            pressure=self._filled(pressure, 0.0),
            contact=self._filled(contact, False),
            spacing=self.spacing,
            origin=self.origin,
            periodic=self.periodic,
            gap=None if gap is None else self._filled(gap, np.nan),
        )

    def _filled(self, values: np.ndarray, elsewhere: float) -> np.ndarray:
        field = np.full(self.shape, elsewhere, dtype=values.dtype)
        field[self.sites] = values
        return field


def _spacing_of(xy: np.ndarray) -> float:
    """Smallest distance of two rows or columns, sharpened by the whole extent."""
    steps = np.diff(np.sort(xy, axis=0), axis=0)
    extent = float(np.ptp(xy, axis=0).max())
    if not extent > 0.0:
        raise ValueError("one atom does not tell the spacing: give spacing=")
    # what is smaller is rounding of the positions
    smallest = steps[steps > _OFF_SITE * steps.max()].min()
    return extent / round(extent / smallest)


def nearest_image(values: FloatArray, period: float | FloatArray) -> FloatArray:
    """Image of a place in a periodic cell that is nearest to the axis.

    Parameters
    ----------
    values : ndarray
        Places relative to the axis (length).
    period : float or ndarray
        Of the cell (length).

    Returns
    -------
    ndarray
        Between -period/2 and period/2.
    """
    return values - period * np.floor(values / period + 0.5)
