"""Map of a contact: pressure, contact and gap on a rectangle of lattice sites."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from ase import Atoms

from ase_roughcontact._util.summary import Summarized, short_text
from ase_roughcontact._util.validation import FloatArray, finite_array, window
from ase_roughcontact.atoms.grid import SurfaceGrid, surface_above
from ase_roughcontact.atoms.history import history_of
from ase_roughcontact.atoms.info import INDENTED, TOUCHING, field_of, info_of
from ase_roughcontact.atoms.snapshot import pressure_of, snapshot
from ase_roughcontact.contact.state import LATERAL, PLASTIC_DEPTH
from ase_roughcontact.interactions import SLIP, SLIP_RATES, STATE
from ase_roughcontact.topography import Surface

#: Names of the fields of friction.
LATERAL_FIELDS = (*LATERAL, SLIP.name, STATE.name, *SLIP_RATES)


@dataclass(frozen=True, eq=False)
class ContactMap(Summarized):
    """Pressure and contact on a rectangle of lattice sites.

    Attributes
    ----------
    pressure : ndarray, shape (n, m)
        Pressures, positive where the wall repels, zero at sites without an atom
        (eV/Å^3).
    contact : ndarray of bool, shape (n, m)
        Whether a repulsive force acts on each atom.
    spacing : float
        Distance of neighbouring sites (Å).
    origin : (float, float)
        Position of site (0, 0) relative to the indenter's axis (Å).
    periodic : bool
        Whether the map repeats; otherwise there is no contact outside of it.
    gap : ndarray, shape (n, m), optional
        Distance to the indenter, NaN at sites without an atom (Å).
    displacement : ndarray, shape (n, m), optional
        Elastic displacement of the surface, positive upward (Å).
    plastic_depth : ndarray, shape (n, m), optional
        Depth by which the surface has flowed (Å).
    lateral : dict of ndarray, shape (n, m)
        Tractions of friction ``traction_x`` and ``traction_y`` on the surface (eV/Å^3),
        lateral displacements ``displacement_x`` and ``displacement_y`` of the surface
        (Å), whether each atom slips, ``slipping`` (1 or 0), and the way that it has
        slipped, ``slip`` (Å), if friction depends on it; ``friction_state``, and slip
        rates ``slip_rate_x`` and ``slip_rate_y`` (Å/s), if friction depends on them.
        Empty without friction.

    Raises
    ------
    ValueError
        If arrays are not two-dimensional and of one shape, `contact` is not of bools, a
        pressure is not finite, or the spacing is not positive.

    Examples
    --------
    >>> from ase_roughcontact import RoughContact, RoughSphere, load_path, substrate
    >>> from ase_roughcontact.analysis import ContactMap
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.9)
    >>> (step,) = load_path(atoms, penetrations=[0.5])
    >>> contact_map = ContactMap.from_atoms(atoms)
    >>> contact_map.pressure.shape
    (16, 16)
    >>> int(contact_map.contact.sum()) == step.repulsive_atoms
    True
    """

    pressure: np.ndarray
    contact: np.ndarray
    spacing: float
    origin: tuple[float, float]
    periodic: bool
    gap: np.ndarray | None = None
    displacement: np.ndarray | None = None
    plastic_depth: np.ndarray | None = None
    lateral: dict[str, np.ndarray] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the fields."""
        finite_array("pressure", self.pressure)
        window(self.pressure.shape, self.spacing, self.origin)
        if self.contact.dtype != bool:
            raise ValueError(f"contact must be bools, got {self.contact.dtype}")
        for name in ("contact", "gap", "displacement", "plastic_depth"):
            values = getattr(self, name)
            if np.ma.is_masked(values):
                raise ValueError(f"{name} has masked points: fill them")
            if values is not None and values.shape != self.pressure.shape:
                raise ValueError(
                    f"{name} must have the shape {self.pressure.shape} of the "
                    f"pressure, got {values.shape}"
                )

    def _summary(self) -> dict[str, str]:
        """Return size, force and area, and the names of the fields."""
        n, m = self.pressure.shape
        names = "gap", "displacement", "plastic_depth"
        given = [name for name in names if getattr(self, name) is not None]
        return {
            "sites": f"{n} x {m}",
            "spacing": short_text(self.spacing, "Å"),
            "periodic": str(self.periodic),
            "normal_force": short_text(self.normal_force, "eV/Å"),
            "contact_area": short_text(self.contact_area, "Å^2"),
            "fields": " ".join(["pressure", "contact", *given, *self.lateral]),
        }

    @classmethod
    def from_frame(cls, frame: Atoms, indenter: Surface | None = None) -> ContactMap:
        """Return the map of a frame of a trajectory.

        Parameters
        ----------
        frame : Atoms
            Frame from `snapshot`, which may have been read from a file.
        indenter : Surface, optional
            Indenter of the frame, required for the gap.

        Returns
        -------
        ContactMap
            Map of the frame, with `gap` if the indenter is given.

        Raises
        ------
        ValueError
            If the frame was not made by `snapshot`.
        """
        grid, info = SurfaceGrid.of(frame), info_of(frame)
        pressure, history = pressure_of(frame), history_of(frame, grid)
        touching = depth = None
        if TOUCHING in info:
            touching = field_of(frame, TOUCHING, grid.window)
        if PLASTIC_DEPTH in info:
            depth = field_of(frame, PLASTIC_DEPTH, grid.window)
        displacement = frame.positions[:-1, 2].reshape(grid.window)
        gap = None
        if indenter is not None:
            gap = surface_above(frame, grid, indenter) - displacement
            if depth is not None and info.get(INDENTED):
                gap += depth
        return cls(
            pressure=pressure,
            contact=(pressure if touching is None else touching) > 0.0,
            spacing=grid.spacing,
            origin=grid.origin,
            periodic=grid.periodic,
            gap=gap,
            displacement=displacement,
            plastic_depth=depth if depth is not None and depth.any() else None,
            lateral={key: history[key] for key in LATERAL_FIELDS if key in history},
        )

    @classmethod
    def from_atoms(cls, atoms: Atoms) -> ContactMap:
        """Return the map of atoms with a calculator.

        Parameters
        ----------
        atoms : Atoms
            Atoms with a `RoughContact` calculator.

        Returns
        -------
        ContactMap
            Map of the atoms, with `gap`.

        Raises
        ------
        ValueError
            If the atoms have no `RoughContact` calculator.
        """
        frame = snapshot(atoms)
        return replace(cls.from_frame(frame), gap=atoms.calc.state(atoms).gap)

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


def nearest_image(values: FloatArray, period: float | FloatArray) -> FloatArray:
    """Return the periodic images of coordinates that are nearest to the axis.

    Parameters
    ----------
    values : ndarray
        Coordinates relative to the axis (length).
    period : float or ndarray
        Side of the periodic cell (length).

    Returns
    -------
    ndarray
        Coordinates between -period/2 and period/2 (length).
    """
    return values - period * np.floor(values / period + 0.5)
