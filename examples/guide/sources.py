"""What made the stored results and pictures of the guide, and whether that has changed.

    python examples/guide/sources.py                  # name what is stale
    python examples/guide/sources.py --renew FILE     # run its command again
    python examples/guide/sources.py --keep FILE      # its code changed, not its result

Files are relative to the folder of examples, as ``images/fit.png``.
``sources.csv`` has a line for each file: the command that made it, the files that the
command reads, and a checksum of these files and of the script, with the modules beside
it that it imports. Layout, comments, docstrings and imports do not count, nor, for
stored rows, the functions that only show them.
"""

import argparse
import ast
import csv
import json
import os
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from hashlib import sha256
from pathlib import Path

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

EXAMPLES = Path(__file__).resolve().parents[1]
LIST = EXAMPLES / "guide" / "sources.csv"
_SHOWS = ("draw", "main", "print", "report", "show")
_NO_MEANING = ("ctx", "kind", "type_comment", "type_ignores", "type_params")


def stored_files() -> list[str]:
    """Return the files that need a line: tables, pictures and rows."""
    found = {*EXAMPLES.glob("images/*"), *EXAMPLES.glob("guide/results/*.md")}
    for folder in (
        "benchmarks",
        "benchmarks/crystals",
        "images",
        "paper/results",
        "published",
    ):
        found.update(
            EXAMPLES.glob(f"{folder}/*.csv"), EXAMPLES.glob(f"{folder}/*.json")
        )
    return sorted(file.relative_to(EXAMPLES).as_posix() for file in found)


def checksum(file: str, command: str, inputs: str) -> str:
    """Return the checksum of all that a command reads in the folder of examples."""
    rows = file.endswith((".csv", ".json"))
    scripts = [EXAMPLES / name for name in re.findall(r"examples/(\S+\.py)", command)]
    whole = [shlex.join(_words(command))]
    whole += [_code(script, rows) for script in sorted(_with_imported(scripts))]
    whole += [_data(EXAMPLES / name) for name in inputs.split()]
    return sha256("\n".join(whole).encode()).hexdigest()[:12]


def _data(file: Path) -> str:
    """Return a checksum of an input: of a page its code, of a scene its values."""
    text = file.read_text(encoding="utf-8")
    if file.suffix == ".toml":
        text = json.dumps(tomllib.loads(text), sort_keys=True)
    if file.suffix == ".md":
        text = "".join(re.findall(r"(?ms)^```(?:python|bash)\n.*?^```$", text))
    return sha256(text.encode()).hexdigest()


def _words(command: str) -> list[str]:
    return shlex.split(command.removeprefix("$ "))


def _with_imported(scripts: list[Path]) -> set[Path]:
    """Add the modules beside scripts that these import."""
    found: set[Path] = set()
    while scripts:
        script = scripts.pop()
        if script in found:
            continue
        found.add(script)
        names = set(
            re.findall(r"(?m)^\s*(?:from|import) (\w+)", script.read_text("utf-8"))
        )
        beside = [script.with_name(f"{name}.py") for name in names - {"markdown"}]
        scripts += [module for module in beside if module.exists()]
    return found


def _code(script: Path, rows: bool) -> str:
    """Return the statements of a script, the same in all versions of Python."""
    tree = ast.parse(script.read_text(encoding="utf-8"))
    if rows:
        tree.body = [
            node
            for node in tree.body
            if not getattr(node, "name", "").lstrip("_").startswith(_SHOWS)
        ]
    return _canonical(tree)


def _canonical(value: object) -> str:
    if isinstance(value, list):
        return "[" + " ".join(filter(None, map(_canonical, value))) + "]"
    if not isinstance(value, ast.AST):
        return repr(value)
    if isinstance(value, ast.Import | ast.ImportFrom) or _is_text(value):
        return ""
    if isinstance(value, ast.Constant) and value.value == "":
        return ""  # Python 3.12 has such parts in formatted strings
    fields = [
        (name, _canonical(field))
        for name, field in ast.iter_fields(value)
        if name not in _NO_MEANING
    ]
    inner = " ".join(
        f"{name}={text}" for name, text in fields if text not in ("[]", "")
    )
    return f"{type(value).__name__}({inner})"


