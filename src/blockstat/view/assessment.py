"""The report of an assessment: what was assumed, what was found, and what it rests on, in one page to hand over."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from datetime import date as Date
from html import escape
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.assess import assess
from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, limit_load
from blockstat.analysis.verdict import Outcome, Verdict, joint_counts
from blockstat.code_check.linear import CheckOutcome, LinearCheck, linear_check
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import check_choice, known_options
from blockstat.io.parts import UNITS
from blockstat.result import Result, listed, plain
from blockstat.studies.directions import DIRECTIONS, DirectionalLimits, DirectionOutcome, limit_load_by_direction
from blockstat.typing import Floats
from blockstat.view.document import CODE, MEANING, SOURCES, bullets, facts, figure, page, table, verdict_box
from blockstat.view.plot import plot, plot_forces, plot_mechanism
from blockstat.view.polar import plot_directions
from blockstat.view.thrust_lines import plot_thrust

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.loading.cases import LoadCase

#: Of assemblies with more free blocks the limit load without dilatancy, by bisection, takes longer than all the rest.
FEW = 100
#: A verdict in Bullet, or by any other means, on the same assembly.
Verifier = Callable[..., Result]
#: The tone of an answer by its word; others are grey.
TONES = {
    "stable": "good", "stands": "good", "satisfied": "good",
    "unstable": "bad", "falls": "bad", "stable_only_by_self_stress": "bad", "not_satisfied": "bad",
}  # fmt: skip


@dataclass(frozen=True, eq=False)
class Assessment(Result):
    """Everything that the report of an assembly shows."""

    associated: Verdict
    coulomb: Verdict
    directions: DirectionalLimits
    dynamic: Result | None  #: the verdict of a simulation; None where none was asked for
    source: str  #: the file, or what else the blocks came from
    units: str  #: of the file's coordinates
    gap: float | str  #: tolerance of the joint search, relative to block size or a length
    #: Name, what acts, verdict and multiplier of the live loads of each load case; only the weight acts where empty.
    cases: tuple[tuple[str, str, str, str], ...] = ()
    case: LoadCase | None = None  #: the case under which all else was found; None for no case
    #: The code check by direction, or why there is no mechanism to verify; empty where it was not asked for.
    checks: tuple[tuple[str, LinearCheck | LoadOutcome], ...] = ()
    loaded: bool = False  #: whether further loads act, beside the weight or the case
    told: tuple[str, ...] = ()  #: warnings about the input, beside those of the parts
    #: Limit loads without the live loads of the case, on which the code check rests; None where it was not asked for.
    pushed: DirectionalLimits | None = None
    #: The least limit load with what joints carry that do not dilate; None where it was not looked for.
    without_dilatancy: LimitLoad | None = None

    @property
    def assembly(self) -> Assembly:
        """The blocks."""
        return self.associated.assembly

    @property
    def outcome(self) -> Outcome:
        """The verdict by force fields alone."""
        return self.associated.outcome

    @property
    def parts(self) -> tuple[tuple[str, Result | None], ...]:
        """The answers by what they are of; None where none was asked for."""
        return (
            ("Force fields alone (associated friction)", self.associated),
            ("Without dilatancy and self-stress (Coulomb friction)", self.coulomb),
            ("Simulation (Bullet)", self.dynamic),
            ("Limit load over the horizon", self.directions),
            *((f"Code check towards {name}", check) for name, check in self.verified),
        )

    def explain(self) -> str:
        """Return the verdict and each of the answers in words.

        Returns
        -------
        str
            The answers one after the other, each below what it is of.
        """
        told = [f"{title}\n{result.explain()}" for title, result in self.parts if result is not None]
        return "\n\n".join([self.outcome.value, *told])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Those of each answer by what it is of, beside the verdict and the warnings.
        """
        own = {"outcome": self.outcome.word, "sentence": self.outcome.value, "warnings": list(self.warnings)}
        return own | {"answers": {title: found.summary() for title, found in self.parts if found is not None}}

    @property
    def warnings(self) -> tuple[str, ...]:
        """The warnings about the input and of all parts, each once."""
        parts = (self.associated, self.coulomb, self.dynamic)
        own = [*self.told, *(text for part in parts for text in getattr(part, "warnings", ())), *self.directions.told]
        if self.pushed is not None and self.pushed is not self.directions:
            own += [f"code check: {text}" for text in self.pushed.told if text not in own]
        every = [(name, text) for name, check in self.verified for text in check.warnings]
        own += [f"code check towards {name}: {text}" for name, text in every if text not in own]
        return tuple(dict.fromkeys(own))

    @property
    def verified(self) -> tuple[tuple[str, LinearCheck], ...]:
        """The directions with a code check."""
        return tuple((name, check) for name, check in self.checks if isinstance(check, LinearCheck))

    @property
    def left_out(self) -> tuple[tuple[str, LoadOutcome], ...]:
        """The directions without one, and why."""
        return tuple((name, check) for name, check in self.checks if isinstance(check, LoadOutcome))


