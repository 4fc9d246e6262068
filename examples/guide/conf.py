"""Configuration of the documentation site.

    sphinx-build examples/guide build/guide

builds it and executes the gallery; `-D plot_gallery=0` shows the scripts of the gallery
without executing them. Nothing is downloaded, neither here nor by the pages: formulas
become MathML, which browsers show without a script.
"""

import re
import sys
from functools import partial
from importlib import import_module
from pathlib import Path
from pkgutil import walk_packages
from typing import Any

from docutils import nodes
from docutils.nodes import Element, Node, SkipNode, literal_block, section, title
from docutils.utils.math.latex2mathml import tex2mathml
from jinja2 import PackageLoader
from jinja2.sandbox import SandboxedEnvironment
from numpydoc import docscrape_sphinx
from PIL import Image
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.math import get_node_equation_number
from sphinx.writers.html5 import HTML5Translator
from sphinx_gallery.utils import scale_image

import ase_roughcontact
from ase_roughcontact.cli.parser import make_parser

sys.path[:0] = [str(Path(__file__).parents[1] / "paper"), str(Path(__file__).parent)]
notebooks = import_module("notebooks")
reference_pages = import_module("reference_pages")

project = "ase_roughcontact"
author = "The ase_roughcontact authors"
copyright = author
version = release = ase_roughcontact.__version__

extensions = [
    "myst_parser",
    "numpydoc",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_gallery.gen_gallery",
]
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3
templates_path = ["_templates"]
exclude_patterns = ["_templates", "results"]
# Names in the guide must exist. Words in single backticks of docstrings may be
# parameters, which have no page.
default_role = "py:obj"
nitpicky = True
nitpick_ignore_regex = [("py:obj", ".*"), ("py:class", r"collections\..*")]

add_module_names = False
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autosummary_generate = True
# Packages within others have pages of their own.
autosummary_context = {
    "packages": [
        module.name
        for module in walk_packages(ase_roughcontact.__path__, "ase_roughcontact.")
        if module.ispkg
    ],
    "excluded": reference_pages.excluded(),
}
numpydoc_show_class_members = False
# Else numpydoc compiles its template for each docstring, a third of the build.
_templates = SandboxedEnvironment(loader=PackageLoader("numpydoc"))
docscrape_sphinx.SandboxedEnvironment = lambda loader: _templates


class GalleryOrder:
    """Order of the scripts in a folder of the gallery."""

    names = (
        *("first_contact", "load_sweep", "hertz_optimizers", "cantilever"),
        *("adhesion_loop", "measured_topography", "crystals", "atoms_under_sphere"),
        *("own_wall", "plastic_contact", "adhesion_hysteresis", "mixed_calculator"),
        *(
            "pull_off_rates",
            "creep_under_load",
            "friction_loop",
            "static_friction",
            "lateral_stiffness",
            "ensemble_database",
        ),
        *("figure1", "figure2", "flat_reference", "reproduction"),
    )

    def __init__(self, folder: str) -> None:
        """Do nothing: the order is that of the names."""

    def __call__(self, file: str) -> int:
        """Return the place of a script."""
        return self.names.index(Path(file).stem)


sphinx_gallery_conf = {
    "examples_dirs": ["../gallery", "../paper"],
    "gallery_dirs": ["gallery", "paper"],
    "filename_pattern": "/gallery/",
    "ignore_pattern": r"paper_scenes\.py",
    "within_subsection_order": GalleryOrder,
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "write_computation_times": False,
    "show_signature": False,
}
suppress_warnings = ["config.cache"]

WIDE = 5.5  # inches
THUMBNAIL = 400, 280  # largest width and height in pixels

html_theme = "pydata_sphinx_theme"
html_title = f"ase_roughcontact {release}"
html_static_path = ["_static"]
html_css_files = ["guide.css"]
html_search_scorer = str(Path(__file__).parent / "_static" / "scorer.js")
html_show_sourcelink = False
html_show_copyright = False
html_theme_options = {
    "navigation_with_keys": False,
    "header_links_before_dropdown": 6,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["sphinx-version"],
    "footer_end": ["theme-version"],
}


