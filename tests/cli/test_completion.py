"""Completion of commands and options in shells."""

import subprocess
import sys
from contextlib import redirect_stdout

import pytest

from ase_roughcontact.cli import main

pytest.importorskip("shtab")

OF_RUN = "--help --json --out --preview --quiet --strict --verbose"


@pytest.fixture(scope="module")
def script(tmp_path_factory):
    """Completion script of bash, in a file."""
    file = tmp_path_factory.mktemp("completion") / "script"
    with file.open("w") as out, redirect_stdout(out):
        assert main(["completion", "bash"]) == 0
    return file


@pytest.mark.parametrize(
    "line, expected",
    [
        (["p"], "places plan"),
        (["--ver"], "--verbose --version"),
        (["run", "--"], OF_RUN),
        (["run", "my.toml", "--o"], "--out"),
        (["tradeoff", "--e"], "--error --error-of"),
        (["run", "--quiet", "--j"], "--json"),
        (["r"], "report run"),
        (["run", "my"], "my.toml"),
    ],
    ids=lambda words: "-".join(words) if isinstance(words, list) else "",
)
def test_bash_completes_commands_options_and_files(line, expected, script, tmp_path):
    (tmp_path / "my.toml").touch()
    words = " ".join(f"'{word}'" for word in ["ase-roughcontact", *line])
    asked = f"""
        complete() {{ [[ $1 = -o ]] && function=$4; }}
        shopt -s extglob
        source {script}
        COMP_WORDS=({words}) COMP_CWORD={len(line)} COMPREPLY=()
        $function ase-roughcontact "{line[-1]}"
        printf '%s\\n' "${{COMPREPLY[@]}}"
    """
    done = subprocess.run(
        ["bash", "-c", asked], cwd=tmp_path, capture_output=True, text=True
    )
    found = {word.strip() for word in done.stdout.splitlines()}
    assert found - {"-h", ""} == set(expected.split()), done.stderr


def test_scripts_for_other_shells_are_printed(capsys):
    assert main(["completion", "zsh"]) == 0
    assert capsys.readouterr().out.startswith("#compdef ase-roughcontact")


def test_without_shtab_the_extra_to_install_is_printed(capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "shtab", None)
    assert main(["completion"]) == 2
    assert "'.[completion]'" in capsys.readouterr().err
