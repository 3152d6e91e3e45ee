"""Options of the criteria by which a design is verified."""

from __future__ import annotations

from typing import Annotated

import typer

Group = Annotated[str | None, typer.Option(help='Group of Eq. 1; "vault" if there is one, else everything.')]
Threshold = Annotated[float | None, typer.Option(help="Displacement that counts as falling, in metres.")]
Engine = Annotated[str, typer.Option(help='"bullet", or "lmgc90" (weight alone; needs compas_lmgc90).')]
Preset = Annotated[str, typer.Option(help='"fast", "default" or "careful".')]