@known_options
def assess_fully(
    assembly: Assembly,
    *,
    source: str = "",
    units: str = "m",
    directions: int = DIRECTIONS,
    gap: float | str = GAP,
    loads: Floats | None = None,
    verify: Verifier | None = None,
    cases: Sequence[tuple[str, str, str, str]] = (),
    case: LoadCase | None = None,
    code: Mapping[str, Any] | None = None,
    interfaces: Interfaces | None = None,
) -> Assessment:
    """Find what a report shows: the verdicts of all kinds, and the limit load over the horizon.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    source : str, optional
        The file, or what else the blocks came from.
    units : str, optional
        Of the coordinates in the file.
    directions : int, optional
        How many directions of the horizon, a multiple of 4.
    gap : float, optional
        Tolerance of the joint search, relative to block size.
    loads : array of float, shape (n_blocks, 6), optional
        Permanent wrench on each block beside its weight [N, N m].
    verify : callable, optional
        Simulates the assembly, such as `dynsim.verify`. Called with the assembly, and with ``loads=`` where there are.
    cases : sequence of tuple of str, optional
        Name, what acts, verdict, and multiplier of the live loads of each load case, to be listed.
    case : LoadCase, optional
        All of its loads act beside the weight, and beside `loads`.
    code : mapping, optional
        Options of `blockstat.linear_check`, such as ``{"site": Site("B"), "demand": 0.15}``: the mechanisms towards +-x
        and +-y and the weakest one are verified where there is a limit load, and those that may carry less are named.
        The live loads of the case are left out there: they may not act in an earthquake.
    interfaces : Interfaces, optional
        Use these joints instead of searching. A simulation finds its own.

    Returns
    -------
    Assessment
        For `assessment_html`.

    Raises
    ------
    InputError
        As in `blockstat.assess`.
    """
    check_choice("units", units, UNITS)
    loaded, permanent, live = loads is not None, loads, case is not None and bool(case.live.any())
    if case is not None:
        beside, stays = np.zeros(6) if loads is None else loads, case.weighted_permanent
        permanent, loads = replace(stays, beside=stays.beside + beside), case.loads + beside
    coulomb = assess(assembly, gap=gap, loads=loads, flow="coulomb", interfaces=interfaces)
    associated, joints, bare = coulomb, {"gap": gap, "interfaces": coulomb.interfaces}, None
    if coulomb.outcome is not Outcome.UNSTABLE:
        associated = assess(assembly, loads=loads, **joints)
    pushed = limits = limit_load_by_direction(assembly, directions, loads=loads, **joints)
    if coulomb.outcome is Outcome.STABLE and limits.outcome is DirectionOutcome.LIMIT and len(assembly.free) <= FEW:
        bare = limit_load(assembly, limits.directions[limits.weakest], loads=loads, flow="coulomb", **joints)
    dynamic = None
    if verify is not None:
        dynamic = verify(assembly) if loads is None else verify(assembly, loads=loads)
    checks: tuple[tuple[str, LinearCheck | LoadOutcome], ...] = ()
    if code is not None:
        if live:
            pushed = limit_load_by_direction(assembly, directions, loads=permanent, **joints)
        checks = tuple(_check(pushed, k, {"loads": permanent, **code}) for k in pushed.notable)
    source = source or assembly.name
    own: dict[str, Any] = {"case": case, "checks": checks, "loaded": loaded, "without_dilatancy": bare}
    own["pushed"] = None if code is None else pushed
    return Assessment(associated, coulomb, limits, dynamic, source, units, gap, tuple(cases), **own)


def _check(limits: DirectionalLimits, k: int, code: Mapping[str, Any]) -> tuple[str, LinearCheck | LoadOutcome]:
    """The code check of a direction, or the outcome of a load that has no limit there."""
    limit = limits.limits[k]
    if limit.outcome is not LoadOutcome.LIMIT:
        return limits.names[k], limit.outcome
    return limits.names[k], linear_check(limit, limits.directions[k], **code)


