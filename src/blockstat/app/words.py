"""What the page says, as HTML: the verdict, the numbers, a block."""

from __future__ import annotations

from dataclasses import dataclass, field
from html import escape
from math import atan, degrees, isfinite, isinf, isnan
from typing import TYPE_CHECKING

import numpy as np

from blockstat.analysis.limit_load import LoadOutcome
from blockstat.analysis.verdict import CAVEAT, Outcome, Verdict, motion_words
from blockstat.app.design import PUSHES, Pushed, Slipped, idle_loads
from blockstat.contact.features import ContactKind
from blockstat.result import Result, plain
from blockstat.view.three_d.colouring import tension

if TYPE_CHECKING:
    from blockstat.typing import Floats

#: Blue and orange, which colour-blind readers tell apart; the word is always there too.
TONES = {
    Outcome.STABLE: ("#0072B2", "Stable"),
    Outcome.UNSTABLE: ("#D55E00", "Unstable"),
    Outcome.UNDECIDED: ("#5c5f66", "Undecided"),
    Outcome.STABLE_ONLY_BY_SELF_STRESS: ("#CC79A7", "Stable only by self-stress"),
}
STEPS = (("build", "blocks"), ("interfaces", "contacts"), ("solve", "solve"), ("draw", "colours"))
#: What is said where a plain "stable" leaves something open, and of a mechanism that is yet to come or will not come.
OPEN = f"{CAVEAT}. Save report has the verdict without either."
LATER = "How the blocks move first follows."
ANY = "It is the first mechanism that proved the fall; the one of least residual tension was not found here."
NO_BLOCK = '<div style="font-size:.85em;margin:0 8px">Click a block to see its forces.</div>'
UNKNOWN = "not known"  #: for a reason that is not the design's
MARGIN = "margin:0 10px"
SMALL = "font-size:.85em;line-height:1.45"
TROUBLE = "border-left:4px solid #D55E00;background:#fdf3ec;padding:.4em .6em"  #: of the box of a warning


@dataclass(frozen=True, eq=False)
class Known:
    """All that is known of the design on show.

    Attributes
    ----------
    verdict : Verdict
        The static verdict.
    seconds : dict of str to float
        Process time of each step [s].
    pushed : dict of str to Pushed
        The limit loads that are known by now, by direction, a key of `PUSHES`.
    slipped : Slipped or None
        The least friction; None while it is being computed.
    stopped : bool
        Whether what is not known by now will not be.
    values : dict of str to float
        Values of the parameters that the verdict is about, by dotted path.
    simulated : Result or None
        The verdict of a simulation on the same design, where one was shown.
    """

    verdict: Verdict
    seconds: dict[str, float] = field(default_factory=dict)
    pushed: dict[str, Pushed] = field(default_factory=dict)
    slipped: Slipped | None = None
    stopped: bool = False
    values: dict[str, float] = field(default_factory=dict)
    simulated: Result | None = None

    @property
    def is_scored(self) -> bool:
        """Whether the mechanism is that of least residual tension, which `blockstat check` tells, and not any one."""
        return not (isnan(self.verdict.score) and self.verdict.mechanism.any())

    @property
    def shows_motion(self) -> bool:
        """Whether there is a mechanism of the verdict to show: not while that of least residual tension may come."""
        return bool(self.verdict.mechanism.any()) and (self.is_scored or self.stopped)

    @property
    def pending(self) -> str:
        """What stands in the place of a number that is not known yet."""
        return "stopped" if self.stopped else "…"

    @property
    def weakest(self) -> Pushed | None:
        """The least of the limit loads; None until all are known, and where no direction has one."""
        bounded = [found for found in self.pushed.values() if found.limit is not None and found.limit.lower >= 0]
        if len(self.pushed) < len(PUSHES) or not bounded:
            return None
        return min(bounded, key=lambda found: found.limit.lower if found.limit is not None else 0.0)


