"""Sections [path] of scenes in which the indenter moves sideways."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.units import FORCES, UNITS
from ase_roughcontact._util.validation import (
    FloatArray,
    finite,
    finite_array,
)
from ase_roughcontact.contact.control import LOAD
from ase_roughcontact.elasticity.lateral import CrossResponse, LateralHalfSpace
from ase_roughcontact.path_kinds.sliding.specification import (
    LATERAL_CONTROLS,
    LateralControl,
    check_spring,
)
from ase_roughcontact.scene.bodies import Bodies
from ase_roughcontact.scene.path_kind import TargetPath, stiffness_of
from ase_roughcontact.scene.section import lengths


@dataclass(frozen=True)
class LateralPath(TargetPath):
    """Base class of paths between lateral targets, against friction.

    Displacements and bases are in Å, forces in nN, or with a unit.
    """

    units = {"spring_stiffness": "N/m", "direction": "deg"}
    aliases = {"spring": "spring_stiffness"}
    in_order = True
    has_friction = True

    loads: tuple | float | str | None = None
    penetrations: tuple | float | str | None = None
    heights: tuple | float | str | None = None
    displacements: tuple | None = None
    forces: tuple | None = None
    bases: tuple | None = None
    spring_stiffness: float | None = None
    direction: float = 0.0

    @property
    def towards(self) -> FloatArray:
        """Unit vector along which the indenter moves."""
        finite(direction=self.direction)
        angle = math.radians(self.direction)
        return np.array([math.cos(angle), math.sin(angle)])

    @property
    def lateral_control(self) -> LateralControl:
        """Quantity that is prescribed laterally.

        Raises
        ------
        ValueError
            If not exactly one of the keys is given.
        """
        given = [name for name in LATERAL_CONTROLS if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(
                "give displacements, forces or bases, between which the indenter "
                f"moves, such as displacements = [0, 5, -5, 5], got "
                f"{' and '.join(given) or 'none of them'}"
            )
        return LATERAL_CONTROLS[given[0]]

    def turns(self, bodies: Bodies) -> FloatArray:
        """Return the lateral targets between which the indenter moves (Å or eV/Å).

        Raises
        ------
        ValueError
            If not exactly one of the keys is given, or a value is invalid.
        """
        key, unit = self.lateral_control.name, self.lateral_control.unit
        units = FORCES if unit in FORCES else lengths(bodies.spacing)
        values = getattr(self.plain([key], units, unit), key)
        found = UNITS[unit] * finite_array(key, list(values))
        if len(found) < 2:
            raise ValueError(f"{key} must be two or more targets, got {len(found)}")
        return found

    def normal_targets(self, bodies: Bodies) -> FloatArray:
        """Return the given normal targets (Å or eV/Å).

        Raises
        ------
        ValueError
            If there is no target, or one is invalid.
        """
        control, key = self.controlled, self.target_key
        if self.values is None:
            raise ValueError(
                "give loads, penetrations or heights while the indenter moves"
            )
        values = self.in_unit([key], bodies).values
        found = UNITS[control.unit] * np.atleast_1d(finite_array(key, values))
        if control == LOAD and bodies.wall.hard and not bodies.wall.attractive:
            self._check_loads(found, np.atleast_1d(np.array(self.values, object)))
        return found

    def _check_loads(self, loads: FloatArray, given: np.ndarray) -> None:
        """Raise an error for a tension, which a wall without attraction can't carry."""
        if loads.min() < 0.0:
            least = given[loads.argmin()]
            text = least if isinstance(least, str) else f"{least:g} {self.unit}"
            raise ValueError(
                "loads must be >= 0, as a hard wall without attraction carries "
                f"no tension, got {text}"
            )

    @property
    def lateral_stiffness(self) -> float | None:
        """Stiffness of the spring between base and indenter (eV/Å^2)."""
        stiffness = stiffness_of("spring_stiffness", self.spring_stiffness)
        check_spring(self.lateral_control, stiffness)
        return stiffness

    def check(self, bodies: Bodies) -> None:
        """Raise an error if the solid has no friction, or no lateral response."""
        super().check(bodies)
        _ = self.towards, self.lateral_stiffness
        if bodies.friction is None:
            raise ValueError(
                f'kind = "{self.kind}" needs a section [friction]: give coefficient or '
                "shear_strength in it"
            )
        try:
            shape, periodic = (2, 2), bodies.problem.periodic
            LateralHalfSpace(shape, bodies.spacing, bodies.solid, periodic)
            if bodies.friction.coupled:
                CrossResponse(shape, bodies.spacing, bodies.solid, periodic)
        except NotImplementedError as error:
            raise ValueError(
                "friction needs the lateral response of the solid, which "
                f"{type(bodies.solid).__name__} does not have: give an isotropic half "
                "space, anisotropic = true, or a crystal from a file of this version"
            ) from error