def assessment_html(found: Assessment, *, day: Date | None = None, parts: Sequence[str] = ()) -> str:
    """Return the report as one page that loads nothing from elsewhere.

    Parameters
    ----------
    found : Assessment
        What `assess_fully` found.
    day : date, optional
        Date of the report; by default today.
    parts : sequence of str, optional
        HTML of further parts, above the pictures.

    Returns
    -------
    str
        HTML.

    Examples
    --------
    >>> from blockstat import Assembly, assess_fully, assessment_html, box
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 0.5, 2), name="slab")]
    >>> found = assess_fully(Assembly.from_blocks(blocks, supports=["ground"], name="slab"), directions=4)
    >>> html = assessment_html(found)
    >>> "towards +y" in html, "https://" in html
    (True, False)
    """
    name = found.assembly.name
    made = f"blockstat {version('blockstat')}, {(day or Date.today()).isoformat()}"
    body = [
        f"<h1>{escape(name)}: assessment as rigid blocks</h1><p>{escape(made)}</p>",
        "<h2>Answer</h2>" + _answers(found),
        "<h2>Inputs and assumptions</h2>" + facts(assumptions(found)),
        "<h2>Load cases</h2>" + _cases(found) if found.cases else "",
        "<h2>Ties</h2>" + _ties(found) if found.assembly.ties else "",
        "<h2>Limit load over the horizon</h2>" + _horizon(found),
        "<h2>Code check</h2>" + _checks(found) if found.checks else "",
        *parts,
        "<h2>Pictures</h2>" + _pictures(found),
        "<h2>Warnings</h2>" + (bullets(found.warnings) or "<p>None.</p>"),
        f"<h2>What the answers mean</h2><p>{escape(MEANING)}</p>",
        "<h2>Evidence</h2>" + _evidence(found),
        "<h2>Sources of the method</h2>" + bullets((*SOURCES, CODE) if found.checks else SOURCES),
    ]
    return page(f"{name}: assessment", body)


def assumptions(found: Assessment) -> list[tuple[str, str]]:
    """Return every input and assumption in words.

    Parameters
    ----------
    found : Assessment
        What `assess_fully` found.

    Returns
    -------
    list of tuple of str
        Names and values.
    """
    assembly, faces = found.assembly, found.associated.interfaces
    free = assembly.free
    density = np.unique(assembly.density[free]) if len(free) else np.unique(assembly.density)
    gravity = np.linalg.norm(assembly.gravity)
    up = -assembly.gravity / gravity
    axis = next((name for name, part in zip("xyz", up, strict=True) if part > 1 - 1e-9), None)
    near = found.gap if isinstance(found.gap, str) else f"{found.gap:g} of the size of the smaller block"
    supports = [assembly.names[i] for i in np.flatnonzero(assembly.support)]
    laws = [_law(law.as_dict()) for law in assembly.joints]
    return [
        ("source", found.source),
        ("units of the file", f"{found.units}; all figures here are in m, kg, N and s unless they say otherwise"),
        ("upward axis", axis or f"({up[0]:.4g}, {up[1]:.4g}, {up[2]:.4g})"),
        ("gravity", f"{gravity:.6g} m/s2"),
        ("friction", f"{assembly.friction:g} (coefficient of all joints without a law of their own)"),
        ("joint laws", "; ".join(laws) or "none: dry joints without tension, cohesion or crushing"),
        ("density", f"{density[0]:g}" + (" kg/m3" if len(density) == 1 else f" to {density[-1]:g} kg/m3, by block")),
        ("blocks", f"{assembly.n_blocks:,}, of which {len(free):,} are free"),
        ("supports", listed(supports, 8)),
        ("ties", f"{len(assembly.ties)}, listed below" if assembly.ties else "none"),
        ("loads", _acting(found, "{0.name}: {0.words}")),
        ("weight of the free blocks", f"{plain(assembly.free_weight / 1e3, 4)} kN"),
        ("volume of the free blocks", f"{plain(assembly.volume[free].sum(), 4)} m3"),
        ("joints", f"{faces.n_interfaces:,} with {faces.n_points:,} contact points; {len(faces.dropped)} left out"),
        ("gap", f"faces count as touching up to {near}"),
        ("blocks are", "rigid and unbreakable; edges do not crush unless a joint law says so"),
    ]


