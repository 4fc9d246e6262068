"""Calculators with properties that ASE does not define."""

from __future__ import annotations

from typing import Any, ClassVar

import numpy as np
from ase import Atoms
from ase.calculators.calculator import Calculator


class PropertiesCalculator(Calculator):
    """Calculator with further properties, which `get_property` returns.

    The dict `results` has only properties that ASE defines, as
    ``SinglePointCalculator(atoms, **results)`` requires. The method `calculate` of a
    subclass sets `results` and `own_results`.

    Attributes
    ----------
    own_properties : list of str
        Names of the further properties.
    own_results : dict
        Values of the further properties in the last calculation, by name.
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
            Name in `implemented_properties` or `own_properties`.
        atoms : Atoms, optional
            Atoms; by default the atoms of the last calculation.
        allow_calculation : bool
            Whether the property may be calculated. If not, it is None if it is not
            known.

        Returns
        -------
        object
            Value of the property; a copy if it is an array.
        """
        if name not in self.own_properties:
            return super().get_property(name, atoms, allow_calculation)
        if super().get_property("energy", atoms, allow_calculation) is None:
            return None
        value = self.own_results[name]
        return value.copy() if isinstance(value, np.ndarray) else value
