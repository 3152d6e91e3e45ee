"""Mechanisms that change abruptly, along capacity curves and settlements, and where two of them tie."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from blockstat import Assembly, settle_to_collapse
from evidence.hard.figures import TEN, Figure, Found, Section, at_change, end_of_curve, limit
from evidence.hard.linkages import FourBar, Spread, first_mechanism, semicircle
from evidence.hard.ties import held_at_the_top, holds
from evidence.scenes.small import arch, assembly, box, stack

ASIDE = (-1e-6, 0.0, 1e-6)  #: how far from the geometry at which two mechanisms tie, relative
ARCHES = ((20, 0.2), (24, 0.3))  #: voussoirs and t / R
LOWER = float(np.sqrt(0.48))  #: width of a lower course that tips with an upper one of .4, both 1 high [m]


def two_courses(upper: float) -> Assembly:
    """A course of that width in the middle of a wider one."""
    ground = box((-5, -5, -1), (5, 5, 0), name="ground")
    low, high = (box((-b / 2, 0, z), (b / 2, 1, z + 1), name=f"course{z}") for b, z in ((LOWER, 0), (upper, 1)))
    return assembly([ground, low, high], friction=0.9)


def weaker(upper: float) -> float:
    """The upper course tips over its bed, or both over the ground."""
    return min(upper, LOWER / 2 * (LOWER + upper) / (LOWER / 2 + 1.5 * upper))


def to_an_edge(travel: float) -> Assembly:
    """A slab of 1 m by 0.5 m on a table, whose resultant reaches the table's edge after that travel."""
    friction, high = 0.4, 0.5
    table = box((-5, -5, -1), (friction * high / 2 + travel, 5, 0), name="table")
    return assembly([table, box((-0.5, 0, 0), (0.5, 1, high), name="slab")], friction=friction)


def thrust_leaves(voussoirs: int, thickness: float, what: str) -> float:
    """Mean displacement, or multiplier, at which the thrust of an arch reaches the edge of a joint that is shut."""
    linkage = first_mechanism(semicircle(voussoirs, thickness))
    kind, turn = linkage.change()
    assert kind == "jump"
    return linkage.displacement(turn) if what == "parameter" else linkage.multiplier(turn)


def after_the_jump() -> float:
    """Multiplier of the arch of 20 voussoirs on the hinges that it jumps to, at the same displacement."""
    place = thrust_leaves(20, 0.2, "parameter")
    linkage = FourBar(semicircle(20, 0.2), (2, 9, 15, 20))
    return linkage.multiplier(linkage.at(place))


def settles(make: Callable[[], Assembly], moves: dict, **options) -> Callable[[], Found]:
    """The question for the movement of supports at which an assembly falls."""

    def ask() -> Found:
        found = settle_to_collapse(make(), moves, **options)
        last = float(found.displacement[-1])
        return Found(found.outcome.word, last, last, found.warnings)

    return ask


def answers(ask: Callable[[], Found]) -> Callable[[], Found]:
    """Whether there is an answer, of whatever value."""

    def asked() -> Found:
        return Found("answer", 1.0, 1.0, ask().told)

    return asked


def lintel(bearing: float, left: float = 0.0) -> Assembly:
    """A lintel of 2.5 m with its left end on a wall that ends at 1 m, and so long a bearing at its right end."""
    walls = [box((left, 0, -1), (1, 1, 0), name="left"), box((3 - bearing, 0, -1), (4, 1, 0), name="right")]
    return assembly([*walls, box((0.5, 0, 0), (3, 1, 0.5), name="lintel")], supports=[0, 1])


