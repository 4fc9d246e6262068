r"""Friction that depends on the slip rate and on a state: rate and state friction.

The traction of an atom that slips at a rate V under the pressure p is

.. math:: |t| = p\, a \operatorname{asinh}\left(\frac{V}{2 V_0}
          e^{(\mu_0 + b \psi)/a}\right) + \eta V, \qquad
          \psi = \ln\frac{V_0 \theta}{D_c},

for :math:`V \gg V_0 e^{-\mu_0/a}` the logarithmic law :math:`\mu_0 + a \ln(V/V_0) + b
\psi`. All atoms in contact slip, however slowly.

References
----------
J. H. Dieterich, J. Geophys. Res. 84, 2161 (1979).
A. Ruina, J. Geophys. Res. 88, 10359 (1983).
J. R. Rice, N. Lapusta, K. Ranjith, J. Mech. Phys. Solids 49, 1865 (2001).
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from ase_roughcontact._util.history import HistoryEntry, declare
from ase_roughcontact._util.parameter import Parameter
from ase_roughcontact._util.validation import nonnegative, positive, shown
from ase_roughcontact.interactions.friction import FrictionLaw, check_law

# Smallest number with a logarithm.
_TINY = np.finfo(float).tiny
#: State of friction, :math:`\psi = \ln(V_0 \theta/D_c)`; zero for an atom that comes
#: into contact: the state of steady sliding at the rate V0.
STATE = declare(HistoryEntry("friction_state", "", in_frames=True))
#: Slip rates along x and y of atoms with friction that depends on them.
SLIP_RATES = tuple(
    declare(HistoryEntry(f"slip_rate_{axis}", "Å/s", in_frames=True)).name
    for axis in "xy"
)


class RateFriction(FrictionLaw):
    """Base class of friction laws that depend on the slip rate, of paths in time.

    A subclass defines `bound`, which increases with the rate, its inverse `slip_rate`,
    and `aged`.

    Attributes
    ----------
    damping : float
        Traction per slip rate in addition to the bound (pressure time/length).
    """

    damping: float

    @abstractmethod
    def slip_rate(
        self, traction: np.ndarray, pressure: np.ndarray, history: Mapping[str, Any]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the slip rate at which the bound is a traction.

        Parameters
        ----------
        traction, pressure : ndarray, shape (k,)
            Magnitudes of the tractions, and positive pressures (pressure).
        history : mapping of str to ndarray of shape (k,)
            Histories of the law.

        Returns
        -------
        rate : ndarray, shape (k,)
            Slip rates (length/time).
        slope : ndarray, shape (k,)
            Derivatives of the rates by the tractions.
        """

    @abstractmethod
    def aged(
        self, history: Mapping[str, Any], rate: np.ndarray, duration: float
    ) -> dict[str, np.ndarray]:
        """Return the histories after a time at a constant slip rate.

        Parameters
        ----------
        history : mapping of str to ndarray of shape (k,)
            Histories at the start.
        rate : ndarray, shape (k,)
            Slip rates (length/time).
        duration : float
            Time.
        """


