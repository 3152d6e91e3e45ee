"""A verdict as one self-contained page that turns with the mouse, for reports and notebooks."""

from __future__ import annotations

from contextlib import redirect_stdout
from html import escape
from io import StringIO
from typing import TYPE_CHECKING, Any

from blockstat.errors import InputError, known_options
from blockstat.typing import Floats
from blockstat.view.painter import posed
from blockstat.view.plot import extent, mechanism_pose
from blockstat.view.three_d.arrows import force_arrows
from blockstat.view.three_d.canvas import Canvas
from blockstat.view.three_d.colouring import colouring
from blockstat.view.three_d.dress import head
from blockstat.view.three_d.geometry import contacts_without_area
from blockstat.view.three_d.guard import HERE, Guard

if TYPE_CHECKING:
    import viser

    from blockstat.analysis.verdict import Verdict
    from blockstat.assembly import Assembly

MISSING = "the 3D view needs viser; install it with: pip install 'blockstat[ui]'"
GLASS = 0.2  #: opacity of blocks with arrows inside
DOT = 0.008  #: radius of a contact at a corner, relative to the extent of the free blocks
HEIGHT = 480  #: of the view in a report or a notebook [px]


def start_viser(*, title: str = "blockstat", **options: Any) -> tuple[viser.ViserServer, str]:
    """Start a viser server on this machine only, which answers only those who know its address, without its greeting.

    Parameters
    ----------
    title : str, optional
        What the browser calls the page at first.
    **options
        Options of `viser.ViserServer`, such as its port.

    Returns
    -------
    server : viser.ViserServer
        `stop_viser` stops it.
    address : str
        Where a browser finds it, with the token that admits it.

    Raises
    ------
    InputError
        When viser is not installed.
    """
    try:
        import viser
    except ImportError:
        raise InputError(MISSING) from None
    guard = Guard(head=head(title))
    with redirect_stdout(StringIO()), guard.over_the_next_server():
        server = viser.ViserServer(host=HERE[0], verbose=False, **options)
    return server, guard.address(server.get_port())


def stop_viser(server: viser.ViserServer) -> None:
    """Stop a server without its farewell.

    Parameters
    ----------
    server : viser.ViserServer
        The server.
    """
    with redirect_stdout(StringIO()):
        server.stop()


def available() -> bool:
    """Return whether the extra that draws these views is installed.

    Returns
    -------
    bool
        True with viser.
    """
    from importlib.util import find_spec

    return find_spec("viser") is not None


def interactive_html(verdict: Verdict, *, choice: str = "verdict", forces: bool = False) -> str:
    """Return a page that needs nothing but itself: the blocks by colour, and what moves as the mechanism moves it.

    Parameters
    ----------
    verdict : Verdict
        The verdict to show.
    choice : str, optional
        What the colours stand for, as in `blockstat.view.three_d.colouring`.
    forces : bool, optional
        Also draw the joint forces as arrows, with lines and dots where edges and corners touch.

    Returns
    -------
    str
        HTML.

    Raises
    ------
    InputError
        When viser is not installed, or for another choice.

    Examples
    --------
    It needs the extra ui:

    >>> from pathlib import Path
    >>> from blockstat import Assembly, assess, box, interactive_html
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> verdict = assess(Assembly.from_blocks(blocks, supports=["ground"]))
    >>> page = interactive_html(verdict, choice="demand")  # doctest: +SKIP
    >>> written = Path("verdict.html").write_text(page)  # doctest: +SKIP
    """
    server, _ = start_viser(port=0)
    try:
        canvas = Canvas(server)
        canvas.recentre(verdict.assembly)
        moved = mechanism_vertices(verdict, 1.0) if verdict.mechanism.any() else None
        canvas.draw(verdict.assembly, colouring(choice, verdict), moved, opacity=GLASS if forces else 1.0)
        if forces:
            for arrows in force_arrows(verdict):
                canvas.arrows(arrows.name, arrows.tail, arrows.head, arrows.colour, arrows.radius)
            canvas.contacts(*contacts_without_area(verdict.interfaces), DOT * extent(verdict.assembly))
        return server.scene.as_html()
    finally:
        stop_viser(server)


def mechanism_vertices(result: Any, share: float, *, amplitude: float | None = None) -> Floats:
    """Return the vertices moved along a share of the way of a mechanism's pose.

    Parameters
    ----------
    result : Verdict or LimitLoad
        What has a mechanism.
    share : float
        Of the way, 0 at rest, 1 at the end.
    amplitude : float, optional
        How far the fastest corner goes at the end [m]; by default a twelfth of the assembly's extent.

    Returns
    -------
    array of float, shape (n_vertices, 3)
        Places of the vertices [m].

    Raises
    ------
    InputError
        When a share above 0 is asked for and the result has no mechanism, or `amplitude` is not above 0.
    """
    if share <= 0:
        return result.assembly.vertices
    reach = share * (extent(result.assembly) / 12 if amplitude is None else amplitude)
    return posed(result.assembly, *mechanism_pose(result, amplitude=reach))


def framed(page: str, *, height: int = HEIGHT) -> str:
    """Return a page inside another one, as the HTML of an inline frame.

    Parameters
    ----------
    page : str
        HTML of the page.
    height : int, optional
        Of the frame [px].

    Returns
    -------
    str
        HTML.
    """
    inside = page.replace("&", "&amp;").replace('"', "&quot;")
    return f'<iframe srcdoc="{inside}" width="100%" height="{height}" style="border:1px solid #ddd"></iframe>'


class Inline:
    """What a notebook shows in place: a caption and the view.

    Parameters
    ----------
    html : str
        HTML of both.
    """

    def __init__(self, html: str) -> None:
        self.html = html

    def _repr_html_(self) -> str:
        return self.html


@known_options
def show(
    assembly: Assembly, verdict: Verdict | None = None, *, choice: str = "verdict", forces: bool = False,
    height: int = HEIGHT,
) -> Inline:  # fmt: skip
    """Show an assembly in three dimensions in a notebook: the last value of a cell is shown in place.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    verdict : Verdict, optional
        Of the assembly; by default it is asked for now.
    choice : str, optional
        What the colours stand for, as in `blockstat.view.three_d.colouring`.
    forces : bool, optional
        Also draw the joint forces as arrows, with lines and dots where edges and corners touch.
    height : int, optional
        Of the view [px].

    Returns
    -------
    Inline
        What the notebook shows.

    Raises
    ------
    InputError
        When viser is not installed, when the verdict is of another assembly, for another choice, or when the assembly
        cannot be assessed.

    Examples
    --------
    It needs the extra ui:

    >>> from blockstat import Assembly, box, show
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> show(assembly, forces=True)  # doctest: +SKIP
    """
    if verdict is None:
        from blockstat.analysis.assess import assess

        verdict = assess(assembly)
    if verdict.assembly.names != assembly.names:
        raise InputError(f'the verdict is of "{verdict.assembly.name}", not of this assembly; assess this one')
    coloured = colouring(choice, verdict)
    caption = f"<p><b>{escape(assembly.name)}</b>: {escape(verdict.outcome.value)}</p>"
    view = framed(interactive_html(verdict, choice=choice, forces=forces), height=height)
    legend = f'<div style="max-width:24em">{coloured.legend}</div>'
    return Inline(f'<div style="font:14px/1.4 system-ui,sans-serif">{caption}{view}{legend}</div>')
