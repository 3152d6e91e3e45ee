"""Start the page on this machine and keep it until it is interrupted."""

from __future__ import annotations

import logging
import sys
import threading
import warnings
from collections.abc import Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from blockstat.app.background import Limits, prepare
from blockstat.app.design import Model, open_model
from blockstat.errors import InputError, InputWarning
from blockstat.view.three_d.page import start_viser, stop_viser

if TYPE_CHECKING:
    from collections.abc import Iterator

    from blockstat.app.page import Page, Panel


@contextmanager
def running(
    model: Model,
    *,
    port: int = 0,
    panels: Sequence[Panel] = (),
    folder: Path | None = None,
    limits: Limits | None = None,
) -> Iterator[tuple[Page, str]]:
    """Run a page for as long as the body of a `with` statement runs.

    Parameters
    ----------
    model : Model
        The scene or the assembly to show first.
    port : int, optional
        Of the page on this machine; 0 for any free one.
    panels : sequence of Panel, optional
        What other packages add to the page.
    folder : Path, optional
        Where the files are that an uploaded scene may name.
    limits : Limits, optional
        What work for the page may use before it is stopped.

    Yields
    ------
    page : Page
        The live page.
    address : str
        Where a browser finds it, with the token that admits it.

    Raises
    ------
    InputError
        When viser is not installed.
    """
    from blockstat.app.page import Page

    prepare()
    server, address = start_viser(port=port, title=model.name, label=model.name)
    page = Page(server, model, panels=panels, folder=folder, limits=limits)
    try:
        yield page, address
    finally:
        page.close()
        stop_viser(server)


def serve(
    path: str | Path,
    *,
    supports: str = "",
    units: str | None = None,
    up: str | None = None,
    gap: str | None = None,
    port: int = 0,
    panels: Sequence[Panel] = (),
    folder: Path | None = None,
    limits: Limits | None = None,
) -> None:
    """Open a file on the page, print its address, and wait to be interrupted.

    Parameters
    ----------
    path : str or Path
        A scene (.toml) or an assembly (.json, .obj, .glb).
    supports : str, optional
        Names of blocks that cannot move, separated by commas; a mesh needs them.
    units, up : str, optional
        Of the coordinates in the file, as in `blockstat.read`.
    gap : str, optional
        Largest gap of a joint in the file, as `--gap` says it.
    port : int, optional
        Of the page on this machine. The next free one is taken when it is in use, any free one for 0.
    panels : sequence of Panel, optional
        What other packages add to the page.
    folder : Path, optional
        Where the files are that an uploaded scene may name; by default the folder of the file.
    limits : Limits, optional
        What work for the page may use before it is stopped.

    Raises
    ------
    InputError
        For a file that cannot be used, or when viser is not installed.

    Warns
    -----
    InputWarning
        With the names of the load cases of the file, none of which acts on the page.
    """
    model = open_model(path, supports=supports, units=units, up=up, gap=gap)
    if model.idle:
        warnings.warn(f"{path}: {model.idle}", InputWarning, stacklevel=2)
    logging.basicConfig(stream=sys.stderr, level=logging.WARNING, format="%(name)s: %(message)s")
    inside = folder or Path(path).parent
    if not inside.is_dir():
        raise InputError(f"{inside}: no such directory; uploaded scenes name files in it")
    try:
        with running(model, port=port, panels=panels, folder=inside, limits=limits) as (_, address):
            print(f"{model.name}: {address}  (Ctrl-C ends it)", flush=True)
            threading.Event().wait()
    except KeyboardInterrupt:
        pass  # the way to end it
