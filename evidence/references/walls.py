"""Walls in their plane and out of it.

Ferris & Tin-Loi, Int. J. Mech. Sci. 43 (2001): the planar set, associated factors and, from a complementarity program,
those without dilatancy. The latter are not unique; the published ones are minima, and ours is the branch reached from
rest. D: a planar linear program, tests/crosscheck/test_linear_program.py. Head joints that only lose their friction keep
their pressure; where they are open, the blocks of a course do not touch: the same for W1 and W3, not for W4. Facade of a U-shaped wall: derived once.
Facade alone: n courses of thickness 1 tip about their foot, lambda = 1/n; any free-standing wall at t/H.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from blockstat import Interfaces, find_interfaces
from evidence.references.row import Row, Value, limit, zero_dilatancy
from evidence.scenes.small import FERRIS, facade, ferris_wall, running_bond, u_wall

SIDE, OUT = (1, 0, 0), (0, -1, 0)


def wall(name: str, **options):
    return ferris_wall(FERRIS[name][0], **options)


def turned_wall(name: str):
    """The wall turned in plan and the load along it: prismatic along no axis, so its cones are solved as cones."""
    turn = Rotation.from_euler("z", 30, degrees=True)
    asm = wall(name)
    return asm.with_(vertices=turn.apply(asm.vertices.copy())), turn.apply(SIDE)


def bed_joints(asm) -> Interfaces:
    """Horizontal joints alone: the blocks of a course do not touch."""
    faces = find_interfaces(asm)
    return faces.subset(np.abs(faces.frame[:, 0, 2]) > 0.5)


def open_heads(name: str) -> Value:
    asm = wall(name)
    return limit(asm, SIDE, interfaces=bed_joints(asm))


OPEN = {"W1": ".639969", "W3": ".359007", "W4": ".285403"}
FRICTIONLESS = {"W1": ".639969", "W3": ".359007", "W4": ".285775"}
ZERO_DILATANCY = {"W1": ".640", "W3": ".356", "W4": ".264"}

#: Where the walls are derived a second time.
LINEAR = "[linear program](../tests/crosscheck/test_linear_program.py)"

ROWS = [
    *(Row("P", f"Ferris & Tin-Loi {n}, associated", "Ferris 2001", f"{data[3]:.3f}", lambda n=n: limit(wall(n), SIDE)) for n, data in FERRIS.items()),
    *(Row("D", f"Ferris & Tin-Loi {n}, associated", LINEAR, f"{data[4]:.6f}", lambda n=n: limit(wall(n), SIDE)) for n, data in FERRIS.items()),
    *(Row("D", f"Ferris & Tin-Loi {n}, exact cones in space", LINEAR, f"{data[4]:.6f}", lambda n=n: limit(*turned_wall(n))) for n, data in FERRIS.items()),
    *(Row("P", f"Ferris & Tin-Loi {n}, zero dilatancy", "Ferris 2001", text, lambda n=n: zero_dilatancy(wall(n), SIDE), slow=True) for n, text in ZERO_DILATANCY.items()),
    *(Row("D", f"Ferris & Tin-Loi {n}, open head joints", LINEAR, text, lambda n=n: open_heads(n)) for n, text in OPEN.items()),
    *(Row("D", f"Ferris & Tin-Loi {n}, frictionless head joints", LINEAR, text, lambda n=n: limit(wall(n, head_friction=0.0), SIDE)) for n, text in FRICTIONLESS.items()),
    *(Row("d", f"facade of a U-shaped wall, {n} courses", "conic program, derived once", text, lambda n=n: limit(u_wall(n), OUT)) for n, text in ((4, ".552372"), (8, ".389499"), (12, ".277391"))),
    *(Row("E", f"facade alone, {n} courses, 1/n", "moments about the foot", 1 / n, lambda n=n: limit(facade(n), OUT)) for n in (3, 8, 12)),
    Row("E", "free-standing wall, t/H", "moments about the foot", 0.2 / (6 * 0.175), lambda: limit(running_bond(6, 5), OUT)),
    Row("E", "low free-standing wall slides, mu", "Coulomb", 0.7, lambda: limit(running_bond(1, 5), OUT)),
]  # fmt: skip
