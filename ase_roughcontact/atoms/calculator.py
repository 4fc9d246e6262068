"""ASE calculator for the contact of a rigid rough indenter with an elastic solid."""

from __future__ import annotations

from typing import Any

import numpy as np
from ase import Atoms
from ase.calculators.calculator import Calculator, all_changes

from ase_roughcontact._util.kernels import array_equal
from ase_roughcontact._util.validation import finite, positive, surface, unknown
from ase_roughcontact.atoms.grid import SurfaceGrid, displacement
from ase_roughcontact.contact import Contact, ContactState
from ase_roughcontact.elasticity.fft import RealFFT2
from ase_roughcontact.elasticity.greens import ElasticSolid
from ase_roughcontact.interactions import Interaction, LennardJones93
from ase_roughcontact.topography import Surface

FFT_OPTIONS = ("dtype", "engine", "threads", "measure")
CONTACT_PROPERTIES = ("normal_force", "contact_area", "pressure", "gap", "contact")


class RoughContact(Calculator):
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

    :math:`K` is the inverse of the half space's Green's function. The boundary is that
    of the atoms: ``pbc = (True, True, False)`` makes a periodic half space, in which
    the mean plane is the reference (the averages above), ``pbc = False`` a free one,
    in which they are zero. Forces have no lateral components.

    Control follows from the indenter atom: fixed (`FixAtoms`), it stays at its height;
    free, it moves until the wall carries the `load`; tied to a point by ASE's
    `Hookean`, it is the tip of a cantilever.

    Parameters
    ----------
    indenter : Surface
        `RoughSphere`, `SelfAffine`, `HeightMap` or anything with their `heights`, and,
        to be written to files, `todict`.
    contact_modulus : float, optional
        ``E* = E/(1 - nu^2)`` of an isotropic substrate (eV/Å^3; 1 GPa is
        `ase.units.GPa`).
    interaction : Interaction, optional
        The wall; by default `LennardJones93.repulsive` as stiff as the substrate.
    solid : ElasticSolid, optional
        Substrate that is not isotropic, in place of `contact_modulus`.
    load : float
        Constant force that presses the indenter down (eV/Å); acts on it only where it
        is free to move.
    fft : dict, optional
        Options of the transforms, see `RealFFT2`: `dtype`, `engine`, `threads`,
        `measure`. With ducc0, the default ones were the fastest within a tenth (grids
        of 150 and 500). All other arithmetic takes as many threads as
        ``OMP_NUM_THREADS`` or `parallel.threads` say, by default all processors.

    Raises
    ------
    ValueError
        If a parameter is not a finite number, not positive where it must be, or not
        what it should be.
    TypeError
        If there is a parameter that is not known.

    Notes
    -----
    Besides ASE's properties there are `normal_force` (eV/Å), `contact_area` (Å^2),
    and, as arrays of the window's shape, `pressure` (eV/Å^3), `gap` (Å) and `contact`
    (bool): from `get_property` or, all of them, from `state`.

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
    >>> state = atoms.calc.state(atoms)
    >>> state.repulsive_atoms
    177
    """

    implemented_properties = ["energy", "free_energy", "energies", "forces"]
    default_parameters: dict[str, Any] = {
        "indenter": None,
        "contact_modulus": None,
        "solid": None,
        "interaction": None,
        "load": 0.0,
        "fft": {},
    }
    discard_results_on_any_change = True
    nolabel = True

    def __init__(
        self,
        indenter: Surface | None = None,
        contact_modulus: float | None = None,
        interaction: Interaction | None = None,
        **kwargs: Any,
    ) -> None:
        self._kept: tuple[tuple, tuple[SurfaceGrid, Contact]] | None = None
        self._held: tuple[np.ndarray, np.ndarray] | None = None
        super().__init__(
            indenter=indenter,
            contact_modulus=contact_modulus,
            interaction=interaction,
            **kwargs,
        )

    def __repr__(self) -> str:
        """Tell indenter, wall and, once atoms are known, boundary and height."""
        given = getattr(self, "parameters", {})
        radius = getattr(given.get("indenter"), "radius", None)
        sphere = isinstance(radius, (int, float))
        told = [f"sphere of radius {radius:.4g} Å" if sphere else "surface"]
        wall = given.get("interaction")
        told.append("repulsive wall" if wall is None else wall.label)
        atoms = getattr(self, "atoms", None)
        if atoms is not None and len(atoms):
            told.append("periodic" if atoms.pbc.any() else "free")
            told.append(f"height {atoms.positions[-1, 2]:.4g} Å")
        return f"RoughContact({', '.join(told)})"

    def set(self, **kwargs: Any) -> dict:
        """Change parameters; a change forgets the results.

        Parameters
        ----------
        **kwargs
            Any parameters of the class.

        Returns
        -------
        dict
            The parameters that changed.

        Raises
        ------
        ValueError, TypeError
            As for the class; nothing is changed then.
        """
        for name in kwargs:
            if name not in self.default_parameters:
                raise TypeError(
                    unknown(name, list(self.default_parameters), "parameter")
                )
        kwargs = {name: _checked(name, value) for name, value in kwargs.items()}
        changed = super().set(**kwargs)
        if set(changed) - {"load"}:
            self._kept = self._held = None
        return changed

    def calculate(
        self,
        atoms: Atoms | None = None,
        properties: list[str] | None = None,
        system_changes: list[str] = all_changes,
    ) -> None:
        """Calculate energy and forces; see the class."""
        super().calculate(atoms, properties, system_changes)
        if not np.isfinite(self.atoms.positions).all():
            raise ValueError("positions must be finite, got NaN or infinity")
        layout, contact = self._scene(self.atoms)
        height = float(self.atoms.positions[-1, 2])
        values = displacement(self.atoms, layout)
        state = contact.evaluate(values, height, self._holding(values))
        self._state = state

        load = self.parameters["load"]
        forces = np.zeros((len(self.atoms), 3))
        forces[:-1, 2] = state.forces.ravel()
        forces[-1, 2] = state.normal_force - load
        energy = state.energy + load * height
        self.results = {
            "energy": energy,
            "free_energy": energy,
            "energies": np.append(state.energies.ravel(), load * height),
            "forces": forces,
        }

    def get_property(
        self, name: str, atoms: Atoms | None = None, allow_calculation: bool = True
    ) -> Any:
        """Property by name: ASE's, and `CONTACT_PROPERTIES`."""
        if name not in CONTACT_PROPERTIES:
            return super().get_property(name, atoms, allow_calculation)
        known = super().get_property("energy", atoms, allow_calculation=False)
        if known is None and not allow_calculation:
            return None
        value = getattr(self.state(atoms), name)
        return value.copy() if isinstance(value, np.ndarray) else value

    def state(self, atoms: Atoms | None = None) -> ContactState:
        """Return forces, gaps and pressures of the atoms.

        Parameters
        ----------
        atoms : Atoms, optional
            By default those of the last calculation.

        Returns
        -------
        ContactState

        Raises
        ------
        ValueError
            If there are neither atoms nor a last calculation.
        """
        if atoms is None and not self.results:
            raise ValueError("nothing is calculated yet: give the atoms")
        self.get_property("energy", atoms)
        return self._state

    def hold(self, atoms: Atoms, pressure: np.ndarray) -> None:
        """Tell the pressure that displaces the atoms to where they are.

        A solver knows it. Elsewhere it has to be calculated from the displacement; that
        of a hard wall is no function of the positions when they are not relaxed, or
        when all atoms of a periodic surface touch.

        Parameters
        ----------
        atoms : Atoms
            Substrate and indenter.
        pressure : ndarray, shape (n, m)
            On the window (eV/Å^3).

        Raises
        ------
        ValueError
            If the pressure does not have the shape of the window.
        """
        layout, contact = self._scene(atoms)
        if pressure.shape != contact.heights.shape:
            raise ValueError(
                f"pressure must have the shape {contact.heights.shape} of the window, "
                f"got {pressure.shape}"
            )
        self._held = displacement(atoms, layout).copy(), pressure
        self.results = {}

    def elastic_pressure(self, atoms: Atoms) -> np.ndarray:
        """Pressure that displaces the atoms to where they are.

        Parameters
        ----------
        atoms : Atoms
            Substrate and indenter.

        Returns
        -------
        ndarray, shape (n, m)
            On the window (eV/Å^3), up to its mean if periodic.
        """
        layout, contact = self._scene(atoms)
        values = displacement(atoms, layout)
        held = self._holding(values)
        if held is None:
            n, m = contact.halfspace.shape
            held = contact.elastic_pressure(values)[:n, :m]
        return held

    def get_spin_polarized(self) -> bool:
        """Return False.

        The base class would put a method of its own here, and so keep the calculator,
        and a large half space with it, alive until the next garbage collection.
        """
        return False

    def check_state(self, atoms: Atoms, tol: float = 1e-15) -> list[str]:
        """Return what has changed since the last calculation; quick if nothing has."""
        if self.atoms is not None and len(self.atoms) == len(atoms):
            pairs = zip(_setting(self.atoms), _setting(atoms), strict=True)
            known = array_equal(self.atoms.positions, atoms.positions)
            if known and all(array_equal(*pair) for pair in pairs):
                return []
        return super().check_state(atoms, tol)

    def contact(self, atoms: Atoms) -> Contact:
        """Half space, indenter and wall as they are at the atoms.

        Parameters
        ----------
        atoms : Atoms
            Substrate and indenter.

        Returns
        -------
        Contact
            Kept as long as nothing but displacement, height and load change.
        """
        return self._scene(atoms)[1]

    def layout(self, atoms: Atoms) -> SurfaceGrid:
        """Shapes of window and grid of the atoms, checked; see `contact`."""
        return self._scene(atoms)[0]

    def _scene(self, atoms: Atoms) -> tuple[SurfaceGrid, Contact]:
        setting = _setting(atoms)
        if self._kept is None or not all(map(array_equal, setting, self._kept[0])):
            layout = SurfaceGrid.of(atoms)
            copies = tuple(part.copy() for part in setting)
            self._kept = copies, (layout, self._build(layout))
        return self._kept[1]

    def _build(self, layout: SurfaceGrid) -> Contact:
        given = self.parameters
        solid = given["solid"] or given["contact_modulus"]
        indenter, interaction = given["indenter"], given["interaction"]
        if indenter is None or solid is None:
            raise ValueError(
                "RoughContact needs an indenter and a contact_modulus or solid"
            )
        if given["solid"] is not None and given["contact_modulus"] is not None:
            raise ValueError("give contact_modulus or solid, not both")
        halfspace = layout.halfspace(solid, **given["fft"])
        if interaction is None:
            modulus = halfspace.contact_modulus
            interaction = LennardJones93.repulsive(modulus, layout.spacing)
        return Contact(halfspace, layout.heights(indenter), interaction)

    def _holding(self, values: np.ndarray) -> np.ndarray | None:
        """Pressure that a solver has told, if the atoms are where they were then."""
        if self._held is None or not array_equal(self._held[0], values):
            return None
        return self._held[1]


