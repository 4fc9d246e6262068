"""Notebooks of pages of the guide, which are written before the site is built."""

import json
import re
from collections.abc import Iterator
from pathlib import Path

GUIDE = Path(__file__).parent
WRITTEN = GUIDE / "notebooks"
#: Pages that are notebooks, too.
PAGES = ("getting_started", "tutorial")
_BLOCK = re.compile(r"(?ms)^```(python|bash|text)\n(.*?)^```$")
_PICTURE = re.compile(r"(?s)!\[[^]]*\]\([^)]*\)\n\n(?:\*.*?\*\n\n)?")
_LINK = re.compile(r"\[([^]]*)\]\((?!https?://)[^)]*\)")
_ROLE = re.compile(r"\{py:\w+\}`[.~]?([\w.]+)`")
_INCLUDED = re.compile(r"(?m)^```\{literalinclude\} (\S+)\n:language: (\w+)\n```$")


def cells(page: Path) -> Iterator[tuple[str, str]]:
    """Yield the cells of a page, "markdown" or "code".

    Pages with a folder of their name run its commands. What code prints is left out.
    """
    text, end = page.read_text("utf-8"), 0
    for block in _BLOCK.finditer(text):
        kind, code = block.groups()
        yield "markdown", _plain(text[end : block.start()])
        end = block.end()
        if kind == "python":
            yield "code", code
        elif kind == "bash" and page.with_suffix("").is_dir():
            yield "code", "".join(f"!{line}\n" for line in code.splitlines())
        elif kind == "bash":
            yield "markdown", block[0]
    yield "markdown", _plain(text[end:])


def _plain(text: str) -> str:
    """Return text without links to other pages, roles of Sphinx and pictures."""
    text = _INCLUDED.sub(_contents, _PICTURE.sub("", text))
    return _LINK.sub(r"\1", _ROLE.sub(r"`\1`", text)).strip()


def _contents(included: re.Match) -> str:
    """Return the contents of a file as a block."""
    file, language = included.groups()
    return f"```{language}\n{(GUIDE / file).read_text('utf-8')}```"


def notebook(page: Path) -> dict:
    """Return the notebook of a page, in format 4 of Jupyter."""
    listed = []
    for kind, text in cells(page):
        cell = {"cell_type": kind, "metadata": {}, "source": text.strip()}
        if kind == "code":
            cell |= {"execution_count": None, "outputs": []}
        if text:
            listed.append(cell)
    return {"cells": listed, "metadata": {}, "nbformat": 4, "nbformat_minor": 4}


def write() -> None:
    """Write the notebooks."""
    WRITTEN.mkdir(exist_ok=True)
    for name in PAGES:
        text = json.dumps(notebook(GUIDE / f"{name}.md"), indent=1, ensure_ascii=False)
        (WRITTEN / f"{name}.ipynb").write_text(text + "\n", "utf-8")
