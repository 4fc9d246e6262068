"""ASE calculator for the contact of a rigid rough indenter with an elastic solid."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NoReturn

import numpy as np
from ase import Atoms
from ase.calculators.calculator import all_changes

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.kernels import array_equal
from ase_roughcontact._util.properties import PropertiesCalculator
from ase_roughcontact._util.rounding import LENGTH_ROUNDING
from ase_roughcontact._util.validation import instance_of, unknown
from ase_roughcontact.atoms.grid import SurfaceGrid, displacement
from ase_roughcontact.atoms.history import (
    check_history,
    creep_of,
    history_of,
    same_history,
)
from ase_roughcontact.atoms.marks import check_indenter, was_fixed
from ase_roughcontact.atoms.model import ContactModel, checked, problem_for
from ase_roughcontact.atoms.sticking import (
    Sticking,
    check_kept,
    indenter_fixed,
    sticking_of,
)
from ase_roughcontact.contact import Contact, ContactState, Problem, State
from ase_roughcontact.elasticity import ElasticSolid
from ase_roughcontact.elasticity.lattice import Box
from ase_roughcontact.interactions import Interaction
from ase_roughcontact.topography import Heterogeneity, Surface

#: Properties of the state of the contact, which ASE does not define.
CONTACT_PROPERTIES = ["normal_force", "contact_area", "pressure", "gap", "contact"]


class RoughContact(PropertiesCalculator):
    r"""Elastic half space under a rigid rough indenter.

    The atoms are a grid of surface atoms and the indenter, see `substrate`. With
    :math:`u` the atoms' z, :math:`Z` the indenter's, :math:`h` the indenter's shape,
    :math:`a_0` the spacing, :math:`V` the wall's energy per area and :math:`L` the
    load, the energy is

    .. math:: U = \frac{a_0^2}{2} \sum u (K u) + a_0^2 \sum V(g) + L Z,
              \qquad g = Z + h - (u - \langle u\rangle),

    and the forces along z follow from it:

    .. math:: f = -a_0^2 [K u + p - \langle p\rangle], \qquad
              f_\text{indenter} = a_0^2 \sum p - L, \qquad p = -V'(g).

    :math:`K` is the inverse of the half space's Green's function. The boundary follows
    from the atoms: ``pbc = (True, True, False)`` makes a periodic half space, in which
    the mean plane is the reference (the averages above), ``pbc = False`` a free one,
    in which they are zero. Forces have lateral components where atoms `stick` only.

    The constraints of the indenter atom choose the control. An indenter that is fixed
    (`FixAtoms`) stays at its height. The load does not act on it then: the terms with
    :math:`L` are absent from energy and forces. A free indenter moves until the wall
    carries the `load`. An indenter that ASE's `Hookean` ties to a point is the tip of a
    cantilever.

    Parameters
    ----------
    indenter : Surface
        `RoughSphere`, `SelfAffine`, `HeightMap` or any object with their method
        `heights` and, so that files and checks can name it, `todict`.
    contact_modulus : float, optional
        ``E* = E/(1 - nu^2)`` of an isotropic substrate (eV/Å^3; 1 GPa is
        `ase.units.GPa`).
    wall : Interaction, optional
        The wall; by default `LennardJones93.repulsive` as stiff as the substrate.
    heterogeneity : Heterogeneity, optional
        Local work of adhesion, relative to the work of adhesion of an attractive wall;
        by default it is the same everywhere. See `Heterogeneity`.
    solid : ElasticSolid, optional
        Substrate that is not isotropic, in place of `contact_modulus`.
    load : float
        Constant force that presses the indenter down (eV/Å), unless it is fixed.
    fft : dict, optional
        Options of the transforms, see `RealFFT2`: `dtype`, `engine`, `threads`.
        All other arithmetic uses ``OMP_NUM_THREADS`` threads, by default one per
        processor.
    atoms : Atoms, optional
        Atoms that get the calculator.
    **unknown
        None: another keyword is an error that names the most similar parameter.

    Raises
    ------
    ValueError
        If a parameter is not a finite number, not positive where it must be, or of the
        wrong kind; at a calculation, if the atoms were built for another indenter, or
        have lost what their surface keeps of earlier steps.
    TypeError
        If a parameter is unknown.

    Warns
    -----
    UserWarning
        Once for every load, if it does not act because the indenter is fixed; once, if
        a file or `Atoms.set_constraint` has freed an indenter that was fixed, or all
        atoms were moved along z.

    Notes
    -----
    The dictionary `results` has the properties that ASE defines. `get_property` returns
    others, too: ``"normal_force"`` (eV/Å), ``"contact_area"`` (Å^2), after
    `sliding_path` and where atoms `stick` the ``"lateral_force"`` along x and y that
    holds the indenter (eV/Å), and, as arrays of the window's shape (n, m),
    ``"pressure"`` (eV/Å^3), ``"gap"`` (Å) and ``"contact"`` (bool). `state` returns
    them all at once. ASE's file formats do not store them; `snapshot` makes frames that
    carry them.

    Indenter, solid and walls can also be given by the result of their method `todict`,
    so that ``RoughContact(**calc.todict())`` is an equal calculator; see `fromdict`.

    Numerical forces, as of `ase.calculators.fd.calculate_numerical_forces`, are
    defined along z: give ``icarts=[2]``.

    The work of the load on a fixed indenter, where it is wanted in an energy, is
    ``load * atoms.positions[-1, 2]``.

    References
    ----------
    L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016); C. Campana,
    M. H. Müser, Phys. Rev. B 74, 075420 (2006).

    Examples
    --------
    >>> from ase.optimize import LBFGS
    >>> from ase_roughcontact import RoughContact, RoughSphere, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (16, 16), sphere, height=1.0)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.5)
    >>> bool(LBFGS(atoms, logfile=None).run(fmax=1e-4))
    True
    >>> atoms.calc.state(atoms).repulsive_atoms
    177
    >>> int(atoms.calc.get_property('contact', atoms).sum())
    177
    """

    implemented_properties = [
        "energy",
        "free_energy",
        "energies",
        "forces",
    ]
    own_properties = [*CONTACT_PROPERTIES, "lateral_force"]
    default_parameters: dict[str, Any] = {
        "indenter": None,
        "contact_modulus": None,
        "solid": None,
        "wall": None,
        "heterogeneity": None,
        "load": 0.0,
        "fft": {},
    }
    discard_results_on_any_change = True
    nolabel = True

    def __init__(
        self,
        indenter: Surface | None = None,
        contact_modulus: float | None = None,
        wall: Interaction | None = None,
        *,
        heterogeneity: Heterogeneity | None = None,
        solid: ElasticSolid | None = None,
        load: float = 0.0,
        fft: dict[str, Any] | None = None,
        atoms: Atoms | None = None,
        **unknown: NoReturn,
    ) -> None:
        self._cached_model: ContactModel | None = None
        self._checked_parameters: dict[str, Any] = {}
        self._fixed: bool | None = None  # whether the indenter was, when calculated
        self._sticking: Sticking | None = None
        self._warned_of_load = 0.0
        self._warned_of_indenter = self._warned_of_translation = False
        if wall is None:  # an earlier name of the parameter
            wall = unknown.pop("interaction", None)
        super().__init__(
            atoms=atoms,
            indenter=indenter,
            contact_modulus=contact_modulus,
            solid=solid,
            wall=wall,
            heterogeneity=heterogeneity,
            load=load,
            fft={} if fft is None else fft,
            **unknown,
        )

    @classmethod
    def fromdict(cls, parameters: Mapping[str, Any]) -> RoughContact:
        """Return the calculator that a dictionary describes.

        Parameters
        ----------
        parameters : mapping
            Result of `todict`, also from a file.

        Returns
        -------
        RoughContact

        Raises
        ------
        ValueError
            If an object does not describe itself completely, such as a `HeightMap`:
            replace its entry by the object.
        """
        return cls(**parameters)

    def __repr__(self) -> str:
        """Return the parameters that differ from their defaults."""
        parameters = getattr(self, "parameters", {})
        changed = [
            f"{name}={value!r}"
            for name, value in parameters.items()
            if value != self.default_parameters[name]
        ]
        return f"RoughContact({', '.join(changed)})"

    def set(self, **kwargs: Any) -> dict:
        """Change parameters; a change discards the results.

        Parameters
        ----------
        **kwargs
            Parameters of the class.

        Returns
        -------
        dict
            The parameters that changed.

        Raises
        ------
        ValueError, TypeError
            As for the class; nothing is changed then.
        """
        if "wall" not in kwargs and "interaction" in kwargs:
            kwargs["wall"] = kwargs.pop("interaction")
        for name in kwargs:
            if name not in self.default_parameters:
                raise TypeError(
                    unknown(name, list(self.default_parameters), "parameter")
                )
        kwargs = {name: checked(name, value) for name, value in kwargs.items()}
        changed = super().set(**kwargs)
        if set(changed) - {"load"}:
            self._cached_model = None
        self._checked_parameters = _copied(self.parameters)
        return changed

    def calculate(
        self,
        atoms: Atoms | None = None,
        properties: list[str] | None = None,
        system_changes: list[str] = all_changes,
    ) -> None:
        """Calculate all properties; see the class."""
        self.adopt_parameters()
        super().calculate(atoms, properties, system_changes)
        model = self._model(self.atoms)
        values = displacement(self.atoms, model.grid)
        height = float(self.atoms.positions[-1, 2])
        state = self._state = model.state(values, height).read_only()
        self._fixed, self._sticking = _constraints_of(self.atoms)
        load = self.parameters["load"]
        if not model.grid.periodic and values.size > 1 and not np.ptp(values):
            self._warn_of_translation(float(values[0, 0]))
        if self._fixed:
            self._warn_of_load(load)
            load = 0.0
        elif state.normal_force and not load and was_fixed(self.atoms):
            self._warn_of_free_indenter()
        work = load * height
        energies = np.append(model.contact.energies(values, state), work)
        del values  # its memory is needed
        forces = np.zeros((len(self.atoms), 3))
        if state.forces.any():
            forces[:-1, 2] = state.forces.ravel()
        forces[-1, 2] = state.normal_force - load
        energy, lateral_force = state.energy + work, model.lateral_force
        if self._sticking is not None:
            lateral, forces[:-1, :2] = model.lateral_energies(self.atoms)
            energy, energies[:-1] = energy + lateral.sum(), energies[:-1] + lateral
            lateral_force = self._sticking.lateral_force(forces)
        self.results = {
            "energy": energy,
            "free_energy": energy,
            "energies": energies,
            "forces": forces,
        }
        self.own_results = {name: getattr(state, name) for name in CONTACT_PROPERTIES}
        self.own_results["lateral_force"] = lateral_force

    def _warn_of_load(self, load: float) -> None:
        """Warn of a load on a fixed indenter, once for every load."""
        if load not in (0.0, self._warned_of_load):
            self._warned_of_load = load
            warn(
                f"the load of {load:g} eV/Å does not act on a fixed indenter: build "
                "the atoms with substrate(..., fixed=False), remove the constraint, or "
                "set the load to zero"
            )

    def _warn_of_free_indenter(self) -> None:
        """Warn once that nothing holds an indenter that was fixed."""
        springs = (
            hasattr(c, "adjust_potential_energy") for c in self.atoms.constraints
        )
        if self._warned_of_indenter or any(springs):
            return
        self._warned_of_indenter = True
        warn(
            "nothing holds the indenter, as a file or set_constraint has removed its "
            "constraint: add FixAtoms([len(atoms) - 1]) to the constraints, or set a "
            "load"
        )

    def _warn_of_translation(self, distance: float) -> None:
        """Warn once that all atoms were moved along z."""
        if self._warned_of_translation or not distance:
            return
        self._warned_of_translation = True
        warn(
            f"the atoms were moved along z by {distance:.4g} Å, which changes the "
            "contact: move them back; center() and translate() are for x and y only"
        )

    def state(self, atoms: Atoms | None = None) -> ContactState:
        """Return forces, gaps and pressures of the atoms.

        Parameters
        ----------
        atoms : Atoms, optional
            The atoms; by default the ones of the last calculation.

        Returns
        -------
        ContactState
            Its arrays are read-only.

        Raises
        ------
        ValueError
            If there are neither atoms nor a last calculation.
        """
        if atoms is None and not self.results:
            raise ValueError("nothing has been calculated: give the atoms")
        self.get_property("energy", atoms)
        return self._state

    def get_spin_polarized(self) -> bool:
        """Return False.

        The base class would store a method of its own here, and so keep the calculator,
        and a large half space with it, alive until the next garbage collection.
        """
        return False

    def check_state(self, atoms: Atoms, tol: float = 1e-15) -> list[str]:
        """Return the names of changes, in any bit, since the last calculation."""
        if self.atoms is None:
            return all_changes[:]
        if self.parameters != self._checked_parameters:
            return ["parameters"]
        fixed, sticking = _constraints_of(atoms)
        if self._fixed != fixed or self._sticking != sticking:
            return ["constraints"]
        if not same_history(self.atoms, atoms):
            return ["history"]
        old = self.atoms
        is_equal = {
            "positions": array_equal(old.positions, atoms.positions),
            "numbers": array_equal(old.numbers, atoms.numbers),
            "cell": array_equal(old.cell[:], atoms.cell[:]),
            "pbc": array_equal(old.pbc, atoms.pbc),
        }
        changes = [name for name, equal in is_equal.items() if not equal]
        if "positions" in changes and len(atoms) == len(self.atoms):
            moved = atoms.positions[:, 2] - self.atoms.positions[:, 2]
            if np.ptp(moved) < LENGTH_ROUNDING * abs(moved[0]):
                self._warn_of_translation(float(moved[0]))
        return changes

    def _check_positions(self, atoms: Atoms) -> None:
        """Raise `ValueError` if an optimizer has failed at a hard wall."""
        wall = self.parameters["wall"]
        if wall is not None and wall.hard and not np.isfinite(atoms.positions).all():
            raise ValueError(
                "positions must be finite, got NaN or infinity: a hard wall has no "
                f"gradient for an optimizer of ASE, relax it with {wall.optimizer}"
            )

    def adopt_parameters(self) -> None:
        """Check parameters that were changed in `parameters`, without `set`."""
        changed = dict(self.parameters)
        if changed != self._checked_parameters:
            self.parameters.clear()
            self.parameters.update(self._checked_parameters)
            self.set(**changed)

    def _model(self, atoms: Atoms) -> ContactModel:
        """Return the model of the atoms, built anew where their lattice has changed."""
        self._check_positions(atoms)
        check_history(atoms)
        if self._cached_model is None or not self._cached_model.fits(atoms):
            self._cached_model = ContactModel.of(atoms, self.parameters)
        self._cached_model.adopt_history(atoms)
        check_indenter(atoms, self._cached_model.surface_id)
        return self._cached_model


def _copied(parameters: Mapping[str, Any]) -> dict[str, Any]:
    """Return parameters as a dictionary that changes of them do not change."""
    return {**parameters, "fft": dict(parameters["fft"])}


def _constraints_of(atoms: Atoms) -> tuple[bool, Sticking | None]:
    check_kept(atoms)
    return indenter_fixed(atoms), sticking_of(atoms)


def contact_of(atoms: Atoms) -> Contact:
    """Return half space, indenter and wall of the atoms.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator.

    Returns
    -------
    Contact
        The same object as long as only displacement, height and load change.

    Raises
    ------
    ValueError
        If the calculator is not a `RoughContact`, or the atoms are not a grid and an
        indenter.
    """
    return model_of(atoms).contact


def problem_of(atoms: Atoms) -> tuple[Problem, Box]:
    """Return the contact problem and the window of atoms; see `contact_of`.

    The indenter is not sampled.
    """
    parameters = calculator_of(atoms).parameters
    check_history(atoms)
    grid = SurfaceGrid.of(atoms)
    problem = problem_for(grid, parameters)
    return problem, problem.window(grid.window, grid.origin)


def state_of(atoms: Atoms) -> State:
    """Return the state of atoms with a `RoughContact` calculator."""
    model = model_of(atoms)
    grid = model.grid
    n, m = grid.window
    return State(
        model.problem.window(grid.window, grid.origin),
        float(atoms.positions[-1, 2]),
        model.elastic_pressure(atoms),
        displacement(atoms, grid)[:n, :m],
        history_of(atoms, grid),
        creep=creep_of(atoms),
    ).in_order()


def uses_model(atoms: Atoms, model: ContactModel) -> bool:
    """Return whether the calculator of the atoms and its parameters are unchanged."""
    return isinstance(atoms.calc, RoughContact) and atoms.calc._cached_model is model


def adopt_model(atoms: Atoms, model: ContactModel) -> None:
    """Let the calculator of atoms use a model that was made for them elsewhere."""
    atoms.calc._cached_model = model


def model_of(atoms: Atoms) -> ContactModel:
    """Return the model that the calculator has of the atoms; see `contact_of`."""
    return calculator_of(atoms)._model(atoms)


def calculator_of(atoms: Atoms) -> RoughContact:
    """Return the calculator of atoms, with its class for type checkers and completion.

    Parameters
    ----------
    atoms : Atoms
        Atoms with a `RoughContact` calculator.

    Returns
    -------
    RoughContact
        ``atoms.calc``, for which ASE declares no class.

    Raises
    ------
    ValueError
        If it is another calculator.
    TypeError
        If the atoms are no `Atoms`.

    Examples
    --------
    >>> from ase_roughcontact import RoughContact, RoughSphere
    >>> from ase_roughcontact import calculator_of, substrate
    >>> sphere = RoughSphere(radius=200.0)
    >>> atoms = substrate('Cu', (8, 8), sphere, height=-0.5)
    >>> atoms.calc = RoughContact(sphere, contact_modulus=0.9)
    >>> calculator_of(atoms).state(atoms).repulsive_atoms
    64
    """
    instance_of(Atoms, atoms=atoms)
    if not isinstance(atoms.calc, RoughContact):
        raise ValueError(f"the atoms need a RoughContact calculator, got {atoms.calc}")
    atoms.calc.adopt_parameters()
    return atoms.calc
