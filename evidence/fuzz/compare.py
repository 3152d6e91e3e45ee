"""Verdicts of the statics against the judge, one scene after another."""

from __future__ import annotations

import traceback
import warnings
from dataclasses import dataclass, replace
from enum import Enum
from time import process_time

import numpy as np

from blockstat import InputError, assess
from evidence.fuzz.generate import FINE, UTM, place, scene, shuffled
from evidence.fuzz.judge import NEAR, Judgement, Truth, choices, decide, judge, near_limit
from evidence.fuzz.programs import LACK, Points
from evidence.fuzz.scene import Place, Scene


class Category(Enum):
    """How a verdict compares with the truth."""

    RIGHT = "right"
    WRONG_STABLE = "wrong stable"
    WRONG_UNSTABLE = "wrong unstable"
    CRASH = "crash"
    REFUSED = "refused"
    UNFOUNDED = "decided without a normal"
    UNDECIDED = "undecided otherwise"
    AT_LIMIT = "undecided within 1e-6 of the limit"
    NO_NORMAL = "undecided for lack of a normal"
    TOLERANCE = "hangs on a tolerance"
    UNJUDGED = "not judged"
    VARIES = "varies with the place"


FAILURES = (
    Category.WRONG_STABLE, Category.WRONG_UNSTABLE, Category.CRASH, Category.REFUSED, Category.UNFOUNDED,
    Category.UNDECIDED, Category.VARIES,
)  # fmt: skip


@dataclass(frozen=True)
class Result:
    """One scene: what was said, what is true, and how long both took."""

    seed: int
    family: str
    category: Category
    word: str
    truth: Truth
    lack: float
    note: str
    product_time: float
    judge_time: float

    @property
    def fails(self) -> bool:
        """Whether it counts against the statics."""
        return self.category in FAILURES


def compared(seed: int, *, places: bool = False) -> Result:
    """Judge the scene of a seed and compare; places : also at other places and in another order."""
    found = scene(seed)
    begin = process_time()
    judgement = judge(found)
    middle = process_time()
    word, note = verdict(found)
    end = process_time()
    category = compare(found, judgement, word)
    if category is Category.RIGHT and places:
        other = [f"{name}: {answer}" for name, answer in elsewhere(found, seed) if answer != word]
        if other and not near_limit(judgement, NEAR):
            category, note = Category.VARIES, "; ".join(other)
    return Result(
        seed, found.family, category, word, judgement.truth, judgement.lack, note, end - middle, middle - begin
    )


def verdict(found: Scene) -> tuple[str, str]:
    """The word of the statics, and the first thing that they say beside it."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            answer = assess(found.assembly())
        except InputError as error:
            return "refused", str(error)
        except Exception:
            return "crash", traceback.format_exc().strip().splitlines()[-1]
    told = [text for text in answer.warnings if answer.outcome.word == "undecided"]
    return answer.outcome.word, told[0] if told else f"needs {answer.certificate.required_force:.3g} weights"


def elsewhere(found: Scene, seed: int) -> list[tuple[str, str]]:
    """The words for the same scene in another order, turned, scaled, and far from the origin."""
    random = np.random.default_rng([seed, 1])
    far = replace(found, place=replace(found.place, scale=1.0, shift=UTM))
    others = [
        ("another order", shuffled(found, random)),
        ("turned", replace(found, place=Place(place(random, far=False).turn, found.place.scale))),
        ("scaled", replace(found, place=Place(found.place.turn, float(10.0 ** random.uniform(-3, 3))))),
    ]
    if found.family not in FINE:
        others.append(("far away", far))
    return [(name, verdict(other)[0]) for name, other in others]


def compare(found: Scene, judgement: Judgement, word: str) -> Category:
    """What a word of the statics is worth."""
    if word in ("crash", "refused"):
        return Category.CRASH if word == "crash" else Category.REFUSED
    truth, undecided = judgement.truth, word == "undecided"
    if truth is Truth.UNSURE:
        return Category.UNJUDGED
    if truth is Truth.TOLERANCE:
        return Category.TOLERANCE
    if truth is Truth.NORMAL:
        return Category.NO_NORMAL if undecided else Category.UNFOUNDED
    if truth is Truth.LIMIT:
        return Category.AT_LIMIT if undecided else Category.RIGHT
    if word.startswith("stable" if truth is Truth.STABLE else "unstable"):
        return Category.RIGHT
    if undecided and judgement.passes:
        return Category.NO_NORMAL
    if _within_gaps(found, judgement, word):
        return Category.TOLERANCE
    if near_limit(judgement, NEAR if undecided else LACK):
        return Category.AT_LIMIT if undecided else Category.RIGHT
    if undecided:
        return Category.UNDECIDED
    return Category.WRONG_UNSTABLE if truth is Truth.STABLE else Category.WRONG_STABLE


def _within_gaps(found: Scene, judgement: Judgement, word: str) -> bool:
    """Whether the answer is another with the points on one side of open joints or on the other."""
    if max((abs(touch.gap) for touch in judgement.touches), default=0.0) < 1e-9:
        return False
    used = [t for t in judgement.touches if t.certain]
    if judgement.truth is Truth.UNSTABLE:
        used = next(choices(judgement.touches))
    for side in (-0.5, 0.5):
        moved = [replace(t, points=t.points + side * t.gap * t.normal) for t in used]
        truth = decide(Points.of(found, moved))[0]
        if truth is not judgement.truth or word.startswith(truth.name.lower()):
            return True
    return False
