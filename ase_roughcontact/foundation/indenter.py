"""Rigid indenter on explicit atoms, with the walls of this package."""

from __future__ import annotations

import math

import numpy as np
from ase import Atom, Atoms
from ase.calculators.calculator import all_changes
from ase.calculators.mixing import SumCalculator
from ase.constraints import FixCartesian
from ase.data import atomic_masses
from scipy.interpolate import RectBivariateSpline

from ase_roughcontact._util.callers import warn
from ase_roughcontact._util.properties import PropertiesCalculator
from ase_roughcontact._util.validation import finite, instance_of, positive, surface
from ase_roughcontact.foundation.calculator import ElasticFoundation
from ase_roughcontact.interactions import Interaction, LennardJones93
from ase_roughcontact.interactions.consistency import check_wall
from ase_roughcontact.topography import Surface
from ase_roughcontact.topography.topography import topography_of

# Number of samples of the shape per spacing, between which the shape is interpolated.
_SAMPLES_PER_SPACING = 4
# Distance from the axis, as a fraction of the cell, beyond which atoms are at the
# border of the cell.
_BORDER = 0.49
# Relative rounding error of a number of samples.
_NUMBER_ERROR = 1e-9
# Largest change of slope across the border of a periodic indenter.
_MAX_KINK = 1e-3


