r"""Linear viscoelasticity: creep and relaxation as series of exponentials.

Relative to the instantaneous response, a solid creeps under a constant pressure and
relaxes at a constant displacement as

.. math:: J(t) = 1 + \sum_k J_k \left(1 - e^{-t/\theta_k}\right) + \phi t, \qquad
          E(t) = 1 - \sum_k g_k \left(1 - e^{-t/\tau_k}\right) .

Either determines the other, as their Laplace transforms satisfy
:math:`s^2 \hat J \hat E = 1`. Times are in seconds, or in any unit that a path in time
shares.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq, nnls

from ase_roughcontact._util.validation import (
    finite_array,
    instance_of,
    nonnegative,
    positive,
    positive_array,
)

# Modulus of a term, relative to the instantaneous one, below which a fit leaves it out.
_MIN_MODULUS = 1e-6
# Rounding error of the sum of the relative moduli.
_SUM_ERROR = 1e-13
# Smallest relative distance of a zero from a pole.
_MIN_POLE_DISTANCE = 1e-13


class CreepStep(NamedTuple):
    """Coefficients of one time step; see `Creep.over`.

    Attributes
    ----------
    decay : ndarray, shape (terms,)
        Factors ``e_k`` of the pressures of the terms before the step.
    old, new : ndarray, shape (terms,)
        Factors ``c_k`` and ``d_k`` of the pressure before and after the step.
    """

    decay: np.ndarray
    old: np.ndarray
    new: np.ndarray

    @property
    def compliance(self) -> float:
        """Compliance of the step for the pressure at its end, relative to J(0)."""
        return 1.0 + float(self.new.sum())


@dataclass(frozen=True)
class Creep:
    r"""Prony series of the creep compliance, relative to the instantaneous compliance.

    .. math:: J(t) = 1 + \sum_k J_k \left(1 - e^{-t/\theta_k}\right) + \phi t

    Parameters
    ----------
    compliances : sequence of float
        Relative compliances ``J_k`` of the terms, positive.
    times : sequence of float
        Retardation times ``theta_k``, positive (time).
    flow : float
        Rate ``phi`` of steady flow (1/time); 0 for a solid.

    Raises
    ------
    ValueError
        If the sequences differ in length, a value is not positive, or the flow is
        negative.

    References
    ----------
    N. W. Tschoegl, The Phenomenological Theory of Linear Viscoelastic Behavior (1989),
    Sec. 3.5.

    Examples
    --------
    >>> from ase_roughcontact import Creep
    >>> rubber = Creep.standard_solid(relaxed=0.2, time=1.0)
    >>> round(rubber.times[0], 9), round(float(rubber.compliance(1e6)), 9)
    (5.0, 5.0)
    """

    compliances: Sequence[float]
    times: Sequence[float]
    flow: float = 0.0

    def __post_init__(self) -> None:
        nonnegative(flow=self.flow)
        sequences = (Sequence, np.ndarray)
        instance_of(sequences, compliances=self.compliances, times=self.times)
        values, times = tuple[float, ...](), tuple[float, ...]()
        if len(self.compliances) or len(self.times) or not self.flow:
            values, times = _terms(compliances=self.compliances, times=self.times)
        object.__setattr__(self, "compliances", values)
        object.__setattr__(self, "times", times)

    @classmethod
    def of_relaxation(cls, moduli: Sequence[float], times: Sequence[float]) -> Creep:
        r"""Return the creep of a solid given by its relaxation.

        .. math:: E(t) = 1 - \sum_k g_k \left(1 - e^{-t/\tau_k}\right)

        Parameters
        ----------
        moduli : sequence of float
            Moduli ``g_k`` relative to the instantaneous modulus. Their sum is at most
            one; a sum of one describes a fluid.
        times : sequence of float
            Relaxation times ``tau_k`` (time).

        Returns
        -------
        Creep
            Series with one term for each distinct relaxation time of a solid. The
            retardation rates are the zeros of the Laplace transform :math:`s \hat
            E(s)`, which lie between the relaxation rates.

        Raises
        ------
        ValueError
            If the series is not valid.
        """
        moduli, times = _terms(relaxation_moduli=moduli, relaxation_times=times)
        if sum(moduli) > 1.0 + _SUM_ERROR:
            raise ValueError(
                "relaxation moduli are relative to the instantaneous modulus, so that "
                f"their sum is at most 1, got {sum(moduli):g}"
            )
        rates, inverse = np.unique(1.0 / np.array(times), return_inverse=True)
        g = np.bincount(inverse, moduli)
        rest = 1.0 - float(g.sum())
        fluid = rest <= _SUM_ERROR

        def modulus(x: float) -> float:  # s E(s) of Laplace's transform at s = -x
            return (0.0 if fluid else rest) - float((g * x / (rates - x)).sum())

        lowest = [] if fluid else [0.1 * rest * rates[0]]
        zeros = np.array(list(_zeros(modulus, [*lowest, *rates])))
        slopes = (g * rates / (rates - zeros[:, None]) ** 2).sum(axis=1)
        flow = 1.0 / float((g / rates).sum()) if fluid else 0.0
        values = 1.0 / (zeros * slopes)
        return cls(tuple(values.tolist()), tuple((1.0 / zeros).tolist()), flow)

    @classmethod
    def standard_solid(cls, relaxed: float, time: float) -> Creep:
        """Return the creep of a standard linear solid.

        Parameters
        ----------
        relaxed : float
            Relaxed over instantaneous modulus, between 0 and 1.
        time : float
            Relaxation time (time).

        Returns
        -------
        Creep
            Series with one term.

        Raises
        ------
        ValueError
            If the ratio is not between 0 and 1, or the time is not positive.
        """
        if not 0.0 < relaxed < 1.0:
            raise ValueError(f"relaxed must be between 0 and 1, got {relaxed}")
        return cls.of_relaxation([1.0 - relaxed], [time])

    @property
    def relaxed(self) -> float:
        """Relaxed over instantaneous modulus; zero for a fluid."""
        return 0.0 if self.flow else 1.0 / (1.0 + sum(self.compliances))

    @property
    def terms(self) -> int:
        """Number of pressure fields that describe the past, one each term and flow."""
        return len(self.compliances) + bool(self.flow)

    def scaled(self, part: float) -> Creep:
        """Return the creep of this solid pressed against an elastic one.

        Parameters
        ----------
        part : float
            Instantaneous compliance of this solid over the sum for both solids.
        """
        values = tuple(part * value for value in self.compliances)
        return Creep(values, self.times, part * self.flow)

    def compliance(self, time: np.ndarray | float) -> np.ndarray:
        """Return J(t) relative to J(0); the result has the shape of the times."""
        time = np.asarray(time, dtype=float)
        parts = -np.expm1(-time[..., None] / np.array(self.times))
        return 1.0 + parts @ np.array(self.compliances) + self.flow * time

    def relaxation_series(self) -> tuple[np.ndarray, np.ndarray]:
        """Convert the series, exactly, to the moduli and times of the relaxation.

        Returns
        -------
        moduli, times : ndarray, shape (terms,)
            ``g_k`` and ``tau_k``, see `of_relaxation`.
        """
        poles = sorted(zip(1.0 / np.array(self.times), self.compliances, strict=True))
        rates, values = np.array(poles).reshape(-1, 2).T

        def compliance(x: float) -> float:  # s J(s) of Laplace's transform at s = -x
            parts = float((values * rates / (rates - x)).sum())
            return 1.0 + parts - self.flow / x

        total = 1.0 + float(values.sum())
        fastest = 10.0 * (total * max(rates, default=0.0) + self.flow)
        slowest = self.flow / total
        lowest = [0.1 * min(slowest, min(rates, default=slowest))] if self.flow else []
        zeros = np.array(list(_zeros(compliance, [*lowest, *rates, fastest])))
        slopes = (values * rates / (rates - zeros[:, None]) ** 2).sum(axis=1)
        slopes = slopes + self.flow / zeros**2
        return 1.0 / (zeros * slopes), 1.0 / zeros

    def relaxation(self, time: np.ndarray | float) -> np.ndarray:
        """Return E(t) relative to E(0); the result has the shape of the times."""
        moduli, times = self.relaxation_series()
        time = np.asarray(time, dtype=float)
        return 1.0 + np.expm1(-time[..., None] / times) @ moduli

    def modulus(self, frequency: np.ndarray | float) -> np.ndarray:
        r"""Return the complex modulus relative to the instantaneous modulus.

        Parameters
        ----------
        frequency : ndarray or float
            Angular frequency :math:`\omega` (1/time).

        Returns
        -------
        ndarray of complex, shape of the frequencies
            Storage modulus plus i times loss modulus,
            :math:`1/[1 + \sum_k J_k/(1 + i \omega \theta_k) + \phi/(i \omega)]`.
        """
        rate = 1j * np.asarray(frequency, dtype=float)
        terms = 1.0 / (1.0 + rate[..., None] * np.array(self.times))
        compliance = 1.0 + terms @ np.array(self.compliances)
        return rate / (rate * compliance + self.flow) if self.flow else 1.0 / compliance

    def over(self, elapsed: float) -> CreepStep:
        r"""Return the coefficients of a step over which the pressure is linear in time.

        The pressure ``q_k`` of each term follows from
        :math:`\theta_k \dot q_k = J_k p - q_k`, exactly, as

        .. math:: q_k' = e_k q_k + c_k p + d_k p' .

        Parameters
        ----------
        elapsed : float
            Duration of the step; zero for a sudden change (time).

        Returns
        -------
        CreepStep
            ``e_k``, ``c_k`` and ``d_k``; the flow, if any, is the last term.

        Raises
        ------
        ValueError
            If the duration is negative or not finite.
        """
        if not 0.0 <= elapsed < np.inf:
            raise ValueError(f"elapsed must be finite and at least 0, got {elapsed}")
        x, values = elapsed / np.array(self.times), np.array(self.compliances)
        mean = np.divide(-np.expm1(-x), x, out=np.ones_like(x), where=x > 0.0)
        decay = np.exp(-x)
        old, new = values * (mean - decay), values * (1.0 - mean)
        if self.flow:
            half = 0.5 * self.flow * elapsed
            decay, old = np.append(decay, 1.0), np.append(old, half)
            new = np.append(new, half)
        return CreepStep(decay, old, new)

    def todict(self) -> dict[str, Any]:
        """Return the parameters, which identify the series in files."""
        return asdict(self)


class RelaxationFit(NamedTuple):
    """Relaxation series of measured moduli; see `fit_relaxation`.

    Attributes
    ----------
    modulus : float
        Instantaneous modulus, in the unit of the measured moduli.
    creep : Creep
        Creep of the fitted relaxation series.
    error : float
        Root mean square of the relative errors of the complex modulus.
    """

    modulus: float
    creep: Creep
    error: float


def fit_relaxation(
    frequencies: ArrayLike, storage: ArrayLike, loss: ArrayLike, per_decade: float = 1.0
) -> RelaxationFit:
    r"""Fit a relaxation series to storage and loss moduli over frequency.

    .. math:: E' + i E'' = E_\infty + \sum_k E_k
              \frac{i \omega \tau_k}{1 + i \omega \tau_k}, \qquad E_k \ge 0

    is fitted by nonnegative least squares of the relative errors. Relaxation times are
    evenly spaced on a logarithmic scale over the range of the frequencies.

    Parameters
    ----------
    frequencies : array_like, shape (n,)
        Angular frequencies (rad/s).
    storage, loss : array_like, shape (n,)
        Storage and loss modulus (any unit).
    per_decade : float
        Number of relaxation times per decade.

    Returns
    -------
    RelaxationFit

    Raises
    ------
    ValueError
        If the arrays differ in length, a value is not positive, or the moduli have no
        relaxation.

    References
    ----------
    M. Baumgaertel, H. H. Winter, Rheol. Acta 28, 511 (1989), on the conversion of
    dynamic moduli to discrete spectra.
    """
    omega = positive_array("frequencies", frequencies)
    storage, loss = positive_array("storage", storage), positive_array("loss", loss)
    if not omega.ndim == 1 or not omega.shape == storage.shape == loss.shape:
        raise ValueError(
            "frequencies, storage and loss must be of one length, got shapes "
            f"{omega.shape}, {storage.shape} and {loss.shape}"
        )
    positive(per_decade=per_decade)
    decades = math.log10(omega.max() / omega.min())
    count = max(2, round(decades * per_decade) + 1)
    times = np.geomspace(1.0 / omega.max(), 1.0 / omega.min(), count)
    rate = 1j * omega[:, None] * times
    waves = np.concatenate([np.ones((omega.size, 1)), rate / (1.0 + rate)], axis=1)
    measured = storage + 1j * loss
    waves /= abs(measured)[:, None]
    measured = measured / abs(measured)
    moduli, residual = nnls(
        np.concatenate([waves.real, waves.imag]),
        np.concatenate([measured.real, measured.imag]),
    )
    kept = moduli[1:] > _MIN_MODULUS * moduli.sum()
    if not kept.any():
        raise ValueError("storage and loss have no relaxation: the solid is elastic")
    total = float(moduli.sum())
    creep = Creep.of_relaxation(moduli[1:][kept] / total, times[kept])
    return RelaxationFit(total, creep, float(residual) / math.sqrt(omega.size))


def _terms(**series: Sequence[float]) -> list[tuple[float, ...]]:
    """Return the two sequences of a series as tuples, checked."""
    values = [finite_array(name, each) for name, each in series.items()]
    first, second = series
    if values[0].ndim != 1 or values[0].shape != values[1].shape or not values[0].size:
        raise ValueError(
            f"{first} and {second} must be sequences of the same length, got "
            f"{series[first]} and {series[second]}"
        )
    for name, each in zip(series, values, strict=True):
        positive(**{name: float(each.min())})
    return [tuple(each.tolist()) for each in values]


def _zeros(
    function: Callable[[float], float], edges: Sequence[float]
) -> Iterator[float]:
    """Yield the zeros of a function between its poles, at most one in each interval.

    Zeros within rounding of a pole, which belong to negligible terms, are left out.
    """
    for low, high in pairwise(edges):
        ends = math.log(low) + _MIN_POLE_DISTANCE, math.log(high) - _MIN_POLE_DISTANCE
        values = [function(math.exp(end)) for end in ends]
        if ends[0] < ends[1] and values[0] * values[1] < 0.0:
            yield math.exp(brentq(lambda y: function(math.exp(y)), *ends, xtol=1e-15))
