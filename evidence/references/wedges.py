"""Wedges of Kao et al., Coupled Rigid-Block Analysis, CAD 146:103216 (2022): critical angles of the rotated assembly.

P: 3DEC and CRA, to a tenth of a degree. E: closed forms, a block in a groove slides at tan(theta) = mu / sin(beta) and
along one flank at theta = 90 - beta + atan(mu), beta the flank's angle from the vertical. D: force-only statics with the
exact cone, by an independent conic program; 180 stands at every angle. The geometry comes from files.
"""

import math

from scipy.spatial.transform import Rotation

from blockstat import assess, read, tilt_limit
from evidence.paths import CASES
from evidence.references.row import Row, Value, between


def wedge(case: str, mu: float):
    return read(CASES / f"cra_type_{case}__y0.json").with_(friction=mu)


def force_only(case: str, axis: str, mu: float) -> Value:
    found = tilt_limit(wedge(case, mu), axis)
    return Value(found.stands, 0.0 if math.isnan(found.falls) else found.falls - found.stands)


def coulomb(case: str, axis: str, mu: float, degrees: float) -> Value:
    """Searched for from the whole degree below to the one above."""
    asm = wedge(case, mu)

    def outcome(angle):
        turn = Rotation.from_euler(axis, angle, degrees=True)
        found = assess(asm, gravity=turn.apply(asm.gravity.copy()), flow="coulomb").outcome
        return found if found.word != "stable_only_by_self_stress" else found.UNSTABLE

    return between(math.floor(degrees - 0.3), math.ceil(degrees + 0.3), outcome, 2e-3)


#: case, axis, mu, 3DEC and CRA, closed form, force-only statics, accuracy of our angle: near the limit the fixed point
#: shrinks as slowly as it grows beyond it, the slower the more friction
WEDGES = [
    ("a", "x", 0.2, "21.8", "21.80", "23.09", 0.01),
    ("a", "y", 0.2, "71.3", "71.31", "71.30", 0.01),
    ("c", "x", 0.2, "13.0", "13.00", "13.08", 0.01),
    ("a", "x", 0.84, "59.2", "59.24", "180", 0.05),
    ("c", "x", 0.84, "44.1", "44.13", "46.96", 0.01),
]

ROWS = [
    row
    for case, axis, mu, published, closed, associated, within in WEDGES
    for row in (
        Row("P", f"wedge {case}-{axis}, mu {mu}, Coulomb [deg]", "Kao 2022", published, lambda c=case, a=axis, m=mu, n=float(closed): coulomb(c, a, m, n), needs=CASES),
        Row("E", f"wedge {case}-{axis}, mu {mu}, Coulomb [deg]", "groove or flank of a wedge", closed, lambda c=case, a=axis, m=mu, n=float(closed): coulomb(c, a, m, n), within=within, needs=CASES),
        Row("D", f"wedge {case}-{axis}, mu {mu}, forces only [deg]", "conic program", associated, lambda c=case, a=axis, m=mu: force_only(c, a, m), needs=CASES),
    )
]  # fmt: skip
