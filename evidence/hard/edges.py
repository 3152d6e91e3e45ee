"""Blocks on edges and corners: near their limits, and where an edge along an edge decides or does not."""

from __future__ import annotations

import numpy as np
from scipy.spatial.transform import Rotation

from blockstat import Assembly, Block, limit_load
from evidence.hard.cases import STABLE, UNDECIDED, UNSTABLE, Case
from evidence.hard.figures import TEN, Figure, Found, Section, limit
from evidence.scenes import edges
from evidence.scenes.edges import Pushed
from evidence.scenes.small import assembly, box

ON_EDGES = (
    edges.tetrahedron(0.1, 3.0, "side"),
    edges.two_ridges(0.1, 0.8, (1, 0)),
    edges.crossed_keels(np.deg2rad(30)),
    edges.ladder(0.5),
    edges.prism_in_groove(0.5, "across"),
    edges.octahedron_in_corner(0.3),
)
NEAR = 1e-6  #: how far from their limits the scenes on edges are


def near_the_limit(pushed: Pushed) -> list[Case]:
    """A scene on edges on both sides of its limit."""
    return [
        Case(
            "on edges",
            f"{pushed.name}, 1 {sign} {NEAR:.0e} of its limit",
            lambda share=1 + factor * NEAR: pushed.at(share),
            right,
            f"limit {pushed.limit:.9g}",
        )
        for sign, factor, right in (("-", -1, STABLE), ("+", 1, UNSTABLE))
    ]


def between_supports(wider: float, ledge: float = 0.0) -> Assembly:
    """A block over an opening of 2 m that is so much wider, on both sides, and rests on a ledge at its left end."""
    sides = [box((-2, -1, -1), (0, 1, 0), name="left"), box((2, -1, -1), (4, 1, 0), name="right")]
    block = box((-wider - ledge, -0.5, 0), (2 + wider, 0.5, 1), name="block")
    return assembly([*sides, block], supports=[0, 1])


def beyond_an_edge() -> Assembly:
    """A block whose lower edge lies along the upper edge of a support beside it."""
    return assembly([box((-2, -1, -1), (0, 1, 0)), box((0, -0.5, 0), (2, 0.5, 1), name="block")])


def two_cubes(friction: float = 0.3) -> Assembly:
    """Two cubes on a floor that touch along an upright edge."""
    cubes = [box((k, k, 0), (k + 1, k + 1, 1), name=f"cube{k}") for k in (0, 1)]
    return assembly([box((-4, -4, -1), (4, 4, 0)), *cubes], friction=friction)


def keel_on_a_ridge(angle: float) -> Assembly:
    """A body with a foot on a plinth and a keel across a ridge; its centroid is between them."""
    ridge = edges.prism([(-0.2, -1), (0.2, -1), (0.2, -0.2), (0, 0), (-0.2, -0.2)], -1, 1, name="ridge")
    plinth = box((-3, -2, -1), (-0.9, 2, 0), name="plinth")
    low = [(-1.5, 0), (-1.0, 0), (-1.0, 0.2), (-0.2, 0.2), (0, 0), (0.2, 0.2), (0.4, 0.2)]
    body = edges.prism([*low, (0.4, 0.8), (-1.5, 0.8)], -0.5, 0.5, name="body")
    body = edges.turned(body, Rotation.from_euler("z", angle).as_matrix(), name="body")
    return assembly([ridge, plinth, body], supports=[0, 1])


def corner_on_corner() -> Assembly:
    """A tetrahedron that stands on its point, on the point of another one."""
    rim = np.array([(1, 0, 1), (-0.5, 0.8, 1), (-0.5, -0.8, 1), (0, 0, 0)], dtype=float)
    faces = [[0, 1, 2], [1, 0, 3], [2, 1, 3], [0, 2, 3]]
    return assembly([Block(rim * [1, 1, -1], [f[::-1] for f in faces]), Block(rim, faces, name="block")])


def balanced(aside: float) -> Assembly:
    """A cube on one ridge, its centroid so far beside it."""
    ridge = edges.prism([(-0.2, -0.4), (0.2, -0.4), (0, 0)], -1, 1, name="ridge")
    return assembly([ridge, box((-0.5 + aside, -0.5, 0), (0.5 + aside, 0.5, 1), name="cube")])


def carried(end: str):
    """An end of the bracket on what pushes one of two cubes towards the other."""

    def ask() -> Found:
        push = np.zeros((3, 6))
        push[1, :2] = np.sqrt(0.5)
        found = limit_load(two_cubes(), push, optimum=True)
        value = getattr(found, end)
        return Found(found.outcome.word, value, value, found.warnings)

    return ask


FITS = "rests on the edges or falls past them"
CASES = (
    *(case for pushed in ON_EDGES for case in near_the_limit(pushed)),
    Case("edge along edge", "block that fits between two supports", lambda: between_supports(0.0), UNDECIDED, FITS),
    Case("edge along edge", "the same with a ledge at one end", lambda: between_supports(0, 0.5), UNDECIDED, FITS),
    Case("edge along edge", "body on a plinth and along a ridge", lambda: keel_on_a_ridge(0), UNDECIDED, FITS),
    Case("edge along edge", "corner on a corner", corner_on_corner, UNDECIDED, "no normal, any force or none"),
    Case("edge along edge", "block 1e-5 wider than that", lambda: between_supports(1e-5), STABLE, "two bearings"),
    Case("edge along edge", "block 1e-5 narrower", lambda: between_supports(-1e-5), UNSTABLE, "touches nothing"),
    Case("edge along edge", "block beside a support", beyond_an_edge, UNSTABLE, "turns about the edge, or falls past"),
    Case("edge along edge", "two cubes on a floor", two_cubes, STABLE, "each rests on the floor"),
    *(
        Case("edge across edge", f"keel across a ridge at {angle:.0e}", lambda angle=angle: keel_on_a_ridge(angle),
             STABLE, "weight between two bearings", near=angle < 1e-6)
        for angle in (1e-1, 1e-3, 1e-5, 1e-7)
    ),
    Case("on one ridge", "cube in balance", lambda: balanced(0.0), STABLE, "weight through the ridge"),
    Case("on one ridge", "cube 1e-6 beside its balance", lambda: balanced(1e-6), UNSTABLE, "weight beside the ridge"),
)  # fmt: skip
FIGURES = (
    *(
        Figure(
            f"limit load: {pushed.name}",
            limit(lambda pushed=pushed: pushed.scene, pushed.direction, optimum=True),
            pushed.limit,
            "closed form",
            TEN,
        )
        for pushed in ON_EDGES[2:5]
    ),
    Figure("one of two cubes pushed to the other: what it carries anyway", carried("lower"), 0.3, "own friction",
           TEN, word="undecided", bracket=False),
    Figure("the same: what it carries with any force in the edge", carried("upper"), 0.6, "friction of both", TEN,
           word="undecided", bracket=False),
)  # fmt: skip
SECTION = Section(
    "Edges and corners",
    """The limits of blocks on edges and corners follow from statics: the resultant of weight and push passes through
the line about which the block turns, or leaves the friction cones. `evidence/scenes/edges.py` has the formula of each.
An edge along an edge, or a corner on a corner, has no unique normal, so no force is known there. Where a block stands
or falls with such a contact, undecided is right. Where it does so whatever the contact carries, it is not. The judge
of the [random scenes](fuzz.md) agrees with the truth about every scene of convex blocks but the first twelve, which
are nearer to their limits than it can tell (`tests/hard`).""",
    CASES,
    FIGURES,
)
