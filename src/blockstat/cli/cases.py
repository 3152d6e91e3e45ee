"""Load cases on the command line: the options that choose one, and the table of all."""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

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
    upright,
)
from blockstat.cli.options import load as load_assembly
from blockstat.cli.places import written
from blockstat.cli.progress import at_work
from blockstat.errors import InputError, InputWarning

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.loading.cases import LoadCase

Case = Annotated[str | None, typer.Option("--case", metavar="NAME", help="Load case of the scene, or of --loads.")]
LoadsFile = Annotated[
    Path | None, typer.Option("--loads", help="TOML file with [loads.NAME] and [cases.NAME], in place of the scene's.")
]
#: What becomes of the live loads of a case, by the word for it in JSON; in words after the loads.
LIVE = {
    "act": "",
    "grow": "; the live loads grow",
    "stay": "; the live loads are held constant",
    "left_out": "; the live loads are left out: put them under factors if they act with the earthquake",
}


@dataclass(frozen=True, eq=False)
class Basis:
    """What an answer rests on: the file, the blocks, the loads on them, and the options with which they were read."""

    file: Path
    assembly: Assembly  #: as it was analysed
    case: LoadCase | None = None  #: the loads under which it was
    live: str = "act"  #: what becomes of the live loads of the case, a key of `LIVE`
    units: str | None = None  #: of the coordinates in the file; None for metres
    up: str | None = None  #: the axis of the file that points up; None for that of its format
    gap: float | str | None = None  #: tolerance of the joint search; None for the default

    def echo(self) -> dict[str, Any]:
        """Return what JSON echoes of it.

        Returns
        -------
        dict
            "friction" (None without limit), "density" [kg/m3] (None where blocks differ), "densities" (the least and
            the greatest), "gravity" [m/s2], "weight" of the free blocks [N], "units" of the file, its axis "up" and
            "gap"; and what `loads_echoed` returns.
        """
        from blockstat.contact.interfaces import GAP
        from blockstat.io.parts import own_up
        from blockstat.result import finite

        assembly = self.assembly
        density = assembly.density[assembly.free] if len(assembly.free) else assembly.density
        ends = [float(density.min()), float(density.max())]
        return {
            "friction": finite(assembly.friction),
            "density": ends[0] if ends[0] == ends[1] else None,
            "densities": ends,
            "gravity": [float(part) for part in assembly.gravity],
            "weight": assembly.free_weight,
            "units": self.units or "m",
            "up": self.up or own_up(self.file.suffix),
            "gap": GAP if self.gap is None else self.gap,
            **loads_echoed(self.case, self.live),
        }

    def words(self) -> str:
        """Return it in a line, and in a second one the loads of a case.

        Returns
        -------
        str
            Friction, density, weight, units and gap; gravity where it is not down; the axis up in a file that was
            turned.
        """
        from blockstat.result import plain

        assembly, found = self.assembly, self.echo()
        low, high = found["densities"]
        density = f"{low:g}" if low == high else f"{low:g} to {high:g}"
        laws = f" and {len(assembly.joints)} joint laws" if assembly.joints else ""
        near = found["gap"] if isinstance(found["gap"], str) else f"{found['gap']:g} of a block"
        x, y, z = assembly.gravity
        turned = "" if found["up"] == "z" else f"turned: {found['up']} up in the file, "
        leans = f"gravity ({x:.5g}, {y:.5g}, {z:.5g}) m/s2, " if (x, y) != (0, 0) or z > 0 else ""
        line = (
            f"Friction {assembly.friction:g}{laws}, density {density} kg/m3, "
            f"weight {plain(found['weight'] / 1e3, 4)} kN, "
            f"{leans}coordinates in {found['units']}, {turned}joints closed to {near}."
        )
        return line if self.case is None else f"{line}\n{loads_said(self.case, self.live)}"


def print_answer(
    basis: Basis, found: Any, *, as_json: bool, head: str = "", files: Mapping[str, str] | None = None
) -> None:
    """Print what was found, below or beside what it rests on.

    Parameters
    ----------
    basis : Basis
        What it rests on.
    found : Result
        The answer.
    as_json : bool
        Print JSON.
    head : str, optional
        What follows the number of blocks in the first line.
    files : mapping of str, optional
        Files that were written, by key.
    """
    if as_json:
        print_json({"file": str(basis.file), **basis.echo(), **found.summary(), **(files or {})})
        return
    assembly = basis.assembly
    typer.echo(f"{assembly.name}: {assembly.n_blocks} blocks{head}\n{basis.words()}\n{found.explain()}")
    written(files or {})


