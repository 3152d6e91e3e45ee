"""Static and dynamic verdicts side by side."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from functools import partial

from blockstat.analysis.assess import assess
from blockstat.analysis.verdict import Outcome
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.tolerance import stated_length
from blockstat.errors import InputError, known_options
from dynsim.checks import check_engine
from dynsim.comparison.causes import agrees, find_cause, joints_as_found, likely_reason, with_coulomb
from dynsim.comparison.first_motion import first_motion_cosine
from dynsim.comparison.table import Comparison, Comparisons
from dynsim.engine.lmgc90 import import_lmgc90
from dynsim.judge.verdict import DynamicOutcome, DynamicVerdict
from dynsim.judge.verify import verify
from dynsim.parallel.pool import Row, listed, paired, run_many, with_options
from dynsim.settings import Settings


@known_options
def compare(
    assemblies: Assembly | Iterable[Assembly],
    *,
    settings: Settings | None = None,
    closely: bool = False,
    engines: Sequence[str] = ("bullet",),
    gap: float | str = GAP,
    interfaces: Interfaces | Sequence[Interfaces] | None = None,
    jobs: int | None = None,
    timeout: float | None = None,
    progress: Callable[[int, Row[Comparison]], None] | None = None,
) -> Comparisons:
    """Return static and dynamic verdicts on one assembly or several, as a table.

    Parameters
    ----------
    assemblies : Assembly or iterable of Assembly
        What is compared, one row each.
    settings : Settings, optional
        Of the dynamic verdicts, as in `verify`.
    closely : bool
        Look for the cause of a difference with further, finer and longer runs.
    engines : sequence of str
        ("bullet",), or ("bullet", "lmgc90") for a second opinion in a column of its own; see `verify`.
    gap : float or str, optional
        Largest gap of a joint, as in `blockstat.assess`; not used where `interfaces` are given.
    interfaces : Interfaces or sequence of Interfaces, optional
        Joints, of each assembly its own; searched for when None.
    jobs : int, optional
        Processes at a time; all cores when None.
    timeout : float, optional
        Time that one assembly may take [s].
    progress : callable, optional
        Called with the number and the row of each assembly as it ends.

    Returns
    -------
    Comparisons
        Rows in the order of the assemblies. One without a verdict has a note that says why.

    Raises
    ------
    InputError
        For a bad number of processes, interfaces of another number of assemblies, or engines that do not exist or are
        not installed. Also for an option that does not exist.

    Examples
    --------
    >>> from blockstat.model import arch, assemble
    >>> from dynsim import compare
    >>> ring = assemble(arch(span=2.0, thickness=0.4, depth=0.5, voussoirs=9, springers=0.3), friction=0.7)
    >>> [(row.static, row.dynamic) for row in compare(ring, jobs=1)]
    [('stable', 'stands')]
    """
    stated_length(gap)
    designs = listed(assemblies)
    names = [design.name for design in designs]
    one = [interfaces] if isinstance(interfaces, Interfaces) else interfaces
    function = partial(
        with_options, partial(compare_one, settings=settings, closely=closely, engines=check_engines(engines), gap=gap)
    )
    rows = run_many(function, paired(designs, one), names=names, jobs=jobs, timeout=timeout, progress=progress)
    return Comparisons(tuple(row.result or Comparison(name=row.name, note=row.error) for row in rows))


def check_engines(engines: Sequence[str]) -> tuple[str, ...]:
    """Return the engines of a comparison.

    Parameters
    ----------
    engines : sequence of str
        "bullet", and "lmgc90" after it.

    Returns
    -------
    tuple of str
        The same.

    Raises
    ------
    InputError
        For others, and where LMGC90 is asked for and not installed.
    """
    for name in engines:
        check_engine(name)
    if tuple(engines) not in (("bullet",), ("bullet", "lmgc90")):
        raise InputError(f"engines are {','.join(engines)!r}; they must be bullet, or bullet,lmgc90")
    if "lmgc90" in engines:
        import_lmgc90()
    return tuple(engines)


def compare_one(
    assembly: Assembly,
    *,
    settings: Settings | None = None,
    closely: bool = False,
    engines: Sequence[str] = ("bullet",),
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> Comparison:
    """Return the row of one assembly, in this process.

    Parameters
    ----------
    assembly : Assembly
        What is compared.
    settings, closely, engines, gap : optional
        As in `compare`.
    interfaces : Interfaces, optional
        Joints of the assembly; searched for when None.

    Returns
    -------
    Comparison
        The row.

    Raises
    ------
    InputError
        Where there is no verdict.
    """
    static = assess(assembly, gap=gap, interfaces=interfaces)
    coulomb = with_coulomb(static)
    dynamic = verify(assembly, settings=settings, interfaces=interfaces or joints_as_found(static))
    cause = find_cause(static, coulomb, dynamic, settings=settings, closely=closely)
    second, why = (
        _second(assembly, settings, interfaces or joints_as_found(static)) if "lmgc90" in engines else (None, "")
    )
    both_fall = static.outcome is Outcome.UNSTABLE and dynamic.outcome is DynamicOutcome.FALLS
    note = likely_reason(static, dynamic) if dynamic.outcome is DynamicOutcome.CREEPS else cause.value if cause else ""
    note = "; ".join(filter(None, (note, why)))
    return Comparison(
        name=assembly.name,
        blocks=assembly.n_blocks,
        interfaces=static.interfaces.n_interfaces,
        static=static.outcome.word,
        coulomb=coulomb.outcome.word,
        score=static.summary()["score"],
        dynamic=dynamic.outcome.word,
        group_drop=dynamic.group_drop,
        max_drop=dynamic.max_drop,
        max_displacement=dynamic.max_displacement,
        settling=dynamic.settling,
        static_seconds=static.timings["total"],
        coulomb_seconds=coulomb.timings["total"],
        dynamic_seconds=dynamic.run.process_seconds,
        agree=agrees(static, dynamic),
        agree_coulomb=agrees(coulomb, dynamic),
        cosine=first_motion_cosine(static, dynamic) if both_fall else None,
        cause=cause.word if cause is not None else "",
        note=note,
        lmgc90=None if second is None else second.outcome.word,
        lmgc90_displacement=None if second is None else second.max_displacement,
        lmgc90_seconds=None if second is None else second.process_seconds,
    )


def _second(assembly: Assembly, settings: Settings | None, interfaces: Interfaces) -> tuple[DynamicVerdict | None, str]:
    """The verdict of LMGC90, or why there is none."""
    try:
        return verify(assembly, settings=settings, interfaces=interfaces, engine="lmgc90"), ""
    except InputError as error:
        return None, f"LMGC90 gave no verdict: {error}"
