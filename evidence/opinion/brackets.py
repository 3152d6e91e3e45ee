"""A second opinion on brackets: tilt, least friction, and limit loads all round the horizon.

Both ends of a bracket are asked again as verdicts, whose evidence `evidence.checks.independent` checks: the assembly
stands on one side, and on the other it does not. Gravity is turned here by Rodrigues' formula.
"""

from __future__ import annotations

import numpy as np

import blockstat
from evidence.checks import independent

NEAR = 1e-6  #: relative, or absolute below 1; verdicts are asked for so far on either side of a limit
WIDTH = 3e-4  #: relative, of a bracket whose middle is decided
HULL = 1e-9  #: relative, of distances
NONE = 2e-9  #: a multiplier of the weight that is told as zero


def turned(vector, axis, degrees):
    """The vector after a right-handed rotation about an axis."""
    named = {"x": (1.0, 0, 0), "y": (0, 1.0, 0), "z": (0, 0, 1.0)}
    unit = np.asarray(named[axis] if isinstance(axis, str) else axis, dtype=float)
    unit = unit / np.abs(unit).max()
    unit = unit / np.linalg.norm(unit)
    angle = np.deg2rad(degrees)
    across = np.cross(unit, vector)
    return vector * np.cos(angle) + across * np.sin(angle) + unit * (unit @ vector) * (1 - np.cos(angle))


def check_ends(stands, falls, word, *, most, width=0.0):
    """Raise AssertionError unless a verdict is "stable" at one end only, and the ends are close to each other.

    word : the verdict at a value; most : the value furthest on the stable side that is asked for; width : the width of
    the bracket that is asked for, where it is wider than by default.
    """
    if np.isnan(falls) and np.isnan(stands):  # undecided: nothing is claimed
        return
    if np.isnan(falls):
        assert stands == most, "the range ends elsewhere"
        assert word(stands) == "stable", "it does not stand"
        return
    if np.isnan(stands):
        assert word(falls) != "stable", "it stands"
        return
    scale = max(abs(stands), abs(falls))
    beyond = np.sign(falls - stands) or float(scale == 0)  # a tilt of nothing is told as zero at both ends
    away = beyond * NEAR * max(scale, 1.0)
    assert away, "both ends are one"
    if stands > abs(away):
        assert word(stands - away) == "stable", "it does not stand"
    assert word(falls + away) != "stable", "it stands"
    if abs(falls - stands) > max(WIDTH * scale, 2 * NEAR, width):
        assert word((stands + falls) / 2) == "undecided", "the bracket is too wide"


def check_tilt(found, asm, axis, *, friction=None, gravity=None, **options):
    """Raise AssertionError unless the assembly stands at the one angle and not at the other.

    Without dilatancy the limit is that of finding a state, whose upper end proves nothing and is not checked.
    """
    down = np.asarray(asm.gravity if gravity is None else gravity, dtype=float)

    def word(degrees):
        down_there = turned(down, axis, degrees)
        return blockstat.assess(asm, gravity=down_there, friction=friction, **options).outcome.word

    _check_kinds(found, word, -1.0)
    assert not 180 < found.stands
    if found.kinds:
        assert np.isnan(found.stands) or word(found.stands) == "stable"
    elif len(asm.free):
        check_ends(found.stands, found.falls, word, most=found.stands if found.open else 180.0)


def check_friction(found, asm, *, top=10.0, width=0.0, **options):
    """Raise AssertionError unless the assembly stands with the one friction and not with the other."""

    def word(mu):
        return blockstat.assess(asm, friction=mu, **options).outcome.word

    _check_kinds(found, word, 1.0)
    if found.kinds:
        assert np.isnan(found.stands) or word(found.stands) == "stable"
        return
    if np.isnan(found.stands):
        assert found.falls == top or np.isnan(found.falls)
    least = 1e-3 if any(law.cohesion for law in asm.joints) else 0.0
    check_ends(found.stands, found.falls, word, most=found.stands if found.open else least, width=width)


def _check_kinds(found, word, sign):
    """The outer values are those of the joints that bear most."""
    if found.kinds:
        values = [(np.inf if np.isnan(stands) else sign * stands, stands, falls) for stands, falls in found.kinds]
        assert np.array_equal(min(values)[1:], (found.stands, found.falls), equal_nan=True)


def check_directions(found, *, loads=None, gap=independent.GAP):
    """Raise AssertionError unless each direction is carried and the bracket of the horizon follows from all of them."""
    asm = found.assembly
    down = asm.gravity / np.linalg.norm(asm.gravity)
    ahead = np.array([1.0, 0, 0]) - down[0] * down
    ahead = ahead if np.linalg.norm(ahead) > 1e-6 else np.array([0, 0, 1.0])
    ahead /= np.linalg.norm(ahead)
    left = np.cross(-down, ahead)
    assert (np.diff(found.angles) > 0).all()
    expected = np.outer(np.cos(found.angles), ahead) + np.outer(np.sin(found.angles), left)
    assert np.abs(expected - found.directions).max() < 1e-9, "a direction is not that of its angle"
    for direction, limit in zip(found.directions, found.limits, strict=True):
        independent.check_limit(limit, direction, loads=loads, gap=gap)
    low, high = found.horizon
    if any(limit.outcome.word != "limit" or limit.coulomb_kinds for limit in found.limits):
        return
    corner = found.lower[:, None] * np.column_stack([np.cos(found.angles), np.sin(found.angles)])
    side = np.roll(corner, -1, axis=0) - corner
    length = np.linalg.norm(side, axis=1)
    turn = corner[:, 0] * side[:, 1] - corner[:, 1] * side[:, 0]
    height = np.divide(turn, length, out=np.zeros_like(turn), where=length > 0)  # nothing carried has no sides
    proven = max(height.min(), 0.0)  # all stand without a load; few directions do not surround the origin
    assert low <= proven * (1 + HULL), "more than forces prove in all directions"
    wrench, _ = independent.dead_load(asm, loads)
    pull = [
        [(independent.live_load(asm, axis) * own.mechanism).sum() for axis in (ahead, left)] for own in found.limits
    ]
    resisted = np.array([-(wrench * own.mechanism).sum() for own in found.limits])
    least = (resisted / np.linalg.norm(pull, axis=1)).min()
    if not (asm.joints or asm.ties):
        assert abs(high - least) <= max(1e-6 * abs(least), NONE), "the mechanisms prove another bound"
        assert low >= proven * (1 - 1e-6), "forces prove more in all directions"


def install():
    """Put the checks of this module behind the functions, as `evidence.checks.independent.install` does."""
    independent.install_all({"tilt_limit": _tilted, "friction_limit": _rubbed, "limit_load_by_direction": _all_round})


def _options(given, *names):
    return {name: given[name] for name in (*names, "loads", "gap", "interfaces", "flow") if given.get(name) is not None}


def _tilted(found, given):
    check_tilt(found, given["assembly"], given["axis"], **_options(given, "friction", "gravity"))


def _rubbed(found, given):
    asked = {name: given[name] for name in ("top", "width") if name in given}
    check_friction(found, given["assembly"], **asked, **_options(given, "gravity"))


def _all_round(found, given):
    gap = given.get("gap", independent.GAP) if given.get("interfaces") is None else None
    check_directions(found, loads=given.get("loads"), gap=gap)
