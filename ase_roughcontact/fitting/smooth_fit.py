"""Fit of the theory of a smooth sphere to a force curve."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import minimize

from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.fitting.force_curve import ForceCurve
from ase_roughcontact.fitting.parameters import changed, value_of
from ase_roughcontact.scene.scene import Scene
from ase_roughcontact.theory import SphereTheory, sphere_theory

# Largest contact radius of the smooth sphere, relative to Hertz's radius.
_MAX_RELATIVE_RADIUS = 2.0
# Largest work of adhesion (J/m²).
_MAX_WORK = 9.0
# First works of adhesion of the fit, relative to the work of adhesion of the scene.
_FIRST_WORKS = np.geomspace(0.05, 20.0, 25)


@dataclass(frozen=True, eq=False)
class SmoothFit(Summarized):
    """Fit of the theory of a smooth sphere to a force curve.

    Attributes
    ----------
    work_of_adhesion : float
        Fitted work of adhesion (J/m²).
    theory : str
        Name of the theory that applies, by Maugis' parameter.
    fitted : ndarray, shape (k,)
        Forces of the fit (eV/Å).
    line : (ndarray, ndarray) or None
        Heights of the base (Å) and forces (eV/Å) on many points for a figure.
    """

    work_of_adhesion: float
    theory: str
    fitted: FloatArray
    line: tuple[FloatArray, FloatArray] | None = None

    def __str__(self) -> str:
        """Return the theory and the work of adhesion."""
        work = f"{round(self.work_of_adhesion, 5):.5g} J/m²"
        return f"smooth sphere ({self.theory}): work_of_adhesion {work}"


def smooth_fit(
    scene: Scene, curve: ForceCurve, baseline: Sequence[str] = ()
) -> SmoothFit:
    """Fit the work of adhesion of a smooth sphere, and the zero of the depth.

    Parameters
    ----------
    scene : Scene
        Scene with radius, modulus and range of the attraction.
    curve : ForceCurve
        Measured force curve.
    baseline : sequence of str
        Parameters of the measured forces that are fitted, too, see `ForceCurve`.

    Returns
    -------
    SmoothFit

    Raises
    ------
    ValueError
        If the wall of the scene has no attraction.

    Notes
    -----
    `sphere_theory` chooses the theory for each work of adhesion. On approach the tip is
    free until it touches the undeformed surface; on retraction it is in contact up to
    the instability.
    """
    if not scene.wall.attractive:
        raise ValueError("a fit of the work of adhesion needs a wall with attraction")
    base, force = curve.base, curve.force
    size = (
        _MAX_RELATIVE_RADIUS * np.sqrt(scene.radius * np.ptp(curve.depth))
        + scene.spacing
    )

    def theory(work: float) -> SphereTheory:
        wall = changed(scene, {"work_of_adhesion": min(abs(work), _MAX_WORK)}).wall
        return sphere_theory(
            scene.radius,
            scene.contact_modulus,
            wall.work_of_adhesion,
            wall.attraction_range,
        )

    lines = curve.baseline(baseline)
    corrected = curve
    if baseline:
        corrected = curve.less(np.full(len(force), curve.far_force))

    def forces(x: FloatArray, at: ForceCurve = curve) -> FloatArray:
        smooth = _forces(theory(x[0]), size, curve, base + x[1])
        slopes = np.linalg.lstsq(lines, force - smooth, rcond=None)[0]
        if at is not curve:
            smooth = _forces(theory(x[0]), size, at, at.base + x[1])
        return smooth + at.baseline(baseline) @ slopes

    def squares(x: FloatArray) -> float:
        return float(np.sum((forces(x) - force) ** 2))

    largest = int(np.argmax(force))
    trials = []
    for work in np.minimum(
        value_of(scene, "work_of_adhesion") * _FIRST_WORKS, _MAX_WORK
    ):
        depths, theory_forces = theory(work).curve(size)
        zero = np.interp(corrected.force[largest], *_increasing(theory_forces, depths))
        trials.append(np.array([work, corrected.depth[largest] - zero]))
    best = min(trials, key=squares)
    # a method without derivatives: they are not defined at a jump
    corners = best + np.array([[0.0, 0.0], [0.1 * best[0], 0.0], [0.0, 0.5]])
    options = {
        "initial_simplex": corners,
        "xatol": 1e-4 * best[0],
        "fatol": curve.noise**2,
    }
    found = minimize(squares, best, method="Nelder-Mead", options=options).x
    work = float(min(abs(found[0]), _MAX_WORK))
    drawn = curve.drawn
    line = drawn.base, forces(found, drawn)
    return SmoothFit(work, theory(work).name, forces(found), line)


def _forces(
    theory: SphereTheory, size: float, curve: ForceCurve, base: FloatArray
) -> FloatArray:
    """Return the forces at heights of the base, relative to the undeformed surface."""
    depth, force = theory.curve(size)
    along = -depth - force / curve.stiffness  # falls while the contact grows
    up = slice(int(np.argmax(along)), None)
    in_contact = np.interp(base, *_increasing(along[up], force[up]))
    forces = np.zeros(len(base))
    for branch in curve.branches:
        end = 0.0 if branch.direction < 0.0 else along.max()
        here = base[branch.points]
        forces[branch.points] = np.where(here <= end, in_contact[branch.points], 0.0)
    return forces


def _increasing(x: FloatArray, y: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return points in the order of x."""
    order = np.argsort(x)
    return x[order], y[order]
