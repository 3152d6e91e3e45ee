"""Arches, a barrel and a dome under their own weight, pushed, tilted and loaded.

P: Milankovitch (1907) and Makris & Alexakis, Archive of Applied Mechanics 83 (2013): least thickness with radial and
with vertical joints. Ochsendorf, PhD thesis, Cambridge (2002): tilt. Shin et al. (2016) and Kao et al., CAD 146:103216
(2022): tilt of 36 blocks. De Lorenzis, DeJong & Ochsendorf, Earthquake Eng. Struct. Dyn. 36 (2007): seven voussoirs.
Heyman, The Stone Skeleton: the dome. Sliding: Gilbert, Casapulla & Ahmed, Computers & Structures 84 (2006), 27 blocks.
D: a planar linear program (tests/crosscheck/test_arch_program.py) and, but for the dome and the piers, hand-written
mechanisms. R is the radius of the centreline; voussoirs have straight
sides ("poly") unless they are true sectors, whose weight is put on by hand.
"""

import math
from functools import partial

import numpy as np

from blockstat import point_load, thrust_range
from evidence.references.row import INF, Row, Value, between, limit, stands, tilt
from evidence.scenes.arches import barrel_on_piers, pointed_arch, round_arch, vertical_arch, weights_instead
from evidence.scenes.small import arch

SIDE = (1, 0, 0)
WIDE = math.radians(157.5)
STICKY = 2.0  #: enough friction that nothing slides
SECTORS = 76  #: so many equal ones have joints at the crown and, to a hundredth of a degree, at the haunches' hinges


def least_thickness(n: int, mu: float = STICKY) -> Value:
    return between(0.3, 0.08, lambda t: stands(arch(n, t), friction=mu), 1e-8)


def with_true_weights(n: int, t: float, *, push: float = 0.0, mu: float = STICKY, **shape):
    """Verdict on an arch with the weights of curved voussoirs under gravity and a horizontal acceleration."""
    asm, mass, centroid = round_arch(n, t, **shape)
    return stands(asm, friction=mu, loads=weights_instead(asm, mass, centroid, (push, 0.0, -1.0)))


def hinging_friction() -> Value:
    """The least friction at which the least thickness, enlarged by a hundred-millionth, still stands."""
    return between(0.45, 0.35, lambda mu: with_true_weights(SECTORS, 0.1074780313, mu=mu), 1e-7)


def friction_of_any_arch() -> Value:
    """Below it no thickness helps; 88 voussoirs have joints where it is reached, others need a little less."""
    return between(0.5, 0.2, lambda mu: stands(arch(88, 0.5), friction=mu), 1e-8)


def thrust(t: float, which: str) -> Value:
    asm = arch(20, t)
    found = thrust_range(asm, ["right"], SIDE, friction=INF)
    return Value(getattr(found, which) / asm.mass[asm.free].sum())


def loaded_voussoir(block: int) -> Value:
    asm = arch(20, 0.2)
    corners = asm.block_vertices(asm.names.index(f"voussoir{block}"))
    outer = corners[np.linalg.norm(corners[:, [0, 2]], axis=1) > 1.0].mean(axis=0)
    force = (0, 0, -asm.mass[asm.free].sum())
    return limit(asm, point_load(asm, f"voussoir{block}", outer, force), friction=INF)


POLY = {4: ".097361", 5: ".094980", 6: ".104134", 8: ".099972", 10: ".107011", 12: ".104857", 16: ".107076",
        20: ".107348", 24: ".107096", 27: ".106721", 36: ".107424", 100: ".1074556"}  # fmt: skip
SLIDING = {.39: ".111630", .38: ".121124", .36: ".140891", .34: ".161767", .32: ".183845", .31: ".195995"}  # fmt: skip
PUSHED = {180: {.12: [".048631"] * 3, .15: [".149350"] * 3, .2: [".285646"] * 3, .3: [".518602", ".456126", ".365081"]},
          157.5: {.15: [".356052"] * 3, .2: [".518652"] * 3, .25: [".675637", ".675637", ".575291"]}}  # fmt: skip
THRUST = {.15: (".175635", ".227718"), .2: (".154245", ".255311"), .3: (".118217", ".299956")}  # fmt: skip
POINTED = {.1: {10: ".085991", 50: ".086797"}, .2: {10: ".069925", 50: ".070727"}, .5: {10: ".039687", 50: ".039970"}}  # fmt: skip
PIERS = {2.5: ".67333", 5.0: ".83754", 10.0: ".95326"}

