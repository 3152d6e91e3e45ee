"""The same scenes at home, at UTM coordinates and in millimetres: how many digits survive."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from blockstat import Assembly, Tie, assess, capacity
from evidence.hard.cases import STABLE, UNSTABLE, Case
from evidence.hard.figures import DIGITS, Figure, Found, Make, Section, at_change, limit
from evidence.hard.linkages import first_mechanism, semicircle
from evidence.scenes import edges
from evidence.scenes.small import arch, assembly, box

UTM = np.array([500_000.0, 4_600_000.0, 200.0])
WIDE, HIGH = 0.37, 1.3  #: of a block whose sides are no sums of powers of two [m]
ROUNDING = float(np.spacing(UTM.max()) / WIDE)  #: of a side along the northing: two ends by half a spacing each
BLOCKS = 10
SOLVER = 2e-9  #: of a bracket: both of its ends are proven to 1e-9 of the loads


@dataclass(frozen=True)
class Where:
    """A place: the unit of length [m], and whether the origin is that of UTM."""

    name: str
    unit: float = 1.0
    far: bool = False

    @property
    def within(self) -> float:
        """How many digits of a limit load there are."""
        return SOLVER + ROUNDING * self.far

    def point(self, at) -> tuple[float, ...]:
        """A point in this place."""
        return tuple(((np.asarray(at, dtype=float) + self.far * UTM) / self.unit).tolist())

    def moved(self, make: Make) -> Assembly:
        """A scene in this place, with its weights as they are."""
        asm = make()
        vertices = (asm.vertices + self.far * UTM) / self.unit
        ties = [
            Tie(tie.between, (self.point(tie.points[0]), self.point(tie.points[1])), tie.least, tie.greatest)
            for tie in asm.ties
        ]
        return asm.with_(vertices=vertices, density=asm.density * self.unit**3, ties=tuple(ties))


#: Lengths in millimetres are rounded after the move, as a file in these units has them.
PLACES = (
    Where("at the origin"),
    Where("at UTM coordinates", far=True),
    Where("in mm", unit=1e-3),
    Where("in mm at UTM coordinates", unit=1e-3, far=True),
)
NORTH = (0.0, 1.0, 0.0)


def column(courses: int, **options) -> Assembly:
    """Courses of a square column."""
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground")]
    tops = HIGH * np.arange(courses + 1) / courses
    blocks += [
        box((0, 0, low), (WIDE, WIDE, high), name=f"course{k}")
        for k, (low, high) in enumerate(zip(tops[:-1], tops[1:], strict=True))
    ]
    return assembly(blocks, **options)


def tied() -> Assembly:
    """A block with a tie at its top that bears a tenth of its weight."""
    tie = Tie(("ground", "course0"), ((0.1, -4, HIGH), (0.1, 0, HIGH)), greatest=0.1 * WIDE**2 * HIGH)
    return column(1, ties=[tie])


def score(where: Where) -> Callable[[], Found]:
    """The score of a block under twice the push that it carries."""

    def ask() -> Found:
        asm = where.moved(lambda: column(1))
        found = assess(asm.with_(gravity=(0, 2 * WIDE / HIGH, -1)))
        return Found(found.outcome.word, found.score, found.score, found.warnings)

    return ask


def half_their_width(where: Where) -> Callable[[], Found]:
    """How many blocks of random sides have capacity curves that end where their centroids are over their toes."""

    def ask() -> Found:
        random, right = np.random.default_rng(0), 0
        for _ in range(BLOCKS):
            side = (*random.uniform(0.2, 1.0, 2).round(2), round(random.uniform(1.0, 3.0), 2))
            ground = box((-5, -5, -1), (5, 5, 0), name="ground")
            asm = where.moved(lambda side=side, ground=ground: assembly([ground, box((0, 0, 0), side, name="block")]))
            found = capacity(asm, NORTH, control="block", friction=2.0)
            end = float(found.displacement[-1]) * where.unit
            right += found.outcome.word == "zero" and abs(end - side[1] / 2) < DIGITS * side[1] / 2
        return Found("zero", right, right)

    return ask


def first_multiplier() -> float:
    """Of an arch, by its linkage."""
    return first_mechanism(semicircle(10, 0.2)).multiplier(0.0)


#: Two points at the heel are pulled by s each: 2 s b = W (a h - b) / 2 for a push of a = 2 b / h; in shares of the
#: load W sqrt(1 + a^2).
SCORE = np.sqrt(2) / 4 / np.sqrt(1 + (2 * WIDE / HIGH) ** 2)
KEELS = edges.crossed_keels(np.deg2rad(30))
FIGURES = (
    *(
        Figure(f"block, limit of its push to the north, {where.name}",
               limit(lambda where=where: where.moved(lambda: column(1)), NORTH, optimum=True),
               WIDE / HIGH, "b / h", where.within)
        for where in PLACES
    ),
    *(
        Figure(f"block, its score under twice that push, {where.name}", score(where), SCORE,
               "least tension of the heel", where.within, word="unstable", bracket=False)
        for where in PLACES
    ),
    *(
        Figure(f"{name}, {where.name}",
               limit(lambda where=where, make=make: where.moved(make), push, optimum=True), truth, why,
               joints * where.within)
        for name, make, push, truth, why, joints in (
            ("column of ten courses", lambda: column(10), NORTH, WIDE / HIGH, "b / h", 1),
            ("block with a tie", tied, NORTH, WIDE / HIGH + 0.2, "b / h + 2 T / W", 1),
            ("arch of ten voussoirs", lambda: arch(10, 0.2), (1, 0, 0), first_multiplier, "four-bar linkage", 2),
            ("keels across ridges", lambda: KEELS.scene, KEELS.direction, KEELS.limit, "a / (z cos 30)", 1),
        )
        for where in PLACES[1::2]
    ),
    *(
        Figure(f"capacity curves of {BLOCKS} blocks pushed to the north that end at half their width, {where.name}",
               half_their_width(where), BLOCKS, "b / 2", word="zero", bracket=False, slow=True)
        for where in PLACES
    ),
)  # fmt: skip


def facing_north(make: Make) -> Make:
    """A scene in the plane x, z, turned into the plane y, z, at UTM coordinates."""

    def made() -> Assembly:
        asm = make()
        return asm.with_(vertices=asm.vertices @ np.array([(0, 1, 0), (-1, 0, 0), (0, 0, 1)]) + UTM)

    return made


def first_jump(voussoirs: int, thickness: float) -> float:
    """Mean displacement at which an arch that is pushed changes its hinges."""
    linkage = first_mechanism(semicircle(voussoirs, thickness))
    kind, turn = linkage.change()
    assert kind == "jump"
    return linkage.displacement(turn)


JUMPS = tuple(
    Figure(
        f"arch of {n} voussoirs, t/R {thickness:g}, first jump of its hinges, {name}",
        at_change(make(lambda n=n, thickness=thickness: arch(n, thickness, friction=0.9)), push, "mean"),
        lambda n=n, thickness=thickness: first_jump(n, thickness),
        "four-bar linkage",
        word="jump",
        bracket=False,
        slow=True,
    )
    for n, thickness in ((12, 0.17), (20, 0.15))
    for name, make, push in (
        ("at the origin", lambda make: make, (1, 0, 0)),
        ("facing north at UTM coordinates", facing_north, NORTH),
    )
)


def pushed(where: Where, share: float) -> Make:
    """A block under a share of its limit."""
    return lambda: where.moved(lambda: column(1)).with_(gravity=(0, share * WIDE / HIGH, -1))


CASES = tuple(
    Case("far away", f"block at 1 {sign} {ratio:.0e} of its limit, {where.name}",
         pushed(where, 1 + factor * ratio), right, "tips at b / h", near=ratio <= 1e-7)
    for where in PLACES[1::2]
    for ratio in (1e-6, 1e-7)
    for sign, factor, right in (("-", -1, STABLE), ("+", 1, UNSTABLE))
)  # fmt: skip
SECTION = Section(
    "UTM coordinates and millimetres",
    f"""The scenes are moved to (500000, 4600000, 200) m, put into millimetres, and both. A verdict, a score and a
limit load do not know about it. What changes is the rounding: neighbouring numbers at 4.6e6 m are
{np.spacing(UTM.max()):.1e} m apart (machine epsilon times 4.6e6 m, rounded to a power of two), so that the base of
0.37 m of the block is known to {ROUNDING:.1e} of itself. The answers may be off by that and by {SOLVER:.0e} for the
bracket, twice as much for the arch, in which two joints move. So eight digits survive, and seven in the place of a
jump. In millimetres the sides are whole numbers where they are whole in the drawing, and lose nothing. Capacity curves
move blocks by finite displacements: that of a block ends where its centroid is over its toe, and the hinges of an arch
change where its linkage says (`evidence/hard/linkages.py`).""",
    CASES,
    (*FIGURES, *JUMPS),
)
