"""The Python code of the README and of the guide, and the comparison of optimizers."""

import re
import runpy
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import numpy as np
import pytest

from ase_roughcontact.scene import Scene

ROOT = Path(__file__).resolve().parents[1]
README = (ROOT / "README.md").read_text()
# Code that needs a queueing system.
ELSEWHERE = {"many_machines"}
# Code that calculates the force constants of a crystal.
SLOW = {"foundation"}
PAGES = {
    page.stem: page
    for page in (ROOT / "README.md", *sorted(ROOT.glob("examples/guide/*.md")))
    if page.stem not in ELSEWHERE and "```python" in page.read_text()
}
sys.path.insert(0, str(ROOT / "examples" / "guide"))
results, sources = import_module("results"), import_module("sources")
STORED = {
    page.relative_to(ROOT).as_posix(): page.read_text()
    for page in results.PAGES
    if "<!-- results/" in page.read_text()
}
REPORTS = {file.stem: (file, command) for file, command in results.reports()}


@pytest.mark.slow  # tests/optimize/test_comparison.py has the comparison itself
def test_comparison_of_optimizers_leaves_a_table_and_a_picture(tmp_path, monkeypatch):
    pytest.importorskip("matplotlib").use("Agg")
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "benchmarks"))
    compare = import_module("compare_optimizers")
    compared = compare.main(["--size", "6", "--out", str(tmp_path / "table")])
    assert {path.name for path in tmp_path.iterdir()} == {"table.csv", "table.png"}
    for case in ("smooth", "rough"):
        compared[case].check(atoms=0, energy=1e-4)
    for result in compared["adhesive"].results:
        assert result.converged and np.isfinite(result.energy_error)


def test_table_of_the_optimizers_of_ase_has_those_that_are_refused(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "benchmarks"))
    all_of_ase, out = import_module("ase_optimizers"), str(tmp_path / "table.csv")
    all_of_ase.main(["--names", "LBFGS", "GPMin", "--out", out])
    capsys.readouterr()
    all_of_ase.main(["--report", "--out", out])
    text = capsys.readouterr().out
    assert "| `LBFGS` | `alpha maxstep memory` |" in text
    assert "- GPMin: " in text and "use LBFGS" in text


def test_the_solver_takes_most_of_the_time_of_a_friction_step(monkeypatch):
    monkeypatch.syspath_prepend(str(ROOT / "examples" / "benchmarks"))
    text = """
        substrate = { contact_modulus = "70 GPa", poisson = 0.2, spacing = "2.5 Å" }
        sphere.radius = "50 nm"
        interaction.kind = "hard"
        friction.coefficient = 0.2
        path = { kind = "sliding", values = [100.0], displacements = [0, "0.2 nm"] }
    """
    shares = import_module("outside_solver").shares(Scene.parse(text))
    assert shares["solver"] > 0.45


def test_readme_has_a_script_of_twelve_lines():
    (script,) = re.findall(r"(?ms)^```python\n(.*?)^```$", README)
    assert len([line for line in script.splitlines() if line.strip()]) <= 12


@pytest.mark.filterwarnings("error::ase_roughcontact.ValidityWarning")
@pytest.mark.parametrize(
    "page",
    [
        pytest.param(page, marks=[pytest.mark.slow] if page in SLOW else [])
        for page in PAGES
    ],
)
def test_python_of_a_page_runs_and_prints_what_the_page_shows(
    page, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("MPLBACKEND", "Agg")
    for block, printed in results.outputs(PAGES[page]):
        assert results.agree(block[2], printed), printed


@pytest.mark.parametrize("page", STORED)
def test_tables_of_a_page_are_the_stored_results(page):
    assert results.with_stored(STORED[page]) == STORED[page]


@pytest.mark.parametrize("name", REPORTS)
def test_stored_tables_are_made_from_their_rows(name, monkeypatch, capsys):
    file, (_, script, *options) = REPORTS[name]
    monkeypatch.chdir(ROOT)
    monkeypatch.syspath_prepend(str(ROOT / script.rpartition("/")[0]))
    monkeypatch.setattr(sys, "argv", [script, *options])
    runpy.run_path(script, run_name="__main__")
    assert capsys.readouterr().out == file.read_text().partition("\n")[2]


def test_stored_results_are_used_once_and_have_an_existing_command():
    pages = "".join(STORED.values())
    for file in results.STORED.glob("*.md"):
        assert pages.count(f"<!-- results/{file.stem} -->") == 1, file.stem
        command = file.read_text().partition("\n")[0]
        (script,) = re.findall(r"(?:examples|tests)/[\w/]+\.py", command)
        assert command.startswith("$ ") and (ROOT / script).exists(), command


def test_stored_results_and_pictures_are_made_by_the_present_scripts():
    stale = " ".join(sources.stale())
    assert not stale, f"run python examples/guide/sources.py --renew {stale}"


@pytest.mark.slow  # seconds each, but nothing else needs them
@pytest.mark.parametrize(
    "name", ["few_atoms", "options_hard", "plastic_pairs", "plastic_walls"]
)
def test_stored_counts_are_not_far_from_the_present_package(name):
    command, _, stored = (results.STORED / f"{name}.md").read_text().partition("\n")
    printed = results.report([sys.executable, *command.split()[2:]])
    assert results.agree(stored, printed, tolerance=0.5)


def test_a_checksum_changes_with_code_and_inputs_and_not_with_layout(
    tmp_path, monkeypatch
):
    monkeypatch.setattr(sources, "EXAMPLES", tmp_path)
    script, rows = tmp_path / "script.py", tmp_path / "rows.csv"
    rows.write_text("1,2")

    def checksum(code, file="picture.png"):
        script.write_text(code)
        return sources.checksum(file, "python examples/script.py", "rows.csv")

    first = checksum("def run(a):\n    return a + 1\n")
    same = '"""What it does."""\nimport math\n\ndef run(\n    a,\n):\n    # more\n'
    assert checksum(same + "    return (a + 1)\n") == first
    assert checksum("def run(a):\n    return a + 2\n") != first
    rows.write_text("1,3")
    assert checksum("def run(a):\n    return a + 1\n") != first
    shown = [f"def run(): pass\ndef report(): return {n}\n" for n in (1, 2)]
    assert checksum(shown[0], "rows.csv") == checksum(shown[1], "rows.csv")
    assert checksum(shown[0]) != checksum(shown[1])


def test_numbers_within_a_tolerance_agree_and_words_must_be_equal():
    assert results.agree("A = 5.16 nm²\n", "A =  5.17 nm²")
    assert not results.agree("A = 5.16 nm²", "A = 5.5 nm²")
    assert not results.agree("A = 5.16 nm²", "B = 5.16 nm²")
    assert not results.agree("1 2", "1")


def test_command_of_the_readme_is_what_ci_runs(tmp_path):
    (command,) = re.findall(
        r"<!-- test command -->\n+```bash\n(.*?)\n```$", README, re.DOTALL | re.M
    )
    # the same script, on a README with a command that only prints what it is
    (tmp_path / ".ci").mkdir()
    (tmp_path / ".ci" / "run").write_text((ROOT / ".ci" / "run").read_text())
    (tmp_path / "README.md").write_text(README.replace(command, "echo it ran"))
    result = subprocess.run(
        ["bash", ".ci/run"], cwd=tmp_path, capture_output=True, text=True
    )
    assert result.returncode == 0, result.stderr
    assert result.stdout.splitlines() == ["+ echo it ran", "it ran"]
    assert "pytest" in command and "ruff" in command and "mypy" in command