@dataclass(frozen=True)
class RateAndState(RateFriction):
    r"""Rate and state friction, with the ageing law or the slip law.

    .. math:: \mu = a \operatorname{asinh}\left(\frac{V}{2 V_0} \exp\frac{\mu_0 + b
              \ln(V_0 \theta/D_c)}{a}\right), \qquad
              \dot\theta = 1 - \frac{V \theta}{D_c} \quad \text{or} \quad
              \dot\theta = -\frac{V \theta}{D_c} \ln\frac{V \theta}{D_c}

    The state is integrated exactly for a constant rate. In steady sliding :math:`\mu =
    \mu_0 + (a - b) \ln(V/V_0)`.

    Parameters
    ----------
    coefficient : float
        Friction coefficient :math:`\mu_0` in steady sliding at the rate `velocity`.
    direct_effect : float
        Increase a of the coefficient with the logarithm of the rate.
    evolution_effect : float
        Increase b of the coefficient with the logarithm of the state :math:`\theta`.
    distance : float
        Slip :math:`D_c` over which the state follows the rate (length).
    velocity : float
        Reference rate :math:`V_0` (length/time).
    slip_law : bool
        Whether the state follows the slip law; by default the ageing law.
    damping : float
        Traction per slip rate :math:`\eta` by radiation of elastic waves (pressure
        time/length); see `radiation_damping`. Unstable slip has a finite rate only with
        it.

    Raises
    ------
    ValueError
        If the evolution effect or the damping is negative, or another parameter not
        positive.

    References
    ----------
    J. H. Dieterich, J. Geophys. Res. 84, 2161 (1979).
    A. Ruina, J. Geophys. Res. 88, 10359 (1983), eqs. 3 and 4.
    N. Lapusta et al., J. Geophys. Res. 105, 23765 (2000), for the integration.
    """

    kind = "rate-and-state"
    parameters = {
        "coefficient": Parameter(),
        "direct_effect": Parameter(),
        "evolution_effect": Parameter(above=-1e-300),
        "distance": Parameter("Å"),
        "velocity": Parameter("nm/s"),
        "slip_law": Parameter(default=False),
        "damping": Parameter("Pa s/m", optional=True),
        "density": Parameter("kg/m^3", optional=True),
        "shear_modulus": Parameter("GPa", optional=True),
    }
    histories = (STATE,)

    coefficient: float
    direct_effect: float
    evolution_effect: float
    distance: float
    velocity: float
    slip_law: bool = False
    damping: float = 0.0

    def __post_init__(self) -> None:
        """Check the parameters."""
        positive(coefficient=self.coefficient, direct_effect=self.direct_effect)
        positive(distance=self.distance, velocity=self.velocity)
        nonnegative(evolution_effect=self.evolution_effect, damping=self.damping)

    @classmethod
    def of_parameters(cls, **parameters: Any) -> RateAndState:
        """Return the law; damping may follow from density and shear modulus."""
        waves = [parameters.pop(key, None) for key in ("density", "shear_modulus")]
        if any(waves):
            if not all(waves) or "damping" in parameters:
                raise ValueError(
                    "damping by radiation needs both density and shear_modulus, or "
                    "damping alone"
                )
            density, modulus = waves
            parameters["damping"] = radiation_damping(modulus, density)
        return cls(**parameters)

    def bound(
        self,
        pressure: np.ndarray,
        slip: np.ndarray,
        rate: np.ndarray,
        time: float,
        history: Mapping[str, Any],
        *others: Any,
    ) -> np.ndarray:
        """Return the friction at a slip rate, without damping; see `FrictionLaw`."""
        exponent = self._exponent(history)
        with np.errstate(divide="ignore"):
            logarithm = np.log(0.5 * np.asarray(rate) / self.velocity) + exponent
        # asinh(e^x), without overflow
        angle = np.where(
            logarithm > 0.0,
            logarithm
            + np.log1p(np.sqrt(1.0 + np.exp(-2.0 * np.maximum(logarithm, 0.0)))),
            np.arcsinh(np.exp(np.minimum(logarithm, 0.0))),
        )
        return self.direct_effect * np.maximum(pressure, 0.0) * angle

    def slip_rate(
        self, traction: np.ndarray, pressure: np.ndarray, history: Mapping[str, Any]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the slip rate at which the bound is a traction, and its slope."""
        scale = self.direct_effect * pressure
        angle, exponent = traction / scale, self._exponent(history)
        # 2 sinh(z) = e^z (1 - e^(-2 z)), and 2 cosh(z)
        grown = self.velocity * np.exp(angle - exponent)
        rate = -grown * np.expm1(-2.0 * angle)
        return rate, grown * (1.0 + np.exp(-2.0 * angle)) / scale

    def aged(
        self, history: Mapping[str, Any], rate: np.ndarray, duration: float
    ) -> dict[str, np.ndarray]:
        r"""Return the state after a time at a constant slip rate.

        With :math:`x = V \Delta t/D_c`, it is :math:`\theta e^{-x} + \Delta t\,(1 -
        e^{-x})/x` by the ageing law, and by the slip law :math:`\psi e^{-x} - (1 -
        e^{-x}) \ln(V/V_0)`.
        """
        state = history[STATE.name]
        ways = rate * duration / self.distance
        left = -np.expm1(-ways)
        if self.slip_law:
            steady = -np.log(np.maximum(rate / self.velocity, _TINY))
            return {STATE.name: state * np.exp(-ways) + left * steady}
        mean = np.divide(left, ways, out=np.ones_like(ways), where=ways > 0.0)
        grown = mean * duration * self.velocity / self.distance
        grown = np.log(np.maximum(grown, _TINY))
        return {STATE.name: np.logaddexp(state - ways, grown)}

    def _exponent(self, history: Mapping[str, Any]) -> np.ndarray:
        effect = self.evolution_effect * np.asarray(history[STATE.name])
        return (self.coefficient + effect) / self.direct_effect


def check_rate(friction: Any) -> RateFriction:
    """Return a law if it depends on the slip rate; raise `TypeError` if not."""
    check_law(friction)
    if not isinstance(friction, RateFriction):
        raise TypeError(
            "a sliding path in time needs friction that depends on the slip rate, such "
            f"as RateAndState, got {shown(friction)}: give targets without times"
        )
    return friction


def check_without_rate(friction: FrictionLaw) -> None:
    """Raise `ValueError` for a law that depends on the slip rate."""
    if isinstance(friction, RateFriction):
        raise ValueError(
            f"{type(friction).__name__} depends on the slip rate, which needs a path "
            "in time: give lateral targets as a Schedule, in a scene "
            'kind = "sliding-in-time"'
        )


def radiation_damping(shear_modulus: float, density: float) -> float:
    r"""Return the traction per slip rate by shear waves in a solid below a rigid body.

    .. math:: \eta = G/c_s = \sqrt{\rho G}

    Waves at normal incidence have this impedance. The indenter is taken as slow against
    the slip rate; two equal elastic half spaces have half of the damping.

    Parameters
    ----------
    shear_modulus : float
        Shear modulus G (pressure).
    density : float
        Density :math:`\rho` (pressure time^2/length^2).

    References
    ----------
    J. R. Rice, J. Geophys. Res. 98, 9885 (1993).
    """
    positive(shear_modulus=shear_modulus, density=density)
    return math.sqrt(shear_modulus * density)