def loads_said(case: LoadCase, live: str = "act") -> str:
    """Return which loads act, in one line.

    Parameters
    ----------
    case : LoadCase
        The case under which the blocks were analysed.
    live : str, optional
        What becomes of its live loads, a key of `LIVE`.

    Returns
    -------
    str
        Such as `Loads: case "storm": 0.9 weight + 1.5 wind (live); the live loads grow.`
    """
    return f'Loads: case "{case.name}": {case.words}{LIVE[live] if case.live.any() else ""}.'


def loads_echoed(case: LoadCase | None, live: str = "act") -> dict[str, Any]:
    """Return which loads act, as JSON echoes it.

    Parameters
    ----------
    case : LoadCase or None
        The case under which the blocks were analysed.
    live : str, optional
        What becomes of its live loads, a key of `LIVE`.

    Returns
    -------
    dict
        "case", "combination" and, where it has live loads, "live_loads"; empty without a case.
    """
    if case is None:
        return {}
    return {"case": case.name, "combination": case.combination} | ({"live_loads": live} if case.live.any() else {})


def growing_or_held(load: Any) -> str:
    """Return what becomes of the live loads in a limit analysis.

    Parameters
    ----------
    load : object
        Value of `--load`.

    Returns
    -------
    str
        A key of `LIVE`: they grow where nothing else does.
    """
    return "grow" if load is None else "stay"


def chosen_case(
    assembly: Assembly, file: Path, case: str | None, loads: Path | None, *, gap: float | str, tilt: str | None
) -> LoadCase | None:
    """Return the load case that the options ask for.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    file : Path
        Where they come from.
    case : str or None
        Value of `--case`.
    loads : Path or None
        Value of `--loads`.
    gap : float or str
        Tolerance of the joint search, as the analysis has it.
    tilt : str or None
        Value of `--tilt`, which `assembly` has: the weight rotates, and the loads are those of upright blocks.

    Returns
    -------
    LoadCase or None
        None where no case is asked for.

    Raises
    ------
    InputError
        With file, line and key, for a load or a case that cannot be used, and for `--loads` without `--case`.

    Warns
    -----
    InputWarning
        With a tilt, that the loads do not tilt; of loads of the scene, which do not act.
    """
    if case is None:
        if loads is not None:
            raise InputError("--loads gives load cases; choose one by --case NAME")
        warn_of_idle_loads(assembly.metadata, file)
        return None
    from blockstat.loading.cases import load_case
    from blockstat.spec.files import load_file, located

    tables = {} if loads is None else load_file(loads)
    try:
        found = load_case(upright(assembly, tilt), case, **tables, gap=gap)
    except InputError as error:
        raise located(loads or file, error) from None
    _warn_of_no_case(tables or assembly.metadata, loads or file)
    _warn_of_tilt(tilt, found)
    return found if tilt is None else found.under_gravity_of(assembly)


def warn_of_idle_loads(tables: Mapping[str, Any], file: Path, *, chosen: bool = True, listed: bool = False) -> None:
    """Warn that the loads of a scene do not act, where no case of it is chosen.

    Parameters
    ----------
    tables : mapping
        With the loads and the load cases of the scene, where there are some.
    file : Path
        Where they are from.
    chosen : bool, optional
        Whether the command has the option `--case`.
    listed : bool, optional
        Whether the answer has a table of the cases beside it.

    Warns
    -----
    InputWarning
        With the names of the cases, and of the loads that none has.
    """
    if names := ", ".join(tables.get("cases", ())):
        why = f"without --case NAME, one of {names}" if chosen else f"here: this command takes no load case, as {names}"
        beside = "; the table of load cases alone has them" if listed else ""
        warnings.warn(f"{file}: no load of the scene acts {why}{beside}", InputWarning, stacklevel=3)
    _warn_of_no_case(tables, file)


def _warn_of_no_case(tables: Mapping[str, Any], file: Path) -> None:
    """Say which loads can never act."""
    # A scene that is yet to be built is checked then.
    cases = [case for case in tables.get("cases", {}).values() if isinstance(case, Mapping)]
    factors = [case[key] for case in cases for key in ("factors", "live") if isinstance(case.get(key), Mapping)]
    if idle := ", ".join(name for name in tables.get("loads", ()) if not any(name in own for own in factors)):
        text = f"{file}: these loads act in no load case: {idle}; a case names them in [cases.NAME]"
        warnings.warn(text, InputWarning, stacklevel=4)


