"""A whole calculation as one object, also written as a TOML file.

See ``ase_roughcontact/default.toml`` for the format, key by key.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from dataclasses import asdict, dataclass, field
from functools import partial
from importlib.resources import files
from pathlib import Path
from typing import Any

import numpy as np
from ase import Atoms
from ase.optimize import FIRE, FIRE2, LBFGS, BFGSLineSearch
from ase.units import GPa, J, m
from numpy.typing import ArrayLike

from ase_roughcontact import theory
from ase_roughcontact.accuracy import Accuracy, accuracy_of
from ase_roughcontact.calculator import RoughContact
from ase_roughcontact.checks import finite, grid_shape, integer, positive, unknown
from ase_roughcontact.interactions import HardWall, Interaction, LennardJones93
from ase_roughcontact.loading import load_path
from ase_roughcontact.material import contact_modulus, crystal_modulus
from ase_roughcontact.memory import check_memory
from ase_roughcontact.optimize import FourierModes, HardWallCG, NewtonKrylov
from ase_roughcontact.plan import Plan, plan_path
from ase_roughcontact.record import LoadStep
from ase_roughcontact.substrate import fcc_spacing, substrate
from ase_roughcontact.tables import (
    InteractionTable,
    PathTable,
    RoughnessTable,
    SolverTable,
    SphereTable,
    SubstrateTable,
    table_of,
)
from ase_roughcontact.topography import RoughSphere, SelfAffine

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

# Of the atoms before a window is chosen for them.
_FIRST_SHAPE = (8, 8)

#: One nanonewton in ASE's unit of force, eV/Å.
NANONEWTON = 1e-9 * J / m


def _on_modes(cls: type, atoms: Atoms, **options: Any) -> Any:
    """Optimizer of ASE on the scaled modes of the half space."""
    modes = FourierModes(atoms)
    if cls in (FIRE, FIRE2):
        options["maxstep"] = modes.maxstep
    if cls is LBFGS:
        options |= {"alpha": 1.0, "memory": 20}
    return cls(modes, **options)


OPTIMIZERS: dict[str, Any] = {
    "NewtonKrylov": NewtonKrylov,
    "HardWallCG": HardWallCG,
    **{
        cls.__name__: partial(_on_modes, cls)
        for cls in (LBFGS, FIRE, FIRE2, BFGSLineSearch)
    },
}


@dataclass(frozen=True)
class Scene:
    """Sphere, material, wall, path and solver.

    Parameters
    ----------
    substrate, sphere, roughness, interaction, path, solver
        The tables of a scene file. Without `roughness` the sphere is smooth.

    Raises
    ------
    ValueError
        From `read` and from the methods, if a value is not what it should be.
    """

    substrate: SubstrateTable = field(default_factory=SubstrateTable)
    sphere: SphereTable = field(default_factory=SphereTable)
    roughness: RoughnessTable | None = None
    interaction: InteractionTable = field(default_factory=InteractionTable)
    path: PathTable = field(default_factory=PathTable)
    solver: SolverTable = field(default_factory=SolverTable)

    @classmethod
    def read(cls, file: str | Path) -> Scene:
        """Read a scene file.

        Parameters
        ----------
        file : path
            TOML, see ``ase-roughcontact scene``.

        Returns
        -------
        Scene

        Raises
        ------
        ValueError
            If the file can't be read, is not TOML, or has an unknown table or key.
        """
        return cls.parse(cls.text_of(file), str(file))

    @staticmethod
    def text_of(file: str | Path) -> str:
        """Return the text of a scene file; see `read`."""
        try:
            return Path(file).read_text(encoding="utf-8")
        except (OSError, UnicodeDecodeError) as error:
            raise ValueError(f"can't read the scene {file}: {error}") from error

    @classmethod
    def parse(cls, text: str, name: str = "scene") -> Scene:
        """Make a scene of the text of a scene file; see `read`."""
        try:
            tables = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise ValueError(f"{name} is not a TOML file: {error}") from error
        known = {
            "substrate": SubstrateTable,
            "sphere": SphereTable,
            "roughness": RoughnessTable,
            "interaction": InteractionTable,
            "path": PathTable,
            "solver": SolverTable,
        }
        parts = {}
        for title, table in tables.items():
            if title not in known:
                raise ValueError(f"{name}: {unknown(title, list(known), 'table')}")
            if not isinstance(table, dict):
                raise ValueError(f"{name}: [{title}] must be a table, got {table!r}")
            parts[title] = table_of(known[title], table, f"{name}: [{title}]")
        return cls(**parts)

    @classmethod
    def default(cls) -> Scene:
        """Return the built-in scene."""
        return cls.parse(default_text(), "default.toml")

    @property
    def spacing(self) -> float:
        """Atomic spacing a0 (Å)."""
        given = self.substrate.spacing
        if given is None:
            return fcc_spacing(self.substrate.symbol)
        positive(spacing=given)
        return given

    @property
    def contact_modulus(self) -> float:
        """E* (eV/Å^3): given, from elastic constants, or of the crystal."""
        given = self.substrate
        if given.contact_modulus is not None and given.elastic_constants is not None:
            raise ValueError("give contact_modulus or elastic_constants, not both")
        if given.elastic_constants is not None:
            return contact_modulus(given.elastic_constants) * GPa
        if given.contact_modulus is not None:
            positive(contact_modulus=given.contact_modulus)
            return given.contact_modulus * GPa
        return crystal_modulus(given.symbol) * GPa

    @property
    def radius(self) -> float:
        """Radius of the sphere (Å)."""
        positive(radius=self.sphere.radius)
        return self.sphere.radius * self.spacing

    @property
    def surface(self) -> RoughSphere:
        """The indenter's surface."""
        given = self.sphere
        return RoughSphere(self.radius, self._rough(), given.profile)

    @property
    def wall(self) -> Interaction:
        """The interaction."""
        kind, work = self.interaction.kind, self.interaction.work_of_adhesion
        if kind in ("adhesive", "full"):
            if work is None:
                raise ValueError(f"[interaction]: {kind} needs work_of_adhesion, J/m^2")
            positive(work_of_adhesion=work)
        elif work is not None:
            raise ValueError(f"a {kind} wall has no work_of_adhesion, got {work}")
        cutoff = self.interaction.cutoff
        if cutoff is not None and kind != "full":
            raise ValueError(f"only a full wall has a cutoff to choose, got {cutoff}")
        walls = {
            "hard": HardWall,
            "repulsive": partial(
                LennardJones93.repulsive, self.contact_modulus, self.spacing
            ),
            "adhesive": lambda: LennardJones93.adhesive(
                self.contact_modulus, self.spacing, work * J / m**2
            ),
            "full": lambda: LennardJones93.full(
                self.spacing,
                work * J / m**2,
                cutoff=self.spacing * (cutoff or self.accuracy.cutoff),
            ),
        }
        return _choice(kind, walls, "kind of interaction")()

    @property
    def steps(self) -> np.ndarray:
        """The path: loads (eV/Å), penetrations or heights (Å)."""
        given = self.path
        unit = _choice(
            given.control,
            {"load": NANONEWTON, "penetration": 1.0, "height": 1.0},
            "control",
        )
        if given.values is not None:
            return unit * np.asarray(given.values, dtype=float)
        first, last, steps = given.first, given.last, integer("steps", given.steps, 1)
        finite(first=first, last=last)
        scales = {"geometric": np.geomspace, "linear": np.linspace}
        scale = _choice(given.scale, scales, "scale")
        if given.scale == "geometric" and not (first and last and first * last > 0):
            raise ValueError(
                "a geometric path needs first and last of one sign and not zero, got "
                f"{first} and {last}"
            )
        return unit * scale(first, last, steps)

    @property
    def fmax(self) -> float | None:
        """Tolerance of the forces (eV/Å), if it is given."""
        if self.solver.fmax is None:
            return None
        positive(fmax=self.solver.fmax)
        return self.solver.fmax * self.contact_modulus * self.spacing**2

    @property
    def accuracy(self) -> Accuracy:
        """What the accuracy asks for."""
        return accuracy_of(self.solver.accuracy)

    @property
    def shape(self) -> tuple[int, int] | None:
        """Atoms that may touch; None if they are chosen step by step."""
        shape = self.substrate.shape
        if not isinstance(shape, str):
            return grid_shape(shape)
        if self.substrate.periodic:
            raise ValueError(
                'shape = "auto" needs a free half space: give the shape of the '
                "periodic cell, [n, m]"
            )
        return _choice(shape, {"auto": None}, "shape")

    @property
    def inverse_kappa(self) -> float:
        """``1/kappa`` of the mean contact pressure ``h'rms E*/kappa``, for this wall.

        Negative where rough flats would stick to each other.
        """
        wall = self.wall
        if not isinstance(wall, LennardJones93):
            return 1.0 / theory.KAPPA_HARD
        surface = self._rough()
        if not wall.attractive or surface is None:
            return 1.0 / theory.KAPPA_REPULSIVE
        rough = surface.statistics()
        attraction = theory.inverse_kappa_attractive(
            wall.work_of_adhesion,
            self.contact_modulus,
            wall.attraction_range,
            rough.rms_slope,
            rough.rms_curvature,
        )
        return float(theory.inverse_kappa_adhesive(theory.KAPPA_REPULSIVE, attraction))

    def atoms(self) -> Atoms:
        """Build the substrate and the indenter above it, with their calculator."""
        given = self.substrate
        if self.shape:
            check_memory(self.shape, margin=not given.periodic)
        atoms = substrate(
            given.symbol,
            self.shape or _FIRST_SHAPE,
            self.surface,
            spacing=self.spacing,
            periodic=given.periodic,
            fixed=self.path.control != "load",
        )
        fft = {"dtype": self.accuracy.dtype}
        atoms.calc = RoughContact(
            self.surface, self.contact_modulus, self.wall, fft=fft
        )
        atoms.positions[-1, 2] = atoms.calc.contact(atoms).first_contact
        return atoms

    def plan(self) -> Plan:
        """Tell windows, memory and time of the path before it is calculated."""
        control = f"{self.path.control}s"
        window = "fixed" if self.shape else "auto"
        return plan_path(self.atoms(), control, self.steps, window)

    def relax(
        self, steps: ArrayLike | None = None, **options: Any
    ) -> Iterator[LoadStep]:
        """Relax step after step.

        Parameters
        ----------
        steps : array_like, optional
            Loads (eV/Å), penetrations or heights (Å) in place of those of the path.
        **options
            Of `load_path`: files, and whether to resume from them.

        Returns
        -------
        iterator of LoadStep
        """
        name = self.solver.optimizer
        optimizer = None if name is None else _choice(name, OPTIMIZERS, "optimizer")
        targets = self.steps if steps is None else steps
        path: dict[str, Any] = {f"{self.path.control}s": targets}
        return load_path(
            self.atoms(),
            optimizer=optimizer,
            fmax=self.fmax,
            accuracy=self.solver.accuracy,
            max_steps=self.solver.max_steps,
            window="fixed" if self.shape else "auto",
            **path,
            **options,
        )

    def run(self, folder: str | Path) -> Iterator[LoadStep]:
        """Relax step after step, writing ``curve.csv`` and ``sweep.traj``.

        Parameters
        ----------
        folder : path
            Where the files go; made if it is not there. If it holds a part of this
            scene's run, the run goes on from there.

        Yields
        ------
        LoadStep

        Raises
        ------
        ValueError
            If the folder holds the results of another scene.
        OSError
            If the folder can't be written.
        """
        folder = Path(folder)
        folder.mkdir(parents=True, exist_ok=True)
        files: dict[str, Any] = {
            "trajectory": folder / "sweep.traj",
            "csv": folder / "curve.csv",
        }
        yield from self.relax(resume=True, **files)

    def predicted_area(self, normal_force: ArrayLike) -> np.ndarray:
        """Contact area by Eq. (4) of the paper, or of Hertz for a smooth sphere.

        Adhesion is in it as a change of kappa; NaN where it is so strong that the law
        does not hold.

        Parameters
        ----------
        normal_force : array_like
            eV/Å.

        Returns
        -------
        ndarray
            Å^2.

        References
        ----------
        L. Pastewka, M. O. Robbins, Appl. Phys. Lett. 108, 221601 (2016), Eq. (4).
        """
        if self.roughness is None:
            return self.hertz_area(normal_force)
        if self.inverse_kappa <= 0.0:
            return np.full(np.shape(normal_force), np.nan)
        pressure = theory.mean_contact_pressure(
            self.roughness.rms_slope, self.contact_modulus, 1.0 / self.inverse_kappa
        )
        return theory.contact_area(
            normal_force, self.radius, self.contact_modulus, pressure
        )

    def hertz_area(self, normal_force: ArrayLike) -> np.ndarray:
        """Contact area of the smooth sphere, without adhesion (Å^2)."""
        return theory.hertz_contact_area(
            normal_force, self.radius, self.contact_modulus
        )

    def _rough(self) -> SelfAffine | None:
        if self.roughness is None:
            return None
        given = asdict(self.roughness)
        for name in (
            "short_wavelength",
            "long_wavelength",
            "longest_wavelength",
            "domain",
        ):
            if given[name] is not None:
                positive(**{name: given[name]})
                given[name] *= self.spacing
        return SelfAffine(**given)


def default_text() -> str:
    """Text of the built-in scene file."""
    return files("ase_roughcontact").joinpath("default.toml").read_text("utf-8")


def _choice(name: str, choices: dict[str, Any], what: str) -> Any:
    if name not in choices:
        raise ValueError(unknown(str(name), list(choices), what))
    return choices[name]
