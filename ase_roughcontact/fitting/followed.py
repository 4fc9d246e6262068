r"""Branches of a relaxed force curve as a cantilever follows them, with derivatives.

A base at height D, to which the tip is connected by the stiffness k, is in equilibrium
with the tip at Z if :math:`D = Z - N(Z)/k`. On a stable branch the derivatives at fixed
D are

.. math:: \frac{dN}{d\theta} = \frac{\partial_\theta N}{1 - \partial_Z N/k}, \qquad
          \frac{dN}{dD} = \frac{\partial_Z N}{1 - \partial_Z N/k}.

The tip jumps where :math:`\partial_Z N = k`. There :math:`dD/dZ = 0`, so that the
height of the base at the jump changes by :math:`-\partial_\theta N/\partial_Z N`, which
also holds where the surface jumps, :math:`\partial_Z N \to \infty`.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ase_roughcontact._util.validation import FloatArray
from ase_roughcontact.path_kinds.loop.cantilever import follow
from ase_roughcontact.path_kinds.loop.instabilities import (
    POINTS,
    Jump,
    interpolated,
    stable_parts,
)
from ase_roughcontact.results.record import LoadStep

# Largest ratio of derivatives at a fixed base and a fixed tip, infinite at a jump.
_MAX_GAIN = 20.0


@dataclass(frozen=True, eq=False)
class FollowedJump:
    """Jump of the tip on a branch.

    Attributes
    ----------
    base : float
        Height of the base (Å).
    change : float
        Change of the normal force (eV/Å).
    derivatives : ndarray, shape (p,)
        Derivatives of the height of the base to the parameters (Å per unit).
    """

    base: float
    change: float
    derivatives: FloatArray


@dataclass(frozen=True, eq=False)
class FollowedBranch:
    """Branch of a force curve that a base follows in one direction.

    Attributes
    ----------
    direction : float
        -1 for an approach, 1 for a retraction.
    along : ndarray, shape (n,)
        Height of the base times the direction, which increases (Å).
    columns : ndarray, shape (n, 2 + p)
        Force, and its derivatives at a fixed base to the height of the base and to the
        parameters.
    jump : FollowedJump or None
        Largest jump towards a contact on approach, or out of it on retraction.
    """

    direction: float
    along: FloatArray
    columns: FloatArray
    jump: FollowedJump | None

    @classmethod
    def of(
        cls,
        states: Sequence[LoadStep],
        jumps: Sequence[Jump],
        derivatives: Mapping[int, FloatArray],
        stiffness: float,
        direction: float,
    ) -> FollowedBranch:
        """Return the branch of the relaxed states of an approach or a retraction.

        Parameters
        ----------
        states : sequence of LoadStep
            Relaxed states, in the order of the path.
        jumps : sequence of Jump
            Instabilities of the surface, across which nothing is interpolated.
        derivatives : mapping of int to ndarray, shape (p,)
            Derivatives of the force to the parameters, by the number of the state.
        stiffness : float
            Stiffness of the cantilever (eV/Å^2), may be infinite.
        direction : float
            -1 for an approach, 1 for a retraction.

        Returns
        -------
        FollowedBranch
        """
        parts = [
            _with_derivatives(part, derivatives) for part in stable_parts(states, jumps)
        ]
        if direction > 0.0:  # the tip may be free where the base is further away
            parts[-1] = np.concatenate([parts[-1], _free_row(parts, stiffness)])
        ends = np.cumsum([len(part) for part in parts])[:-1]
        height, force, slope, *rows = np.concatenate(parts).T
        gain = 1.0 / np.maximum(1.0 - slope / stiffness, 1.0 / _MAX_GAIN)
        columns = np.column_stack([force, slope * gain, *(row * gain for row in rows)])
        along = direction * (height - force / stiffness)
        reached, columns, last, landed = follow(along, columns, ends)
        change = landed[:, 0] - force[last]
        jump = None
        if (direction * change).max(initial=0.0) > 0.0:
            largest = int(np.argmax(direction * change))
            i = last[largest]
            steep = slope[i] if np.isinf(stiffness) else max(slope[i], stiffness)
            to_parameters = -np.array([row[i] for row in rows]) / steep
            jump = FollowedJump(
                direction * float(along[i]),
                float(change[largest]),
                to_parameters if steep > 0.0 else np.zeros(len(rows)),
            )
        return cls(direction, reached, columns, jump)

    def at(self, base: FloatArray) -> FloatArray:
        """Return force and derivatives at heights of the base.

        Parameters
        ----------
        base : ndarray, shape (k,)
            Heights of the base (Å).

        Returns
        -------
        ndarray, shape (k, 2 + p)
            Rows as in `columns`. Beyond the deepest state the force is a straight line.
        """
        along = self.direction * base
        columns = (np.interp(along, self.along, column) for column in self.columns.T)
        values = np.column_stack(list(columns))
        deepest = -1 if self.direction < 0.0 else 0
        force, slope = self.columns[deepest, :2]
        beyond = base - self.direction * self.along[deepest]
        values[beyond < 0.0, 0] = force + slope * beyond[beyond < 0.0]
        return values


def _free_row(parts: Sequence[FloatArray], stiffness: float) -> FloatArray:
    """Return a row of a free tip as far away as a cantilever can pull it off."""
    force = min(float(part[:, 1].min()) for part in parts)
    row = np.zeros((1, parts[-1].shape[1]))
    row[0, 0] = parts[-1][-1, 0] - 1.1 * min(force, 0.0) / stiffness
    return row


def _with_derivatives(
    states: Sequence[LoadStep], derivatives: Mapping[int, FloatArray]
) -> FloatArray:
    """Return height, force, slope and derivatives on a stable part of a branch."""
    branch = interpolated(states)
    rows = np.array([derivatives[state.step] for state in states])
    known = np.isfinite(rows).all(axis=1)
    if not known.any():
        rows, known = np.zeros_like(rows), ~known
    numbers, between = np.flatnonzero(known), np.arange(len(branch[0])) / POINTS
    columns = (np.interp(between, numbers, column) for column in rows[known].T)
    return np.column_stack([*branch, *columns])
