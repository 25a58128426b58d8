"""How Sphinx builds the site: ``sphinx-build -W --keep-going -n docs build/docs``, without a network."""

import logging
import sys
from pathlib import Path

import baroarma

sys.path.insert(0, str(Path(__file__).parent))  # our two small extensions
logging.getLogger("baroarma").setLevel(logging.WARNING)  # the theme's colours turn everybody's logging on

project = "baroarma"
author = "The baroarma developers"
project_copyright = "The baroarma developers, MIT licence"
version = release = baroarma.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "matplotlib.sphinxext.plot_directive",
    "docstrings",
    "mathml",
]
source_suffix = {".md": "markdown"}
myst_enable_extensions = ["deflist", "dollarmath"]
myst_heading_anchors = 3
html_math_renderer = "mathml"

# Docstrings: numpydoc sections say types, units and shapes better than annotations do.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_param = False
napoleon_use_rtype = False
default_role = "py:obj"
nitpick_ignore_regex = [
    ("py:obj", ".*"),  # a name in single backticks is a link where there is something to link to
    ("py:class", r"(numpy|collections\.abc)\..*"),  # other projects' indices would need a network
]

plot_formats = ["svg"]
plot_html_show_formats = False
plot_html_show_source_link = False
plot_rcparams = {
    "figure.figsize": (7.5, 3.6),
    "font.size": 10,
    "figure.constrained_layout.use": True,
    "savefig.bbox": "tight",
}
plot_apply_rcparams = True

html_theme = "furo"
html_title = f"baroarma {version}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
highlight_language = "text"
pygments_dark_style = "github-dark"
