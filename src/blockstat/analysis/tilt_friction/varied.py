"""A problem of which one parameter varies, and what a reader must know of its bracket."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from blockstat.analysis.assess import judged
from blockstat.analysis.coulomb import FAMILY
from blockstat.analysis.problem import Problem, pose, with_joints
from blockstat.analysis.reserve import doubtful_joints, moved, resting_warning
from blockstat.analysis.rims import gap_warnings
from blockstat.analysis.tilt_friction.bisection import Answer
from blockstat.analysis.tilt_friction.bracket import Bracket
from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.contact.interfaces import Interfaces
from blockstat.loads import Loads

if TYPE_CHECKING:
    from blockstat.assembly import Assembly


class Varied(NamedTuple):
    """A problem of which one parameter varies."""

    problem: Problem
    at: Callable[[Assembly, float], Assembly]  #: the assembly at a value
    loads: Loads | None
    solver: str
    flow: str

    def judge(self, value: float, kinds: Sequence[tuple[float, float]] = FAMILY) -> Verdict:
        """Return the verdict at a value.

        Parameters
        ----------
        value
            Of the parameter.
        kinds
            As of `blockstat.analysis.assess.judged`.

        Returns
        -------
        Verdict
            Without the doubtful joints that it rests on.
        """
        own, there = self.problem, self.at(self.problem.assembly, value)
        problem = pose(there, friction=None, gravity=None, loads=self.loads, gap=own.gap, interfaces=own.given)
        return judged(problem, loads=self.loads, solver=self.solver, flow=self.flow, reserve=False, kinds=kinds)

    def answer(self, value: float) -> Answer:
        """Return the outcome and the score at a value.

        Parameters
        ----------
        value
            Of the parameter.

        Returns
        -------
        tuple
            As a bisection asks for.
        """
        found = self.judge(value)
        return found.outcome, found.score

    def decided(self, kind: tuple[float, float]) -> Callable[[float], Answer]:
        """Return what answers without dilatancy: no state found is none, and no score leads to the limit.

        Parameters
        ----------
        kind
            Of joints.

        Returns
        -------
        callable
            Gives the answer at a value.
        """
        none = {Outcome.UNDECIDED: Outcome.STABLE_ONLY_BY_SELF_STRESS}
        return lambda value: (none.get(outcome := self.judge(value, [kind]).outcome, outcome), math.nan)


def with_warnings(varied: Varied, bracket: Callable[[Varied], Bracket], *more: str) -> Bracket:
    """Return a bracket with what its reader must know of the joints; of near ones where the assembly does not stand.

    Parameters
    ----------
    varied
        The problem.
    bracket
        Finds the bracket of a problem.
    *more
        Further warnings.

    Returns
    -------
    Bracket
        With warnings.
    """
    problem, found = varied.problem, replace(bracket(varied), flow=varied.flow)
    nowhere = math.isnan(stands := found.stands)
    options: dict[str, Any] = {"loads": varied.loads, "solver": varied.solver, "reserve": False}
    motion = judged(problem, **options).mechanism if nowhere else None
    told = [*problem.warnings, *gap_warnings(problem, more_may_help=nowhere, mechanism=motion), *more]
    if nowhere or not doubtful_joints(problem, None).steps:
        return replace(found, warnings=tuple(told))
    tilts, room = found.parameter == "tilt", float(np.nan_to_num(abs(found.falls - stands)))
    # Forces at two tilts that are less than half a turn apart add up to those at each between them.
    verdicts = [varied.judge(value) for value in ((0.0, stands) if tilts else (stands,))]
    known = stands < 180.0 and all(verdict.outcome is Outcome.STABLE for verdict in verdicts)

    def again(joints: Interfaces) -> float | None:
        bare = bracket(varied._replace(problem=with_joints(problem, joints, varied.loads))).stands
        return None if math.isnan(bare) else bare

    told += resting_warning(
        problem, np.sum([np.abs(own.forces) for own in verdicts], axis=0) if known else None, stands, again,
        f"it stands up to {stands:.6g} deg" if tilts else f"a friction of {stands:.6g} is enough",
        worse=lambda bare, last: (bare < last if tilts else bare > last) and moved(bare, last, room),
        words=lambda bare: f"it is {bare:.6g} deg" if tilts else f"it is {bare:.6g}",
    )  # fmt: skip
    return replace(found, warnings=tuple(told))
