"""How Sphinx makes the pages: `make docs`."""

from __future__ import annotations

import hashlib
import re
from pathlib import Path

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.ext import napoleon
from sphinx.util.inspect import TypeAliasForwardRef

import blockstat

HERE = Path(__file__).parent
SOURCES = sorted((HERE.parent / "src").rglob("*.py"))

project = "blockstat"
author = copyright = "The blockstat authors"
version = release = blockstat.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.viewcode"]
# Sphinx has a page search.html of its own, so design_search.md includes search.md.
exclude_patterns = ["results", "search.md", "**.ipynb_checkpoints"]
html_theme = "furo"
html_title = "blockstat"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_theme_options = {"navigation_with_keys": True}
html_copy_source = False
smartquotes = False  # quotes and dashes of options stay as one types them
html_math_renderer = "mathml"  # browsers show it without a script from another server

myst_enable_extensions = ["dollarmath", "html_image"]
myst_heading_anchors = 3

# docs/notebooks is a link to notebooks/, so the notebooks run in their own directory. Their outputs are kept until the
# notebook or the source code changes.
nb_execution_mode = "cache"
nb_execution_cache_path = str(
    HERE.parent
    / "build"
    / "notebooks"
    / hashlib.sha256(b"".join(path.read_bytes() for path in SOURCES)).hexdigest()[:12]
)
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_merge_streams = True

# Docstrings have numpy sections. Types there are prose ("shape (n_blocks, 6) [N, N m]"), so no word of them is a link.
napoleon_google_docstring = False
napoleon_use_param = False
napoleon_use_rtype = False
napoleon_use_ivar = True  # attributes in a section are members too, which need no second entry

# Two rooms have a `Plan` each; an annotation with that name is a link to neither.
suppress_warnings = ["ref.python"]
autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_type_aliases = {name: name for name in ("Floats", "Ints", "Scene", "Values")}
TypeAliasForwardRef.__repr__ = lambda self: self.name  # otherwise tuples of Floats are written out in full
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 100
default_role = "code"

#: Links as a Git host needs them, and as the built pages need them.
LINKS = {
    "](search.md": "](design_search.md",
    "](../search.md": "](../design_search.md",
}
#: A link to a notebook. MyST follows docs/notebooks out of the pages and finds none there; the role of Sphinx does not.
NOTEBOOK = re.compile(r"\[([^][]*)\]\((?:\.\./notebooks/)?(\w+)\.ipynb\)")


class _Docstring(napoleon.NumpyDocstring):
    """Read the docstrings of attributes like all others: napoleon would take words before a colon for a type."""

    def __init__(self, docstring, config=None, app=None, what="", *rest):
        super().__init__(docstring, config, app, "method" if what in ("attribute", "data", "property") else what, *rest)


napoleon.NumpyDocstring = _Docstring


def _links(app, docname, source):
    for written, built in LINKS.items():
        source[0] = source[0].replace(written, built)
    source[0] = NOTEBOOK.sub(r"{doc}`\1 </notebooks/\2>`", source[0])


def _plain_data(app, what, name, obj, options, lines):
    """Drop the docstring of the type of a constant: that of `dict` says nothing about the constant."""
    if what == "data" and "\n".join(lines).split() == (type(obj).__doc__ or "").split():
        lines.clear()


def _signature(app, what, name, obj, options, signature, returns):
    """Write `...` for a default that a factory makes: `<factory>` is not Python, and Sphinx cannot break the line."""
    return signature and signature.replace("<factory>", "..."), returns


def _mathml(writer, node):
    writer.body.append(tex2mathml(node.astext(), as_block=isinstance(node, nodes.math_block)))
    raise nodes.SkipNode


def setup(app):
    app.add_html_math_renderer("mathml", inline_renderers=(_mathml, None), block_renderers=(_mathml, None))
    app.connect("source-read", _links)
    app.connect("autodoc-process-docstring", _plain_data, priority=1)  # before napoleon reads it
    app.connect("autodoc-process-signature", _signature)
