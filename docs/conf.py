"""How Sphinx makes the pages: `make docs`."""

from __future__ import annotations

import hashlib
import inspect
import re
from itertools import groupby
from pathlib import Path

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx.util.inspect import TypeAliasForwardRef

import blockstat

HERE = Path(__file__).parent
SOURCES = sorted((HERE.parent / "src").rglob("*.py"))

project = "blockstat"
author = copyright = "The blockstat authors"
version = release = blockstat.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.viewcode"]
# The page of the design search would be search.html, which is Sphinx's own: design_search.md includes it.
exclude_patterns = ["results", "search.md", "**.ipynb_checkpoints"]
html_theme = "furo"
html_title = "blockstat"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_theme_options = {"navigation_with_keys": True}
html_copy_source = False
html_math_renderer = "mathml"  # browsers show it by themselves, without a script from elsewhere

myst_enable_extensions = ["dollarmath", "html_image"]
myst_heading_anchors = 3

# docs/notebooks is a link to notebooks/, so the notebooks run where they lie. Their outputs are kept until the notebook
# or the code that it runs has changed.
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

autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_type_aliases = {name: name for name in ("Floats", "Ints", "Scene", "Values")}
TypeAliasForwardRef.__repr__ = lambda self: self.name  # else tuples of Floats are told in full
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 100
default_role = "code"

#: Links as a Git host needs them, and as the built pages do.
LINKS = {
    "](../notebooks/": "](notebooks/",
    "](search.md": "](design_search.md",
    "](../search.md": "](../design_search.md",
}


def _links(app, docname, source):
    for written, built in LINKS.items():
        source[0] = source[0].replace(written, built)


def _as_text(text: str) -> str:
    """Docstrings are plain text with `code`: |x|, a*b and f_ mean themselves."""
    parts = re.split(r"(`[^`]*`)", text)
    parts[::2] = [re.sub(r"([*|\\]|_\b)", r"\\\1", part) for part in parts[::2]]
    parts[1::2] = [f"`{part}`" for part in parts[1::2]]
    return "".join(parts)


def _parameters(obj) -> list[str]:
    """Names that a docstring may explain."""
    try:
        return list(inspect.signature(obj).parameters)
    except (TypeError, ValueError):
        return []


def _listed(text: str, names: str) -> list[str]:
    """Where parameters need words docstrings say `name, other : meaning`: a list of these.

    A sentence that begins a line is about the whole again.
    """
    mark = re.compile(rf"(?:^|(?<=[.;)]\s))((?:{names})(?:, (?:{names}))*)(?: \[[^]]*\])? : ", re.MULTILINE)
    lines = []
    for part in re.split(r"(?<=\.)\n(?=[A-Z])", text):
        before, *pairs = mark.split(part)
        lines += [*_as_text(before).split("\n"), ""]
        for key, meaning in zip(pairs[::2], pairs[1::2], strict=True):
            lines.append(f"- **{_as_text(key)}**: {' '.join(_as_text(meaning).split()).rstrip(';')}")
        lines.append("")
    return lines


def _docstring(app, what, name, obj, options, lines):
    """Docstrings are plain text; what is indented is code."""
    names = "|".join(map(re.escape, _parameters(obj))) or "(?!)"
    result = []
    for paragraph in re.split(r"\n\s*\n", "\n".join(lines)):
        for indented, group in groupby(paragraph.split("\n"), key=lambda line: line.startswith("    ")):
            text = list(group)
            result += ["::", "", *text, ""] if indented else _listed("\n".join(text), names)
    lines[:] = result


def _signature(app, what, name, obj, options, signature, returns):
    """A default that a factory makes is no Python, and Sphinx would not break the line."""
    return signature and signature.replace("<factory>", "..."), returns


def _mathml(writer, node):
    writer.body.append(tex2mathml(node.astext(), as_block=isinstance(node, nodes.math_block)))
    raise nodes.SkipNode


def setup(app):
    app.add_html_math_renderer("mathml", inline_renderers=(_mathml, None), block_renderers=(_mathml, None))
    app.connect("source-read", _links)
    app.connect("autodoc-process-docstring", _docstring)
    app.connect("autodoc-process-signature", _signature)
