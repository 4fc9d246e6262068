"""Contact, load and constraints of atoms, for the solvers."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from ase import Atoms
from ase.constraints import Hookean

from ase_roughcontact.atoms.calculator import contact_of
from ase_roughcontact.atoms.sticking import check_released, indenter_fixed
from ase_roughcontact.contact import Contact
from ase_roughcontact.contact.support import External, Support


def soft_contact_of(atoms: Atoms) -> Contact:
    """Return the contact of atoms under a soft wall.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator.

    Returns
    -------
    Contact

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, or the wall is hard.
    """
    contact = contact_of(atoms)
    wall = contact.wall
    if wall.hard:
        advice = f"relax it with {wall.optimizer}"
        raise ValueError(f"a hard wall has no gradient: {advice}")
    return contact


def support_of(atoms: Atoms) -> Support:
    """Return the support of the indenter atom: its height, or the load, and springs.

    Parameters
    ----------
    atoms : Atoms
        Substrate and indenter with a `RoughContact` calculator.

    Raises
    ------
    ValueError
        If atoms stick, or a constraint acts on surface atoms along z, or does anything
        to the indenter but fix it or tie it by a `Hookean` to a point or a plane.
    """
    check_released(atoms)
    springs = []
    for constraint in atoms.constraints:
        if isinstance(constraint, Hookean):
            _check_spring(constraint, atoms)
            springs.append(constraint)
        elif not _supported(constraint, atoms):
            raise ValueError(
                f"{constraint} acts on surface atoms, or is not supported here: "
                "use one of ASE's optimizers on the atoms themselves"
            )
    return _support(atoms, _Springs(atoms, springs) if springs else None)


def support_beside_others(atoms: Atoms) -> Support:
    """Return the support of the indenter, or its load alone if surface atoms are held.

    Parameters
    ----------
    atoms : Atoms
        Substrate and indenter with a `RoughContact` calculator.
    """
    return _support(atoms, None) if surface_held(atoms) else support_of(atoms)


def surface_held(atoms: Atoms) -> bool:
    """Return whether atoms have constraints for which `support_of` raises an error."""
    try:
        support_of(atoms)
    except ValueError:
        return True
    return False


def _support(atoms: Atoms, springs: External | None) -> Support:
    """Return the support by the calculator's load, and springs."""
    fixed = indenter_fixed(atoms)
    return Support(fixed, 0.0 if fixed else atoms.calc.parameters["load"], springs)


class _Springs:
    """Energy and upward force of springs on the indenter atom, at a height."""

    def __init__(self, atoms: Atoms, springs: list[Hookean]) -> None:
        self._last, self._springs = len(atoms) - 1, springs
        self._xy = atoms.positions[-1, :2].copy()
        self._cell = {"cell": atoms.cell.copy(), "pbc": atoms.pbc.copy()}

    def __call__(self, height: float) -> tuple[float, float]:
        """Return energy and upward force (eV, eV/Å)."""
        # in place of arrays over all atoms: Hookean reads one entry
        position = np.array([*self._xy, height])
        atoms = SimpleNamespace(positions={self._last: position}, **self._cell)
        forces, energy = {self._last: np.zeros(3)}, 0.0
        for spring in self._springs:
            spring.adjust_forces(atoms, forces)
            energy += spring.adjust_potential_energy(atoms)
        return float(energy), float(forces[self._last][2])


def _check_spring(constraint: Hookean, atoms: Atoms) -> None:
    """Raise `ValueError` unless a spring ties the indenter along z."""
    last, xy = len(atoms) - 1, atoms.positions[-1, :2]
    pair = constraint._type == "two atoms"
    if pair or constraint.index % len(atoms) != last:
        raise ValueError(
            f"{constraint} does not tie the indenter to a point or a plane: "
            "use one of ASE's optimizers on the atoms themselves"
        )
    if constraint._type == "point" and not np.allclose(
        constraint.origin[:2], xy, rtol=0.0, atol=1e-6
    ):
        raise ValueError(
            f"the spring is tied to {constraint.origin}, beside the indenter at {xy}, "
            "which moves along z only: tie it to a point with the same x and y"
        )


def _supported(constraint: object, atoms: Atoms) -> bool:
    """Return whether a constraint at most cancels the force on the indenter.

    Lateral constraints are harmless, since all forces are along z.
    """
    forces = np.zeros((len(atoms), 3))
    forces[:, 2] = np.linspace(1.0, 2.0, len(atoms))
    adjusted = forces.copy()
    constraint.adjust_forces(atoms, adjusted)  # type: ignore[attr-defined]
    if adjusted[-1, 2] == 0.0:
        forces[-1] = 0.0
    return np.array_equal(adjusted, forces)


def reference_stiffness(contact: Contact) -> float:
    """Return a stiffness to add to the half space, so that no wave is too compliant.

    Parameters
    ----------
    contact : Contact
        Contact with a soft wall.

    Returns
    -------
    float
        Three times the wall's stiffness where it begins to repel, and at least a tenth
        of E*/a0 (pressure per length).
    """
    wall, halfspace = contact.wall, contact.halfspace
    onset = wall.stiffness_at_contact
    return max(0.1 * halfspace.contact_modulus / halfspace.spacing, 3.0 * onset)