def headline(known: Known) -> str:
    """Return the verdict in words: one word, its sentence, the blocks that move first and how they move.

    Parameters
    ----------
    known : Known
        What is known of the design on show.

    Returns
    -------
    str
        HTML.
    """
    verdict = known.verdict
    colour, word = TONES[verdict.outcome]
    names = [verdict.assembly.names[i] for i in verdict.moving[:3]] if known.shows_motion else []
    sentence = verdict.headline.partition(": ")[2]
    lines = [escape(sentence[:1].upper() + sentence[1:])]
    if verdict.outcome is Outcome.STABLE:
        lines.append(OPEN)
    if not known.is_scored:
        lines.append(ANY if known.stopped else LATER)
    if names:
        more = len(verdict.moving) - len(names)
        lines.append(f"First to move: {escape(', '.join(names))}{f' and {more} more' if more else ''}.")
        moves = motion_words(verdict.assembly, verdict.interfaces, verdict.mechanism, limit=1)
        lines += [escape(text) for text in moves]
    if verdict.worst:
        lines.append(f"Where {escape(verdict.worst)}.")
    lines += [f"Note: {escape(text)}." for text in verdict.warnings[:2]]
    body = "".join(f'<div style="{SMALL}">{line}</div>' for line in lines)
    big = f'<div style="color:{colour};font-size:1.5em;font-weight:700">{word}</div>'
    return f'<div role="status" style="{MARGIN}">{big}{body}</div>{trouble(idle_loads(verdict.assembly))}'


def refusal(message: str, known: Known | None, name: str) -> str:
    """Return what stands in the verdict's place after a file was refused.

    Parameters
    ----------
    message : str
        Why, in plain text.
    known : Known or None
        What is known of the design that stays on show.
    name : str
        Of that design.

    Returns
    -------
    str
        HTML.
    """
    colour = TONES[Outcome.UNSTABLE][0]
    big = f'<div style="color:{colour};font-size:1.5em;font-weight:700">Not opened</div>'
    shown = f"{name} ({TONES[known.verdict.outcome][1].lower()})" if known is not None else name
    rest = f'<div style="{SMALL};color:#5c5f66">Still on show: {escape(shown)}.</div>'
    return f'<div style="{MARGIN}">{big}</div>{trouble(message)}<div style="{MARGIN}">{rest}</div>'


def numbers(known: Known) -> str:
    """Return a table of the numbers; dots stand for what is still being computed.

    Parameters
    ----------
    known : Known
        What is known of the design on show.

    Returns
    -------
    str
        HTML.
    """
    verdict, assembly = known.verdict, known.verdict.assembly
    free = assembly.free
    rows = [
        ("score", "residual tension / weight", _score(known)),
        *((f"limit load, {push}", _mark(known, push), _limit(known, push)) for push in PUSHES),
        ("reserve in tilt", "from the least", _tilt(known)),
        ("least friction", f"now {assembly.friction:g}", least_friction(known, known.pending)),
        ("volume", "m³", plain(float(assembly.volume[free].sum()), 4)),
        ("weight", "kN", plain(assembly.free_weight / 1e3, 4)),
        ("blocks / joints", "", f"{assembly.n_blocks:,} / {verdict.interfaces.n_interfaces:,}"),
    ]
    if words := verdict.interfaces.contact_words:
        rows.append(("contacts", "", words))
    cells = "".join(
        f'<tr><td style="padding:.12em .6em .12em 0">{escape(name)} <span style="color:#5c5f66;font-size:.85em">'
        f'{escape(unit)}</span></td><td style="text-align:right;vertical-align:top"><b>{value}</b></td></tr>'
        for name, unit, value in rows
    )
    table = f'<table style="width:100%;{SMALL};border-collapse:collapse;margin-top:.5em">{cells}</table>'
    return f'<div style="{MARGIN}">{table}{_steps(known.seconds)}</div>'


def waiting(sentence: str) -> str:
    """Return what stands in the verdict's place before there is one.

    Parameters
    ----------
    sentence : str
        Plain text.

    Returns
    -------
    str
        HTML.
    """
    return f'<div style="{MARGIN};color:#5c5f66;font-size:1.2em">{escape(sentence)}</div>'


def trouble(message: str) -> str:
    """Return why there is no new verdict.

    Parameters
    ----------
    message : str
        Plain text; empty for nothing.

    Returns
    -------
    str
        HTML; empty for no message.
    """
    if not message:
        return ""
    box = f"{TROUBLE};margin:.4em 10px;overflow-wrap:anywhere"
    return f'<div role="alert" class="trouble" style="{box};{SMALL}">{escape(message).replace(chr(10), "<br>")}</div>'


def small(html: str) -> str:
    """Return what stands below a headline in small letters.

    Parameters
    ----------
    html : str
        HTML; plain text is escaped before. Empty for nothing.

    Returns
    -------
    str
        HTML; empty for nothing.
    """
    return f'<div style="{MARGIN};{SMALL};overflow-wrap:anywhere;padding-top:.4em">{html}</div>' if html else ""


