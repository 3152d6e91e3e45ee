"""Options of the criteria by which a design is verified."""

from __future__ import annotations

from typing import Annotated

import typer

from blockstat.errors import InputError
from dynsim.settings import Settings

Group = Annotated[
    str | None, typer.Option(help='Group of Eq. 1 of Fita et al. 2017; "vault" if there is one, else everything.')
]
Threshold = Annotated[float | None, typer.Option(help="Displacement that counts as falling, in metres.")]
Engine = Annotated[str, typer.Option(help='"bullet", or "lmgc90" (weight alone; needs compas_lmgc90).')]
Preset = Annotated[str, typer.Option(help='"fast", "default" or "careful".')]


def settings_of(preset: str, threshold: float | None, group: str | None = None) -> Settings:
    """Return the settings that the options ask for.

    Parameters
    ----------
    preset : str
        Name of a preset.
    threshold : float or None
        Displacement that counts as falling, by Eq. 1 and by Eq. 2 [m]; None: relative to block size.
    group : str, optional
        Group of Eq. 1.

    Returns
    -------
    Settings
        The settings.

    Raises
    ------
    InputError
        For a threshold that is not positive, and for a preset that does not exist.
    """
    if threshold is not None and not 0 < threshold < float("inf"):
        raise InputError(f"--threshold is {threshold!r}; it must be a positive number of metres")
    return Settings.named(preset, group=group, roof_threshold=threshold, brick_threshold=threshold)
