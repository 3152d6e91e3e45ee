"""Ties between blocks of very different weights, and ties that bear very little or very much."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from blockstat import Assembly, Tie, capacity
from evidence.hard.cases import STABLE, UNSTABLE, Case
from evidence.hard.figures import TEN, Figure, Found, Section, limit, patient
from evidence.hard.linkages import turned
from evidence.scenes.small import assembly, box

#: Of a light block of weight 1, and of the tie at half its height to a heavy block of 2 m by 2 m [m].
WIDE, HIGH, LENGTH, FRICTION = 0.5, 2.0, 4.0, 0.7
GROUND = box((-20, -5, -1), (20, 5, 0), name="ground")
LIGHT = np.array([[0.0] * 6, [1.0, *[0.0] * 5], [0.0] * 6])  #: a push on the light block alone
RATIOS = (1e4, 1e6, 1e8)


def pair(ratio: float, bears: float | None = np.inf) -> Assembly:
    """A light block tied to one that is so many times heavier; None for no tie."""
    light = box((0, 0, 0), (WIDE, 1, HIGH), name="light")
    heavy = box((-LENGTH - 2, 0, 0), (-LENGTH, 1, 2), name="heavy", density=ratio / 4)
    ends = ((-LENGTH, 0.5, HIGH / 2), (0, 0.5, HIGH / 2))
    ties = [] if bears is None else [Tie(("heavy", "light"), ends, greatest=bears)]
    return assembly([GROUND, light, heavy], friction=FRICTION, ties=ties)


def pulls(ratio: float, bears: float | None) -> float:
    """The push that a light block carries: it tips at b / h; the tie adds its force until the heavy block slides."""
    return WIDE / HIGH + (0.0 if bears is None else min(bears, FRICTION * ratio))


def anchored(ratio: float) -> Assembly:
    """A heavy pillar with a light block as the anchor of its tie, at a quarter of the pillar's height."""
    heavy = box((0, 0, 0), (WIDE, 1, HIGH), name="heavy", density=ratio)
    light = box((-LENGTH - 1, 0, 0), (-LENGTH, 1, 1), name="anchor")
    tie = Tie(("anchor", "heavy"), ((-LENGTH, 0.5, 0.5), (0, 0.5, 0.5)))
    return assembly([GROUND, heavy, light], friction=FRICTION, ties=[tie])


def held_at_the_top(bears: float) -> Assembly:
    """A pillar of weight 1 with a tie from the ground to its top."""
    tie = Tie(("ground", "pillar"), ((-LENGTH, 0.5, HIGH), (0, 0.5, HIGH)), greatest=bears)
    pillar = box((0, 0, 0), (WIDE, 1, HIGH), name="pillar")
    return assembly([GROUND, pillar], friction=FRICTION, ties=[tie])


def holds(bears: float) -> float:
    """It tips, or its foot slides, or it tips back over its heel as the foot slides."""
    slope = WIDE / HIGH
    return min(slope + 2 * bears, FRICTION + bears, 2 * FRICTION + slope)


def tendon(force: float, courses: int = 8) -> Assembly:
    """A column of weight 1 with a tendon of constant force along its axis."""
    tops = HIGH * np.arange(courses + 1) / courses
    blocks = [
        box((0, 0, low), (WIDE, 1, high), name=f"course{k}")
        for k, (low, high) in enumerate(zip(tops[:-1], tops[1:], strict=True))
    ]
    tie = Tie(("ground", blocks[-1].name), ((WIDE / 2, 0.5, 0), (WIDE / 2, 0.5, HIGH)), force, force)
    return assembly([GROUND, *blocks], friction=np.inf, ties=[tie])


def balance(turn: float, bears: float) -> float:
    """Push on the centroid of a light block of weight 1 that has turned about its toe while its tie yields."""
    toe = np.array([WIDE, 0.0])
    centre, end = (toe + turned(p - toe, -turn) for p in (np.array([WIDE / 2, HIGH / 2]), np.array([0.0, HIGH / 2])))
    pull = np.array([-LENGTH, HIGH / 2]) - end
    pull *= bears / np.linalg.norm(pull)
    arm = end - toe
    return float((toe[0] - centre[0] + arm[0] * pull[1] - arm[1] * pull[0]) / centre[1])


def upright(bears: float) -> float:
    """Displacement of the centroid at which no push is left."""
    low, high = 0.0, 1.5
    for _ in range(100):
        middle = (low + high) / 2
        low, high = (middle, high) if balance(middle, bears) > 0 else (low, middle)
    toe = np.array([WIDE, 0.0])
    return float((toe + turned(np.array([WIDE / 2, HIGH / 2]) - toe, -low))[0] - WIDE / 2)


