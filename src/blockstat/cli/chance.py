"""What is not known for certain: the option for the worst case of imperfections, and `blockstat reliability`."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Container
from pathlib import Path
from time import monotonic
from typing import TYPE_CHECKING, Annotated, Any, TypeVar

import typer

from blockstat.cli.cases import Basis, Case, LoadsFile, chosen_case
from blockstat.cli.options import (
    AsJson,
    FileArgument,
    Friction,
    Gap,
    Gravity,
    Supports,
    Tilt,
    Units,
    Up,
    gap_of,
    numbers,
    print_json,
)
from blockstat.cli.options import load as load_assembly
from blockstat.errors import InputError
from blockstat.system.lines import PlainLines

T = TypeVar("T")

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.chance.variables import Random
    from blockstat.imperfection.imperfections import Imperfections

IMPERFECTIONS = (
    "edge=LENGTH or edge=SHARE%, friction=DIVISOR, density.GROUP=LEAST,GREATEST or loads.GROUP=LEAST,GREATEST"
)

Imperfect = Annotated[
    list[str] | None,
    typer.Option(
        "--imperfection",
        metavar="KEY=VALUE",
        help="Ask for the worst case: 'edge=3 mm' that joints lose at each edge (or 'edge=5 %' of their width), "
        "friction=1.2 that divides friction, density.wall=1800,2200 [kg/m3], loads.vault=0,1.5 as factors. "
        "May be given several times.",
    ),
]
FirstOrder = Annotated[bool, typer.Option("--first-order", help="Find the design point of --load, and draw about it.")]
FORM = (
    "KEY=normal,MEAN,DEVIATION, KEY=lognormal,MEAN,DEVIATION or KEY=uniform,LEAST,GREATEST, KEY one of friction, edge, "
    "corner, push, density.GROUP, loads.GROUP; after them may follow EACH, one of all, group, course, block, joint, "
    "and the CORRELATION of their values"
)
Uncertain = Annotated[
    list[str] | None,
    typer.Option(
        metavar="KEY=KIND,A,B[,EACH[,CORRELATION]]",
        help="What is random, several times, in place of [uncertain] of the scene: friction=lognormal,0.6,0.1, or "
        "friction=lognormal,0.6,0.1,joint,0.3 with a value for each joint.",
    ),
]
Load = Annotated[
    str | None,
    typer.Option(metavar="AX,AY,AZ", help="Acceleration in units of gravity that acts too; push is a factor."),
]
Flow = Annotated[
    str, typer.Option(help="associated, or coulomb: what only dilatancy or self-stress holds has fallen; much slower.")
]
Kept = Annotated[
    Path | None,
    typer.Option("-o", "--output", help="Keep each draw here (.jsonl); the same command goes on from it."),
]


def reliability_command(
    file: FileArgument,
    uncertain: Uncertain = None,
    draws: Annotated[int, typer.Option(min=1, help="Number of draws.")] = 1000,
    jobs: Annotated[int, typer.Option(min=1, help="Processes side by side.")] = 1,
    seed: Annotated[int, typer.Option(help="Of the random numbers.")] = 0,
    load: Load = None,
    first_order: FirstOrder = False,
    flow: Flow = "associated",
    output: Kept = None,
    case: Case = None,
    loads: LoadsFile = None,
    friction: Friction = None,
    gravity: Gravity = None,
    tilt: Tilt = None,
    supports: Supports = None,
    units: Units = None,
    up: Up = None,
    gap: Gap = None,
    as_json: AsJson = False,
) -> None:
    """Estimate the probability that an assembly falls when friction, joints, weights and loads are random."""
    from blockstat.chance.first_order import first_order as design_point
    from blockstat.chance.monte_carlo import reliability
    from blockstat.contact.overlap.searched import searched_joints

    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    near = gap_of(gap)
    chosen = chosen_case(assembly, file, case, loads, gap=near, tilt=tilt)
    scene = None if uncertain else file  # where the random variables come from
    random, direction = _of_scene(scene, lambda: _chosen(file, assembly, uncertain, load))
    options: dict[str, Any] = {"load": direction, "gap": near, "interfaces": searched_joints(assembly, near)[0]}
    options["loads"] = None if chosen is None else chosen.weighted_loads
    if first_order and direction is None:
        raise InputError("--first-order asks when a load is not carried; give it by --load AX,AY,AZ")
    point = _of_scene(scene, lambda: design_point(assembly, random, **options)) if first_order else None
    about = point if point is not None and point.outcome.word == "found" else None  # else draw about the mean
    options |= {"about": about, "flow": flow, "file": output, "jobs": jobs, "progress": _Progress()}
    found = _of_scene(scene, lambda: reliability(assembly, random, draws=draws, seed=seed, **options))
    if found.stopped and output is not None:
        typer.echo(f"{output} keeps the draws that were made: the same command goes on from there", err=True)
    basis = Basis(file, assembly, chosen, "act", units, up, near)
    if as_json:
        first = {} if point is None else {"first_order": point.summary()}
        print_json({"file": str(file), **basis.echo(), **found.summary(), **first})
    else:
        typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks\n{basis.words()}")
        typer.echo("\n".join(own.explain() for own in (point, found) if own is not None))
    if found.stopped:
        raise KeyboardInterrupt  # some draws are missing


def _of_scene(file: Path | None, call: Callable[[], T]) -> T:
    """Call a function, and say in which file and line the random variables are that it refuses."""
    from blockstat.spec.files import located

    try:
        return call()
    except InputError as error:
        if file is None or not all(str(text).startswith("uncertain") for text in error.args):
            raise
        keys = (re.sub('^uncertain "([^"]*)"', r"uncertain.\1", str(text)) for text in error.args)
        raise located(file, type(error)(*keys)) from None


def _chosen(
    file: Path, assembly: Assembly, uncertain: list[str] | None, load: str | None
) -> tuple[dict[str, Random], list[float] | None]:
    """What is random, and the direction of the load, by the options or by the scene."""
    from blockstat.chance.variables import as_strong_as, random_variables

    random, direction = (_random(uncertain), None) if uncertain else random_variables(assembly)
    if not random:
        raise InputError(f"{file}: nothing is uncertain; write [uncertain] in the scene, or give --uncertain {FORM}")
    if load is not None:
        direction = numbers(load, 3, "--load", "AX,AY,AZ")
    if direction is not None:
        return as_strong_as(random, math.hypot(*direction)), direction
    if "push" in random:
        raise InputError("push is a factor on a load; give it by --load AX,AY,AZ, or as uncertain.push.direction")
    return random, None


class _Progress:
    """Tells how far the draws are, and how long the others take."""

    def __init__(self) -> None:
        self._line, self._begin, self._before = PlainLines(), monotonic(), None

    def __call__(self, done: int, draws: int) -> None:
        now = monotonic()
        if self._before is None:
            self._begin, self._before = now, done
            self._line(f"{done} of {draws} draws")
            return
        pace = (now - self._begin) / max(done - self._before, 1)
        self._line(f"{done} of {draws} draws, {pace * (draws - done):.0f} s to go")


def _random(given: list[str]) -> dict[str, Random]:
    """The random variables that the options name."""
    from blockstat.chance.variables import Random

    found: dict[str, Random] = {}
    for text in given:
        key, equals, rest = (part.strip() for part in text.partition("="))
        parts = [part.strip() for part in rest.split(",")]
        if not equals or not 3 <= len(parts) <= 5:
            raise InputError(f'--uncertain is "{text}"; it must read {FORM}')
        once(found, key, "--uncertain")
        low, high = numbers(",".join(parts[1:3]), 2, "--uncertain", FORM, given=text)
        each = parts[3] if len(parts) > 3 else "all"
        correlation = numbers(parts[4], 1, "--uncertain", FORM, given=text)[0] if len(parts) > 4 else 0.0
        found[key] = Random(parts[0], low, high, each, correlation)
    return found


def once(found: Container[str], key: str, option: str) -> None:
    """Raise InputError where an option has named a key before.

    Parameters
    ----------
    found : container
        The keys that have been read.
    key : str
        The key that is read now.
    option : str
        The option.

    Raises
    ------
    InputError
        Naming the key.
    """
    if key in found:
        raise InputError(f"{option} gives {key or 'its value'} twice")


def imperfections_of(given: list[str] | None) -> Imperfections | None:
    """Return what the options allow for.

    Parameters
    ----------
    given : list of str or None
        Values of `--imperfection`.

    Returns
    -------
    Imperfections or None
        None where the option is not given.

    Raises
    ------
    InputError
        For a key or a value that there is not.

    Examples
    --------
    >>> imperfections_of(["edge=3 mm", "density.wall=1800,2200"]).density
    {'wall': (1800.0, 2200.0)}
    """
    if not given:
        return None
    from blockstat.imperfection.imperfections import Imperfections

    found: dict[str, Any] = {}
    seen = set[str]()
    for text in given:
        key, equals, value = (part.strip() for part in text.partition("="))
        kind, _, group = key.partition(".")
        once(seen, key, "--imperfection")
        seen.add(key)
        try:
            if equals and key == "edge":
                found["edge"] = value
            elif equals and key == "friction":
                found["friction"] = float(value)
            elif equals and kind in ("density", "loads") and group:
                low, high = value.split(",")
                found.setdefault(kind, {})[group] = (float(low), float(high))
            else:
                raise ValueError
        except ValueError:
            raise InputError(f'--imperfection is "{text}"; it must read {IMPERFECTIONS}') from None
    return Imperfections(**found)
