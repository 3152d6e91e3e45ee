"""The report of an assessment with the verdict of Bullet in it."""

from __future__ import annotations

from functools import partial
from typing import Annotated

import typer

from blockstat.cli.cases import Case, LoadsFile
from blockstat.cli.displacement import F0, Ag, Behaviour, Confidence, Soil, Tc, Topography
from blockstat.cli.options import FileArgument, Friction, Gap, Gravity, Supports, Tilt, Units, Up, gap_of, load
from blockstat.cli.studies import Page, asked_code, write_report
from dynsim.cli.criteria import Preset


def report(
    file: FileArgument,
    output: Page,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    preset: Preset = "default",
    directions: Annotated[int, typer.Option(metavar="N", help="Of the horizon; a multiple of 4.")] = 16,
    case: Case = None,
    loads: LoadsFile = None,
    ag: Ag = None,
    soil: Soil = None,
    topography: Topography = None,
    f0: F0 = None,
    tc: Tc = None,
    confidence: Confidence = None,
    behaviour: Behaviour = None,
) -> None:
    """Write the report of `blockstat report` with the verdict of a simulation beside those of the statics."""
    from dynsim.judge.verify import verify
    from dynsim.settings import Settings

    near = gap_of(gap)
    code = asked_code(ag, soil, topography, f0, tc, confidence, behaviour)
    assembly = load(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    simulated = partial(verify, settings=Settings.named(preset), gap=near)
    acting = {"case": case, "loads": loads, "tilt": tilt}
    options = {"units": units, "up": up, "gap": near, "directions": directions, "code": code}
    write_report(file, assembly, output, verify=simulated, **options, **acting)
