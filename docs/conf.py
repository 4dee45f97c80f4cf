"""The site of the documentation (`make site`)."""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT / "src"), str(ROOT / "docs")]

from reference import write_reference  # noqa: E402

from softsample import __version__  # noqa: E402

project = "softsample"
version = release = __version__
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon"]
exclude_patterns = ["figures", "data"]
myst_heading_anchors = 3
autosummary_generate = True
autodoc_typehints = "none"
autodoc_default_options = {"members": True, "show-inheritance": True}
napoleon_google_docstring = False
# figures, data and sources that pages link are beside them in the repository, not on the site
suppress_warnings = ["myst.xref_missing", "docutils", "ref.python", "ref.footnote", "autosummary"]
html_theme = "alabaster"
html_theme_options = {
    "description": "Shear modulus of soft tissue on real geometry",
    "page_width": "1200px",
    "body_max_width": "none",
}
html_copy_source = False

write_reference(ROOT, ROOT / "docs/generated")
