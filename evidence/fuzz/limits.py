"""Limit loads of random scenes between what polygons inside and outside the cones carry."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, replace

import numpy as np
from scipy.optimize import linprog
from scipy.sparse import csc_matrix, hstack

from blockstat import InputError, limit_load
from evidence.fuzz.generate import scene
from evidence.fuzz.judge import Truth, judge
from evidence.fuzz.programs import Points
from evidence.fuzz.solids import Array

SIDES = 64
MANY = 1e5  #: a multiplier that counts as unbounded
AGREES = 1e-6  #: of the multiplier, and of the weight


@dataclass(frozen=True)
class Limit:
    """One limit load by both."""

    seed: int
    family: str
    inner: float
    outer: float
    lower: float
    upper: float
    word: str

    @property
    def fails(self) -> bool:
        """Whether the bracket of the statics and that of the judge exclude one another, or there is none."""
        if self.word == "dead_load_unstable":
            return self.outer > AGREES  # else the scene is at its limit without the load
        if self.word not in ("limit", "unbounded"):
            return True
        if self.word == "unbounded":
            return self.outer < MANY
        slack = AGREES * (1 + abs(self.outer))
        return self.lower > self.outer + slack or (self.upper < self.inner - slack and self.inner < MANY)


def limit(seed: int) -> Limit | None:
    """The limit load of a seed in a random level direction; None where the scene does not surely stand."""
    found = scene(seed)
    judgement = judge(found)
    if judgement.truth is not Truth.STABLE or not all(t.certain for t in judgement.touches):
        return None
    angle = np.random.default_rng([seed, 2]).uniform(0, 2 * np.pi)
    level = np.array([np.cos(angle), np.sin(angle), 0.0])
    around = 2 * np.pi * np.arange(SIDES) / SIDES
    points = Points.of(found, judgement.touches)
    points = replace(points, angles=(around,) * len(points.point))
    inner, outer = (carried(points, level, outer=outer) for outer in (False, True))
    lower = upper = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            answer = limit_load(found.assembly(), (found.place.turn @ level).tolist())
            word, lower, upper = answer.outcome.word, answer.lower, answer.upper
        except InputError:
            word = "refused"
        except Exception as error:
            word = f"crash: {error!r}"
    return Limit(seed, found.family, inner, outer, lower, upper, word)


def carried(points: Points, direction: Array, *, outer: bool) -> float:
    """The largest multiple of the weight in a direction that forces in the polygons balance."""
    live = np.tile(np.concatenate([direction, np.zeros(3)]), len(points.free))
    rays = points.rays(outer=outer)
    whole = hstack([points.matrix @ rays, csc_matrix(live[:, None])], format="csc")
    cost = np.zeros(whole.shape[1])
    cost[-1] = -1.0
    options = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
    bounds = [(0, None)] * rays.shape[1] + [(None, MANY)]
    found = linprog(cost, A_eq=whole, b_eq=-points.load, bounds=bounds, method="highs-ds", options=options)
    return float(-found.fun) if found.x is not None else (-np.inf if not outer else np.inf)
