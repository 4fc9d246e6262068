"""API reference: sphinx-build examples/reference build/reference."""

project = "ase_roughcontact"
author = "The ase_roughcontact authors"
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.mathjax",
    "numpydoc",
]
autosummary_generate = True
autodoc_member_order = "bysource"
autodoc_typehints = "none"
numpydoc_show_class_members = False
html_theme = "alabaster"
