"""Settings of the documentation site: ``make docs`` builds it into build/docs. Nothing in the built pages asks the network."""

from __future__ import annotations

import os
import sys
from pathlib import Path

DOCS = Path(__file__).resolve().parent
sys.path.insert(0, str(DOCS / "_site"))
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from api_pages import PUBLIC  # noqa: E402
from gallery_figures import scrape  # noqa: E402
from sphinx_gallery.sorting import FileNameSortKey  # noqa: E402

import valvetrain  # noqa: E402

project = "valvetrain"
author = "The valvetrain developers"
copyright = author
version = release = valvetrain.__version__
language = "en"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "numpydoc",
    "sphinx_design",
    "sphinx_copybutton",
    "sphinx_gallery.gen_gallery",
    "native_math",
    "page_tree",
    "api_pages",
    "command_pages",
    "reference_pages",
    "gallery_figures",
]
root_doc = "index"
exclude_patterns = [
    "_site/**",
    *(
        f"{name}/{file}"
        for name in ("gallery", "notebooks")
        for file in ("*.py", "*.ipynb", "sg_execution_times.rst")
    ),
    "sg_execution_times.rst",
]
suppress_warnings = [
    "config.cache"
]  # settings below hold functions and classes, which no cache keeps

# Markdown as code hosts show it: same anchors of headings, relative links to files.
myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 4
myst_links_external_new_tab = False

# API: from docstrings, which say units and shapes. The values are those of the source text.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
numpydoc_show_class_members = False
numpydoc_xref_param_type = True  # names of our classes among what an argument is
numpydoc_xref_ignore = "all"
numpydoc_xref_aliases = {name: path for name, path in PUBLIC.items() if name[0].isupper()}
nitpicky = True

html_theme = "pydata_sphinx_theme"
html_title = "valvetrain"
html_static_path = ["_site/static"]
html_css_files = ["site.css"]
html_js_files = ["figures.js"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_show_search_summary = (
    False  # would fetch each page, which a browser refuses to pages opened as files
)
html_context = {"default_mode": "auto"}
html_theme_options = {
    "logo": {"text": "valvetrain"},
    "header_links_before_dropdown": 8,
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "navbar_persistent": ["search-button"],
    "footer_start": ["copyright"],
    "footer_center": [],
    "footer_end": [],
    "show_prev_next": True,
    "navigation_with_keys": False,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
}
html_sidebars = {"index": [], "tutorial": []}
copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True

sphinx_gallery_conf = {
    "examples_dirs": ["../examples/gallery", "../examples/notebooks"],
    "gallery_dirs": ["gallery", "notebooks"],
    "filename_pattern": r"\.py$",
    "within_subsection_order": FileNameSortKey,
    "image_scrapers": (scrape,),
    "backreferences_dir": "gallery/used",
    "doc_module": ("valvetrain",),
    "reset_modules": (),
    "capture_repr": ("_repr_html_",),  # what the last line of a notebook's cell shows
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_memory": False,
    "show_signature": False,
    "min_reported_time": 1e9,
    "plot_gallery": True,
    "abort_on_example_error": False,
    "only_warn_on_example_error": False,
    "write_computation_times": False,
}
