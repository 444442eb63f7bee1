"""Sphinx configuration: `make docs` builds the pages that are beside this file."""

from __future__ import annotations

import sys
import tomllib
from pathlib import Path
from typing import Any

HERE = Path(__file__).parent
ROOT = HERE.parent
sys.path.insert(0, str(ROOT))

from docs import api_pages, plot_benchmarks  # noqa: E402

_project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]

project = "ABI visualiser"
release = version = _project["version"]
author = "The ABI visualiser contributors"
copyright = author

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.viewcode",
    "docs.mathml",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build"]
# What a function returns has a name that is taken for a type; some have it in several modules.
suppress_warnings = ["ref.python"]

html_math_renderer = "mathml"
myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_type_aliases = {"FloatArray": "FloatArray", "IntArray": "IntArray", "Vec3": "Vec3"}
autodoc_default_options = {"members": True, "show-inheritance": False}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

html_theme = "furo"
html_title = f"{project} {release}"
html_static_path: list[str] = []
html_show_copyright = False
pygments_style = "friendly"
pygments_dark_style = "monokai"

sphinx_gallery_conf = {
    "examples_dirs": str(ROOT / "examples"),
    "gallery_dirs": "gallery",
    "filename_pattern": "/",
    "ignore_pattern": r"__init__\.py",
    "image_scrapers": ("docs.gallery_pictures.scrape",),
    "reset_argv": "docs.gallery_pictures.arguments",
    "default_thumb_file": str(HERE / "pictures" / "page.webp"),
    "within_subsection_order": "FileNameSortKey",
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "show_memory": False,
    "min_reported_time": 1e9,
    "write_computation_times": False,
}


def setup(app: Any) -> None:
    """Escape what reads as markup in the docstrings' formulas."""
    app.connect("autodoc-process-docstring", api_pages.escape)


api_pages.write(ROOT, HERE / "api")
plot_benchmarks.plot(HERE / "data" / "bench.json", HERE / "data")
