"""The guide builds without a warning, and what it mentions exists."""

import os
import re
import shlex
import shutil
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pytest

from ase_roughcontact import LoadStep, __version__
from ase_roughcontact import __all__ as public_names
from ase_roughcontact.cli.parser import make_parser
from ase_roughcontact.path_kinds.sliding.record import SlidingStep
from ase_roughcontact.path_kinds.sliding.timed_record import TimedSlidingStep
from ase_roughcontact.path_kinds.time.record import TimeStep
from ase_roughcontact.results.column import EVERYWHERE
from ase_roughcontact.results.flat_record import FlatStep
from ase_roughcontact.results.record import columns_of, columns_on_request
from ase_roughcontact.scene.path_kind import PATHS

ROOT = Path(__file__).resolve().parents[1]
GUIDE = ROOT / "examples" / "guide"
PAGES = {
    page.relative_to(ROOT).as_posix(): page.read_text()
    for page in (
        *sorted(GUIDE.glob("*.md")),
        *(ROOT / "examples" / folder / "README.md" for folder in ("", "benchmarks")),
        *(ROOT / name for name in ("README.md", "CONTRIBUTING.md")),
    )
}
# Modules of classes that the pages mention by their name alone.
KNOWN = (
    "ase",
    "ase.calculators.mixing",
    "ase.constraints",
    "ase.optimize",
    "ase.optimize.precon",
    "ase.optimize.sciopt",
)
# Public names of the package, without its units.
LISTED = {*public_names} - {"GPa", "nN", "nm"}


@pytest.fixture
def build(tmp_path):
    """Function that builds the guide from a copy, and returns the folder of its pages.

    The gallery writes its pages beside the pages of the guide, and its results beside
    its scripts.
    """
    pytest.importorskip("sphinx", reason="needs the extra docs")
    left_out = shutil.ignore_patterns("results", "generated", "names", "__pycache__")
    shutil.copytree(ROOT / "examples", tmp_path / "examples", ignore=left_out)
    for name in ("CHANGELOG.md", "CONTRIBUTING.md", "ase_roughcontact/default.toml"):
        (tmp_path / name).parent.mkdir(exist_ok=True)
        shutil.copy(ROOT / name, tmp_path / name)
    pages = tmp_path / "pages"
    pages.mkdir()

    def built(*options):
        source = str(tmp_path / "examples" / "guide")
        path = os.pathsep.join(filter(None, [str(ROOT), os.environ.get("PYTHONPATH")]))
        result = subprocess.run(
            [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", *options,
             source, str(pages)],
            cwd=pages,
            env=os.environ | {"PYTHONPATH": path},
            capture_output=True,
            text=True,
        )  # fmt: skip
        assert result.returncode == 0, result.stderr
        return pages

    return built


@pytest.mark.first
def test_guide_builds_without_warnings(build):
    pages = build("-D", "plot_gallery=0")
    for name in LISTED:
        page = (pages / "reference" / "names" / f"{name}.html").read_text()
        assert f"{name}</span>" in page
    commands = (pages / "command_line.html").read_text()
    assert "--error-of" in commands and "ensemble" in commands
    for file in (pages / "reference" / "generated").glob("*.html"):
        assert "alpha simple" not in file.read_text()  # initials are no lists
    theory = (pages / "theory.html").read_text()
    assert "<math" in theory and "http" not in re.findall(
        r'<script[^>]*src="([^"]*)', theory
    )
    page = (pages / "gallery" / "own_wall.html").read_text()
    assert "Derjaguin" in page and "own_wall.png" in page  # not executed
    assert "tutorial.ipynb" in (pages / "tutorial.html").read_text()


@pytest.mark.slow  # all examples at their full size
def test_gallery_is_executed_without_warnings(build):
    pages = build()
    page = (pages / "gallery" / "load_sweep.html").read_text()
    assert "of Eq. (4)" in page and "sphx_glr_load_sweep_001.png" in page