def end(ratio: float, bears: float) -> Callable[[], Found]:
    """Where the capacity curve of a tied light block ends."""

    def ask() -> Found:
        found = capacity(pair(ratio, bears), LIGHT, control="light")
        last = float(found.displacement[-1])
        return Found(found.outcome.word, last, last, found.warnings)

    return ask


def named(ratio: float, bears: float | None) -> str:
    """A pair in words."""
    if bears is None:
        return f"block beside one {ratio:.0e} times heavier"
    tie = "a tie without end" if np.isinf(bears) else f"a tie of {bears:g} of its weight"
    return f"block held by {tie} to one {ratio:.0e} times heavier"


TOTAL = "2e-9 of the whole weight count as no width, and the heavy block is nearly all of it"
LOOSE = "the upper bound lies above what its mechanism proves"
DIGITS_LOST = "the lower bound has five digits, fewer than the tie adds"
FLAWS = {
    (1e6, 1e-6): LOOSE,
    (1e8, 1.0): TOTAL,
    (1e8, 1e-6): TOTAL,
    (1e8, None): TOTAL,
}
CASES = tuple(
    Case("ties", f"{named(ratio, bears)}, 1 {sign} {share:.0e} of its limit",
         lambda ratio=ratio, bears=bears: pair(ratio, bears), right, "b / h + T / W",
         {"loads": pulls(ratio, bears) * (1 + factor * share) * LIGHT},
         near=share * pulls(ratio, bears) <= 1e-9 * ratio)
    for ratio in RATIOS[1:] for bears in (np.inf, 1.0, None) for share in ((1e-3, 1e-5) if ratio > 1e6 else (1e-5,))
    for sign, factor, right in (("-", -1, STABLE), ("+", 1, UNSTABLE))
)  # fmt: skip
FIGURES = (
    *(
        Figure(f"push on a {named(ratio, bears)}", limit(lambda ratio=ratio, bears=bears: pair(ratio, bears), LIGHT),
               pulls(ratio, bears), "b / h + T / W", flaw=FLAWS.get((ratio, bears), ""))
        for ratio in RATIOS for bears in (np.inf, 1.0, 1e-6, None) if ratio > 1e4 or bears == 1.0
    ),
    Figure(f"acceleration of a {named(1e8, 1.0)}, pushed by 1 - 1e-05 of its limit",
           patient(limit(lambda: pair(1e8, 1.0), (1, 0, 0), loads=pulls(1e8, 1.0) * (1 - 1e-5) * LIGHT), 20),
           pulls(1e8, 1.0) * 1e-5, "what is left of b / h + T / W", flaw=TOTAL),
    *(
        Figure(f"pillar {ratio:.0e} times heavier than the anchor of its tie",
               limit(lambda ratio=ratio: anchored(ratio), ratio * LIGHT, optimum=True),
               WIDE / HIGH + FRICTION * 0.5 / ratio, "b / h + 2 mu w z / (W h)", TEN,
               flaw=DIGITS_LOST if ratio == 1e5 else "")
        for ratio in (1e5, 1e8)
    ),
    *(
        Figure(f"pillar whose tie bears {bears:.0e} of its weight",
               limit(lambda bears=bears: held_at_the_top(bears), (1, 0, 0), optimum=True), holds(bears),
               "tips, slides, or both", TEN, flaw="two digits are lost to the size of the tie" if bears > 1e4 else "")
        for bears in (1e-8, 1e-4, 1.0, 1e4, 1e8)
    ),
    *(
        Figure(f"column with a tendon of {force:.0e} of its weight",
               limit(lambda force=force: tendon(force), (1, 0, 0)), WIDE / HIGH * (1 + force), "b / h (1 + F / W)")
        for force in (1e4, 1e8)
    ),
    *(
        Figure(f"end of the capacity curve of a {named(ratio, bears)}", end(ratio, bears),
               lambda bears=bears: upright(bears), "moments about the toe as it turns", word="zero", bracket=False,
               flaw=TOTAL if ratio > 1e6 else "", slow=ratio < 1e8)
        for ratio in RATIOS for bears in (0.5,)
    ),
)  # fmt: skip
SECTION = Section(
    "Mass ratios with ties",
    """A light block of weight 1 tips about its toe under a push of b / h. A tie at half its height adds its force, up
to what it bears or to the friction of the heavy block at its other end. A pillar with a tie at its top slides at its
foot where the tie is strong enough, and tips back over its heel where it is stronger. A tendon of constant force
presses like a weight. A heavy pillar of width b, height h and weight W is tied at a quarter z of its height to an
anchor of weight w, which slides at mu w. As the light block turns, its yielding tie follows its ends, and moments
about the toe give the push. The tolerance of a bracket and of a proof of instability is relative to the weight of the
whole assembly, 2e-9 and 1e-9 of it. Beside a block that is 1e8 times heavier that is a fifth of the light block's
weight, and the answers show it: they are wide or undecided.""",
    CASES,
    FIGURES,
)
