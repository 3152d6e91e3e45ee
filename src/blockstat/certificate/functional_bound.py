"""What a motion proves that a linear functional of the contact forces does not exceed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blockstat.certificate.check import opening_slack
from blockstat.certificate.interior_motions import least_slack
from blockstat.program.penalty import PenaltyProgram
from blockstat.typing import Floats


def value_bound(
    program: PenaltyProgram, functional: Floats, twist: Floats, total: float, motions: Sequence[Floats]
) -> float:
    """Return what a motion proves that a functional does not exceed.

    Parameters
    ----------
    program : PenaltyProgram
        The program.
    functional : array of float, shape (3 m,)
        Its row c.
    twist : array of float, shape (6 n,)
        The motion u.
    total : float
        What contact forces add up to at most, if some joint still closes.
    motions : sequence of array, shape (6 n,)
        Twists that may open every joint.

    Returns
    -------
    float
        In the units of the program, the shift of joint laws included.

    Notes
    -----
    For A'u - c in K*, forces in balance have c'f <= (A'u)'f = -w'u. Bounds of single forces are bought as in
    `blockstat.certificate.check.power`. Where a joint closes by v, the contact forces add at most their total times v;
    or a motion that opens every joint is added to the twist.
    """
    twists = [twist]
    closing = float(np.maximum(-_rates(program, functional, twist)[0], 0.0).max(initial=0.0))
    for motion in motions:
        least = least_slack(program, motion)
        if least > 0:
            twists.append(twist + closing / least * motion)
    return min(_bound(program, functional, moved, total) for moved in twists)


def _bound(program: PenaltyProgram, functional: Floats, twist: Floats, total: float) -> float:
    """As `value_bound`, for one motion and contact forces that add up to so much."""
    slack, rate = _rates(program, functional, twist)
    bought, no_slip = np.isfinite(program.upper), np.isinf(program.friction)
    opening = np.where(no_slip, rate[:, 0], slack)
    price = np.where(bought, program.upper, 0.0) @ np.maximum(-opening, 0.0)
    gain = program.lower @ np.maximum(slack, 0.0)
    slide = np.where(no_slip, np.hypot(rate[:, 1], rate[:, 2]), 0.0)
    violation = float(np.where(bought, slide, np.maximum(-slack, 0.0)).max(initial=0.0))
    return float(price - gain - program.load @ twist) + total * violation


def _rates(program: PenaltyProgram, functional: Floats, twist: Floats) -> tuple[Floats, Floats]:
    """The slack of the opening of each point under A'u - c, shape (m,), and these rates, shape (m, 3)."""
    rate = (program.matrix.T @ twist - functional).reshape(-1, 3)
    return opening_slack(rate, program.friction), rate