#: Where they are derived a second time.
LINEAR = "[linear program](../tests/crosscheck/test_arch_program.py)"

ROWS = [
    *(Row("D", f"least t/R, {n} voussoirs", LINEAR, text, partial(least_thickness, n)) for n, text in POLY.items()),
    Row("P", "least t/R, 100 voussoirs against the continuum", "Makris 2013", ".1075", lambda: least_thickness(100)),
    Row("D", "least t/R, 76 true sectors against the continuum", LINEAR, ".1074780", lambda: between(0.3, 0.08, lambda t: with_true_weights(SECTORS, t), 1e-9)),
    Row("P", "least t/R, 400 vertical joints", "Makris 2013", ".1095", lambda: between(0.12, 0.1, lambda t: stands(vertical_arch(400, t), friction=50.0), 1e-6)),
    *(Row("D", f"least t/R, 27 voussoirs, mu {mu}", LINEAR, text, partial(least_thickness, 27, mu)) for mu, text in SLIDING.items()),
    Row("D", "least friction at the least t/R, 76 sectors", LINEAR, ".395265", hinging_friction, within=1e-6),
    Row("D", "least friction at any t/R, 88 voussoirs", LINEAR, ".309215", friction_of_any_arch),
    *(Row("D", f"lambda, {n} deg, t/R {t}, mu {mu}", LINEAR, text, lambda n=n, t=t, mu=mu: limit(arch(20, t, embrace=math.radians(n)), SIDE, friction=mu))
      for n, rows in PUSHED.items() for t, values in rows.items() for mu, text in zip((INF, 0.7, 0.6), values, strict=True)),
    Row("D", "De Lorenzis arch, straight sides", LINEAR, ".373612", lambda: limit(arch(7, 0.15, embrace=WIDE), SIDE, friction=INF)),
    Row("D", "De Lorenzis arch, true sectors", LINEAR, ".370010", lambda: between(0.3, 0.4, lambda a: with_true_weights(7, 0.15, push=a, embrace=WIDE), 1e-7)),
    Row("P", "De Lorenzis arch, true sectors", "De Lorenzis 2007", ".37", lambda: between(0.3, 0.4, lambda a: with_true_weights(7, 0.15, push=a, embrace=WIDE), 1e-4)),
    Row("P", "tilt of 100 voussoirs, t/R .20 [deg]", "Ochsendorf 2002", "15.84", lambda: tilt(arch(100, 0.2), friction=INF)),
    Row("D", "tilt of 100 voussoirs, t/R .20 [deg]", LINEAR, "15.8444", lambda: tilt(arch(100, 0.2), friction=INF)),
    Row("D", "tilt of 20 voussoirs, t/R .20 [deg]", LINEAR, "15.9418", lambda: tilt(arch(20, 0.2), friction=INF)),
    Row("P", "tilt of 36 voussoirs, t/R .15 [deg]", "Shin 2016, Kao 2022", "8.2", lambda: tilt(arch(36, 0.15), friction=INF)),
    Row("D", "tilt of 36 voussoirs, t/R .15 [deg]", LINEAR, "8.2464", lambda: tilt(arch(36, 0.15), friction=INF)),
    *(Row("D", f"{which} thrust / weight, t/R {t}", LINEAR, text, partial(thrust, t, which)) for t, values in THRUST.items() for which, text in zip(("least", "greatest"), values, strict=True)),
    *(Row("D", f"load on voussoir {k} of 20 / weight", LINEAR, text, partial(loaded_voussoir, k)) for k, text in ((4, "3.018464"), (9, ".422907"))),
    *(Row("D", f"least t/R, pointed arch, e/R {e}, {n} a half", LINEAR, text, lambda n=n, e=e, text=text: between(1.2 * float(text), 0.8 * float(text), lambda t: stands(pointed_arch(n, e, t), friction=STICKY), 1e-8))
      for e, values in POINTED.items() for n, text in values.items()),
    Row("D", "least t/R, hemispherical dome, 60 rings", LINEAR, ".042813", lambda: between(0.06, 0.03, lambda t: with_true_weights(120, t, lune=True), 1e-8)),
    Row("P", "least t/R, hemispherical dome, about", "Heyman 1995", ".042", lambda: between(0.06, 0.03, lambda t: with_true_weights(120, t, lune=True), 1e-4), within=1e-3),
    *(Row("D", f"barrel on piers of {h} m, least width [m]", LINEAR, text, lambda h=h: between(1.2, 0.5, lambda w: stands(barrel_on_piers(w, h)), 1e-7)) for h, text in PIERS.items()),
]  # fmt: skip