def _law(law: dict[str, Any]) -> str:
    between = " and ".join(law.pop("between"))
    return f"between {between}: " + ", ".join(f"{name} {value:g}" for name, value in law.items())


def _answers(found: Assessment) -> str:
    rows: tuple[tuple[str, Any], ...] = found.parts[:3]
    parts = []
    for title, result in rows:
        if result is None:
            parts.append(verdict_box("", title, "Not asked for. dynsim report simulates the blocks, too."))
            continue
        said = _in_words(result.headline if isinstance(result, Verdict) else result.outcome.value)
        word, _, sentence = said.partition(": ")
        tone = TONES.get(result.outcome.word, "")
        parts.append(verdict_box(tone, f"{title}: {word.lower()}", sentence[:1].upper() + sentence[1:]))
    parts.append(verdict_box("", *_least(found)))
    return "".join([*parts, _code_box(found) if found.checks else ""])


def _in_words(text: str) -> str:
    """A text for readers who write no Python: what a function is to be asked for stands beside it in the report."""
    return text.replace(' (see flow="coulomb")', "").replace("tightnesses=12", "--tightnesses 12")


def _least(found: Assessment) -> tuple[str, str]:
    """The least limit load, and what is known of it without dilatancy."""
    limits = found.directions
    if limits.outcome is not DirectionOutcome.LIMIT:
        return f"Least limit load: {_answer(limits.outcome)}", limits.outcome.value
    bare = limits.said_without_dilatancy(found.without_dilatancy)
    if found.coulomb.outcome is Outcome.STABLE_ONLY_BY_SELF_STRESS:
        bare = "Without dilatancy and self-stress none is carried: the weight alone is not."
    return f"Least limit load (associated friction): {limits.least.upper:.4g}", f"{limits.said} {bare}"


def _code_box(found: Assessment) -> str:
    """The answer of the code check; where a direction is left out that may carry less than the others there is none."""
    towards: dict[LoadOutcome, list[str]] = {}
    for name, outcome in found.left_out:
        towards.setdefault(outcome, []).append(name)
    words = [f"Not verified towards {', '.join(names)}: {outcome.value}" for outcome, names in towards.items()]
    answer, tone = "not verified", ""
    if found.verified:
        name, check = min(found.verified, key=lambda row: row[1].ag_life)
        asked = "" if check.demand is None else f", asked for {check.demand:.4g} g"
        words.insert(0, f"Least towards {name}: ag = {check.ag_life:.4g} g at SLV{asked}. {check.outcome.value}")
        if check.outcome is CheckOutcome.NOT_SATISFIED or set(towards) <= {LoadOutcome.UNBOUNDED}:
            answer, tone = _answer(check.outcome), TONES.get(check.outcome.word, "")
    return verdict_box(tone, f"Code check (linear): {answer}", " ".join(words))


def _answer(outcome: CheckOutcome | LoadOutcome | DirectionOutcome) -> str:
    return outcome.word.replace("_", " ")


def _cases(found: Assessment) -> str:
    what = f"Verdicts and pictures here are those under {_acting(found)}. The horizontal acceleration is added."
    heads = ["case", "loads", "verdict", "multiplier of the live loads"]
    return f"<p>{escape(what)}</p>" + table(heads, found.cases)


def _acting(found: Assessment, form: str = 'all loads of the case "{0.name}": {0.words}') -> str:
    """What the verdicts are under; a case in the given form."""
    what = "the weight of the blocks" if found.case is None else form.format(found.case)
    return f"{what}, and further loads" if found.loaded else what


def _ties(found: Assessment) -> str:
    """The ties, and their forces in the force fields that the page rests on."""
    least = found.directions.least.ties if found.directions.outcome is DirectionOutcome.LIMIT else None
    rows = []
    for k, tie in enumerate(found.assembly.ties):
        forces = ["-" if own is None else plain(round(own[k]) / 1e3) for own in (found.associated.ties, least)]
        bounds = f"{plain(tie.least / 1e3)} to {plain(tie.greatest / 1e3)}"
        rows.append(
            (tie.name or str(k), " and ".join(map(str, tie.between)), "strut" if tie.strut else "tie", bounds, *forces)
        )
    heads = ["name", "between", "", "force [kN]", "at rest [kN]", "at the least limit load [kN]"]
    words = "<p>The force at rest is one of an admissible force field; others may be admissible too.</p>"
    return table(heads, rows) + words


