"""Sliding paths of atoms, with friction."""

from __future__ import annotations

from collections.abc import Generator
from typing import Any

import numpy as np
from ase import Atoms

from ase_roughcontact.atoms.loading import AtomsPath, single_path
from ase_roughcontact.interactions.friction import FrictionLaw
from ase_roughcontact.paths.output import Output
from ase_roughcontact.paths.record import LoadStep
from ase_roughcontact.paths.sliding import follow_sliding
from ase_roughcontact.paths.validity import Validity


def sliding_path(
    atoms: Atoms,
    friction: FrictionLaw,
    penetrations: np.ndarray | float | None = None,
    *,
    heights: np.ndarray | float | None = None,
    loads: np.ndarray | float | None = None,
    displacements: np.ndarray | None = None,
    forces: np.ndarray | None = None,
    bases: np.ndarray | None = None,
    spring: float | None = None,
    coupling: str = "neglected",
    validity: str | Validity = "warn",
    output: Output | None = None,
    **options: Any,
) -> Generator[LoadStep, None, None]:
    """Move the indenter sideways against friction, one step after another.

    Parameters
    ----------
    atoms : Atoms
        From `substrate`, with a `RoughContact` calculator whose solid has lateral
        components: ``Isotropic(contact_modulus, poisson=...)``.
    friction : FrictionLaw
        `Coulomb`, `Tresca`, or a class of your own.
    penetrations, heights, loads : array_like, shape (steps,), or float
        Exactly one of them; see `load_path`. One number is that of all steps.
    displacements, forces, bases : array_like, shape (steps,) or (steps, 2)
        Exactly one of them, along x or along x and y: lateral displacements of the
        indenter (Å), lateral forces on it (eV/Å), or displacements of the base of a
        spring that moves it (Å).
    spring : float, optional
        Stiffness of the spring, for bases (eV/Å^2).
    coupling : {"neglected", "solved"}
        See `follow_sliding`.
    validity, output
        See `load_path`. Results are of the class `SlidingStep`.
    **options
        `optimizer`, `fmax`, `accuracy`, `max_steps` and `window`; see `load_path`.

    Yields
    ------
    SlidingStep
        Also one that has not converged, as a contact that slides under a force does.

    Raises
    ------
    ValueError
        If not exactly one normal and one lateral path are given, the spring is missing,
        or as `load_path` does.
    TypeError
        If `output.record` is not derived from `SlidingStep`.
    NotImplementedError
        If the solid has no lateral components.

    Notes
    -----
    Lateral displacements leave the heights above the atoms as they are: the indenter
    stays at its x and y. Unless the coupling is solved, they leave the pressure as it
    is, too, which is exact for a Poisson's ratio of 1/2 (Goodman's approximation). The
    atoms move along x and y, but energy and forces depend on z only. Their arrays
    ``traction_x``, ``traction_y`` (eV/Å^3) and ``slipping`` (1 or 0), and the
    displacements, are in frames, too; see `lateral_of`.
    The calculator's `results` have the ``lateral_force``.

    Examples
    --------
    >>> import numpy as np
    >>> from ase_roughcontact import Coulomb, HardWall, RoughContact, RoughSphere
    >>> from ase_roughcontact import sliding_path, substrate
    >>> from ase_roughcontact.elasticity import Isotropic
    >>> sphere = RoughSphere(radius=500.0)
    >>> atoms = substrate("Cu", (32, 32), sphere, spacing=2.5)
    >>> solid = Isotropic(0.8, poisson=0.3)
    >>> atoms.calc = RoughContact(sphere, solid=solid, interaction=HardWall())
    >>> path = np.linspace(0.0, 2.0, 5)
    >>> steps = list(sliding_path(atoms, Coulomb(0.3), 1.0, displacements=path))
    >>> round(steps[-1].lateral_force_x / steps[-1].normal_force, 3)
    0.3
    """
    normal, targets = single_path(
        penetrations=penetrations, heights=heights, loads=loads
    )
    control, lateral = single_path(
        displacements=displacements, forces=forces, bases=bases
    )
    path = AtomsPath(atoms, normal, validity=validity, output=output, **options)
    sliding = targets, friction, lateral, control
    return path.follow(follow_sliding, *sliding, spring=spring, coupling=coupling)
