"""The report of a search: one self-contained HTML page, the history, and the best design."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from textwrap import fill

from blockstat.analysis.assess import assess
from blockstat.analysis.verdict import Verdict
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP, find_interfaces
from blockstat.design_search.search import ERROR, PRUNED, Candidate, SearchResult
from blockstat.errors import InputError
from blockstat.imperfection.imperfections import Imperfections
from blockstat.io.files import write
from blockstat.spec import build, parameters, with_values
from blockstat.studies.directions import DirectionOutcome, limit_load_by_direction
from blockstat.system.writing import written_whole
from blockstat.view.document import image, page
from blockstat.view.plot import DEMAND, USED, plot, plot_verdict
from blockstat.view.polar import plot_directions
from blockstat.view.three_d.page import available, framed, interactive_html

#: Longest line of the title of a picture [characters].
TITLE = 70


@dataclass(frozen=True)
class Figure:
    """A picture on disk, or a page (.html), and what it shows."""

    path: Path
    caption: str


def write_designs(
    result: SearchResult,
    directory: Path,
    *,
    under: Callable[[Assembly], Assembly] = lambda assembly: assembly,
    gap: float | str = GAP,
    imperfections: Imperfections | None = None,
) -> list[Figure]:
    """Write the best design, and pictures of what statics say of it and of the thinnest pruned one.

    Parameters
    ----------
    result : SearchResult
        The search.
    directory : Path
        Where best.json, best.glb and the pictures go. With viser installed (extra ui) view.html goes there too, a view
        of the best design in three dimensions.
    under : callable, optional
        Puts each design under another friction or gravity.
    gap : float or str, optional
        Largest gap of a joint, as in `blockstat.assess`.
    imperfections : Imperfections, optional
        Those of the search: what is shown of the statics is their worst case. Limit loads are those of the drawing.

    Returns
    -------
    list of Figure
        The pictures and the page, for `write_report`.

    Raises
    ------
    InputError
        When the directory does not exist.
    """
    figures = []
    shown, words = _shown_design(result, under)
    if shown is not None:
        figures.append(Figure(plot(shown, directory / "building.png", title=shown.name), f"{words}."))
    if shown is not None and result.best is not None:
        write(shown, directory / "best.json")
        write(shown, directory / "best.glb")
        joints = find_interfaces(shown, gap=gap)
        verdict = assess(shown, gap=gap, interfaces=joints, imperfections=imperfections)
        path = plot(
            shown, directory / "demand.png", values=verdict.demand(), colours=DEMAND, top=1.0, label=USED,
            title="demand of the best design",
        )  # fmt: skip
        words = f"How much of its friction and strength each block uses in the certified force field{_worst(verdict)}."
        figures.append(Figure(path, words))
        least = limit_load_by_direction(shown, 4, refine=False, interfaces=joints)
        if least.outcome is DirectionOutcome.LIMIT:
            path = plot_directions(least, directory / "directions.png")
            words = f"{least.least.upper:.4g} times gravity, towards {least.names[least.weakest]}"
            figures.append(Figure(path, f"Limit loads of the best design along +-x and +-y; the least is {words}."))
        if available():
            turning = directory / "view.html"
            text = interactive_html(verdict)
            with written_whole(turning) as place:
                place.write_text(text, encoding="utf-8")
            figures.append(Figure(turning, "The same, to turn with the mouse."))
    pruned = [c for c in result.history if c.dynamic == PRUNED]
    if pruned:
        thinnest = min(pruned, key=lambda c: c.volume or 0.0)
        assembly = under(build(with_values(result.building, thinnest.parameters)))
        verdict = assess(assembly, gap=gap, imperfections=imperfections)
        state = verdict.outcome.word.replace("_", " ") + ", first motion exaggerated" * bool(len(verdict.moving))
        title = f"{fill(f'rejected design: {_values(thinnest)}', TITLE)}\n{state}"
        path = plot_verdict(verdict, directory / "mechanism.png", title=title)
        words = f"How the thinnest pruned design ({_values(thinnest)}) would move first{_worst(verdict)}."
        figures.append(Figure(path, words))
    return figures


def _shown_design(result: SearchResult, under: Callable[[Assembly], Assembly]) -> tuple[Assembly | None, str]:
    """The best design; without one that of the start, or where it cannot be built the first that can, if there is any.

    Which it is in words, too.
    """
    if result.best is not None:
        return under(build(result.best)), "The best design"
    try:
        return under(build(result.building)), "The design the search started from"
    except InputError:  # the history says why
        first = next((c for c in result.history if c.static != ERROR), None)
    if first is None:
        return None, ""
    words = f"The first design that could be built ({_values(first)})"
    return under(build(with_values(result.building, first.parameters))), words


def _worst(verdict: Verdict) -> str:
    """Of which case a verdict is, where it is one of imperfections."""
    return f", in the worst case of the imperfections: {verdict.worst}" if verdict.worst else ""


def write_report(
    result: SearchResult, directory: Path, figures: Sequence[Figure], *, notes: Sequence[str] = ()
) -> Path:
    """Write report.html, with the figures inside it.

    Parameters
    ----------
    result : SearchResult
        The search.
    directory : Path
        Where it goes; it must exist.
    figures : sequence of Figure
        Shown in this order.
    notes : sequence of str, optional
        Paragraphs of plain text, above the figures.

    Returns
    -------
    Path
        The file.
    """
    name = escape(result.building.name)
    history = result.history
    pruned = sum(c.dynamic == PRUNED for c in history)
    verified = result.dynamic_runs
    static_seconds = sum(c.static_seconds for c in history)
    dynamic_seconds = sum(c.dynamic_seconds for c in history)
    body = [f"<h1>{name}: design search</h1>"]
    if not result.finished:
        body.append("<p><b>Interrupted.</b> Run the same command again to go on.</p>")
    body.append(_best_table(result))
    body.append(
        f"<p>{len(history)} design{'s' if len(history) != 1 else ''}: "
        f"{pruned} pruned by statics in {static_seconds:.1f} s "
        f"({result.static_solves} solved, {result.certificates_reused} by the evidence of earlier ones), "
        f"{verified} verified by dynamics in {dynamic_seconds:.1f} s (process time). "
        f"Statics and dynamics disagree on {len(result.disagreements)} of them.</p>"
    )
    body += [f"<p>{escape(note)}</p>" for note in notes]
    for figure in figures:
        caption = escape(figure.caption)
        body.append(f"<figure>{_shown(figure, caption)}<figcaption>{caption}</figcaption></figure>")
    if result.front:
        body.append("<h2>Volume against reserve</h2>" + _front_table(result.front))
    body.append("<h2>History</h2>" + _history_table(history))
    path = directory / "report.html"
    with written_whole(path) as place:
        place.write_text(page(f"{result.building.name}: design search", body), encoding="utf-8")
    return path


def _shown(figure: Figure, caption: str) -> str:
    """A picture, or a page in three dimensions, as a part of this page."""
    if figure.path.suffix == ".html":
        return framed(figure.path.read_text(encoding="utf-8"))
    return image(figure.path, caption)


def _values(candidate: Candidate) -> str:
    return ", ".join(f"{name} {value:g}" for name, value in candidate.parameters.items())


def _best_table(result: SearchResult) -> str:
    if result.best_parameters is None:
        words = result.none_stood.capitalize() if result.finished else "Interrupted before any design stood"
        return f"<p><b>{words}.</b></p>"
    start = {name: found.value for name, found in parameters(result.building).items()}
    rows = "".join(
        f"<tr><td>{escape(name)}</td><td>{start[name]:g}</td><td><b>{value:g}</b></td></tr>"
        for name, value in result.best_parameters.items()
    )
    return f'<div class="wide"><table><tr><th>parameter</th><th>start</th><th>best</th></tr>{rows}</table></div>'


def _front_table(front: Sequence[Candidate]) -> str:
    """Designs none of which is both lighter and safer than another."""
    head = "".join(f"<th>{escape(name)}</th>" for name in [*front[0].parameters, "volume m3", "reserve"])
    rows = "".join(
        "<tr>" + "".join(f"<td>{value:.4g}</td>" for value in (*c.parameters.values(), c.volume, c.reserve)) + "</tr>"
        for c in front
    )
    return f'<div class="wide"><table><tr>{head}</tr>{rows}</table></div>'


def _history_table(history: Sequence[Candidate]) -> str:
    names = list(history[0].parameters) if history else []
    head = "".join(
        f"<th>{escape(n)}</th>"
        for n in [*names, "volume m3", "static", "score", "static s", "dynamic", "dynamic s", "note"]
    )
    rows = []
    for c in history:
        cells = [f"{v:g}" for v in c.parameters.values()]
        cells += [
            "" if c.volume is None else f"{c.volume:.2f}",
            c.static,
            "" if c.score is None else f"{c.score:.2e}" if c.score else "0",
        ]
        cells += [
            f"{c.static_seconds:.2f}",
            c.dynamic,
            f"{c.dynamic_seconds:.1f}" if c.dynamic_seconds else "",
            c.note,
        ]
        kind = "stands" if c.stands else "no"
        rows.append(f'<tr class="{kind}">' + "".join(f"<td>{escape(cell)}</td>" for cell in cells) + "</tr>")
    return f'<div class="wide"><table><tr>{head}</tr>{"".join(rows)}</table></div>'