def _is_text(node: ast.AST) -> bool:
    """Whether a statement is a docstring or another text of its own."""
    return (
        isinstance(node, ast.Expr)
        and isinstance(node.value, ast.Constant)
        and isinstance(node.value.value, str)
    )


def read() -> dict[str, dict[str, str]]:
    """Return the list; commands of tables are those of their first lines."""
    with LIST.open(newline="") as lines:
        listed = {row["file"]: row for row in csv.DictReader(lines)}
    for file, row in listed.items():
        row["command"] = _command(file) or row["command"]
    return listed


def _command(file: str) -> str:
    """Return the command in the first line of a table."""
    table = EXAMPLES / file
    if not file.endswith(".md") or not table.exists():
        return ""
    return table.read_text("utf-8").partition("\n")[0]


def write(listed: dict[str, dict[str, str]]) -> None:
    """Write the list, sorted by file."""
    with LIST.open("w", newline="") as lines:
        names = ("file", "checksum", "inputs", "command")
        writer = csv.DictWriter(lines, names, lineterminator="\n")
        writer.writeheader()
        for file in sorted(listed):
            row = dict(listed[file])
            if file.endswith(".md"):
                row["command"] = ""
            writer.writerow(row)


def stale() -> Iterator[str]:
    """Yield what is not made from the present scripts and inputs, or is not listed."""
    listed = read()
    for file in sorted({*stored_files(), *listed}):
        row = listed.get(file)
        present = row is not None and (EXAMPLES / file).exists()
        made = checksum(file, row["command"], row["inputs"]) if present else None
        if not present or row["checksum"] != made:
            yield file


def renew(file: str) -> set[str]:
    """Run the command of a file in an empty folder.

    Keeps what it prints, as a table, or the listed files that it writes, and returns
    their names.
    """
    listed = read()
    command = _command(file) or listed.get(file, {}).get("command")
    if not command:
        sys.exit(f"{file}: add a line with its command to {LIST.name}")
    words = [re.sub("^examples/", f"{EXAMPLES}/", word) for word in _words(command)]
    given = dict(word.split("=") for word in words if re.match("[A-Z_]+=", word))
    path = [str(EXAMPLES.parent), os.environ.get("PYTHONPATH", "")]
    given |= {"MPLBACKEND": "Agg", "PYTHONPATH": os.pathsep.join(filter(None, path))}
    words = words[words.index("python") + 1 :]
    printed = subprocess.PIPE if file.endswith(".md") else None
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(
            [sys.executable, *words],
            cwd=folder,
            env=os.environ | given,
            stdout=printed,
            check=True,
            text=True,
        )
        if printed:
            (EXAMPLES / file).write_text(f"{command}\n{run.stdout.rstrip()}\n", "utf-8")
        found = {file}
        for name, row in listed.items():
            made = Path(folder, Path(name).name)
            if row["command"] == command and made.exists():
                shutil.move(made, EXAMPLES / name)
                found.add(name)
    return found


def main() -> None:
    """Name, renew or keep files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--renew", nargs="+", default=[], metavar="FILE")
    parser.add_argument("--keep", nargs="+", default=[], metavar="FILE")
    options = parser.parse_args()
    if not options.renew and not options.keep:
        sys.exit("\n".join(stale()))
    made = [renew(file) for file in options.renew]
    listed = read()
    for file in set(options.keep).union(*made):
        row = listed.setdefault(file, {"file": file, "command": "", "inputs": ""})
        row["command"] = _command(file) or row["command"]
        row["checksum"] = checksum(file, row["command"], row["inputs"])
    write(listed)


if __name__ == "__main__":
    main()