@pytest.mark.parametrize("page", PAGES)
def test_links_to_files_and_headings_exist(page):
    folder = (ROOT / page).parent
    for target in re.findall(r"\]\(([^)\s]+)\)", PAGES[page]):
        if "://" in target or target.startswith("#"):
            continue
        file, _, heading = target.partition("#")
        if file.startswith(("gallery/", "paper/", "reference/index")):
            source = ROOT / "examples" / file
            assert source.with_suffix(".py").exists() or source.stem == "index", target
            continue
        assert (folder / file).exists(), target
        if heading:
            text = (folder / file).read_text()
            titles = re.findall(r"(?m)^#+ (.*)$", text.lower())
            anchors = [re.sub(r"[^\w -]", "", each) for each in titles]
            assert heading in [each.replace(" ", "-") for each in anchors], target


@pytest.mark.parametrize("page", PAGES)
def test_names_of_the_package_and_files_in_code_exist(page):
    names = re.findall(r"(?<![\w/`.-])ase_roughcontact(?:\.\w+)+", PAGES[page])
    assert not [name for name in {*names} if find(name) is None]
    files = re.findall(
        r"\b(?:examples|tests|ase_roughcontact)/[\w/.-]+", "\n".join(code(page))
    )
    assert not [file for file in files if not (ROOT / file.rstrip(".")).exists()]


def find(dotted):
    """Object of a dotted name, None without one."""
    parts = dotted.split(".")
    for count in range(len(parts), 0, -1):
        try:
            found = import_module(".".join(parts[:count]))
        except ImportError:
            continue
        for part in parts[count:]:
            found = getattr(found, part, None)
        return found
    return None


def code(page):
    """Inline code of a page, and the lines of its blocks of shell commands."""
    text = PAGES[page]
    blocks = re.findall(r"^```bash\n(.*?)^```$", text, re.MULTILINE | re.DOTALL)
    inline = re.sub(r"^```.*?^```$", "", text, flags=re.MULTILINE | re.DOTALL)
    lines = "\n".join(blocks).replace("\\\n", " ").splitlines()
    return [
        " ".join(found.split()) for found in re.findall(r"`([^`]+)`", inline)
    ] + lines


@pytest.mark.parametrize("page", PAGES)
def test_commands_are_understood(page, capsys):
    for line in code(page):
        for command in re.findall(r"(?:^|/)ase-roughcontact ([^>|&]+)", line):
            try:
                make_parser().parse_args(shlex.split(command))
            except SystemExit as end:
                assert end.code == 0, f"{command}: {capsys.readouterr().err}"


def test_classes_in_code_exist():
    files = (file.relative_to(ROOT) for file in ROOT.glob("ase_roughcontact/**/*.py"))
    modules = {".".join(file.with_suffix("").parts) for file in files}
    known = {name for module in {*KNOWN, *modules} for name in dir(find(module))}
    for page in PAGES:
        for line in code(page):
            if name := re.fullmatch(r"\.?([A-Z][a-z]+[A-Z]\w*)(\(.*\))?", line):
                assert name[1] in known, f"{page}: {name[1]}"


def test_the_package_lists_no_names_that_it_imports_for_itself():
    listed = dir(import_module("ase_roughcontact"))
    assert {"RoughContact", "__version__"} < {*listed}
    assert not {"Any", "TYPE_CHECKING", "import_module"} & {*listed}


def test_version_is_the_same_everywhere():
    citation = (ROOT / "CITATION.cff").read_text()
    assert f"\nversion: {__version__}\n" in citation
    assert f"\n  version: {__version__}\n  year: 2026\n" in citation
    assert f"\n## {__version__}" in (ROOT / "CHANGELOG.md").read_text()
    for page in ("README.md", "examples/guide/index.md"):
        assert f"version = {{{__version__}}},\n  year    = {{2026}}" in PAGES[page]


def test_times_of_other_codes_on_the_front_page_are_those_measured():
    (row,) = re.findall(r"(?m)^\| time for the same contact.*$", PAGES["README.md"])
    shown = [cell.strip() for cell in row.split("|")[3:6]]
    measured = [[], [], []]
    results = GUIDE / "results"
    for line in (results / "peers.md").read_text().splitlines()[3:]:
        _, _, _, code, arrays, *_ = (cell.strip() for cell in line.split("|"))
        measured["Tamaas" in code].append(float(arrays))
    for line in (results / "aspher.md").read_text().splitlines()[3:]:
        measured[2] += map(float, re.findall(r"([\d.]+) /", line))
    ranges = [f"{min(values):.2g} to {round(max(values))}" for values in measured]
    assert shown == ranges


