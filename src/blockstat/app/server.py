"""Start the page on this machine and keep it until it is interrupted."""

from __future__ import annotations

import logging
import sys
import threading
from collections.abc import Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from blockstat.app.background import prepare
from blockstat.app.design import Model, open_model
from blockstat.view.three_d.page import start_viser, stop_viser

if TYPE_CHECKING:
    from collections.abc import Iterator

    from blockstat.app.page import Page, Panel


@contextmanager
def running(model: Model, *, port: int = 0, panels: Sequence[Panel] = ()) -> Iterator[tuple[Page, str]]:
    """A page that is up while the block runs, and its address. port : 0 for any free one."""
    from blockstat.app.page import Page

    prepare()
    server = start_viser(port=port, label=model.name)
    page = Page(server, model, panels=panels)
    try:
        yield page, f"http://127.0.0.1:{server.get_port()}"
    finally:
        page.close()
        stop_viser(server)


def serve(path: str | Path, *, supports: str = "", port: int = 0, panels: Sequence[Panel] = ()) -> None:
    """Open a file on the page, print its address, and wait to be interrupted.

    port : the next free one is taken when it is in use, any for 0. Raises InputError for a file that cannot be used.
    """
    model = open_model(path, supports=supports)
    logging.basicConfig(stream=sys.stderr, level=logging.WARNING, format="%(name)s: %(message)s")
    try:
        with running(model, port=port, panels=panels) as (_, address):
            print(f"{model.name}: {address}  (Ctrl-C ends it)", flush=True)
            threading.Event().wait()
    except KeyboardInterrupt:
        pass  # the way to end it
