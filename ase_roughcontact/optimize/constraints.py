"""What a solver of the half space reads off the atoms."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
from ase import Atoms
from ase.constraints import FixAtoms, FixCartesian, Hookean

from ase_roughcontact._util.validation import positive
from ase_roughcontact.atoms.calculator import RoughContact
from ase_roughcontact.contact import Contact


def contact_of(atoms: Atoms, *, hard: bool = False) -> Contact:
    """Return the contact of atoms, or say why a solver can't take them.

    Parameters
    ----------
    atoms : Atoms
        With a `RoughContact` calculator.
    hard : bool
        Whether the solver is for the hard wall, or for all others.

    Returns
    -------
    Contact

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, or the wall not of the kind.
    """
    if not isinstance(atoms.calc, RoughContact):
        raise ValueError(f"the atoms need a RoughContact, got {atoms.calc!r}")
    contact = atoms.calc.contact(atoms)
    if contact.interaction.hard != hard:
        raise ValueError(
            f"ActiveSet is for the hard wall, got {contact.interaction}"
            if hard
            else "a hard wall has no gradient: relax it with ActiveSet"
        )
    return contact


class Indenter:
    """Load and constraints of the indenter atom, as functions of its height.

    Parameters
    ----------
    atoms : Atoms
        Substrate and indenter with a `RoughContact` calculator.

    Attributes
    ----------
    fixed : bool
        Whether the height is fixed.

    Raises
    ------
    ValueError
        If there is a constraint that is not understood here: on a surface atom, or on
        the indenter other than `FixAtoms`, `FixCartesian` and a `Hookean` spring to a
        point or a plane.
    """

    def __init__(self, atoms: Atoms) -> None:
        self._last = len(atoms) - 1
        self._xy = atoms.positions[-1, :2].copy()
        self._load = atoms.calc.parameters["load"]
        self._box = {"cell": atoms.cell.copy(), "pbc": atoms.pbc.copy()}
        self._springs = []
        self.fixed = False
        for constraint in atoms.constraints:
            if isinstance(constraint, Hookean):
                self._springs.append(self._spring(constraint))
            else:
                self.fixed |= self._fixes(constraint)

    def external(self, height: float) -> tuple[float, float]:
        """Energy and force of load and springs, positive upward, at a height.

        Parameters
        ----------
        height : float
            Of the indenter (Å).

        Returns
        -------
        energy, force : float
            eV and eV/Å.
        """
        # the constraint asks for arrays over all atoms, and reads one of them
        position = np.array([*self._xy, height])
        atoms = SimpleNamespace(positions={self._last: position}, **self._box)
        forces = {self._last: np.zeros(3)}
        energy = self._load * height
        for spring in self._springs:
            spring.adjust_forces(atoms, forces)
            energy += spring.adjust_potential_energy(atoms)
        return float(energy), float(forces[self._last][2] - self._load)

    def _spring(self, constraint: Hookean) -> Hookean:
        pair = constraint._type == "two atoms"
        if pair or constraint.index % (self._last + 1) != self._last:
            raise ValueError(
                f"{constraint} does not tie the indenter to a point or a plane: "
                "relax it with one of ASE's optimizers on the atoms themselves"
            )
        if constraint._type == "point" and not np.allclose(
            constraint.origin[:2], self._xy, rtol=0.0, atol=1e-6
        ):
            raise ValueError(
                f"the spring is tied to {constraint.origin}, beside the indenter at "
                f"{self._xy}, which moves along z only: tie it to a point above or "
                "below, x, y, _ = atoms.positions[-1]"
            )
        return constraint

    def _fixes(self, constraint: object) -> bool:
        if isinstance(constraint, FixAtoms):
            along_z = True
        elif isinstance(constraint, FixCartesian):
            along_z = bool(constraint.mask[2])
        else:
            along_z = None
        indices = np.atleast_1d(getattr(constraint, "index", [])) % (self._last + 1)
        if along_z is False:
            return False  # nothing moves along x and y anyway
        if along_z and set(indices) <= {self._last}:
            return len(indices) > 0
        raise ValueError(
            f"{constraint} acts on surface atoms, or is not understood here: relax it "
            "with one of ASE's optimizers on the atoms themselves"
        )


def reference_stiffness(contact: Contact, given: float | None = None) -> float:
    """Stiffness to add to the half space's own, so that no wave is too soft.

    Parameters
    ----------
    contact : Contact
        With a soft wall.
    given : float, optional
        Taken instead, if it is positive.

    Returns
    -------
    float
        By default three times the wall's stiffness where it begins to repel, and at
        least a tenth of E*/a0 (pressure per length).
    """
    if given is None:
        onset = np.nextafter(contact.interaction.contact_distance, -np.inf)
        halfspace = contact.halfspace
        soft = 0.1 * halfspace.contact_modulus / halfspace.spacing
        given = max(soft, 3.0 * float(contact.interaction.evaluate(onset)[2]))
    positive(reference_stiffness=given)
    return given