def test_the_page_of_a_package_index_stands_alone():
    text = (ROOT / "examples" / "release" / "PACKAGE.md").read_text("utf-8")
    links = re.findall(r"\]\(([^)]*)\)", text)
    assert links and all(link.startswith("https://") for link in links)
    (script,) = re.findall(r"(?s)```python\n.*?```", text)
    assert script in PAGES["README.md"]  # where it is tested


@pytest.mark.parametrize("name", ["getting_started", "tutorial"])
def test_a_notebook_has_the_code_of_its_page_and_no_markup_of_the_site(
    name, monkeypatch
):
    monkeypatch.syspath_prepend(str(GUIDE))
    page = import_module("notebooks").notebook(GUIDE / f"{name}.md")
    code = [each["source"] for each in page["cells"] if each["cell_type"] == "code"]
    text = [each["source"] for each in page["cells"] if each["cell_type"] != "code"]
    blocks = re.findall(
        r"(?ms)^```python\n(.*?)\n```$", (GUIDE / f"{name}.md").read_text()
    )
    assert [each for each in code if each[0] != "!"] == blocks
    assert not re.search(r"\{\w|\.md\)|!\[", "\n".join(text))
    commands = (
        "!ase-roughcontact plan tip.toml\n!ase-roughcontact run tip.toml --out results"
    )
    assert (commands in code) == (name == "tutorial")


def rows_of(columns):
    """Rows of a table of columns, with where they are defined."""
    rows = []
    for name, column in columns.items():
        where = "" if column.where is EVERYWHERE else column.where.text
        rows.append(f"| `{name}` | {column.description} | {column.unit} | {where} |\n")
    return "".join(rows)


def test_columns_on_the_page_agree_with_a_step():
    columns = columns_of(LoadStep)
    for record in (LoadStep, TimeStep, FlatStep, SlidingStep, TimedSlidingStep):
        listed = columns_of(record)
        if record is TimedSlidingStep:
            columns = columns_of(SlidingStep)
        if record is not LoadStep:
            listed = {k: v for k, v in listed.items() if v != columns.get(k)}
        assert rows_of(listed) in PAGES["examples/guide/columns.md"]
    on_request = columns_on_request(LoadStep) | columns_on_request(SlidingStep)
    assert rows_of(on_request) in PAGES["examples/guide/columns.md"]


def test_results_of_paths_are_on_the_page_of_columns():
    for kind, path in PATHS.items():
        for name, result in path.results.items():
            if path.__module__.startswith("ase_roughcontact."):
                row = f"| `{kind}` | `{name}` | {result.unit} | {result.description}"
                assert row in PAGES["examples/guide/columns.md"]


@pytest.mark.parametrize("page", sorted(GUIDE.glob("*.md")), ids=lambda page: page.stem)
def test_page_of_the_guide_is_read_at_one_sitting(page):
    text = [line for line in page.read_text().splitlines() if line[:1] != "|"]
    assert len(" ".join(text).split()) <= 2500


def test_cheat_sheet_has_all_commands():
    page = (GUIDE / "cheat_sheet.md").read_text()
    shown = set(re.findall(r"`ase-roughcontact (\w+)", page))
    listed = re.findall(r"^    (\w+)(?: {2}|$)", make_parser().format_help(), re.M)
    assert shown == set(listed) - {"command"}


def test_each_public_name_is_on_the_page_of_one_topic(monkeypatch):
    monkeypatch.syspath_prepend(str(GUIDE))
    pages = import_module("reference_pages")
    listed = [name for names in pages.topics().values() for name in names]
    assert sorted(listed) == sorted(
        n for names in pages.public().values() for n in names
    )


def test_reference_lists_all_packages_and_public_names():
    page = (GUIDE / "reference" / "index.rst").read_text()
    modules = (GUIDE / "reference" / "modules.rst").read_text()
    package = ROOT / "ase_roughcontact"
    folders = (file.parent for file in package.glob("[a-z]*/**/__init__.py"))
    packages = {".".join(folder.relative_to(package).parts) for folder in folders}
    listed = re.findall(r"^   ase_roughcontact\.([\w.]+)$", modules, re.M)
    assert set(listed) == packages
    assert set(re.findall(r":(?:class|func):`\.(\w+)`", page)) == LISTED