AWAY, DOWN = {"right": (1, 0, 0)}, {"right": (0, 0, -1)}
STEP = "the resolution is a thirtieth of the size of the assembly; `displacement` makes it finer"
EARLY = "the joint that opens is named open at the change already, where it is still shut"
TIES = (
    *(
        Figure(f"block that slides and tips, mu 1 {e:+.0e} times b / h",
               limit(lambda e=e: stack(1, 0.5, 2.0, friction=0.25 * (1 + e)), (1, 0, 0), optimum=True),
               0.25 * min(1, 1 + e), "least of mu and b / h", TEN)
        for e in ASIDE
    ),
    *(
        Figure(f"two courses that tip together, the upper 1 {e:+.0e} times as wide",
               limit(lambda e=e: two_courses(0.4 * (1 + e)), (1, 0, 0), optimum=True), weaker(0.4 * (1 + e)),
               "least of both joints", TEN)
        for e in ASIDE
    ),
    *(
        Figure(f"pillar with a tie that bears 1 {e:+.0e} times {bears:g} of its weight",
               limit(lambda e=e, bears=bears: held_at_the_top(bears * (1 + e)), (1, 0, 0), optimum=True),
               holds(bears * (1 + e)), "b / h + 2 T / W, mu + T / W, 2 mu + b / h", TEN)
        for bears in (0.45, 0.95) for e in ASIDE if e or bears < 0.5
    ),
)  # fmt: skip
CURVES = (
    *(
        Figure(f"slab that slides by {travel:.0e} m, then turns over an edge: where",
               at_change(lambda travel=travel: to_an_edge(travel), (1, 0, 0), "slab"), travel, "D - mu h / 2", 1e-4,
               scale=0.1 + travel, word="change", bracket=False, flaw=flaw, slow=travel != 1e-3)
        for travel, flaw in ((1.0, ""), (1e-3, ""), (1e-6, EARLY))
    ),
    *(
        Figure(f"arch of {n} voussoirs, t/R {thickness:g}: {name} its first jump",
               at_change(lambda n=n, thickness=thickness: arch(n, thickness, friction=3.0), (1, 0, 0), "mean",
                         what=what),
               lambda n=n, thickness=thickness, what=what: thrust_leaves(n, thickness, what), "four-bar linkage",
               word="jump", bracket=False, slow=True)
        for n, thickness in ARCHES
        for name, what in (("mean displacement at", "parameter"), ("multiplier before", "before"))
    ),
    Figure("arch of 20 voussoirs, t/R 0.2: multiplier after its first jump",
           at_change(lambda: arch(20, 0.2, friction=3.0), (1, 0, 0), "mean", what="after"), after_the_jump,
           "four-bar linkage on the next hinges", word="jump", bracket=False, slow=True),
    Figure("arch of 10 voussoirs, t/R 0.2: collapse where five hinges are open",
           end_of_curve(lambda: arch(10, 0.2, friction=3.0), (1, 0, 0), "mean"),
           lambda: thrust_leaves(10, 0.2, "parameter"), "four-bar linkage; its jump carries nothing", word="collapse",
           bracket=False),
)  # fmt: skip
SETTLEMENTS = (
    *(
        Figure(f"arch of {n} voussoirs, t/R {thickness:g}, on spreading supports: movement to its fall",
               settles(lambda n=n, thickness=thickness: arch(n, thickness, friction=0.9), AWAY),
               lambda n=n, thickness=thickness: Spread(semicircle(n, thickness)).collapse, "three-hinged arch",
               word="collapse", bracket=False, slow=n > 10)
        for n, thickness in ((10, 0.15), (20, 0.2))
    ),
    *(
        Figure(f"lintel with a bearing of {bearing:.0e} m whose support moves away{how}",
               settles(lambda bearing=bearing: lintel(bearing, 0.7), AWAY, **options), bearing, "its bearing", 1e-3,
               word="collapse", bracket=False, flaw="" if options else STEP, slow=bool(options))
        for bearing in (0.1, 1e-3)
        for how, options in (("", {}), (", followed over twice that", {"displacement": 2 * bearing}))
        if not options or bearing > 1e-3
    ),
    *(
        Figure(f"lintel with a bearing of {bearing:.0e} m whose support sinks{how}",
               settles(lambda bearing=bearing: lintel(bearing), DOWN, **options),
               2 * np.sqrt(bearing - bearing**2 / 4), "its corner at the edge of its support", 1e-2, word="collapse",
               bracket=False, flaw=flaw, slow=bool(options))
        for bearing, how, options, flaw in (
            (4e-2, "", {}, ""),
            (2e-2, ", 150 steps", {"steps": 150}, ""),
            (1e-2, "", {}, ""),
            (1e-3, "", {}, STEP),
            (1e-3, ", followed over thrice that", {"displacement": 6 * np.sqrt(1e-3)}, ""),
            (1e-5, "", {}, STEP),
        )
    ),
    Figure("lintel with a bearing of 1e-01 m whose support sinks, 200 steps: answers",
           answers(settles(lambda: lintel(0.1), DOWN, steps=200)), 1.0, "a question that may be asked", word="answer",
           bracket=False),
)  # fmt: skip
SECTION = Section(
    "Jumps of mechanisms",
    """Where two mechanisms tie the limit is the least of two formulas, and has a kink. A slab slides at mu until its
resultant reaches the edge, and turns over it then. An arch that is pushed is a four-bar linkage until the thrust
reaches the edge of a fifth joint. A state with five open joints has no stable equilibrium, so the arch jumps to other
hinges at the same displacement. Place and multipliers of the jump are those of `evidence/hard/linkages.py`, which
knows plane geometry alone. An arch on spreading supports has three hinges, is determinate, and falls where its thrust
reaches the extrados of a springing. A lintel slides on the support that carries less, and falls when its bearing is
used up. When that support sinks by s, the lintel turns about the edge of the other one, 2 m away, and draws its end
back by 2 - sqrt(4 - s^2). It is this end that slides, up to a bearing of 6 cm: the force on the other end stays in
its friction cone, which turns with the lintel.""",
    (),
    (*TIES, *CURVES, *SETTLEMENTS),
)