def _checks(found: Assessment) -> str:
    """The linear verification towards each direction."""
    rows: list[tuple[str, ...]] = [
        (
            name, f"{check.alpha0:.5g}", str(len(check.bodies)), f"{check.participation:.4g}", f"{check.apart:.4g}",
            f"{check.acceleration:.4g}", f"{check.ag_damage:.4g}", f"{check.ag_life:.4g}",
            "-" if check.outcome is CheckOutcome.CAPACITY else _answer(check.outcome),
        )
        for name, check in found.verified
    ]  # fmt: skip
    rows += [(name, *["-"] * 7, _answer(outcome)) for name, outcome in found.left_out]
    said = "" if found.case is None else found.case.left_out
    left_out = f" {said[0].upper()}{said[1:]}." if said else ""
    heads = ["towards", "alpha0", "bodies", "e*", "apart", "a0* [m/s2]", "ag SLD [g]", "ag SLV [g]", "answer"]
    if not found.verified:
        words = "Linear verification of the mechanisms by Circolare 7/2019, C8.7.1.2.1: no load has a limit to verify."
        return f"<p>{escape(words + left_out)}</p>" + table(heads, rows)
    first = found.verified[0][1]
    asked = "" if first.demand is None else f" Asked for at SLV: ag = {first.demand:.4g} g."
    words = (
        f"Linear verification of the mechanisms by Circolare 7/2019, C8.7.1.2.1, with FC = {first.confidence:g} and "
        f"q = {first.behaviour:g}; on {first.ground}.{asked} alpha0 is {first.multiplier}. e* is that taken; beside it "
        f"that of the bodies apart. The mass is that of the blocks; loads have none.{left_out}"
    )
    return f"<p>{escape(words)}</p>" + table(heads, rows)


def _horizon(found: Assessment) -> str:
    limits = found.directions
    if limits.outcome is DirectionOutcome.DEAD_LOAD_UNSTABLE:
        return f"<p>{escape(limits.outcome.value)}</p>"
    rows = [
        (name, f"{limit.lower:.5g}", f"{limit.upper:.5g}", limit.outcome.word, _first(limit))
        for name, limit in zip(limits.names, limits.limits, strict=True)
    ]
    heads = ["towards", "carried", "moves at", "answer", "joints that move"]
    return table(heads, rows)


def _first(limit: LimitLoad) -> str:
    return ", ".join(joint_counts({kind: pairs for kind, pairs in limit.joints().items() if pairs})) or "-"


def _pictures(found: Assessment) -> str:
    limits, parts = found.directions, []
    with tempfile.TemporaryDirectory(prefix="blockstat-") as folder:
        directory = Path(folder)

        def draw(function: Callable[..., Any], result: Any, name: str, caption: str, **options: Any) -> None:
            parts.append(figure(Path(function(result, directory / f"{name}.png", **options)), caption))

        draw(plot, found.assembly, "blocks", "The blocks; supports are grey.", title=found.assembly.name)
        if found.associated.outcome is Outcome.STABLE:
            draw(plot_forces, found.associated, "forces", "Resultants of the joints in one admissible force field.")
            draw(plot_thrust, found.associated, "thrust", "The way of the thrust in the same force field.")
        elif found.associated.mechanism.any():
            proven = found.associated.outcome is Outcome.UNSTABLE
            words = f"How the blocks {'move first' if proven else 'might move'} under {_acting(found)}."
            draw(plot_mechanism, found.associated, "fall", words if proven else f"{words} Nothing is proven to move.")
        if limits.outcome is DirectionOutcome.LIMIT:
            draw(plot_directions, limits, "horizon", "Limit load by direction; the least is orange.")
            limited = [k for k in limits.notable if limits.limits[k].outcome is LoadOutcome.LIMIT]
            for k in sorted(limited, key=lambda k: limits.upper[k]):
                what = "least limit load" if k == limits.weakest else "limit load"
                words = f"Mechanism of the {what}, {limits.upper[k]:.4g} towards {limits.names[k]}."
                draw(plot_mechanism, limits.limits[k], f"mechanism{k}", words)
    return f'<div class="pictures">{"".join(parts)}</div>'


def _evidence(found: Assessment) -> str:
    parts = [("Force fields alone", found.associated), ("Without dilatancy", found.coulomb)]
    parts += [("Simulation", found.dynamic)] if found.dynamic is not None else []
    return "".join(f"<h3>{escape(title)}</h3><pre>{escape(_in_words(part.explain()))}</pre>" for title, part in parts)
