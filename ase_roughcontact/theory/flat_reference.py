"""Tabulated contact fraction of nominally flat rough surfaces.

With strong adhesion no closed form is accurate for the fraction f(p) of the area in
contact at the nominal pressure p. It is calculated once for an interaction and a
roughness, and interpolated here.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import PchipInterpolator

from ase_roughcontact._util.validation import (
    FloatArray,
    nonnegative,
    nonnegative_array,
    positive,
)

TABLE = Path(__file__).with_name("flat_reference.csv")
_COLUMNS = "work_of_adhesion", "pressure", "contact_fraction"


@dataclass(frozen=True, eq=False)
class FlatReference:
    """Contact fraction of rough flats, interpolated between tabulated values.

    Parameters
    ----------
    pressures : array_like, shape (n,)
        Nominal pressures, increasing from zero, force per area.
    fractions : array_like, shape (n,)
        Fractions of the area in contact, between 0 and 1.

    Raises
    ------
    ValueError
        If the values are not finite, out of range or not in order.

    Examples
    --------
    >>> flat = FlatReference.read(work_of_adhesion=0.005)
    >>> bool(flat.fraction(1e-3) > 0.05)
    True
    """

    pressures: FloatArray
    fractions: FloatArray

    def __post_init__(self) -> None:
        """Check the values and convert them to arrays."""
        pressures = nonnegative_array("pressures", self.pressures)
        fractions = nonnegative_array("fractions", self.fractions)
        if pressures.ndim != 1 or pressures.shape != fractions.shape:
            raise ValueError(
                "pressures and fractions must be sequences of one length, got shapes "
                f"{pressures.shape} and {fractions.shape}"
            )
        if pressures.size < 2 or pressures[0] != 0 or np.any(np.diff(pressures) <= 0):
            raise ValueError(
                f"pressures must increase from zero, got {self.pressures!r}"
            )
        if fractions.max() > 1:
            raise ValueError(f"fractions must not exceed 1, got {self.fractions!r}")
        object.__setattr__(self, "pressures", pressures)
        object.__setattr__(self, "fractions", fractions)

    @classmethod
    def read(
        cls,
        work_of_adhesion: float,
        contact_modulus: float = 1.0,
        file: str | os.PathLike[str] = TABLE,
    ) -> FlatReference:
        """Read the curve for one work of adhesion from a table.

        Parameters
        ----------
        work_of_adhesion : float
            w/(E* a0), one of the values in the table.
        contact_modulus : float
            E*, the unit of the pressures in the table, force per area.
        file : path
            Table written by ``examples/paper/flat_reference.py``; by default that of
            the package for the roughness and the walls of the paper, whose header
            contains the commands that made it.

        Returns
        -------
        FlatReference

        Raises
        ------
        ValueError
            If the table has no such curve, or lacks the columns of such a table.

        References
        ----------
        L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), fig. 2c: the
        procedure; the table was calculated with this package.
        """
        nonnegative(work_of_adhesion=work_of_adhesion)
        positive(contact_modulus=contact_modulus)
        with open(file) as lines:
            text = [line for line in lines if line[0] != "#"]
        table = np.genfromtxt(text, delimiter=",", names=True, ndmin=1)
        if not set(_COLUMNS) <= set(table.dtype.names or ()):
            raise ValueError(
                f"{os.fspath(file)} is not a table with the columns "
                f"{', '.join(_COLUMNS)}, got {table.dtype.names}"
            )
        works, pressures, fractions = (table[name] for name in _COLUMNS)
        curve = np.isclose(works, work_of_adhesion, rtol=1e-6, atol=0)
        if not curve.any():
            known = ", ".join(map(str, np.unique(works)))
            raise ValueError(
                f"{os.fspath(file)} has no curve for work_of_adhesion "
                f"{work_of_adhesion!r}, only for {known}; calculate it with "
                "examples/paper/flat_reference.py"
            )
        return cls(contact_modulus * pressures[curve], fractions[curve])

    def fraction(self, pressure: ArrayLike) -> FloatArray:
        """Return the fraction of the nominal area in contact, f(p).

        The interpolation is cubic and monotonic; beyond the last pressure of the table
        the fraction is constant.

        Parameters
        ----------
        pressure : array_like
            Nominal pressure p >= 0, force per area.

        Returns
        -------
        ndarray
            f between 0 and 1; shape of the argument.

        Raises
        ------
        ValueError
            If a pressure is not finite or negative.

        References
        ----------
        F. N. Fritsch, R. E. Carlson, SIAM J. Numer. Anal. 17, 238 (1980).
        """
        pressure = nonnegative_array("pressure", pressure)
        curve = PchipInterpolator(self.pressures, self.fractions)
        fraction: FloatArray = curve(np.minimum(pressure, self.pressures[-1]))
        return fraction
