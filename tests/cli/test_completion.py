"""Completion in bash: what it is told, and what it offers."""

import os
import subprocess
import sys

import pytest

from ase_roughcontact.cli import main
from ase_roughcontact.cli.completion import candidates
from ase_roughcontact.cli.parser import make_parser

COMMANDS = ["completion", "ensemble", "figure", "plan", "run", "scene", "tradeoff"]


@pytest.mark.parametrize(
    "line, offered",
    [
        ("ase-roughcontact ", COMMANDS),
        ("ase-roughcontact p", ["plan"]),
        ("ase-roughcontact --v", ["--version"]),
        (
            "ase-roughcontact run --",
            ["--help", "--json", "--out", "--quiet", "--verbose"],
        ),
        ("ase-roughcontact run my.toml --o", ["--out"]),
        ("ase-roughcontact tradeoff --e", ["--error"]),
        ("ase-roughcontact run ", []),  # a file: bash knows
        ("ase-roughcontact run --out ", []),
        ("ase-roughcontact run --quiet --j", ["--json"]),
        ("ase-roughcontact nonsense ", COMMANDS),
    ],
)
def test_what_can_come_next_is_offered(line, offered):
    assert candidates(make_parser(), line) == offered


def test_without_a_question_the_line_for_bashrc_is_printed(capsys, monkeypatch):
    monkeypatch.delenv("COMP_LINE", raising=False)
    assert main(["completion"]) == 0
    (line,) = capsys.readouterr().out.splitlines()
    assert line.startswith("complete -o default -C ")
    assert line.endswith(" ase-roughcontact")


def test_bash_is_answered_up_to_the_cursor():
    line = "ase-roughcontact ens --table x"
    environment = {"COMP_LINE": line, "COMP_POINT": str(line.index(" --"))}
    code = "import sys; from ase_roughcontact.cli import main; sys.exit(main())"
    words = ["completion", "ase-roughcontact", "ens", "ase-roughcontact"]
    done = subprocess.run(
        [sys.executable, "-c", code, *words],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stdout) == (0, "ensemble\n"), done.stderr


def test_an_option_that_bash_hands_over_is_not_taken_for_one_of_its_own(
    capsys, monkeypatch
):
    monkeypatch.setenv("COMP_LINE", "ase-roughcontact run --qu")
    assert main(["completion", "ase-roughcontact", "--qu", "run"]) == 0
    assert capsys.readouterr().out == "--quiet\n"
