"""Friction that weakens by slip, from a peak to a residual."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.validation import positive
from ase_roughcontact.interactions.friction import (
    SLIP,
    FrictionLaw,
    bound_of,
    check_law,
    law_of,
)


@dataclass(frozen=True)
class SlipWeakening(FrictionLaw):
    r"""Friction that falls with the slip s, from a peak to a residual.

    .. math:: |t| \le \tau_p\, [\rho + (1 - \rho) f(s/D)], \qquad
              f(z) = \max(1 - z, 0) \ \text{or}\ e^{-z}

    Parameters
    ----------
    peak : FrictionLaw
        Law of the bound before any slip, :math:`\tau_p`.
    residual : float
        Part :math:`\rho` of the peak that remains, between 0 and 1.
    distance : float
        Slip D over which the bound falls, linearly, or by a factor e (length).
    exponential : bool
        Whether it falls exponentially instead of linearly.

    Raises
    ------
    ValueError
        If the residual is not between 0 and 1, the distance is not positive, or the
        peak has histories, too.
    TypeError
        If the peak is no law.

    References
    ----------
    A. C. Palmer, J. R. Rice, Proc. R. Soc. Lond. A 332, 527 (1973).
    """

    kind = "slip-weakening"
    parameters = {
        "coefficient": Parameter(optional=True),
        "shear_strength": Parameter("GPa", optional=True),
        "residual": Parameter(above=-1e-300, below=1.0),
        "distance": Parameter("Å"),
        "exponential": Parameter(default=False),
    }
    histories = (SLIP,)

    peak: FrictionLaw
    residual: float
    distance: float
    exponential: bool = False

    def __post_init__(self) -> None:
        """Check the parameters."""
        check_law(self.peak)
        if self.peak.histories:
            raise ValueError(
                "peak must be a law without histories, such as Coulomb(0.6), got "
                f"{type(self.peak).__name__}"
            )
        if not 0.0 <= self.residual < 1.0:
            raise ValueError(
                "residual must be a part of the peak, at least 0 and below 1, got "
                f"{self.residual}"
            )
        positive(distance=self.distance)

    @classmethod
    def of_parameters(cls, **parameters: Any) -> SlipWeakening:
        """Return the law; its peak is the law of coefficient and shear strength."""
        own = {name: parameters.pop(name) for name in ("residual", "distance")}
        exponential = parameters.pop("exponential")
        peak = law_of(None, parameters).of_parameters(**parameters)
        return cls(peak, **own, exponential=exponential)

    def todict(self) -> dict[str, Any]:
        """Return the name and the parameters, with the parameters of the peak."""
        return {**super().todict(), "peak": self.peak.todict()}

    def bound(self, pressure: np.ndarray, slip: np.ndarray, *others: Any) -> np.ndarray:
        """Return the bound after a slip; see `FrictionLaw`."""
        peak = bound_of(self.peak, pressure, slip, *others)
        way = slip / self.distance
        left = np.exp(-way) if self.exponential else np.maximum(1.0 - way, 0.0)
        return peak * (self.residual + (1.0 - self.residual) * left)