def warn_of_no_mass(assembly: Assembly, case: LoadCase | None, *, live_grows: bool = False) -> None:
    """Say that an acceleration does not push what a case adds to the weight.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    case : LoadCase or None
        Has the loads that stay while an acceleration of the blocks grows.
    live_grows : bool
        Whether the acceleration is among its live loads, which then grow.

    Warns
    -----
    InputWarning
        With the force that presses down without mass.
    """
    if case is not None and (told := case.without_mass(assembly, live_grows=live_grows)):
        warnings.warn(f'case "{case.name}": {told}', InputWarning, stacklevel=3)


def warn_of_left_out(case: LoadCase | None) -> None:
    """Say that a verification under an earthquake leaves out the live loads of a case.

    Parameters
    ----------
    case : LoadCase or None
        The case.

    Warns
    -----
    InputWarning
        With what to write where they act.
    """
    if case is not None and case.left_out:
        warnings.warn(case.left_out, InputWarning, stacklevel=3)


def _warn_of_tilt(tilt: str | None, *cases: LoadCase) -> None:
    """Say that loads do not tilt with the ground, where there are some."""
    if tilt is not None and any(case.weighted_loads.beside.any() for case in cases):
        text = f"--tilt {tilt} rotates gravity alone; loads of a case stay as they are"
        warnings.warn(text, InputWarning, stacklevel=3)


def placed_load_and_loads(assembly: Assembly, load: str | None, case: LoadCase | None) -> tuple[Any, Any]:
    """Return what grows and what stays as blocks move far, with the forces of a case at their points.

    Parameters
    ----------
    assembly, load, case
        As in `load_and_loads`.

    Returns
    -------
    load, loads
        As `blockstat.capacity` takes them.

    Raises
    ------
    InputError
        Where nothing would grow.
    """
    growing, _ = load_and_loads(assembly, load, case)
    if case is None:
        return growing, None
    return (case.placed_live, case.placed_permanent) if load is None else (growing, case.placed_loads)


def load_and_loads(
    assembly: Assembly, load: str | None, case: LoadCase | None, *, weighted: bool = False
) -> tuple[Any, Any]:
    """Return what grows and what stays in a limit analysis.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    load : str or None
        Value of `--load`, "AX,AY,AZ".
    case : LoadCase or None
        With `--load`, all of its loads stay; without, the live ones grow.
    weighted : bool
        Whether its factor on the weight is kept apart, for densities that are not as drawn.

    Returns
    -------
    load, loads
        As `blockstat.limit_load` takes them.

    Raises
    ------
    InputError
        Where nothing would grow.

    Warns
    -----
    InputWarning
        That loads of the case press down without mass, where an acceleration grows.
    """
    if load is not None:
        warn_of_no_mass(assembly, case)
        acting = None if case is None else case.weighted_loads if weighted else case.loads
        return numbers(load, 3, "--load", "AX,AY,AZ"), acting
    if case is None:
        raise InputError("--load AX,AY,AZ or --case NAME with live loads is needed: what grows until the limit")
    if not case.live.any():
        lack = (
            f'the live loads of case "{case.name}" are zero'
            if case.live_names
            else f'case "{case.name}" has no live loads'
        )
        raise InputError(f"{lack}; give what grows by --load AX,AY,AZ")
    warn_of_no_mass(assembly, case, live_grows=True)
    return case.live, case.weighted_permanent if weighted else case.permanent


