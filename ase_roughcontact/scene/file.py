"""Contents of a scene file: its sections, read from TOML, changed and compared."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from importlib.resources import files
from itertools import chain
from pathlib import Path
from typing import Any, TypeVar, get_type_hints

from ase_roughcontact._util.files import tomllib
from ase_roughcontact._util.identity import identity
from ase_roughcontact._util.summary import Summarized
from ase_roughcontact._util.validation import lookup, shown
from ase_roughcontact.results.record import STRESS_COLUMNS
from ase_roughcontact.scene import config
from ase_roughcontact.scene.path_kind import PathKind, Steps
from ase_roughcontact.scene.random_fields import (
    HeterogeneityConfig,
    RoughnessConfig,
    SubstrateRoughnessConfig,
    TipRoughnessConfig,
)
from ase_roughcontact.scene.scan import (
    SubstrateTopographyConfig,
    TipTopographyConfig,
    TopographyConfig,
)
from ase_roughcontact.scene.section import Problems, Section, members
from ase_roughcontact.scene.solid import is_crystal
from ase_roughcontact.scene.study import StudyConfig

AnyFile = TypeVar("AnyFile", bound="SceneFile")

# Advice on other names of sections, in lower case.
_SECTION_HINTS = {
    **dict.fromkeys(("wall", "adhesion", "potential"), "[interaction], the wall"),
    **dict.fromkeys(("solid", "material", "surface"), "[substrate], the elastic solid"),
    **dict.fromkeys(("scan", "afm"), "[topography], a scan"),
    **dict.fromkeys(("load", "loading", "loads"), "[path], with loads = [...]"),
    "ensemble": "[study]",
}
# Section with keys that can be set for both bodies at once.
_OF_BOTH = "roughness"


def read_text(file: str | Path) -> str:
    """Return the text of a scene file.

    Parameters
    ----------
    file : path
        Scene file, in UTF-8.

    Returns
    -------
    str

    Raises
    ------
    ValueError
        If the file can't be read.
    """
    try:
        return Path(file).read_text(encoding="utf-8-sig")  # Windows may add a mark
    except UnicodeDecodeError as error:
        raise ValueError(f"{file} is not a TOML file: it is not text") from error
    except OSError as error:
        raise ValueError(f"can't read the scene {file}: {error.strerror}") from error


@dataclass(frozen=True)
class SceneFile(Summarized):
    """Sections of a scene file; see `Scene`.

    The section ``[tip.roughness]`` is the attribute `tip_roughness`.
    """

    substrate: config.SubstrateConfig = field(default_factory=config.SubstrateConfig)
    substrate_roughness: SubstrateRoughnessConfig | None = None
    substrate_topography: SubstrateTopographyConfig | None = None
    tip: config.TipConfig | None = None
    tip_roughness: TipRoughnessConfig | None = None
    tip_topography: TipTopographyConfig | None = None
    sphere: config.SphereConfig = field(default_factory=config.SphereConfig)
    indenter: config.IndenterConfig | None = None
    roughness: RoughnessConfig | None = None
    topography: TopographyConfig | None = None
    heterogeneity: HeterogeneityConfig | None = None
    interaction: config.InteractionConfig = field(
        default_factory=config.InteractionConfig
    )
    friction: config.FrictionConfig | None = None
    path: PathKind = field(default_factory=Steps)
    solver: config.SolverConfig = field(default_factory=config.SolverConfig)
    output: config.OutputConfig = field(default_factory=config.OutputConfig)
    study: StudyConfig | None = None

    def _summary(self) -> dict[str, str]:
        """Return the values of each section that are not the default."""
        found = {}
        for each in fields(self):
            section = getattr(self, each.name)
            values = section._summary() if section else {}
            if values:
                texts = [f"{key} = {text}" for key, text in values.items()]
                found[each.name] = f"[{', '.join(texts)}]"
        return found

    @classmethod
    def parse(
        cls: type[AnyFile], text: str, name: str = "scene", copied: bool = False
    ) -> AnyFile:
        """Read the text of a scene file, without checking that the values are valid.

        The scene of an ensemble may omit keys that are set for each case.

        Parameters
        ----------
        text : str
            TOML.
        name : str
            Name of the file, for error messages. The path of a scan is relative to the
            folder of this file.
        copied : bool
            Whether copies of other files that a run has made in this folder are
            preferred.

        Returns
        -------
        Scene

        Raises
        ------
        ValueError
            If the text is not TOML, a section, key, unit or material is unknown, a
            value is of the wrong type, or a length has no unit.
        """
        try:
            document = load_toml(text)
        except ValueError as error:
            quotes = 'text, and numbers with a unit, need quotes, as radius = "30 nm"'
            raise ValueError(f"{name} is not a TOML file: {error}; {quotes}") from error
        sections, problems = dict[str, Any](), Problems(name)
        outer = {title: each for title, each in SECTIONS.items() if "." not in title}
        for title, entries in _tables(document):
            with problems.of():
                section = SECTIONS.get(title) or lookup(
                    title, outer, "section", _SECTION_HINTS
                )
                if not isinstance(entries, dict):
                    raise ValueError(
                        f"[{title}] must be a section, got {shown(entries)}"
                    )
                values = section.of(entries).located(Path(name).parent, copied)
                sections[attribute_of(title)] = values
        problems.check()
        return cls(**sections)

    @classmethod
    def read(cls: type[AnyFile], file: str | Path, copied: bool = False) -> AnyFile:
        """Read a scene file.

        Parameters
        ----------
        file : path
            TOML, see ``ase-roughcontact scene``.
        copied : bool
            See `parse`.

        Returns
        -------
        Scene

        Raises
        ------
        ValueError
            If the file can't be read, is not TOML, or has an invalid value. The error
            names file, section and key.
        """
        scene = cls.parse(read_text(file), str(file), copied)
        scene.check(str(file))
        return scene

    @classmethod
    def of_results(cls: type[AnyFile], folder: str | Path) -> AnyFile:
        """Read the scene of a folder of results; see `Scene.run` and `read`.

        Raises
        ------
        ValueError
            If the folder has no results of a run, or as in `read`.
        """
        file = Path(folder) / "scene.toml"
        if not file.exists():
            raise ValueError(
                f"{folder} is not the folder of a run: it has no scene.toml; give the "
                "folder of --out"
            )
        return cls.read(file, copied=True)

    text_of = staticmethod(read_text)

    @classmethod
    def default(cls: type[AnyFile]) -> AnyFile:
        """Return the built-in scene."""
        return cls.parse(default_text(), "default.toml")

    def check(self, name: str = "scene") -> None:
        """Raise an error if a value is out of range or inconsistent with others.

        Parameters
        ----------
        name : str
            Name of the file for error messages.

        Raises
        ------
        ValueError
            If a value is wrong, with file, section and key of each, as far as these do
            not depend on each other.
        MemoryError
            If the roughness needs more memory than is free.
        """
        if len({Path(file).name for file in self.files}) < len(set(self.files)):
            raise ValueError(
                f"{name}: the files of a scene must have different names, as they are "
                f"copied to the folder of its results, got {', '.join(self.files)}"
            )

    @property
    def model(self) -> str:
        """Meaning of the points of the grid: ``"atoms"`` or ``"continuum"``.

        If it is not given, they are atoms where the grid is the surface of a crystal,
        and the indenter is neither measured nor flat.
        """
        substrate, measured = self.substrate, bool(self.scans)
        if substrate.model or substrate.of_atoms:
            return substrate.model or "atoms"
        smooth = not measured and self.sphere.radius != math.inf
        return "atoms" if smooth and is_crystal(substrate) else "continuum"

    @property
    def tip_material(self) -> str:
        """Name of the material of the indenter; empty if it is rigid."""
        of_shape = (self.indenter or self.sphere).material
        return of_shape if self.tip is None else self.tip.material or of_shape

    @property
    def scans(self) -> dict[str, TopographyConfig]:
        """Sections of scans by title; scans of the substrate first."""
        titles = "substrate.topography", "topography", "tip.topography"
        given = self.sections
        return {title: given[title] for title in titles if title in given}  # type: ignore[misc]

    @property
    def roughnesses(self) -> dict[str, RoughnessConfig]:
        """Sections of roughness that is no scan, by title."""
        sections = self.sections.items()
        return {k: each for k, each in sections if isinstance(each, RoughnessConfig)}

    @property
    def asks_for_stress(self) -> bool:
        """Whether stresses below the surface are asked for: columns, or a limit."""
        asked = STRESS_COLUMNS.intersection(self.output.columns or ())
        return bool(asked) or self.substrate.yield_strength is not None

    @property
    def seed(self) -> int | None:
        """Seed of the roughness, the first one of two bodies; None without one."""
        return next((each.seed for each in self._random.values()), None)

    @property
    def _random(self) -> dict[str, Any]:
        """Sections of random roughness, and of realisations of scans, by title."""
        scans = {k: each for k, each in self.scans.items() if each.seed is not None}
        return {**self.roughnesses, **scans}

    @property
    def sections(self) -> dict[str, Section]:
        """Sections by title, without those that are missing."""
        given = {title: getattr(self, attribute_of(title)) for title in SECTIONS}
        return {title: section for title, section in given.items() if section}

    @property
    def files(self) -> list[str]:
        """Other files that the scene needs."""
        return [file for each in self.sections.values() for file in each.files]

    def entries(self) -> dict[str, dict[str, Any]]:
        """Return the values by section and key, None for keys that are not given."""
        return {title: each.entries() for title, each in self.sections.items()}

    @property
    def toml(self) -> str:
        """The scene as the text of a file, without defaults that mean no value."""
        lines = []
        for title, entries in self.entries().items():
            lines.append(f"[{title}]")
            for key, value in entries.items():
                if value is not None:
                    lines.append(f"{key} = {_toml(value)}")
            lines.append("")
        return "\n".join(lines)

    def with_values(self: AnyFile, values: Mapping[str, Any]) -> AnyFile:
        """Return the scene with other values of some keys.

        Parameters
        ----------
        values : mapping
            Values by key, ``"sphere.radius"``, in the units of the file; or whole
            sections by title, None for none. Without a section ``[roughness]`` the key
            ``"roughness.seed"`` is the seed of both bodies, and of realisations of a
            scan; its other keys are keys of both bodies, too.

        Returns
        -------
        Scene

        Raises
        ------
        ValueError
            If a section or key is unknown, or a value is of the wrong type.
        """
        changes: dict[str, Any] = {}
        # sections first, then kinds and units, on which other keys depend
        order = sorted(
            values,
            key=lambda k: (k not in SECTIONS, not k.endswith((".kind", ".unit"))),
        )
        for key in chain.from_iterable(map(self._keys, order)):
            outer, _, inner = key.rpartition(".")
            is_section = key in SECTIONS or not outer
            title, name = (key, "") if is_section else (outer, inner)
            section_type = lookup(title, SECTIONS, "section")
            section: Any = changes.get(title, self.sections.get(title))
            value = values.get(key, values.get(f"{_OF_BOTH}.{name}"))
            if name and section is None:
                raise ValueError(f"{key} can't be set: the scene has no [{title}]")
            if not (name or value is None or isinstance(value, section_type)):
                raise ValueError(f"[{title}] must be a section, got {shown(value)}")
            changes[title] = section.changed(name, value) if name else value
        changes = {attribute_of(title): each for title, each in changes.items()}
        return replace(self, **changes)

    def _keys(self, key: str) -> list[str]:
        """Return a key, or for a key of `_OF_BOTH` the keys of both bodies.

        Its seed is also the seed of realisations of scans.
        """
        title, _, name = key.rpartition(".")
        random = self._random if name == "seed" else self.roughnesses
        bodies = [each for each in random if each != _OF_BOTH]
        if title != _OF_BOTH or not bodies:
            return [key]
        return [f"{body}.{name}" for body in bodies]

    @property
    def identity(self) -> str:
        """Hash of the values that are not the default, and of the contents of files.

        Keys that are added to the scene file later do not change it.
        """
        return identity(self._given)

    def changes_from(self, old: SceneFile) -> list[str]:
        """Return descriptions of the keys with other values than in another scene.

        There are none if, and only if, both have the same `identity`.
        """
        changes = []
        all_was, all_now = old._compared.entries(), self._compared.entries()
        for title, section in SECTIONS.items():
            if not section.changes_results:
                continue
            was, now = all_was.get(title, {}), all_now.get(title, {})
            given_then = old._given.get(title, {})
            given_now = self._given.get(title, {})
            for key in {**was, **now}:
                changed = given_then.get(key) != given_now.get(key)
                if not (was and now):  # the section is new, or was removed
                    changed = changed or was.get(key) != now.get(key)
                if changed:
                    values = f"was {_toml(was.get(key))}, is {_toml(now.get(key))}"
                    changes.append(f"[{title}] {key} {values}")
        return changes

    @property
    def _given(self) -> dict[str, dict[str, Any]]:
        """Values by section and key that are not the default, for comparison."""
        sections = self._compared.sections
        return {k: v.given for k, v in sections.items() if v.changes_results}

    @property
    def _compared(self: AnyFile) -> AnyFile:
        """The same scene with its model; the model of atoms has an empty name."""
        model = "" if self.model == "atoms" else self.model
        return replace(self, substrate=replace(self.substrate, model=model))


def default_text() -> str:
    """Return the text of the built-in scene file."""
    return files("ase_roughcontact").joinpath("default.toml").read_text("utf-8")


def load_toml(text: str) -> dict[str, Any]:
    """Return the document of a text, or raise `ValueError`."""
    try:
        return tomllib.loads(text)
    except RecursionError as error:
        raise ValueError(str(error)) from error


def attribute_of(title: str) -> str:
    """Return the name of the attribute of a section: "tip_roughness"."""
    return title.replace(".", "_")


def _tables(document: Mapping[str, Any]) -> Iterator[tuple[str, Any]]:
    """Yield titles and entries of all sections: ``tip.roughness`` after ``tip``."""
    for title, entries in document.items():
        if not isinstance(entries, dict):
            yield title, entries
            continue
        inner = [key for key in entries if f"{title}.{key}" in SECTIONS]
        if len(inner) < len(entries) or not inner:
            yield title, {k: each for k, each in entries.items() if k not in inner}
        for key in inner:
            yield f"{title}.{key}", entries[key]


def _types_of_sections() -> list[type[Section]]:
    """Return the classes of the sections in the order of a file."""
    types: Any = [members(hint)[0] for hint in get_type_hints(SceneFile).values()]
    return list(types)


def _toml(value: Any) -> str:
    if value is None:
        return "not given"
    if isinstance(value, dict):
        items = [f"{key} = {_toml(each)}" for key, each in value.items()]
        return f"{{ {', '.join(items)} }}"
    if isinstance(value, float) and value == math.inf:
        return "inf"  # JSON has "Infinity"
    return json.dumps(value, ensure_ascii=False)


#: Classes of the sections by title.
SECTIONS: dict[str, type[Section]] = {
    section.title: section for section in _types_of_sections()
}
