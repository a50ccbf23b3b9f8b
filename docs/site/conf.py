"""The documentation site: `make docs`. Pages are `docs/*.md`; reference pages are generated."""

import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parents[1])]

import reference  # noqa: E402 - beside this file

import vividc  # noqa: E402

project = "vividc"
copyright = "the vividc authors"
version = release = vividc.__version__
extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_click",
]
source_suffix = {".md": "myst-nb", ".ipynb": "myst-nb"}
nb_execution_mode = "cache"
nb_execution_cache_path = str(HERE.parents[1] / "build" / "notebooks")
nb_execution_timeout = 600
nb_execution_raise_on_error = True
exclude_patterns = ["site"]
html_theme = "furo"
html_title = f"vividc {version}"
myst_heading_anchors = 3
myst_enable_extensions = ["colon_fence"]
napoleon_google_docstring = False
napoleon_use_ivar = True
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_class_signature = "separated"
autodoc_default_options = {"members": True, "imported-members": True, "undoc-members": True}
autodoc_preserve_defaults = True
linkcheck_anchors = False
nitpicky = False
suppress_warnings = ["myst.header", "ref.python"]


def setup(app):
    """Generate the reference pages before anything is read."""
    app.connect("builder-inited", lambda app: reference.write(Path(app.srcdir) / "reference"))
    app.connect("source-read", _repository_links)


def _repository_links(_app, docname, source):
    """Files of the repository that are no pages are named, and not linked to."""
    source[0] = reference.without_links_out(source[0])