def cases_command(
    file: FileArgument,
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
    """Table of all load cases: the verdict under each, and the multiplier of its live loads."""
    assembly = load_assembly(file, friction=friction, gravity=gravity, tilt=tilt, supports=supports, units=units, up=up)
    near = gap_of(gap)
    cases = all_cases(assembly, file, loads, gap=near, tilt=tilt)
    if not cases:
        raise InputError(f"{loads or file}: there are no load cases; write them as [cases.NAME]")
    head = {"file": str(file), **Basis(file, assembly, units=units, up=up, gap=near).echo()}
    rows = list[dict[str, Any]]()
    try:
        with at_work(f"{len(cases)} load cases"):
            for row in case_answers(assembly, cases, gap=near):
                rows.append(row)
    except KeyboardInterrupt:
        if rows:
            _print(head, rows, as_json)
        raise
    _print(head, rows, as_json)


def _print(head: dict[str, Any], rows: list[dict[str, Any]], as_json: bool) -> None:
    if as_json:
        print_json({**head, "rows": rows, "warnings": case_warnings(rows)})
    else:
        _print_table(rows)


def _print_table(rows: list[dict[str, Any]]) -> None:
    width = max(4, *(len(row["case"]) for row in rows))
    typer.echo(f"{'case':<{width}}  {'verdict':<10}  {'multiplier of the live loads'}")
    for row in rows:
        typer.echo(f"{row['case']:<{width}}  {row['verdict'].replace('_', ' '):<10}  {bracket(row)}")
    for text in case_warnings(rows):
        typer.echo(f"Warning: {text}")


def case_warnings(rows: Iterable[dict[str, Any]]) -> list[str]:
    """Return the warnings of all load cases, each once and with the cases that it is about.

    Parameters
    ----------
    rows : iterable of dict
        Those of `case_answers`.

    Returns
    -------
    list of str
        A warning of every case without their names.
    """
    found: dict[str, list[str]] = {}
    rows = list(rows)
    for row in rows:
        for text in row["warnings"]:
            found.setdefault(text, []).append(row["case"])
    return [
        text if len(names) == len(rows) else f"{'case' if len(names) == 1 else 'cases'} {', '.join(names)}: {text}"
        for text, names in found.items()
    ]


def all_cases(
    assembly: Assembly, file: Path, loads: Path | None, *, gap: float | str, tilt: str | None
) -> dict[str, LoadCase]:
    """Return all load cases of a scene, or of `--loads`.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    file : Path
        Where they come from.
    loads : Path or None
        Value of `--loads`.
    gap : float or str
        Tolerance of the joint search, as the analysis has it.
    tilt : str or None
        Value of `--tilt`, as in `chosen_case`.

    Returns
    -------
    dict of str to LoadCase
        By name; empty where there are none.

    Raises
    ------
    InputError
        With file, line and key, for a load or a case that cannot be used.

    Warns
    -----
    InputWarning
        With a tilt, that the loads do not tilt; of loads that no case has.
    """
    from blockstat.loading.cases import load_cases
    from blockstat.spec.files import load_file, located

    tables = {} if loads is None else load_file(loads)
    try:
        found = load_cases(upright(assembly, tilt), **tables, gap=gap)
    except InputError as error:
        raise located(loads or file, error) from None
    _warn_of_no_case(tables or assembly.metadata, loads or file)
    _warn_of_tilt(tilt, *found.values())
    return found if tilt is None else {name: case.under_gravity_of(assembly) for name, case in found.items()}


def case_answers(assembly: Assembly, cases: dict[str, LoadCase], *, gap: float | str) -> Iterator[dict[str, Any]]:
    """Give the verdict under each case, and the bracket on the multiplier of its live loads, one by one.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    cases : dict of str to LoadCase
        By name.
    gap : float or str
        Tolerance of the joint search.

    Yields
    ------
    dict
        Row with the keys "case", "verdict", "lower", "upper" and "warnings", and "status" where there are live loads.

    Raises
    ------
    InputError
        When blocks overlap.
    """
    from blockstat.analysis.assess import assess
    from blockstat.analysis.limit_load import limit_load
    from blockstat.contact.overlap.searched import searched_joints

    options: dict[str, Any] = {"gap": gap, "interfaces": searched_joints(assembly, gap)[0]}
    for name, case in cases.items():
        verdict = assess(assembly, loads=case.loads, **options)
        row: dict[str, Any] = {"case": name, "verdict": verdict.outcome.word, "lower": None, "upper": None}
        told = verdict.warnings
        if case.live.any():
            found = limit_load(assembly, case.live, loads=case.permanent, **options).summary()
            row |= {"status": found["status"], "lower": found["lower"], "upper": found["upper"]}
            told += (*found["warnings"], *filter(None, [case.without_mass(assembly, live_grows=True)]))
        elif case.live_names:
            row["status"] = "live_loads_are_zero"
        yield row | {"warnings": list(dict.fromkeys(told))}


def bracket(row: dict[str, Any]) -> str:
    """Return the multiplier of the live loads of a row of `case_answers` in words.

    Parameters
    ----------
    row : dict
        The row.

    Returns
    -------
    str
        Both bounds, or why there are none.
    """
    if row["lower"] is not None and row["upper"] is not None:
        return f"{row['lower']:.6g} to {row['upper']:.6g}"
    return row.get("status", "no live loads").replace("_", " ")
