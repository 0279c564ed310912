# SPDX-License-Identifier: MIT
"""Sphinx configuration of the documentation site. scripts/docs.sh assembles the pages and calls it."""
import os
import re

project = "selvedge"
author = "the selvedge developers"
copyright = "the selvedge developers, MIT licence"
extensions = ["myst_parser", "breathe", "sphinx.ext.mathjax"]
myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 3
# Formulas are drawn by KaTeX, which is copied into the site: it works offline.
mathjax_path = "formulas.js"
html_static_path = ["_static"]
html_css_files = ["katex/katex.min.css", "wide.css"]
html_js_files = [
    ("katex/katex.min.js", {"defer": "defer"}),
    ("katex/contrib/auto-render.js", {"defer": "defer"}),
]
html_theme = "furo"
html_title = "selvedge"
highlight_language = "none"
breathe_projects = {"selvedge": os.environ["SELVEDGE_DOXYGEN_XML"]}
breathe_default_project = "selvedge"
# Doxygen's XML names some types in ways that the C++ domain cannot look up.
suppress_warnings = ["cpp", "duplicate_declaration", "myst.header"]
primary_domain = "cpp"

_PAGES = re.compile(r"^[\w./-]+\.(?:md|png|gif|webp|jpg|html|csv)(?:#[\w-]+)?$")


def point_inside(app, docname, source):
    """Links to pages and pictures of the site stay; those to files of the source tree become their names."""

    def link(match):
        mark, text, target = match.groups()
        if mark or re.match(r"^(https?:|#)", target):
            return match.group(0)
        target = re.sub(r"^(\.\./)*docs/", "", target)
        if re.match(r"^(\.\./)+README\.md$|^README\.md$", target):
            up = "../" * docname.count("/")
            return f"[{text}]({up}getting_started.md)"
        here = os.path.join(app.srcdir, os.path.dirname(docname), target.split("#")[0])
        if _PAGES.match(target) and os.path.exists(here):
            return f"[{text}]({target})"
        return text if text.startswith("`") else f"`{text}`"

    source[0] = re.sub(r"(!?)\[([^\]]*)\]\(([^)\s]+)\)", link, source[0])
    source[0] = re.sub(r"!\[([^\]]*)\]\((?:\.\./)*docs/", r"![\1](", source[0])


def setup(app):
    app.connect("source-read", point_inside)
