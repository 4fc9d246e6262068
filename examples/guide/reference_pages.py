"""Pages of the reference that are written before the site is built.

Each public name gets a page of its own: the names of ``ase_roughcontact`` itself, and
the names of the packages `PACKAGES`. Each row of the table in ``reference/index.rst``
and each package gets a page with its names. Modules list the remaining names.
"""

import re
from importlib import import_module
from pathlib import Path

WRITTEN = Path(__file__).parent / "reference" / "names"
PACKAGES = {
    "scene": "Scenes",
    "ensemble": "Ensembles",
    "theory": "Theory",
    "analysis": "Analysis",
    "elasticity": "Solids",
    "interactions": "Walls",
    "topography": "Indenters",
    "optimize": "Optimizers",
    "plot": "Figures",
    "foundation": "Explicit atoms",
}


def public() -> dict[str, dict[str, object]]:
    """Classes and functions by the package that they are imported from."""
    found: dict[str, dict[str, object]] = {}
    seen: set[int] = set()
    for package in ("", *PACKAGES):
        module = import_module(f"ase_roughcontact.{package}".rstrip("."))
        objects = {name: getattr(module, name) for name in module.__all__}
        found[package] = {
            name: thing
            for name, thing in sorted(objects.items(), key=lambda item: item[0].lower())
            if getattr(thing, "__module__", "").startswith("ase_roughcontact.")
            and getattr(thing, "__name__", "") == name
            and id(thing) not in seen
        }
        seen |= {id(thing) for thing in found[package].values()}
    return found


def topics() -> dict[str, list[str]]:
    """Public names by topic: a row of the table, or a package, or both."""
    index = (WRITTEN.parent / "index.rst").read_text("utf-8")
    found = {
        title: re.findall(r":(?:class|func):`\.(\w+)`", row)
        for title, row in re.findall(r"   \* - (.*)\n((?:     .*\n)+)", index)
    }
    shown = {name for names in found.values() for name in names}
    for package, objects in public().items():
        rest = [name for name in objects if name not in shown]
        if rest:
            found[PACKAGES[package]] = found.get(PACKAGES[package], []) + rest
    return {title: names for title, names in found.items() if names}


def excluded() -> dict[str, str]:
    """Names with a page of their own, by the module that defines them."""
    names: dict[str, list[str]] = {}
    for objects in public().values():
        for name, thing in objects.items():
            names.setdefault(thing.__module__, []).append(name)
    return {module: ", ".join(sorted(found)) for module, found in names.items()}


def write() -> None:
    """Write a page for each public name and topic, and the lists of packages."""
    WRITTEN.mkdir(exist_ok=True)
    lists, lines = [], {}
    for package, objects in public().items():
        origin = f"ase_roughcontact.{package}".rstrip(".")
        if package:
            title = PACKAGES[package]
            lists += [title, "~" * len(title), "", f"From ``{origin}``:", ""]
        for name, thing in objects.items():
            kind = "class" if isinstance(thing, type) else "function"
            page = [
                name,
                "=" * len(name),
                "",
                ".. code-block:: python",
                "",
                f"   from {origin} import {name}",
                "",
                f".. auto{kind}:: {thing.__module__}.{name}",
                *(["   :members:"] if kind == "class" else []),
                "",
            ]
            (WRITTEN / f"{name}.rst").write_text("\n".join(page), "utf-8")
            first = (thing.__doc__ or "").strip().partition("\n")[0]
            role = "class" if kind == "class" else "func"
            target = f":{role}:`{name} <{thing.__module__}.{name}>`"
            lines[name] = f"- {target}: {first}"
            if package:
                lists += [lines[name]]
        lists.append("")
    (WRITTEN / "packages.inc").write_text("\n".join(lists), "utf-8")
    for title, names in topics().items():
        page = [title, "=" * len(title), ""]
        page += [lines[name] for name in names]
        page += ["", ".. toctree::", "   :hidden:", ""]
        page += [f"   {name}" for name in names]
        file = WRITTEN / f"topic-{title.lower().replace(' ', '-')}.rst"
        file.write_text("\n".join(page) + "\n", "utf-8")
