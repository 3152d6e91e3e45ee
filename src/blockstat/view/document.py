"""Parts that all reports share: texts, a self-contained page, tables and pictures, on screen, telephone and paper."""

from __future__ import annotations

import base64
from collections.abc import Iterable, Sequence
from html import escape
from pathlib import Path

KINDS = {".png": "image/png", ".svg": "image/svg+xml"}
MEANING = (
    "Blocks are rigid and joints carry no tension unless a joint law says so. Stable by force fields alone means that "
    "forces within every friction cone balance every block. This is necessary for rest and, with real friction, not "
    "sufficient: such friction dilates, and blocks may jam each other on paper. Stable without dilatancy excludes "
    "both. Unstable is proven by a mechanism. A multiplier is the horizontal acceleration in units of gravity, on all "
    "free blocks, beside the loads named; it lies between two bounds that were checked without the solver."
)
SOURCES = (
    "R. K. Livesley: Limit analysis of structures formed from rigid blocks. International Journal for Numerical "
    "Methods in Engineering 12, 1978. The limit load as a program over forces and mechanisms.",
    "J. Heyman: The stone skeleton. International Journal of Solids and Structures 2, 1966. The safe theorem for "
    "masonry.",
    "E. Whiting, J. Ochsendorf, F. Durand: Procedural modeling of structurally-sound masonry buildings. ACM "
    "Transactions on Graphics 28, 2009. The score: the tension that is missing.",
    "M. Gilbert, C. Casapulla, H. M. Ahmed: Limit analysis of masonry block structures with non-associative frictional "
    "joints using linear programming. Computers & Structures 84, 2006. Limit loads without dilatancy.",
    "G. De Saxce, Z.-Q. Feng: The bipotential method. Mathematical and Computer Modelling 28, 1998. The fixed point "
    "behind the verdict without dilatancy.",
)
CODE = "Circolare 21 gennaio 2019, n. 7 C.S.LL.PP., C8.7.1.2.1, linear verification; NTC 2018, 3.2.3.2.1."


def page(title: str, body: Sequence[str]) -> str:
    """Return a page in the style of the reports.

    Parameters
    ----------
    title : str
        Plain text.
    body : sequence of str
        HTML of its parts.

    Returns
    -------
    str
        HTML that loads nothing from elsewhere.
    """
    return _PAGE.format(title=escape(title), body="\n".join(body))


def image(path: Path, caption: str) -> str:
    """Return a picture as a part of a page.

    Parameters
    ----------
    path : Path
        A PNG or SVG file.
    caption : str
        HTML-safe text for those who do not see it.

    Returns
    -------
    str
        HTML with the picture inside it.
    """
    data = base64.b64encode(path.read_bytes()).decode()
    return f'<img src="data:{KINDS[path.suffix]};base64,{data}" alt="{caption}">'


def figure(path: Path, caption: str) -> str:
    """Return a picture with its caption.

    Parameters
    ----------
    path : Path
        A PNG or SVG file.
    caption : str
        Plain text.

    Returns
    -------
    str
        HTML.
    """
    words = escape(caption)
    return f"<figure>{image(path, words)}<figcaption>{words}</figcaption></figure>"


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """Return a table; on a narrow screen it scrolls by itself, and the page does not.

    Parameters
    ----------
    heads : sequence of str
        Plain text of the heading; empty for none.
    rows : iterable of sequences of str
        Plain text of the cells.

    Returns
    -------
    str
        HTML.
    """
    head = f"<tr>{''.join(f'<th>{escape(name)}</th>' for name in heads)}</tr>" if heads else ""
    body = "".join(f"<tr>{''.join(f'<td>{escape(cell)}</td>' for cell in row)}</tr>" for row in rows)
    return f'<div class="wide"><table>{head}{body}</table></div>'


def facts(rows: Iterable[tuple[str, str]]) -> str:
    """Return a list of names and what they are, one above the other on a narrow screen.

    Parameters
    ----------
    rows : iterable of tuple of str
        Plain text: a name and its value.

    Returns
    -------
    str
        HTML.
    """
    cells = "".join(f"<div><dt>{escape(name)}</dt><dd>{escape(value)}</dd></div>" for name, value in rows)
    return f'<dl class="facts">{cells}</dl>'


def verdict_box(tone: str, title: str, words: str) -> str:
    """Return an answer in a box.

    Parameters
    ----------
    tone : str
        "good", "bad", or empty for neither.
    title, words : str
        Plain text: the answer, and what it rests on.

    Returns
    -------
    str
        HTML.
    """
    return f'<div class="verdict {tone}"><b>{escape(title)}</b><br>{escape(words)}</div>'


def bullets(lines: Iterable[str]) -> str:
    """Return a list of sentences.

    Parameters
    ----------
    lines : iterable of str
        Plain text.

    Returns
    -------
    str
        HTML; empty for none.
    """
    items = "".join(f"<li>{escape(line)}</li>" for line in lines)
    return f"<ul>{items}</ul>" if items else ""


_PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>
body {{ font: 15px/1.5 system-ui, sans-serif; max-width: 60rem; margin: 2rem auto; padding: 0 1rem; color: #222;
  overflow-wrap: break-word }}
h1 {{ line-height: 1.2 }} h2 {{ margin-top: 2rem; border-bottom: 2px solid #ddd }}
table {{ border-collapse: collapse; margin: 1rem 0; font-variant-numeric: tabular-nums }}
th, td {{ padding: .25rem .7rem; border-bottom: 1px solid #ddd; text-align: left; vertical-align: top }}
tr.stands td {{ background: #e8f1fa }}
.wide {{ overflow-x: auto }}
.verdict {{ border-left: 6px solid #6b6b6b; padding: .2rem .9rem; margin: 1rem 0; break-inside: avoid }}
.verdict b {{ font-size: 1.25em }} .good {{ border-color: #0072B2 }} .bad {{ border-color: #D55E00 }}
.facts {{ margin: 1rem 0 }} .facts div {{ display: flex; border-bottom: 1px solid #ddd; padding: .2rem 0 }}
.facts dt {{ flex: 0 0 15rem; color: #555 }} .facts dd {{ margin: 0; flex: 1; min-width: 0 }}
.pictures {{ display: grid; grid-template-columns: 1fr 1fr; gap: 1rem }}
pre {{ white-space: pre-wrap }}
figure {{ margin: 1.5rem 0; break-inside: avoid }} img {{ max-width: 100%; height: auto }}
figcaption {{ color: #555 }}
@media (max-width: 640px) {{
  body {{ margin: 1rem auto }} .pictures {{ grid-template-columns: 1fr }} th, td {{ padding: .25rem .4rem }}
  .facts div {{ display: block }} .wide td:last-child {{ min-width: 14em }}
}}
@media print {{
  @page {{ margin: 18mm 15mm }}
  body {{ font-size: 10.5pt; margin: 0; max-width: none; padding: 0 }} .pictures {{ grid-template-columns: 1fr 1fr }}
  h2, h3 {{ break-after: avoid }} pre, tr {{ break-inside: avoid }} .wide {{ overflow: visible }}
  * {{ print-color-adjust: exact; -webkit-print-color-adjust: exact }}
}}
</style></head><body>
{body}
</body></html>
"""