def visit_math(self: HTML5Translator, node: Element) -> None:
    """Write a formula within a line."""
    self.body.append(tex2mathml(node.astext()))
    raise SkipNode


def visit_displaymath(self: HTML5Translator, node: Element) -> None:
    """Write a formula of its own."""
    self.body.append(self.starttag(node, "div", CLASS="math"))
    if node["number"]:
        number = get_node_equation_number(self, node)
        self.body.append(f'<span class="eqno">({number})</span>')
    self.body.append(tex2mathml(node.astext(), as_block=True) + "</div>\n")
    raise SkipNode


def escape_initials(*arguments: Any) -> None:
    """Keep initials of authors, and symbols, from becoming the numbers of a list."""
    lines = arguments[-1]
    lines[:] = [re.sub(r"^(\s*[A-Za-z])\.(?= |$)", r"\1\\.", line) for line in lines]


class CommandLine(SphinxDirective):
    """All commands with their options, as the parser prints them."""

    def run(self) -> list[Node]:
        """Return a section for each command."""
        parser = make_parser()
        (commands,) = (
            action for action in parser._actions if isinstance(action.choices, dict)
        )
        help_texts = {"ase-roughcontact": parser, **commands.choices}
        parts: list[Node] = []
        for name, command in help_texts.items():
            command.formatter_class = partial(command.formatter_class, width=79)
            part = section(ids=[f"command-{name}"])
            part += title(text=name)
            part += literal_block(text=command.format_help(), language="none")
            parts.append(part)
        return parts


def stored_picture(app: Sphinx, script: str) -> Path | None:
    """Return the stored picture of a script of the gallery that is not executed."""
    folder, _, name = script.rpartition("/")
    picture = Path(app.srcdir).parent / "images" / f"{name}.png"
    executed = folder == "gallery" and app.config.sphinx_gallery_conf["plot_gallery"]
    listed = folder in sphinx_gallery_conf["gallery_dirs"] and picture.exists()
    return picture if listed and not executed else None


def show_stored_thumbnails(app: Sphinx) -> None:
    """Show stored pictures in the list of scripts that are not executed."""
    for thumbnail in Path(app.srcdir).glob("*/images/thumb/sphx_glr_*_thumb.png"):
        name = thumbnail.name.removeprefix("sphx_glr_").removesuffix("_thumb.png")
        picture = stored_picture(app, f"{thumbnail.parents[2].name}/{name}")
        if picture is not None:
            scale_image(picture, thumbnail, *THUMBNAIL)


def show_stored_picture(app: Sphinx, script: str, source: list[str]) -> None:
    """Show a stored picture below a script that is not executed."""
    if stored_picture(app, script) is not None:
        name, links = script.rpartition("/")[2], "\n.. _sphx_glr_download_"
        picture = (
            f"\n.. image:: ../../images/{name}.png\n   :class: sphx-glr-single-img\n"
        )
        source[0] = source[0].replace(links, f"{picture}{links}", 1)


def link_notebook(app: Sphinx, page: str, source: list[str]) -> None:
    """End a page that is a notebook, too, with a link to the notebook."""
    if page in notebooks.PAGES:
        file = f"notebooks/{page}.ipynb"
        source[0] += f"\n\n{{download}}`This page as a notebook <{file}>`\n"


def mark_wide(app: Sphinx, doctree: Node) -> None:
    """Mark pictures of several panels, which small screens scroll."""
    for image in doctree.findall(nodes.image):
        file = Path(app.srcdir) / image["uri"]
        picture = Image.open(file)
        if picture.width > WIDE * picture.info.get("dpi", (200,))[0]:
            image["classes"].append("wide")


def setup(app: Sphinx) -> None:
    """Let browsers set the formulas, and write pages before they are read."""
    reference_pages.write()
    notebooks.write()
    app.add_directive("command-line", CommandLine)
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displaymath, None))
    app.connect("autodoc-process-docstring", escape_initials)
    app.connect("builder-inited", show_stored_thumbnails, priority=900)
    app.connect("source-read", show_stored_picture)
    app.connect("source-read", link_notebook)
    app.connect("doctree-read", mark_wide)


html_math_renderer = "mathml"
