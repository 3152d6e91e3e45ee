"""What the page opens and saves."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from blockstat.app.background import Channel, Refused
from blockstat.app.design import DENSITY, EDGES, Model, idle_loads, open_model
from blockstat.errors import InputError

if TYPE_CHECKING:
    from blockstat.app.words import Known

Saved = tuple[str, bytes]  #: name of a file and what is in it


def send_upload(
    channel: Channel,
    name: str,
    content: bytes,
    supports: str,
    units: str | None,
    up: str | None,
    gap: str | None,
    folder: Path | None,
) -> None:
    """Read a file that a browser sent, in a process that can be ended.

    Parameters
    ----------
    channel : Channel
        The model is sent through it, or else the error that says why there is none.
    name, content, supports, units, up, gap, folder
        As of `read_upload`.
    """
    try:
        channel.send(read_upload(name, content, supports, units=units, up=up, gap=gap, folder=folder))
    except InputError as error:
        channel.send(error)


def read_upload(
    name: str,
    content: bytes,
    supports: str,
    *,
    units: str | None = None,
    up: str | None = None,
    gap: str | None = None,
    folder: Path | None = None,
) -> Model:
    """Return the model in a file that a browser sent.

    Parameters
    ----------
    name : str
        Name of the file; its suffix says the format.
    content : bytes
        What is in the file.
    supports : str
        Names of blocks that cannot move, separated by commas; a mesh needs them.
    units, up : str, optional
        Of the coordinates in the file, as in `blockstat.read`.
    gap : str, optional
        Largest gap of a joint, as a user types it.
    folder : Path, optional
        Where the files are that an uploaded scene may name; without one it may name none.

    Returns
    -------
    Model
        What the page shows.

    Raises
    ------
    InputError
        For a file that cannot be used, naming the file and what is wrong in it.
    """
    with tempfile.TemporaryDirectory(prefix="blockstat-") as directory:
        path = Path(directory) / (Path(name).name or "file")
        path.write_bytes(content)
        try:
            return open_model(path, supports=supports, units=units, up=up, gap=gap, folder=folder or Path(directory))
        except InputError as error:
            raise type(error)(*(str(text).replace(str(path), path.name) for text in error.args)) from None
        except (OSError, ValueError, KeyError, IndexError, TypeError) as error:
            # What the error says may quote the file, or another that it names.
            raise InputError(f"{path.name}: cannot be read ({type(error).__name__})") from None


def scene_file(model: Model, values: dict[str, float]) -> Saved:
    """Return the scene with its present values as TOML; what a scene cannot say is in comments.

    Parameters
    ----------
    model : Model
        The model on the page.
    values : dict of str to float
        Present values of its parameters, by dotted path.

    Returns
    -------
    name : str
        Name of the file.
    content : bytes
        What is in the file.

    Raises
    ------
    InputError
        For an assembly, which has no scene.
    """
    from blockstat.io.scene_text import scene_text

    text = scene_text(model.moved(values))
    return f"{_stem(model.name)}.toml", "".join([*(f"# {line}\n" for line in _unsaid(model, values)), text]).encode()


def _unsaid(model: Model, values: dict[str, float]) -> Iterator[str]:
    """What was set on the page and is not in its scene, a sentence each."""
    if lost := values.get(EDGES):
        yield f"{EDGES} = {lost:g} mm was set on the page; a scene has no key for it, and its edges here are sharp."
        yield f'blockstat check FILE --imperfection "edge={lost:g} mm" rounds them again.'
    own = [name for name, element in getattr(model.scene, "elements", {}).items() if DENSITY in element]
    if own and DENSITY in model.moved_material(values):
        yield f"{DENSITY} = {values[DENSITY]:g} kg/m3 was set on the page for all blocks."
        yield f"These elements keep their own here: {', '.join(own)}."


def blocks_file(known: Known) -> Saved:
    """Return the blocks with displacement, mechanism and demand as GLB.

    Parameters
    ----------
    known : Known
        What is known of the design on show.

    Returns
    -------
    name : str
        Name of the file.
    content : bytes
        What is in the file.
    """
    from blockstat.view.attributes import write_verdict

    return _written(f"{_stem(known.verdict.assembly.name)}.glb", lambda path: write_verdict(known.verdict, path))


def picture_file(known: Known) -> Saved:
    """Return a picture of the verdict as PNG.

    Parameters
    ----------
    known : Known
        What is known of the design on show.

    Returns
    -------
    name : str
        Name of the file.
    content : bytes
        What is in the file.
    """
    from blockstat.view.plot import plot_verdict

    return _written(f"{_stem(known.verdict.assembly.name)}.png", lambda path: plot_verdict(known.verdict, path))


def report_file(known: Known) -> Saved:
    """Return the report of `blockstat report` on the design on show, with its parameters and a view to turn.

    Parameters
    ----------
    known : Known
        What is known of the design on show, with the values that it was judged at. The verdict of a simulation goes
        into the report where one was shown; all else is found again, by the joints of the page.

    Returns
    -------
    name : str
        Name of the file.
    content : bytes
        What is in the file.
    """
    from blockstat.app.words import least_friction
    from blockstat.view.assessment import assess_fully, assessment_html
    from blockstat.view.document import facts
    from blockstat.view.three_d.colouring import colouring
    from blockstat.view.three_d.page import framed, interactive_html

    shown, simulated = known.verdict, known.simulated
    assembly, joints = shown.assembly, shown.interfaces
    found = assess_fully(
        assembly,
        source=f"{assembly.name}, as shown on the live page",
        gap=joints.searched,
        interfaces=joints,
        verify=None if simulated is None else lambda _: simulated,
    )
    rounded = f"Statics here are those of imperfect joints: {shown.worst}." if shown.worst else ""
    found = replace(found, told=tuple(filter(None, (idle_loads(assembly), rounded))))
    rows = [(path, f"{value:g}") for path, value in known.values.items()]
    turning = framed(interactive_html(found.associated))
    parts = [
        "<h2>Values on the page</h2>" + facts([*rows, ("least friction with which it stands", least_friction(known))]),
        f"<figure>{turning}{colouring('verdict', found.associated).legend}</figure>",
    ]
    return f"{_stem(assembly.name)}.html", assessment_html(found, parts=parts).encode()


def send_report(channel: Channel, known: Known) -> None:
    """Make a report in a process of its own.

    Parameters
    ----------
    channel : Channel
        What `report_file` returns is sent through it, or else why there is none.
    known : Known
        As of `report_file`.
    """
    try:
        channel.send(report_file(known))
    except InputError as error:
        channel.send(Refused(f"no report: {error}"))


def left_out(model: Model, values: dict[str, float]) -> str:
    """Return what was set on the page and does not go into its scene, and how the commands take it.

    Parameters
    ----------
    model : Model
        The model on the page.
    values : dict of str to float
        Present values of its parameters, by dotted path.

    Returns
    -------
    str
        Plain text; empty where all goes into the scene.
    """
    return " ".join(_unsaid(model, values))


SCENE = "Save scene (.toml)"  #: the words of the button that saves the present values, judged or not
REPORT = "Save report (.html)"  #: of the one whose file takes longer, for it holds more than the page knows
#: What can be saved at once of the design on show: the button's words and what makes the file.
SAVES: dict[str, Callable[[Known], Saved]] = {
    "Save blocks (.glb)": blocks_file,
    "Save picture (.png)": picture_file,
}


def _written(name: str, write: Callable[[Path], object]) -> Saved:
    with tempfile.TemporaryDirectory(prefix="blockstat-") as directory:
        path = Path(directory) / name
        write(path)
        return name, path.read_bytes()


def _stem(name: str) -> str:
    return "".join(c if c.isalnum() or c in "-_." else "-" for c in name).strip(".") or "design"
