"""Joint laws from first principles for the second opinion: what a contact point and a bond may carry and take up.

Of `blockstat` only the laws themselves and the fit of names to groups are used.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from blockstat.contact.point_law import last_law


class Strength(NamedTuple):
    """At each contact point: |f_t| <= mu f_n + cohesion, -tension <= f_n <= cap."""

    mu: np.ndarray
    cohesion: np.ndarray
    tension: np.ndarray
    cap: np.ndarray


def strengths(asm, faces):
    """The strength of every contact point, shape (n_points,)."""
    k = faces.point_interface
    share = faces.point_share
    rows = []
    for i, law in enumerate(last_law(asm, faces)):
        if law is not None and faces.area[i]:
            _check_shares(faces, i, share[faces.start[i] : faces.start[i + 1]])
        if law is None:
            rows.append((friction_of(asm, faces, i), 0.0, 0.0, np.inf))
            continue
        mu = friction_of(asm, faces, i)
        area = faces.area[i]
        tension = law.tension * area + (law.bond if law.bond_moment is None and area else 0.0)
        cohesion = np.nan if law.cohesion is None else law.cohesion * area
        if np.isnan(cohesion):
            cohesion = mu * tension if np.isfinite(mu) else np.inf * tension if tension else 0.0
        elif np.isfinite(mu):
            tension = min(tension, cohesion / mu)
        cap = np.inf if law.compression is None else law.compression * area
        rows.append((mu, cohesion, tension, cap))
    table = np.array(rows).reshape(-1, 4)[k].T
    columns = (np.nan_to_num(column, nan=0.0, posinf=np.inf) for column in table[1:])
    return Strength(table[0], *(np.where(np.isinf(c), np.inf, share * np.where(np.isinf(c), 0.0, c)) for c in columns))


def _check_shares(faces, interface, share):
    """Raise AssertionError unless uniform stress on a joint has the resultant of its shares at the contact points."""
    points = faces.point[faces.start[interface] : faces.start[interface + 1]]
    assert (share >= 0).all(), "a point stands for less than no area"
    assert abs(share.sum() - 1) < 1e-9, "the points stand for more or less than the area"
    away = np.linalg.norm(share @ (points - points[0]) - (_centroid(faces, interface) - points[0]))
    assert away <= 1e-6 * np.linalg.norm(np.ptp(points, axis=0)), "uniform stress has another arm"


def friction_of(asm, faces, interface):
    """The friction of one joint: its own, that of the last fitting law, or the assembly's where this gives none."""
    if faces.friction is not None:
        return faces.friction[interface]
    groups = [asm.groups[b] for b in faces.pair[interface]]

    def fits(name, group):
        return name in ("*", group) or group.startswith(name + ".")

    mu = asm.friction
    for law in asm.joints:
        one, two = law.between
        if any(fits(one, a) and fits(two, b) for a, b in (groups, groups[::-1])):
            mu = asm.friction if law.friction is None else law.friction
    return mu


def check_points(strength, forces, spare):
    """Raise AssertionError for a contact force beyond its strength by more than `spare`."""
    mu, cohesion, tension, cap = strength
    normal, tangent = forces[:, 0], np.hypot(forces[:, 1], forces[:, 2])
    assert (normal >= -tension - spare).all(), "a joint pulls"
    assert (normal <= cap + spare).all(), "a joint is crushed"
    with np.errstate(invalid="ignore"):
        unbounded = np.where(normal + tension > 0, np.inf, spare)
        grip = np.where(np.isinf(mu), unbounded, mu * (normal + spare) + cohesion + 1e-6 * spare)
    assert (tangent <= grip).all(), "friction beyond its cone"


def taken_up(strength, rate):
    """Power that cohesion, tension and crushing take up at each point, and what is left of the closing there.

    The greatest -f.g over the admissible forces f of a point that moves at g; without a cap a closing is a violation.
    """
    mu, cohesion, tension, cap = strength
    slide = np.hypot(rate[:, 1], rate[:, 2])
    sticky = np.isinf(mu)
    room = np.where(sticky, rate[:, 0], rate[:, 0] - np.where(sticky, 0.0, mu) * slide)
    # With infinite friction the cone has its apex at the tension: what slides there is a violation, not a price.
    shear = np.where(sticky, 0.0, np.where(sticky, 0.0, cohesion) * slide)
    power = shear + tension * np.maximum(room, 0.0)
    crushed = np.isfinite(cap) & (room < 0)
    power = power + np.where(crushed, np.where(np.isfinite(cap), cap, 0.0) * np.maximum(-room, 0.0), 0.0)
    closing = np.where(crushed, 0.0, np.maximum(-room, 0.0)) + np.where(sticky, slide, 0.0)
    return power, closing


def bond_laws(asm, faces):
    """Joints with a bond at their centre: (interface, centre, force, moment capacity)."""
    found = []
    for i, law in enumerate(last_law(asm, faces)):
        if faces.area[i] and law is not None and law.bond_moment is not None and (law.bond or law.bond_moment):
            found.append((i, _centroid(faces, i), law.bond, law.bond_moment))
    return found


