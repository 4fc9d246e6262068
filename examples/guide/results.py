"""Numbers of the guide: printed output of its code, and stored results of scripts.

    python examples/guide/results.py              # name the pages that differ
    python examples/guide/results.py --write      # rewrite them
    python examples/guide/results.py --pictures tutorial    # pictures of a page

A ``text`` block after a ``python`` block is what that code prints. Lines between
``<!-- results/NAME -->`` and ``<!-- /results -->`` are those of the file
``results/NAME.md``, whose first line is the command that measured them; ``sources.py``
runs it. Pages with a folder of their name run in a copy of it, with their commands.
"""

import argparse
import contextlib
import io
import math
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from pathlib import Path

GUIDE = Path(__file__).resolve().parent
PAGES = (*sorted(GUIDE.glob("*.md")), GUIDE.parent / "benchmarks" / "README.md")
STORED = GUIDE / "results"
_BLOCK = re.compile(r"(?ms)^```(python|bash|text)\n(.*?)^```$")
_MARK = re.compile(r"(?s)<!-- results/(\w+) -->\n(.*?)<!-- /results -->")
_NUMBER = re.compile(r"[-+]?\d+\.?\d*(?:e[-+]?\d+)?")


def stored(name: str) -> str:
    """Lines of a stored result for a page: numbers, and the command that made them."""
    command, _, text = (STORED / f"{name}.md").read_text("utf-8").partition("\n")
    return f"{text.strip()}\n\n`{command.removeprefix('$ ')}`\n"


def reports() -> Iterator[tuple[Path, list[str]]]:
    """Yield results that are made from stored rows, and their commands."""
    for file in sorted(STORED.glob("*.md")):
        command = file.read_text("utf-8").partition("\n")[0].removeprefix("$ ")
        if command.endswith("--report"):
            yield file, [sys.executable, *command.split()[1:]]


def report(command: list[str]) -> str:
    """Return what a command prints."""
    run = subprocess.run(
        command, cwd=GUIDE.parents[1], capture_output=True, text=True, check=True
    )
    return run.stdout


def with_stored(page: str) -> str:
    """Return a page with its stored results."""
    return _MARK.sub(
        lambda found: (
            f"<!-- results/{found[1]} -->\n{stored(found[1])}<!-- /results -->"
        ),
        page,
    )


def outputs(page: Path) -> Iterator[tuple[re.Match, str]]:
    """Run a page in the present folder: its text blocks, and what was printed instead.

    The blocks of commands are run on pages with a folder of their own.
    """
    from ase_roughcontact.cli import main

    files = page.with_suffix("")
    if files.is_dir():
        shutil.copytree(files, ".", dirs_exist_ok=True)
    names: dict = {"__name__": "__main__"}
    whole, end, printed = page.read_text(encoding="utf-8"), 0, ""
    for block in _BLOCK.finditer(whole):
        kind, text = block.groups()
        if kind == "text":
            if not whole[end : block.start()].strip():
                yield block, printed
            continue
        end = block.end()
        with contextlib.redirect_stdout(io.StringIO()) as output:
            if kind == "python":
                exec(compile(text, page.name, "exec"), names)
            elif files.is_dir():
                for line in text.splitlines():
                    status = main(shlex.split(line)[1:])
                    if status:
                        raise RuntimeError(f"exit status {status}: {line}")
        printed = output.getvalue()


def agree(text: str, other: str, tolerance: float = 0.02) -> bool:
    """Whether two texts have the same words, and numbers within a tolerance."""
    numbers = [list(map(float, _NUMBER.findall(one))) for one in (text, other)]
    words = [_NUMBER.sub(" ", one).split() for one in (text, other)]
    return (
        words[0] == words[1]
        and len(numbers[0]) == len(numbers[1])
        and all(
            math.isclose(a, b, rel_tol=tolerance, abs_tol=1e-9)
            for a, b in zip(*numbers, strict=True)
        )
    )


def with_outputs(page: Path) -> str:
    """Return the text of a page with what its code prints."""
    text, end, parts = page.read_text(encoding="utf-8"), 0, []
    for block, printed in outputs(page):
        parts += [text[end : block.start(2)], printed]
        end = block.end(2)
    return "".join(parts) + text[end:]


def main() -> None:
    """Compare or rewrite the pages."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--write", action="store_true", help="rewrite the pages")
    parser.add_argument("--pictures", action="store_true", help="keep them here")
    parser.add_argument("pages", nargs="*", help="names of pages; default: all")
    options = parser.parse_args()
    os.environ.setdefault("MPLBACKEND", "Agg")
    here = os.getcwd()
    for page in PAGES:
        if options.pages and page.stem not in options.pages:
            continue
        before = page.read_text("utf-8")
        made = with_stored(before)
        if "```text" in made and "```python" in made:
            with tempfile.TemporaryDirectory() as folder:
                os.chdir(folder)
                made = with_stored(with_outputs(page))
                for picture in Path().glob("*.png") if options.pictures else ():
                    shutil.copy(picture, here)
                os.chdir(here)
        if made != before and not options.pictures:
            print(page.name, "rewritten" if options.write else "differs")
            if options.write:
                page.write_text(made, "utf-8")
            elif not agree(before, made):
                sys.exit(1)


if __name__ == "__main__":
    main()
