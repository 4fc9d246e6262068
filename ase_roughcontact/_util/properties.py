"""Calculators with properties that ASE does not define."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from ase import Atoms
from ase.calculators.calculator import Calculator


class PropertiesCalculator(Calculator):
    """Calculator whose `get_property` also returns properties of its own.

    `results` has the properties that ASE defines, and no others, as
    ``SinglePointCalculator(atoms, **results)`` requires. A subclass sets `own_results`
    in its method `calculate`, together with them.

    Attributes
    ----------
    own_properties : list of str
        Names of the other properties.
    own_results : dict
        Their values in the last calculation.
    """

    own_properties: ClassVar[list[str]] = []
    own_results: dict[str, Any]

    def get_property(
        self, name: str, atoms: Atoms | None = None, allow_calculation: bool = True
    ) -> Any:
        """Return a property of the atoms; see ASE.

        Parameters
        ----------
        name : str
            One of `implemented_properties` or `own_properties`.
        atoms : Atoms, optional
            By default those of the last calculation.
        allow_calculation : bool
            Whether it may be calculated; else it is None if it is not known.

        Returns
        -------
        object
            A copy, if it is an array.
        """
        if name not in self.own_properties:
            return super().get_property(name, atoms, allow_calculation)
        if super().get_property("energy", atoms, allow_calculation) is None:
            return None
        value = self.own_results[name]
        return value.copy() if isinstance(value, np.ndarray) else value