def block_card(verdict: Verdict, block: int, moved: Floats | None = None, *, shows_motion: bool = True) -> str:
    """Describe a block: its name, weight, displacement, neighbours and the force that each puts on it.

    Parameters
    ----------
    verdict : Verdict
        The static verdict on the design.
    block : int
        Number of the block.
    moved : array of float, shape (n_blocks,), optional
        Distances of the blocks on show from where they are built [m].
    shows_motion : bool, optional
        Whether the mechanism of the verdict is on show.

    Returns
    -------
    str
        HTML.
    """
    assembly, faces = verdict.assembly, verdict.interfaces
    weight = assembly.mass[block] * float(np.linalg.norm(assembly.gravity))
    rows = []
    for joint in np.flatnonzero((faces.pair == block).any(axis=1)):
        a, b = (int(i) for i in faces.pair[joint])
        own = slice(faces.start[joint], faces.start[joint + 1])
        net = verdict.forces[own].sum(axis=0)
        shear = float(np.hypot(net[1], net[2]))
        other = assembly.names[a if b == block else b]
        if faces.kinds[joint] != ContactKind.FACE:
            other += f" ({ContactKind(faces.kinds[joint]).name.lower()})"
        rows.append(f"<tr><td>{escape(other)}</td><td>{plain(net[0] / 1e3)}</td><td>{plain(shear / 1e3)}</td></tr>")
    fixed = " (support)" if assembly.support[block] else ""
    lines = [f"<b>{escape(assembly.names[block])}</b>{fixed}, weight {plain(weight / 1e3, 4)} kN"]
    if shows_motion and verdict.mechanism.any():
        lines.append(f"in the mechanism {verdict.motion[block]:.3g} of the fastest corner's way")
    if moved is not None:
        lines.append(f"moved {plain(1e3 * moved[block])} mm")
    missing = 0.0 if isnan(verdict.score) else float(tension(verdict)[block])
    if missing:
        lines.append(f"tension missing {plain(missing / 1e3)} kN")
    head = "<tr style='color:#5c5f66'><td>neighbour</td><td>normal kN</td><td>shear kN</td></tr>"
    table = f'<table style="width:100%;{SMALL}">{head}{"".join(rows)}</table>'
    return f'<div style="margin:0 8px"><div style="{SMALL}">{"<br>".join(lines)}</div>{table}</div>'


def _score(known: Known) -> str:
    verdict = known.verdict
    if isnan(verdict.score):
        return known.pending
    return "∞" if isinf(verdict.score) else f"{verdict.score:.3g}"


def _mark(known: Known, push: str) -> str:
    weakest = known.weakest
    return "× gravity, the least" if weakest is not None and weakest.push == push else "× gravity"


def _limit(known: Known, push: str) -> str:
    found = known.pushed.get(push)
    if found is None:
        return known.pending
    if found.limit is None:
        return UNKNOWN
    if found.limit.outcome is LoadOutcome.DEAD_LOAD_UNSTABLE:
        return "none"
    if found.limit.outcome is LoadOutcome.UNBOUNDED:
        return "unbounded"
    return f"{found.limit.lower:.4g}" + ("" if found.limit.outcome is LoadOutcome.LIMIT else " at least")


def _tilt(known: Known) -> str:
    if len(known.pushed) < len(PUSHES):
        return known.pending
    if any(found.limit is None for found in known.pushed.values()):
        return UNKNOWN
    weakest = known.weakest
    return f"{degrees(atan(weakest.limit.lower)):.3g}°" if weakest is not None and weakest.limit is not None else "none"


def least_friction(known: Known, pending: str = "not found yet when this was saved") -> str:
    """Return the least friction with which a design stands.

    Parameters
    ----------
    known : Known
        What is known of the design.
    pending : str, optional
        What stands in its place while it is looked for.

    Returns
    -------
    str
        Plain text.
    """
    if known.slipped is None:
        return pending
    if known.slipped.reason:
        return UNKNOWN
    least = known.slipped.least
    return f"{least:.3f}" if isfinite(least) else "none is enough"


def _steps(seconds: dict[str, float]) -> str:
    own = dict(seconds)
    own["solve"] = sum(own.pop(step, 0.0) for step in ("equilibrium", "memory", "solve", "certificate"))
    words = ", ".join(f"{word} {1e3 * own[step]:.0f}" for step, word in STEPS if step in own)
    return f'<div style="color:#5c5f66;{SMALL}">milliseconds: {words}</div>' if words else ""
