"""The independent check of answers that rest on verdicts and limit loads: domains, settlements, ties, trains, plans.

Balance, cones and velocities are those of `evidence.checks.independent`. A claim without evidence of its own, a corner
of a domain or a bracket of a train, is asked again as a verdict, whose evidence is checked.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import blockstat
from blockstat.result import Unfinished
from evidence.checks import independent
from evidence.checks.strength import bond_laws, strengths, taken_up, tie_wrenches, ties_taken_up

NEAR = 1e-4  #: verdicts are asked for so far on either side of a limit, relative to it
TOUCH = 1e-5  #: of its distance from the origin, how far a half-plane may pass from its corner
WORK = 1e-5  #: of the forces times the speed, what settling joints may take up more than they do


def check_domain(found, asm, one, two, *, loads=None, faces=None):
    """Raise AssertionError unless corners of the inner polygon are carried, and what is beyond a half-plane is not."""
    first, second = (independent.live_load(asm, load) for load in (one, two))
    dead = 0.0 if loads is None else np.asarray(loads, dtype=float)

    def outcome(x, y):
        return blockstat.assess(asm, loads=dead + x * first + y * second, interfaces=faces).outcome.word

    reach = np.linalg.norm(found.inner, axis=1)
    angle = 2 * np.pi * np.arange(len(reach)) / len(reach)
    rays = np.column_stack([np.cos(angle), np.sin(angle)])
    assert np.abs(found.inner - reach[:, None] * rays).max() <= 1e-9 * reach.max(), "a corner lies on no ray"
    distance = found.outer[:, 2] - np.einsum("ij,ij->i", found.outer[:, :2], found.inner)
    scale = np.linalg.norm(found.outer[:, :2], axis=1) * reach
    assert (np.abs(distance) <= TOUCH * scale + 1e-12).all(), "a half-plane does not pass through its corner"
    inside = found.outer[:, :2] @ found.inner.T - found.outer[:, 2:]
    assert (inside <= TOUCH * scale.max()).all(), "a corner lies beyond a half-plane"
    for x, y in found.inner:
        assert outcome((1 - NEAR) * x, (1 - NEAR) * y) == "stable", "a corner is not carried"
    for (a, b, _), (x, y), size in zip(found.outer, found.inner, reach, strict=True):
        normal = np.array([a, b]) / np.hypot(a, b)
        along = np.array([-normal[1], normal[0]])
        for step in (-0.1, 0.0, 0.1):
            place = np.array([x, y]) + size * (NEAR * normal + step * along)
            assert outcome(*place) != "stable", "a load beyond a half-plane is carried"


def check_settlement(found, *, loads=None):
    """Raise AssertionError unless forces balance, joints open as the motion says, and no force resists its joint.

    The motion that begins is the one of least potential energy: forces and rates are then a pair of the flow rule.
    """
    asm, faces = found.assembly, found.interfaces
    wrench, centroid = independent.dead_load(asm, loads)
    independent.check_forces(asm, faces, wrench, centroid, found.forces, found.bonds, ties=found.ties)
    assert found.bonds is not None or not bond_laws(asm, faces), "nothing is said of the bonds"
    k = faces.point_interface
    velocity = np.zeros((2, len(k), 3))
    for side in (0, 1):
        block = faces.pair[k, side]
        velocity[side] = found.mechanism[block, :3]
        velocity[side] += np.cross(found.mechanism[block, 3:], faces.point - centroid[block])
        for part in found.foundations:
            own = np.isin(k, part.joints) & asm.support[block]
            velocity[side, own] = part.displacement
    rate = np.einsum("nij,nj->ni", faces.frame[k], velocity[1] - velocity[0])
    power, closing = taken_up(strengths(asm, faces), rate)
    work = np.einsum("ni,ni->n", found.forces, rate)
    # Supports that hold ties only move no joint.
    speed = max(np.abs(velocity).max(initial=0.0), np.abs(found.mechanism[:, :3]).max(initial=0.0))
    scale = np.linalg.norm(found.forces, axis=1).sum() * speed
    tied, ties, scale = _between_blocks(asm, found.ties, scale, speed)
    assert closing.max(initial=0.0) <= WORK * speed, "a joint closes"
    # Each term is at least 0: it is the most that the joint may take up, less what it does.
    assert (power + work).sum() <= WORK * scale, "a force resists the motion of its joint"
    pull = tie_wrenches(tied, centroid, ties, None)
    taken, given = ties_taken_up(tied, centroid, found.mechanism)
    assert given <= WORK * speed, "a tie without a greatest force gives way"
    assert abs(taken + (pull * found.mechanism).sum()) <= WORK * scale, "a tie yields at another force than its bounds"
    push = np.zeros((faces.n_interfaces, 3))  # of block a on block b
    np.add.at(push, k, np.einsum("nij,ni->nj", faces.frame[k], found.forces))
    if found.bonds is not None:
        np.add.at(push, found.bonds.interface, found.bonds.force)
    done = float((pull * found.mechanism)[asm.support].sum())
    for side, sign in ((0, -1.0), (1, 1.0)):
        fixed = asm.support[faces.pair[:, side]]  # which do not turn: one velocity at all points of a joint
        done += sign * float((push * velocity[side, faces.start[:-1]])[fixed].sum())
    np.testing.assert_allclose(found.reaction * found.displacement, done, atol=1e-8 * scale)
    for part in found.foundations:
        pair = faces.pair[part.joints]
        moved = np.unique(pair[asm.support[pair]])
        if not len(part.joints):
            moved = np.array([asm.names.index(part.name.strip('"'))])  # ties alone hold on to it
        whole = moved[found.mechanism[moved].any(axis=1)]  # carry the ends of their ties
        held = np.where(asm.support[pair[:, 1]], 1.0, -1.0) @ push[part.joints] + pull[whole, :3].sum(axis=0)
        np.testing.assert_allclose(part.reaction, held, atol=1e-9 * scale / speed)


def _between_blocks(asm, ties, scale, speed):
    """The assembly without the ties that act on supports alone, the forces of the others, and these in the scale."""
    if not asm.ties:
        return asm, None, scale
    number = {name: block for block, name in enumerate(asm.names)}
    acts = np.array([not all(asm.support[number.get(b, b)] for b in tie.between) for tie in asm.ties])
    kept = tuple(tie for tie, own in zip(asm.ties, acts.tolist(), strict=True) if own)
    return replace(asm, ties=kept), np.asarray(ties)[acts], scale + speed * float(np.asarray(ties)[acts].sum())


def check_tie_range(found, *, faces, loads=None):
    """Raise AssertionError unless forces prove that the assembly stands at both ends of the range of a tie."""
    asm = found.assembly
    wrench, centroid = independent.dead_load(asm, loads)
    assert found.least <= found.greatest
    assert found.tie in asm.ties, "another tie"
    for force, forces in ((found.least, found.least_forces), (found.greatest, found.greatest_forces)):
        if np.isfinite(force):
            assert len(asm.ties) == 1, "with several ties the range does not say what the others carry"
            independent.check_forces(asm, faces, wrench, centroid, forces, ties=[force])


def check_moving_load(found, *, loads=None, faces=None):
    """Raise AssertionError unless the train at its worst place is carried just below its bracket and not above."""
    k = found.worst
    assert found.upper[k] == found.upper.min()
    assert (found.lower <= found.upper * (1 + 1e-9)).all()
    if not np.isfinite(found.upper[k]):
        return
    wrench, _ = independent.dead_load(found.assembly, loads)
    rate = (found.load * found.mechanism).sum()
    assert rate > 0, "the train does not drive the mechanism"
    np.testing.assert_allclose(-(wrench * found.mechanism).sum() / rate, found.upper[k], rtol=1e-4)
    for multiplier, carried in ((found.lower[k] * (1 - NEAR), True), (found.upper[k] * (1 + NEAR), False)):
        total = multiplier * found.load + (0.0 if loads is None else loads)
        verdict = blockstat.assess(found.assembly, loads=total, interfaces=faces)
        assert (verdict.outcome.word == "stable") == carried, "the bracket of the worst place is wrong"


def check_plan(found):
    """Raise AssertionError unless the verdict on each step of a plan is proven and the outcome follows from them.

    Props may hold a step that does not stand without them; their forces are not checked here.
    """
    for k, (verdict, outcome) in enumerate(zip(found.verdicts, found.outcomes, strict=True)):
        independent.check_verdict(verdict)
        if found.falsework and found.falsework[k] is not None:
            assert verdict.outcome.word != "stable"
        else:
            assert outcome is verdict.outcome
    falls = [outcome for outcome in found.outcomes if outcome.word != "stable"]
    assert found.outcome is (falls[0] if falls else Unfinished.STOPPED if found.missing else found.outcomes[0])


def install():
    """Put the checks that cost little behind the functions, as `evidence.checks.independent.install` does."""
    independent.install_all(
        {
            "settlement": lambda found, given: check_settlement(found, loads=given.get("loads")),
            "settle": lambda found, given: check_settlement(found, loads=given.get("loads")),
            "assess_plan": lambda found, given: check_plan(found),
            "load_domain": _domain,
            "moving_load": lambda found, given: check_moving_load(found, loads=given.get("loads"), faces=_faces(given)),
            "tie_range": _tied,
        }
    )


def _faces(given):
    return given.get("interfaces")


def _domain(found, given):
    changes = {name: given[name] for name in ("friction", "gravity") if given.get(name) is not None}
    asm = given["assembly"].with_(**changes) if changes else given["assembly"]
    check_domain(found, asm, given["one"], given["two"], loads=given.get("loads"), faces=_faces(given))


def _tied(found, given):
    asm = found.assembly
    if len(asm.ties) == 1:  # of several the range does not say what the others carry
        faces = blockstat.find_interfaces(asm, gap=given.get("gap", independent.GAP))
        check_tie_range(found, faces=faces if _faces(given) is None else _faces(given), loads=given.get("loads"))