def _setting(atoms: Atoms) -> tuple[np.ndarray, ...]:
    """All that half space, heights and wall depend on."""
    xy, axis = atoms.positions[:-1, :2], atoms.positions[-1, :2]
    return xy, axis, atoms.cell.array, atoms.pbc, atoms.numbers


def _checked(name: str, value: Any) -> Any:
    """Return a parameter in the form in which it is kept, or raise `ValueError`."""
    if name == "load":
        finite(load=value)
        return float(value)
    if name == "fft":
        return _checked_fft(value)
    if value is None:
        return None
    if name == "solid" and not isinstance(value, ElasticSolid):
        raise ValueError(f"solid must be an ElasticSolid, got {value!r}")
    if name == "contact_modulus":
        positive(contact_modulus=value)
        return float(value)
    if name == "interaction" and not isinstance(value, Interaction):
        raise ValueError(f"interaction must be an Interaction, got {value!r}")
    if name == "indenter":
        surface(indenter=value)
    return value


def _checked_fft(options: Any) -> dict:
    if not isinstance(options, dict):
        raise ValueError(f"fft must be a dict of options, got {options!r}")
    options = dict(options)
    for key in options:
        if key not in FFT_OPTIONS:
            raise ValueError(unknown(str(key), FFT_OPTIONS, "option of fft"))
    # fails now, and not at the first calculation, if an option is wrong
    trial = RealFFT2((1, 1), **options)
    if "dtype" in options:
        options["dtype"] = trial.dtype.name
    return options
