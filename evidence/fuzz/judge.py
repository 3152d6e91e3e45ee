"""The judge: whether a scene surely stands, surely falls, or is too close, and what that hangs on.

Surely stable: with the certain contacts alone, forces inside the exact cones and of bounded size balance every block.
Surely unstable: a mechanism that keeps all possible contacts is driven by the loads. Two edges or corners without a
normal of their own only keep each other apart: they pass each other if the motion opens them along one of the normals
that separate them, and do not resist it then. So one of their normals is chosen, without friction, and each choice is
tried. Nothing lies between but scenes that hang on such a contact, on a tolerance, or on the last digits.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from enum import Enum
from itertools import islice, product

import numpy as np

from evidence.fuzz.programs import Answer, Points, least_lack
from evidence.fuzz.scene import Scene
from evidence.fuzz.touch import Touch, touches

MOST = 64  #: choices of normals that are tried
ROUNDS = 6  #: refinements of the friction polygons
MODEST, LARGE = 1e3, 1e5  #: forces that are tried, in weights of all free blocks
NEAR = 1e-6  #: of each block's weight: loads that differ by less are the limit itself


class Truth(Enum):
    """What the judge says of a scene."""

    STABLE = "surely stable"
    UNSTABLE = "surely unstable"
    LIMIT = "near its limit"
    NORMAL = "hangs on a contact without a normal"
    TOLERANCE = "hangs on a tolerance"
    UNSURE = "the judge's numbers decide nothing"


@dataclass(frozen=True)
class Judgement:
    """What is known of a scene."""

    truth: Truth
    lack: float  #: unbalanced load with the contacts that decided, in weights of the blocks
    touches: list[Touch]
    points: Points  #: of the contacts that decided
    passes: bool = False  #: blocks fall past one another at contacts without a normal of their own


def judge(scene: Scene) -> Judgement:
    """Decide a scene."""
    found = touches(scene)
    certain = Points.of(scene, [t for t in found if t.certain])
    sure = decide(certain)
    if sure[0] is Truth.STABLE or all(t.certain for t in found):
        return Judgement(*sure[:2], found, sure[2])
    tried = [sure]
    for chosen in choices(found):
        tried.append(decide(Points.of(scene, chosen)))
        if tried[-1][0] is Truth.UNSTABLE:
            return Judgement(*tried[-1][:2], found, tried[-1][2], any(not t.unique for t in found))
    if hangs_on_a_tolerance(scene, found):
        return Judgement(Truth.TOLERANCE, sure[1], found, sure[2])
    loose = any(not t.unique for t in found)
    for truth, lack, points in tried:
        if truth in (Truth.UNSURE, Truth.LIMIT):
            return Judgement(truth, lack, found, points)
    return Judgement(Truth.NORMAL if loose else Truth.TOLERANCE, sure[1], found, sure[2])


def hangs_on_a_tolerance(scene: Scene, found: list[Touch]) -> bool:
    """Whether a scene stands or falls as soon as the contacts near a tolerance are, or are not, there."""
    if all(t.certain for t in found if t.unique):
        return False
    if decide(Points.of(scene, [t for t in found if t.unique]))[0] is Truth.STABLE:
        return True
    without = [t for t in found if t.certain or not t.unique]
    return any(decide(Points.of(scene, chosen))[0] is Truth.UNSTABLE for chosen in choices(without))


def choices(found: list[Touch]) -> Iterator[list[Touch]]:
    """All possible contacts, those of each rim with one of its normals; the first few where there are many."""
    rims: dict[tuple[int, ...], list[Touch]] = {}
    for touch in found:
        if not touch.unique:
            rims.setdefault(touch.rim, []).append(touch)
    unique = [touch for touch in found if touch.unique]
    for chosen in islice(product(*rims.values()), MOST):
        yield [*unique, *chosen]


def decide(points: Points) -> tuple[Truth, float, Points]:
    """Stable or unstable with these contacts, by polygons that are refined until they tell."""
    outer = Answer(np.inf, np.empty((0, 3)), False, False)
    for _ in range(ROUNDS):
        if least_lack(points, outer=False, most=MODEST).stands:
            return Truth.STABLE, 0.0, points
        outer = least_lack(points, outer=True)
        if outer.falls:
            return Truth.UNSTABLE, outer.lack, points
        inner = least_lack(points, outer=False, most=LARGE)
        if inner.stands:
            return Truth.STABLE, 0.0, points
        if np.isin(points.friction, (0.0, np.inf)).all() or not np.isfinite(outer.lack + inner.lack):
            break
        points = points.refined(outer.force).refined(inner.force)
    near = outer.lack <= NEAR
    return (Truth.LIMIT if near else Truth.UNSURE), outer.lack, points


def near_limit(judgement: Judgement, distance: float, *, trials: int = 4) -> bool:
    """Whether loads that differ by so many weights of each block change the answer.

    They are tried in random directions and their opposites: the answer of a block balanced on an edge changes in one of
    the two, however small they are.
    """
    points = judgement.points
    if judgement.truth is Truth.UNSTABLE:
        return judgement.lack <= distance
    random = np.random.default_rng(0)
    for _ in range(trials):
        shift = distance * random.choice([-1.0, 1.0], len(points.load))
        for sign in (1.0, -1.0):
            if least_lack(points, outer=True, shift=sign * shift).falls:
                return True
            if not least_lack(points, outer=False, shift=sign * shift).lack < distance / 10:
                return True
    return False
