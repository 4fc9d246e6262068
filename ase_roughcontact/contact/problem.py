"""Contact problem: solid, wall and indenter on a lattice, without a state."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import boolean, instance_of, positive, surface
from ase_roughcontact.contact.contact import Contact
from ase_roughcontact.elasticity.greens import ElasticSolid, Isotropic
from ase_roughcontact.elasticity.halfspace import (
    FreeHalfSpace,
    HalfSpace,
    PeriodicHalfSpace,
)
from ase_roughcontact.elasticity.lattice import Box, lattice_index, lattice_offset
from ase_roughcontact.elasticity.reduced import ReducedHalfSpace
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.interactions.consistency import check_wall
from ase_roughcontact.topography import Heterogeneity, Surface
from ase_roughcontact.topography.base import sampled_heights
from ase_roughcontact.topography.topography import Topography, topography_of


@dataclass(frozen=True, eq=False)
class Problem(Summarized):
    """Solid, wall and indenter, and the lattice of the surface atoms.

    The method `contact` returns the `Contact` of a window of this lattice, which is a
    `Box` of indices counted from the atom next to the indenter's axis. Lengths,
    pressures and energies are in any consistent system of units.

    Parameters
    ----------
    indenter : Surface
        Shape of the indenter.
    solid : ElasticSolid
        Elastic or viscoelastic solid of the substrate.
    wall : Interaction
        Interaction of the surfaces.
    spacing : float
        Distance of neighbouring atoms (length).
    periodic : bool
        Whether boundaries are periodic, with the period of the window; by default they
        are free.
    offset : (float, float)
        Position of the atom of index (0, 0) relative to the indenter's axis (length).
    heterogeneity : Heterogeneity, optional
        Local work of adhesion relative to the work of adhesion of an attractive wall;
        by default it is uniform.
    fft : mapping
        Options of the transforms; see `RealFFT2`.

    Raises
    ------
    ValueError
        If the local work of adhesion varies under a wall without attraction, the solid
        has another spacing, or a user's wall contradicts itself; see `check_wall`.
    TypeError
        If an argument has the wrong type.
    """

    indenter: Surface
    solid: ElasticSolid
    wall: Interaction
    spacing: float
    periodic: bool = False
    offset: tuple[float, float] = (0.0, 0.0)
    heterogeneity: Heterogeneity | None = None
    fft: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check the parts and their combination."""
        surface(indenter=self.indenter)
        instance_of(ElasticSolid, solid=self.solid)
        instance_of(Interaction, wall=self.wall)
        positive(spacing=self.spacing)
        boolean(periodic=self.periodic)
        if self.heterogeneity is not None:
            instance_of(Heterogeneity, heterogeneity=self.heterogeneity)
        instance_of(Mapping, fft=self.fft)
        self.solid.check(self.spacing)
        check_wall(self.wall, self.spacing)
        if self.heterogeneity and not self.wall.attractive:
            raise ValueError(
                f"heterogeneity needs a wall with attraction, got {self.wall!r}"
            )

    @cached_property
    def topography(self) -> Topography:
        """Properties of the indenter, such as its radius, periods and wavelengths."""
        return topography_of(self.indenter)

    def origin(self, window: Box) -> tuple[float, float]:
        """Return the position of the first atom of a window from the axis (length)."""
        (i, j), (x, y) = window.start, self.offset
        return i * self.spacing + x, j * self.spacing + y

    def window(self, shape: tuple[int, int], origin: tuple[float, float]) -> Box:
        """Return the window of a shape with the first atom at a position (length)."""
        x, y = origin
        start = lattice_index(x, self.spacing), lattice_index(y, self.spacing)
        return Box(start, shape)

    def heights(self, window: Box) -> np.ndarray:
        """Return the heights of the indenter above a window, shape (n, m) (length)."""
        return sampled_heights(
            self.indenter, window.shape, self.spacing, self.origin(window)
        )

    def halfspace(self, shape: tuple[int, int], padded: bool = False) -> HalfSpace:
        """Return the half space under a window, with or without padding atoms."""
        kind: type[HalfSpace] = FreeHalfSpace if padded else ReducedHalfSpace
        if self.periodic:
            kind = PeriodicHalfSpace
        return kind(shape, self.spacing, self.solid, **self.fft)

    def contact(
        self,
        window: Box,
        plastic_depth: np.ndarray | None = None,
        *,
        padded: bool = False,
    ) -> Contact:
        """Return the contact on a window.

        Parameters
        ----------
        window : Box
            The window.
        plastic_depth : ndarray, shape (n, m), optional
            Depth by which the surface has flowed in earlier steps (length).
        padded : bool
            Whether the displacement includes the padding of a free half space.

        Returns
        -------
        Contact
            Half space, heights and wall on the window.
        """
        adhesion = None
        if self.heterogeneity is not None:
            adhesion = self.heterogeneity.factors(
                window.shape, self.spacing, self.origin(window)
            )
        return Contact(
            self.halfspace(window.shape, padded),
            self.heights(window),
            self.wall,
            adhesion,
            plastic_depth,
        )

    def todict(self) -> dict[str, Any]:
        """Return the parts of the problem as dicts, for files.

        Returns
        -------
        dict
            Results of the parts' methods `todict`. Spacing and offset are not included.
        """
        solid = self.solid.todict()
        if isinstance(self.solid, Isotropic):
            del solid["name"]
        else:
            solid = {"solid": solid}
        described = {"indenter": self.topography.todict()}
        described |= solid
        described["interaction"] = self.wall.todict()
        if self.heterogeneity is not None:
            described["heterogeneity"] = self.heterogeneity.todict()
        described["precision"] = np.dtype(self.fft.get("dtype", float)).name
        return described


def lattice_offsets(origin: tuple[float, float], spacing: float) -> tuple[float, float]:
    """Return the `Problem.offset` of a lattice with an atom at a position (length)."""
    x, y = origin
    return lattice_offset(x, spacing), lattice_offset(y, spacing)
