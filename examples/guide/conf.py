"""Configuration of the documentation site.

    sphinx-build examples/guide build/guide

builds it and executes the gallery; `-D plot_gallery=0` shows the scripts of the gallery
without executing them. Nothing is downloaded, neither here nor by the pages: formulas
become MathML, which browsers show without a script.
"""

import sys
from pathlib import Path

from docutils.nodes import Element
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.application import Sphinx
from sphinx.util.math import get_node_equation_number
from sphinx.writers.html5 import HTML5Translator

import ase_roughcontact

sys.path.insert(0, str(Path(__file__).parents[1] / "paper"))

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
exclude_patterns = ["_templates"]
# Names in the guide must exist. Words in single backticks of docstrings may be
# parameters, which have no page.
default_role = "py:obj"
nitpicky = True
nitpick_ignore_regex = [("py:obj", ".*"), ("py:class", r"collections\..*")]

autodoc_member_order = "bysource"
autodoc_typehints = "none"
autosummary_generate = True
numpydoc_show_class_members = False

sphinx_gallery_conf = {
    "examples_dirs": ["../gallery", "../paper"],
    "gallery_dirs": ["gallery", "paper"],
    "filename_pattern": "/gallery/",
    "ignore_pattern": r"paper_scenes\.py",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "write_computation_times": False,
    "show_signature": False,
}
suppress_warnings = ["config.cache"]

html_theme = "pydata_sphinx_theme"
html_title = "ase_roughcontact"
html_static_path = ["_static"]
html_css_files = ["guide.css"]
html_show_sourcelink = False
html_show_copyright = False
html_theme_options = {
    "show_prev_next": True,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 6,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["sphinx-version"],
    "footer_end": ["theme-version"],
}


def visit_math(self: HTML5Translator, node: Element) -> None:
    """Write a formula within a line."""
    self.body.append(tex2mathml(node.astext()))


def visit_displaymath(self: HTML5Translator, node: Element) -> None:
    """Write a formula of its own."""
    self.body.append(self.starttag(node, "div", CLASS="math"))
    if node["number"]:
        number = get_node_equation_number(self, node)
        self.body.append(f'<span class="eqno">({number})</span>')
    self.body.append(tex2mathml(node.astext(), as_block=True) + "</div>\n")


def depart(self: HTML5Translator, node: Element) -> None:
    """Do nothing more."""


def setup(app: Sphinx) -> None:
    """Let browsers set the formulas."""
    app.add_html_math_renderer(
        "mathml", (visit_math, depart), (visit_displaymath, depart)
    )


html_math_renderer = "mathml"