def _centroid(faces, interface):
    """Centroid of a joint: of its cells, of the patches it is made of, or of its outline."""
    own = slice(faces.start[interface], faces.start[interface + 1])
    corners, normal = faces.point[own], faces.frame[interface, 0]
    if faces.share is not None or len(corners) < 3:
        share = np.full(len(corners), 1 / len(corners)) if faces.share is None else faces.share[own]
        return share @ corners
    outlines = [corners]
    if (patches := faces.patches) is not None:
        first = np.cumsum(patches.count) - patches.count
        found = [
            patches.origin[i] + patches.corner[first[i] : first[i] + patches.count[i]] @ patches.frame[i, 1:]
            for i in np.flatnonzero((patches.pair == faces.pair[interface]).all(axis=1))
        ]
        level = 1e-9 + faces.gap[interface] + 1e-15 * np.abs(corners).max()
        outlines = [x for x in found if np.abs((x - corners[0]) @ normal).max() <= level] or outlines
    moments = [_moments(outline, faces.frame[interface]) for outline in outlines]
    return sum(first for _, first in moments) / sum(area for area, _ in moments)


def _moments(corners, frame):
    """Area of a convex polygon and its first moment, from the triangles about the mean of its corners."""
    middle = corners.mean(axis=0)
    arm = corners - middle
    arm = arm[np.argsort(np.arctan2(arm @ frame[2], arm @ frame[1]))]
    after = np.roll(arm, -1, axis=0)
    area = np.cross(arm, after) @ frame[0] / 2
    return area.sum(), area.sum() * middle + (area[:, None] * (arm + after)).sum(axis=0) / 3


def check_bonds(asm, faces, bonds, spare):
    """Raise AssertionError for bonds beyond their capacity; what each does to its block b."""
    laws = {i: (centre, force, moment) for i, centre, force, moment in bond_laws(asm, faces)}
    if bonds is None:
        return []
    wrenches = []
    for i, push, turn in zip(bonds.interface, bonds.force, bonds.moment, strict=True):
        centre, force, moment = laws[int(i)]
        frame = faces.frame[i]
        slack = 1e-9 * (force + moment) + spare
        assert -force - slack <= frame[0] @ push <= slack, "a bond pulls too hard, or pushes"
        assert np.hypot(*(frame[1:] @ push)) <= force + slack, "a bond shears too hard"
        assert np.hypot(*(frame[1:] @ turn)) <= moment + slack, "a bond bends too hard"
        assert abs(frame[0] @ turn) <= moment + slack, "a bond twists too hard"
        wrenches.append((int(i), centre, push, turn))
    return wrenches


def tie_ends(asm, centroid):
    """Of each tie its two blocks, the arms of its ends on them, and the unit vector from the first to the second."""
    for tie in asm.ties:
        blocks = [asm.names.index(b) if b in asm.names else int(b) for b in tie.between]
        ends = np.asarray(tie.points, dtype=float)
        along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
        yield tie, blocks, [end - centroid[b] for end, b in zip(ends, blocks, strict=True)], along


def constant_ties(asm):
    """The force of each tie whose force is given, which is a load, and 0 of the others."""
    return [tie.least if tie.least == tie.greatest else 0.0 for tie in asm.ties]


def tie_wrenches(asm, centroid, forces, spare):
    """The wrench of the ties on each block; raises AssertionError for one out of its bounds by more than `spare`."""
    wrench = np.zeros((asm.n_blocks, 6))
    if not asm.ties:
        return wrench
    assert forces is not None, "nothing is said of the ties"
    for (tie, blocks, arms, along), force in zip(tie_ends(asm, centroid), forces, strict=True):
        assert spare is None or tie.least - spare <= force <= tie.greatest + spare, "a tie beyond its bounds"
        for block, arm, sign in zip(blocks, arms, (1.0, -1.0), strict=True):
            pull = (-sign if tie.strut else sign) * force * along
            wrench[block] += np.concatenate([pull, np.cross(arm, pull)])
    return wrench


def ties_taken_up(asm, centroid, motion):
    """Power that the ties take up, and the largest rate at which one without a greatest force gives way."""
    power, given = 0.0, 0.0
    for tie, blocks, arms, along in tie_ends(asm, centroid):
        first, second = (motion[b, :3] + np.cross(motion[b, 3:], arm) for b, arm in zip(blocks, arms, strict=True))
        longer = (second - first) @ along * (-1.0 if tie.strut else 1.0)
        if longer <= 0:
            power += tie.least * longer
        elif np.isfinite(tie.greatest):
            power += tie.greatest * longer
        else:
            given = max(given, longer)
    return power, given


def bonds_taken_up(asm, faces, centroid, motion):
    """Power that the bonds at the centres of joints take up."""
    power = 0.0
    for i, centre, force, moment in bond_laws(asm, faces):
        a, b = faces.pair[i]
        velocity, turning = np.zeros(3), motion[b, 3:] - motion[a, 3:]
        for block, sign in ((a, -1.0), (b, 1.0)):
            velocity += sign * (motion[block, :3] + np.cross(motion[block, 3:], centre - centroid[block]))
        g, w = faces.frame[i] @ velocity, faces.frame[i] @ turning
        power += force * (max(g[0], 0.0) + np.hypot(g[1], g[2])) + moment * (np.hypot(w[1], w[2]) + abs(w[0]))
    return power