class RigidIndenter(PropertiesCalculator):
    r"""Forces between atoms and a rigid rough indenter.

    The indenter is an atom of the number zero (symbol X) at :math:`(X, Y, Z)`. With its
    shape :math:`h`, the energy of the other atoms is

    .. math:: U = A \sum_i V(g_i) + L Z, \qquad
              g_i = Z + h(x_i - X, y_i - Y) - z_i .

    Atoms also move along the surface: cubic splines interpolate :math:`h`, and its
    slopes cause lateral forces. The wall acts on all atoms within its range, also below
    the surface.

    Parameters
    ----------
    indenter : Surface
        Shape of the indenter: `RoughSphere`, `SelfAffine`, `HeightMap` or any object
        with their method `heights`.
    wall : Interaction
        Wall, which must not be hard.
    spacing : float
        Distance of nearest neighbours in the surface (Å).
    area : float
        Area A of an atom in the surface (Å^2).
    load : float, optional
        Force L that presses the indenter down (eV/Å). Without it, constraints hold the
        indenter.

    Raises
    ------
    ValueError
        If a parameter is out of range, or the wall is hard; in a calculation, if there
        is not one atom X, or the wall acts at the border of the cell and the indenter
        does not have the period of the cell.

    Warns
    -----
    UserWarning
        Once, if no constraint holds an indenter that should be held.

    Notes
    -----
    Besides the properties of ASE, `get_property` returns ``"normal_force"`` (eV/Å) and,
    as arrays of all atoms, ``"gap"`` (Å, infinite where the shape is not known) and
    ``"contact"`` (bool).
    """

    implemented_properties = ["energy", "free_energy", "forces"]
    own_properties = ["normal_force", "gap", "contact"]
    nolabel = True

    def __init__(
        self,
        indenter: Surface,
        wall: Interaction,
        spacing: float,
        area: float,
        load: float | None = None,
    ) -> None:
        super().__init__()
        surface(indenter=indenter)
        positive(spacing=spacing, area=area)
        self.load = 0.0 if load is None else load
        finite(load=self.load)
        if not isinstance(wall, Interaction) or wall.hard:
            raise ValueError(
                f"atoms need a soft wall such as LennardJones93.repulsive, got {wall!r}"
            )
        check_wall(wall, spacing)
        self.indenter, self.wall = indenter, wall
        self.spacing, self.area = spacing, area
        # directions along which constraints hold the indenter
        self._held = [True, True, load is None]
        self._warned = False
        self._step = spacing / _SAMPLES_PER_SPACING
        self._cell = np.zeros((2, 2))

    def lowest(self, cell: np.ndarray) -> float:
        """Return the lowest height of the indenter in a cell, shape (2, 2)."""
        self._interpolate(cell)
        return float(self._heights.min())

    def calculate(
        self,
        atoms: Atoms | None = None,
        properties: list[str] | None = None,
        system_changes: list[str] = all_changes,
    ) -> None:
        """Calculate energy and forces; see the class."""
        super().calculate(atoms, properties, system_changes)
        index, others = indenter_index(self.atoms), self.atoms.numbers > 0
        cell = self.atoms.cell.array[:2, :2]
        if (cell != self._cell).any():
            self._interpolate(cell)
        relative = self.atoms.positions[others] - self.atoms.positions[index]
        fractions = relative[:, :2] @ np.linalg.inv(cell)
        fractions -= np.rint(fractions)
        positions = fractions @ cell
        heights, slopes = self._shape(positions)
        gap = heights - relative[:, 2]
        near = gap < self.wall.cutoff
        if self._kink and (abs(fractions[near]) > _BORDER).any():
            raise ValueError(
                "the wall acts on atoms at the border of the periodic cell, where the "
                "indenter meets its image at an angle: use a larger cell, or a smaller "
                "radius or depth"
            )
        energy, pressure = np.zeros(gap.shape), np.zeros(gap.shape)
        energy[near], pressure[near], _ = self.wall.evaluate(gap[near])

        forces = np.zeros((len(self.atoms), 3))
        forces[others, :2] = self.area * pressure[:, None] * slopes
        forces[others, 2] = -self.area * pressure
        forces[index] = -forces.sum(axis=0)
        normal_force = float(forces[index, 2])
        if normal_force:
            self._warn_if_released(index)
        forces[index, 2] -= self.load
        total = self.area * float(energy.sum())
        total += self.load * self.atoms.positions[index, 2]
        gaps = np.full(len(self.atoms), np.inf)
        contact = np.zeros(len(self.atoms), bool)
        gaps[others], contact[others] = gap, pressure > 0.0
        self.results = {"energy": total, "free_energy": total, "forces": forces}
        self.own_results = {
            "normal_force": normal_force,
            "gap": gaps,
            "contact": contact,
        }

    def _warn_if_released(self, index: int) -> None:
        """Warn once if no constraint holds an indenter that should be held."""
        constraints = self.atoms.constraints
        springs = any(hasattr(each, "adjust_potential_energy") for each in constraints)
        if self._warned or springs:
            return
        forces = np.ones((len(self.atoms), 3))
        for constraint in constraints:
            constraint.adjust_forces(self.atoms, forces)
        if forces[index, self._held].any():
            self._warned = True
            warn(
                "nothing holds the indenter: the constraint of add_indenter is lost. "
                "Add FixCartesian, or constraints by "
                "set_constraint([*atoms.constraints, new])"
            )

    def _interpolate(self, cell: np.ndarray) -> None:
        """Sample the shape over a cell around the axis."""
        half = abs(cell).sum(axis=0) / 2
        indenter = topography_of(self.indenter)
        flat = indenter.apex_radius == math.inf
        periodic = flat and np.allclose(indenter.periods, 2 * half)
        extent = half if periodic else np.minimum(half, indenter.extent)
        number = np.floor(extent / self._step * (1 + _NUMBER_ERROR)).astype(int)
        whole = periodic and np.allclose(half, self._step * number)
        if not whole:  # beyond the cell, for the slopes at its border
            number += extent >= half
        (n, m), (x, y) = (2 * number + 1 - whole).tolist(), (-self._step * number)
        self._heights = self.indenter.heights((n, m), self._step, (x, y))
        if whole:  # one period, which also gives the samples beyond the cell
            self._heights = np.pad(self._heights, (1, 2), mode="wrap")
            number += 1
        x, y = (self._step * np.arange(-k, k + 1) for k in number)
        self._spline = RectBivariateSpline(x, y, self._heights)
        self._reach = self._step * number
        self._cell = cell.copy()
        ends = np.array([1.0, -1.0])[:, None] * cell[:, None] / 2
        slopes = self._shape(ends.reshape(4, 2))[1].reshape(2, 2, 2)
        self._kink = abs(np.diff(slopes, axis=1)).max() > _MAX_KINK

    def _shape(self, positions: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return heights, shape (n,), and slopes, shape (n, 2)."""
        inside = (abs(positions) <= self._reach).all(axis=1)
        heights = np.full(len(positions), np.inf)
        slopes = np.zeros((len(positions), 2))
        x, y = positions[inside].T
        heights[inside] = self._spline.ev(x, y)
        slopes[inside, 0] = self._spline.ev(x, y, dx=1)
        slopes[inside, 1] = self._spline.ev(x, y, dy=1)
        return heights, slopes


def indenter_index(atoms: Atoms) -> int:
    """Return the index of the indenter; raise `ValueError` if there is not one."""
    found = np.flatnonzero(atoms.numbers == 0)
    if len(found) != 1:
        raise ValueError(
            f"there must be one atom X, the indenter, got {len(found)}: see "
            "add_indenter"
        )
    return int(found[0])


def add_indenter(
    atoms: Atoms,
    indenter: Surface,
    wall: Interaction | None = None,
    *,
    height: float | None = None,
    position: tuple[float, float] | None = None,
    load: float | None = None,
    mass: float | None = None,
) -> RigidIndenter:
    """Put a rigid indenter on a slab.

    Parameters
    ----------
    atoms : Atoms
        Slab with an `ElasticFoundation` as calculator, see `crystal_slab`. The
        indenter, an atom X, and its calculator are added in place. If there is an
        indenter already, as in atoms from a file, it stays at its position.
    indenter : Surface
        Shape of the indenter.
    wall : Interaction, optional
        Wall; by default `LennardJones93.repulsive`, as stiff as the crystal.
    height : float, optional
        Position z of the indenter (Å); by default its lowest point is where the wall
        begins to repel the highest atom.
    position : (float, float), optional
        Position x and y of the axis of the indenter (Å), which is fixed; by default the
        middle of the cell.
    load : float, optional
        Force that presses the indenter down (eV/Å). Without it the height is fixed,
        too.
    mass : float, optional
        Mass of the indenter in dynamics (amu). By default it is the mass of a layer of
        the slab: the indenter does then not vibrate faster than an atom, however many
        atoms touch it.

    Returns
    -------
    RigidIndenter
        Calculator of the indenter; ``atoms.calc`` is the sum of it and the foundation.

    Raises
    ------
    ValueError
        If the atoms have no foundation, or a height or a position is given for an
        indenter that is there already.

    Examples
    --------
    >>> from ase.calculators.emt import EMT
    >>> from ase_roughcontact import RoughSphere
    >>> from ase_roughcontact.foundation import add_indenter, crystal_slab
    >>> atoms, foundation = crystal_slab("Cu", (8, 8), 4, EMT())  # doctest: +SKIP
    >>> sphere = add_indenter(atoms, RoughSphere(50.0))  # doctest: +SKIP
    >>> atoms.positions[-1, 2] -= 0.5  # press it down by 0.5 Å  # doctest: +SKIP
    """
    instance_of(Atoms, atoms=atoms)
    has_indenter = (atoms.numbers == 0).any()
    if has_indenter and (height is not None or position is not None):
        raise ValueError(
            "the atoms have an indenter already: omit height and position, and move it "
            "by atoms.positions"
        )
    foundation = atoms.calc
    if not isinstance(foundation, ElasticFoundation):
        raise ValueError(
            "the atoms need an ElasticFoundation as calculator, see crystal_slab, got "
            f"{foundation!r}. To replace an indenter, set atoms.calc = foundation first"
        )
    spacing, area = foundation.surface.constants.spacing, foundation.surface.cell_area
    if wall is None:
        modulus = foundation.surface.contact_modulus
        wall = LennardJones93.repulsive(modulus, spacing)
    calculator = RigidIndenter(indenter, wall, spacing, area, load)
    if has_indenter:
        index = indenter_index(atoms)
    else:
        index = len(atoms)
        if height is None:
            top = atoms.positions[:, 2].max()
            lowest = calculator.lowest(atoms.cell.array[:2, :2])
            height = top + wall.contact_distance - lowest
        if position is None:
            x, y = atoms.cell.array[:2, :2].sum(axis=0) / 2
        else:
            x, y = position
        atoms.append(Atom("X", (x, y, height)))
    masses = atoms.get_masses()
    if mass is None and masses[index] == atomic_masses[0]:  # the default of ASE
        lowest = foundation.sites.indices[-1]
        mass = float(masses[atoms.numbers > 0][lowest].sum())
    if mass is not None:
        positive(mass=mass)
        masses[index] = mass
        atoms.set_masses(masses)
    # constraints that do not act on the indenter alone
    others = [
        each
        for each in atoms.constraints
        if np.ravel(getattr(each, "index", [])).tolist() != [index]
    ]
    fixed = FixCartesian([index], mask=(True, True, load is None))
    atoms.set_constraint([*others, fixed])
    atoms.calc = SumCalculator([foundation, calculator])
    return calculator
