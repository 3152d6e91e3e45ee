"""Plans one step of which is at its limit, and what is asked of such a step: tilt, friction, props and orders."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from blockstat import Assembly, Plan, Prop, Step, assess_plan, count_orders, falsework
from evidence.hard.cases import STABLE, UNSTABLE
from evidence.hard.figures import Figure, Found, Section, Stages
from evidence.scenes.small import assembly, box, overhanging, stack

RESERVES = (1e-3, 1e-5, 1e-7)  #: of the centroid from the edge over which a block tips [m]
CUBES = 6
TABLE = box((-3, 0, -1), (0, 1, 0), name="table")
PROPPED = 0.25  #: from the edge of the table to the prop [m]


def counterweighted(reserve: float) -> Assembly:
    """A cube whose centroid is that far behind the edge of a table, and another one on its tail."""
    low = box((-0.5 - reserve, 0, 0), (0.5 - reserve, 1, 1), name="low")
    return assembly([TABLE, low, box((-0.9, 0, 1), (0.1, 1, 2), name="tail")])


def hanging(reserve: float) -> Assembly:
    """A cube that is held, and one on it whose centroid is that far behind its edge."""
    low = box((-0.2, 0, 0), (0.8, 1, 1), name="low")
    return assembly([TABLE, low, box((0.3 - reserve, 0, 1), (1.3 - reserve, 1, 2), name="top")])


def leaning(share: float) -> Assembly:
    """Six cubes over the edge of a table, each out over the next by a share of what balances those above it."""
    return overhanging(CUBES, share * sum(1 / (2 * k) for k in range(1, CUBES + 1)))


def slope(steepness: float) -> Assembly:
    """Two slabs on a slope of that tangent."""
    down = np.array([steepness, 0.0, -1.0]) / np.hypot(steepness, 1.0)
    return stack(2, 1.0, 0.3).with_(gravity=down)


PROP = {"prop": Prop("low", (PROPPED, 0.5, 0.0), (0.0, 0.0, 1.0))}
BUILT = Plan((Step(("low",), ("low",)), Step(), Step(("tail",))))
ON_A_PROP = Plan((Step(("low",), props_in=("prop",)), Step(("tail",), props_out=("prop",))), props=PROP)
LET_GO = Plan(
    (Step(("low",), ("low",)), Step(("top",), ("low", "top")), Step((), ("low",)), Step((), ("top",)), Step())
)

ONE_BY_ONE = Plan(tuple(Step((f"block{k + 1}",)) for k in range(CUBES)))


def tilt(reserve: float) -> Callable[[], Found]:
    """How far the ground may tilt while the cube stands without its counterweight [deg]."""

    def ask() -> Found:
        found = assess_plan(counterweighted(reserve), Plan((Step(("low",)), Step(("tail",)))), tilt=True)
        assert found.tilt is not None
        return Found(found.outcome.word, found.tilt[0], found.tilt[0])

    return ask


def push_of_the_prop(reserve: float) -> Callable[[], Found]:
    """Least force of the prop, in weights."""

    def ask() -> Found:
        found = falsework(counterweighted(reserve), (["low"], []), list(PROP.values()))
        return Found(found.outcome.word, found.total, found.total)

    return ask


def orders(reserve: float) -> Callable[[], Found]:
    """In how many orders the two cubes can be placed with no hand."""

    def ask() -> Found:
        found = count_orders(counterweighted(reserve))
        return Found("undecided" if found.undecided else "decided", found.orders, found.orders)

    return ask


def least_friction(steepness: float) -> Callable[[], Found]:
    """The bracket on the least friction with which every step of a plan on a slope stands."""

    def ask() -> Found:
        plan = Plan((Step(("stone0",)), Step(("stone1",))))
        found = assess_plan(slope(steepness), plan, reserve=True)
        assert found.least_friction is not None
        return Found(found.outcome.word, *found.least_friction)

    return ask


SIGNED = tuple(sign * reserve for reserve in RESERVES for sign in (1, -1))
STAGES = (
    *(
        Stages(f"cube with its centroid {reserve:+.0e} m behind the edge, released, then weighted",
               lambda reserve=reserve: counterweighted(reserve), BUILT,
               (STABLE, STABLE if reserve > 0 else UNSTABLE, STABLE), "weight over the table or not")
        for reserve in SIGNED
    ),
    *(
        Stages(f"the same at {reserve:+.0e} m on a prop until it is weighted",
               lambda reserve=reserve: counterweighted(reserve), ON_A_PROP, (STABLE, STABLE), "the prop pushes or not")
        for reserve in SIGNED[-2:]
    ),
    *(
        Stages(f"cube on a held one, its centroid {reserve:+.0e} m behind the edge; then hold both, lower, upper, none",
               lambda reserve=reserve: hanging(reserve), LET_GO,
               (STABLE, STABLE, STABLE if reserve > 0 else UNSTABLE, STABLE, UNSTABLE),
               "weight over the held one or not; wedged under it; weight beyond the table")
        for reserve in SIGNED
    ),
    *(
        Stages(f"six cubes out by 1 {-reserve:+.0e} times the harmonic series, from the bottom",
               lambda reserve=reserve: leaning(1 - reserve), ONE_BY_ONE,
               (*[STABLE] * (CUBES - 1), STABLE if reserve > 0 else UNSTABLE), "weight over every edge or over none")
        for reserve in SIGNED
    ),
)  # fmt: skip
FIGURES = (
    *(
        Figure(f"tilt that the cube at {reserve:+.0e} m stands without its weight [deg]", tilt(reserve),
               float(np.degrees(np.arctan(reserve / 0.5))), "reserve over half the height", word="stable",
               bracket=False)
        for reserve in RESERVES
    ),
    *(
        Figure(f"least force of the prop at {reserve:+.0e} m [weights]", push_of_the_prop(reserve),
               max(-reserve, 0.0) / PROPPED, "moments about the edge", 1e-9, scale=1.0, word="held", bracket=False)
        for reserve in (-1e-3, -1e-5, -1e-7, -1e-9)
    ),
    *(
        Figure(f"orders of placing the cube at {reserve:+.0e} m and its weight", orders(reserve), float(reserve > 0),
               "weight over the table or not", scale=1.0, word="decided", bracket=False)
        for reserve in SIGNED[-2:]
    ),
    *(
        Figure(f"least friction of a plan on a slope of tangent {steepness:g}", least_friction(steepness), steepness,
               "tangent of the slope", word="stable")
        for steepness in (0.3,)
    ),
)  # fmt: skip
SECTION = Section(
    "Sequences near their limit",
    """A cube over the edge of a table stands while its centroid is behind the edge. A weight on its tail makes it safe
again, so that one step of the plan is at its limit and the others are not. A prop carries what moments about the edge
ask for, which is next to nothing. Cubes out by the harmonic series have as little reserve over every edge when the
last one is placed, and more before. A cube that leans out under a held one is wedged: forces exist with a friction
above 0.3, the tangent of the line from the edge to the near end of their joint. A plan on a slope needs the tangent of
the slope, which the bracket tells to 1e-5.""",
    (),
    FIGURES,
    STAGES,
)
