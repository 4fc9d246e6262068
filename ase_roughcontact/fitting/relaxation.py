r"""Least-squares fit of a viscoelastic solid to an approach and a hold.

While the contact grows or stays as it is, the force of an indenter of simple shape at
the depth d(t) is (E. H. Lee and J. R. M. Radok, J. Appl. Mech. **27**, 438 (1960))

.. math:: N(t) = \int_0^t E^*(t - s) \frac{d}{ds} n(d(s) - d_0) \, ds, \qquad
          E^*(t) = E_\infty + \sum_k E_k e^{-t/\tau_k},

with the elastic force :math:`E^* n(d)` of `ase_roughcontact.theory.indenters`. Times
and depths are measured: relaxation of the force at constant height and creep at
constant force are fitted alike. Between the points n is linear in time. Moduli, times,
the contact point and the force of a free tip are fitted.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import least_squares, nnls

from ase_roughcontact._util.printing import Printed, number, table
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.units import UNITS, pressure_unit
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.force_curve import ForceCurve, noise_of
from ase_roughcontact.fitting.residual_runs import (
    standard_errors,
    systematic_residuals,
)
from ase_roughcontact.theory.indenters import Indenter

# Largest number of points to which a curve is averaged.
_MAX_POINTS = 800
# Number of contact points that are tried first.
_TRIED_CONTACTS = 40
# Number of relaxation times of the solid that is tried first.
_TRIED_TIMES = 8
# Largest logarithm of a modulus or a time over its unit.
_MAX_LOGARITHM = 100.0
# Change of the unknowns for differences.
_DIFFERENCE_STEP = 1e-5


@dataclass(frozen=True, eq=False)
class RelaxationFit(Summarized, Printed):
    """Result of `fit_relaxation`.

    Attributes
    ----------
    indenter : Indenter
        Fitted indenter, with lengths in Å.
    contact_modulus, contact_modulus_error : float
        E* of the relaxed solid, E_inf, and its standard error (eV/Å^3).
    instantaneous_modulus : float
        E_inf + sum of E_k (eV/Å^3).
    relaxation_moduli, relaxation_times : ndarray, shape (m,)
        E_k over the instantaneous modulus, as in ``[substrate]`` of a scene, and tau_k
        (s); NaN, not known, where the standard error is zero or not below the value.
    relaxation_times_errors : ndarray, shape (m,)
        Standard errors (s).
    contact_depth, force_offset : float
        Depth of the tip at the contact point, without the offset (Å), and force of a
        free tip (eV/Å).
    time, force, fitted : ndarray, shape (k,)
        Averaged times (s), and measured and fitted forces (eV/Å).
    noise : float
        Standard deviation of the residuals (eV/Å).
    converged : bool
        Whether the least-squares solution has converged.
    warnings : tuple of str
        Reasons to doubt the fit.
    """

    indenter: Indenter
    contact_modulus: float
    contact_modulus_error: float
    instantaneous_modulus: float
    relaxation_moduli: FloatArray
    relaxation_times: FloatArray
    relaxation_times_errors: FloatArray
    contact_depth: float
    force_offset: float
    time: FloatArray
    force: FloatArray
    fitted: FloatArray
    noise: float
    converged: bool
    warnings: tuple[str, ...] = ()

    @property
    def parts(self) -> list[object]:
        """Parameters with errors, and warnings, in printed form."""
        unit = pressure_unit(self.contact_modulus)
        relaxed = self.contact_modulus / UNITS[unit]
        error = self.contact_modulus_error / UNITS[unit]
        instantaneous = self.instantaneous_modulus / UNITS[unit]
        rows = [
            ["contact_modulus, relaxed", number(relaxed, 5), number(error, 2), unit],
            ["contact_modulus, instantaneous", number(instantaneous, 5), "", unit],
        ]
        for k, modulus in enumerate(self.relaxation_moduli):
            time, error = self.relaxation_times[k], self.relaxation_times_errors[k]
            rows.append([f"relaxation_moduli[{k}]", number(float(modulus)), "", ""])
            shown = "not known" if math.isnan(time) else number(float(time))
            row = [shown, number(float(error), 2), "s"]
            rows.append([f"relaxation_times[{k}]", *row])
        depth, offset = self.contact_depth / UNITS["nm"], self.force_offset
        rows.append(["contact_depth", number(depth, 5), "", "nm"])
        rows.append(["force_offset", number(offset / UNITS["nN"]), "", "nN"])
        rows.append(["noise", number(self.noise / UNITS["nN"], 3), "", "nN"])
        failed = () if self.converged else ("NOT CONVERGED",)
        heads = [self.indenter.name, "value", "± error", "unit"]
        warned = (f"warning: {warning}" for warning in self.warnings)
        return [*failed, table(heads, rows, left=1), *warned]


def fit_relaxation(
    time: FloatArray, curve: ForceCurve, indenter: Indenter, terms: int = 1
) -> RelaxationFit:
    """Fit relaxation moduli and times to an approach and a hold.

    Parameters
    ----------
    time : array_like, shape (k,)
        Increasing times of the points (s).
    curve : ForceCurve
        Approach and hold, see `read_with_times`.
    indenter : Indenter
        Indenter with lengths in Å.
    terms : int
        Number of relaxation times.

    Returns
    -------
    RelaxationFit

    Raises
    ------
    ValueError
        If times do not increase, or no contact is found.
    """
    time = np.asarray(time, float)
    if time.shape != curve.force.shape or not np.all(np.diff(time) > 0.0):
        raise ValueError(
            f"a fit over time needs increasing times, one for each of the "
            f"{len(curve.force)} points, got {len(time)}: read approach and hold alone"
        )
    model = _Model(time, curve, indenter, terms)
    first = model.first()
    found = least_squares(
        model.residuals, first, x_scale="jac", diff_step=_DIFFERENCE_STEP, max_nfev=200
    )
    return model.result(found.x, bool(found.success))


class _Model:
    """Averaged forces over time; the unknowns x are dimensionless.

    Logarithms of E_inf, of E_k and tau_k over first values, the contact depth over the
    range of the depths, and the offset over the range of the forces.
    """

    def __init__(
        self, time: FloatArray, curve: ForceCurve, indenter: Indenter, terms: int
    ) -> None:
        parts = np.array_split(np.arange(len(time)), min(_MAX_POINTS, len(time)))

        def averaged(values: FloatArray) -> FloatArray:
            return np.array([values[part].mean() for part in parts])

        self._each = len(time) / len(parts)
        self._time = averaged(time - time[0])
        self._depth, self._force = averaged(curve.depth), averaged(curve.force)
        self._stiffness, self._indenter, self._terms = curve.stiffness, indenter, terms
        self._extent = float(np.ptp(self._depth))
        self._range = float(np.ptp(self._force))
        self._noise = max(curve.noise, 1e-6 * self._range)
        # unit of the moduli
        self._modulus = self._range / float(indenter.force(self._extent))

    def forces(self, x: FloatArray) -> FloatArray:
        """Return the forces for some unknowns."""
        moduli, times, contact, offset = self._values(x)
        responses = self._responses(contact - offset / self._stiffness, times)
        return offset + responses @ moduli

    def residuals(self, x: FloatArray) -> FloatArray:
        """Return residuals relative to the noise."""
        return (self.forces(x) - self._force) / self._noise

    def _values(self, x: FloatArray) -> tuple[FloatArray, FloatArray, float, float]:
        """Return E_inf and E_k, tau_k, the contact depth and the offset."""
        m = self._terms
        # what the points do not determine may go to zero or infinity
        factors = np.exp(np.clip(x[: 2 * m + 1], -_MAX_LOGARITHM, _MAX_LOGARITHM))
        moduli = self._modulus * factors[: m + 1]
        times = self._time[-1] * factors[m + 1 :]
        return moduli, times, self._extent * x[-2], self._range * x[-1]

    def _responses(self, contact: float, times: FloatArray) -> FloatArray:
        """Return forces per modulus: elastic, and of each relaxation time."""
        elastic = self._indenter.force(self._depth - contact)
        columns = [elastic]
        steps, changes = np.diff(self._time), np.diff(elastic)
        for each in times:
            ratio = steps / each
            decay = np.exp(-ratio)
            gain = -np.expm1(-ratio) / ratio * changes
            column = np.empty_like(elastic)
            column[0] = value = elastic[0]
            for i in range(len(steps)):
                value = decay[i] * value + gain[i]
                column[i + 1] = value
            columns.append(column)
        return np.column_stack(columns)

    def first(self) -> FloatArray:
        """Return first values: contact points and times are tried in turn."""
        grid = self._time[-1] * np.geomspace(1.0 / len(self._time), 1.0, _TRIED_TIMES)
        free = float(np.median(self._force[: max(len(self._force) // 20, 2)]))
        least, best = math.inf, None
        low, high = self._depth.min(), self._depth.max()
        for contact in np.linspace(low, high, _TRIED_CONTACTS, endpoint=False):
            responses = self._responses(contact, grid)
            scale = max(float(abs(responses).max()), 1e-300)
            moduli, misfit = nnls(responses / scale, self._force - free)
            if misfit < least and moduli.sum() > 0.0:
                least, best = misfit, (contact, moduli / scale)
        if best is None:
            raise ValueError(
                "no contact is found: the force does not rise with the depth; look at "
                "the curve as it was read"
            )
        contact, moduli = best
        total = max(float(moduli.sum()), 1e-300)
        # times in equal parts of the sum of the relaxing moduli
        part = np.cumsum(moduli[1:]) / max(float(moduli[1:].sum()), 1e-300)
        middle = (np.arange(self._terms) + 0.5) / self._terms
        times = grid[np.minimum(np.searchsorted(part, middle), _TRIED_TIMES - 1)]
        relaxing = max(float(moduli[1:].sum()), 0.05 * total) / self._terms
        relaxed = max(float(moduli[0]), 0.05 * total)
        logarithms = np.log([relaxed, *[relaxing] * self._terms]) - math.log(
            self._modulus
        )
        contact += free / self._stiffness
        offsets = contact / self._extent, free / self._range
        return np.concatenate([logarithms, np.log(times / self._time[-1]), offsets])

    def result(self, x: FloatArray, converged: bool) -> RelaxationFit:
        """Return the fit of some unknowns."""
        moduli, times, contact, offset = self._values(x)
        fitted = self.forces(x)
        residual = fitted - self._force
        noise = math.sqrt(float(residual @ residual) / max(len(residual) - len(x), 1))
        steps = _DIFFERENCE_STEP * np.eye(len(x))
        slopes = [self.forces(x + step) - self.forces(x - step) for step in steps]
        errors = standard_errors(
            np.transpose(slopes) / (2.0 * _DIFFERENCE_STEP), residual
        )
        order = np.argsort(times)
        m, total = self._terms, float(moduli.sum())
        time_errors = times * errors[m + 1 : 2 * m + 1]
        is_known = (time_errors > 0.0) & (time_errors < times)
        times = np.where(is_known, times, math.nan)
        time_errors = np.where(is_known, time_errors, math.nan)
        fit = RelaxationFit(
            indenter=self._indenter,
            contact_modulus=float(moduli[0]),
            contact_modulus_error=float(moduli[0] * errors[0]),
            instantaneous_modulus=total,
            relaxation_moduli=moduli[1:][order] / total,
            relaxation_times=times[order],
            relaxation_times_errors=time_errors[order],
            contact_depth=contact,
            force_offset=offset,
            time=self._time,
            force=self._force,
            fitted=fitted,
            noise=noise,
            converged=converged,
        )
        return replace(fit, warnings=tuple(self._warnings(fit)))

    def _warnings(self, fit: RelaxationFit) -> list[str]:
        """Return reasons to doubt a fit."""
        warnings = []
        spacing = float(np.median(np.diff(self._time)))
        duration = float(self._time[-1])
        fewer = "fit fewer terms" if self._terms > 1 else "leave out --relaxation"
        advice = f"{spacing:.2g} to {duration:.3g} s: {fewer}, or hold longer"
        for k, time in enumerate(fit.relaxation_times):
            if math.isnan(time):
                warnings.append(
                    f"relaxation_times[{k}] is not known: no such relaxation is seen "
                    f"in the measured times, {advice}"
                )
            elif not spacing <= time <= duration:
                warnings.append(
                    f"the relaxation time of {time:.3g} s is outside of the measured "
                    f"times, {advice}"
                )
        if 3.0 * fit.contact_modulus_error > fit.contact_modulus:
            warnings.append(
                "the relaxed modulus is not larger than three standard errors: it may "
                "be a fluid, or was not held long enough"
            )
        noise = max(noise_of(fit.force), self._noise / math.sqrt(self._each))
        largest = float(abs(fit.force - fit.force_offset).max())
        residual = fit.fitted - fit.force
        return warnings + systematic_residuals(residual, noise, largest)
