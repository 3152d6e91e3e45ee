"""Check a proof file of blockstat with the standard library alone: python check_proof.py proof.json.

A contact is a point, a normal n from block a to b, and a friction mu. A force F on b is admissible if F.n >= 0 and
|F|^2 |n|^2 <= (1 + mu^2) (F.n)^2; with a joint law F + apex n is, its multiple of n between `least` and `most`.
PROVED stable: admissible forces balance every block exactly. PROVED unstable: the loads drive a motion that none of
them resist, or none with multiples of n of the printed sum. REJECTED: all else. Exit status 0 only if all is proved.
Each contact is checked to lie where its blocks touch; that none is missing is not checked.
"""

import hashlib
import json
import sys
from fractions import Fraction as Q
from math import isqrt


def need(holds, reason):
    if not holds:
        raise ValueError(reason)


def numbers(given, count=3):
    return tuple(Q(x) for x, _ in zip(given, range(count), strict=True))


def plus(a, b, times=1):
    return tuple(x + times * y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def body(block):  # its corners; edges; outline, middle and area of each face; mass; mass x centroid
    corners, sides = [numbers(v) for v in block["vertices"]], [list(zip(f, f[1:] + f[:1])) for f in block["faces"]]
    both = sorted(side for face in sides for side in face)
    need(both == sorted((j, i) for i, j in both) and both[0][0] >= 0, "a block is not closed")
    volume, moment, faces, density = Q(0), (Q(0),) * 3, [], Q(block["density"])
    for face in sides:
        middle = tuple(sum(corners[i][k] for i, _ in face) / len(face) for k in range(3))
        areas = [cross(plus(corners[i], middle, -1), plus(corners[j], middle, -1)) for i, j in face]
        for (i, j), area in zip(face, areas):
            part = dot(middle, area) / 6
            volume, moment = volume + part, plus(moment, plus(plus(middle, corners[i]), corners[j]), part / 4)
        faces.append(([(corners[i], corners[j]) for i, j in face], middle, tuple(map(sum, zip(*areas)))))
    need(volume > 0 and density > 0, "a block has no mass")
    return corners, set(both), faces, density * volume, tuple(density * x for x in moment)


def near(p, a, b, reach):
    along, to = plus(b, a, -1), plus(p, a, -1)
    off = plus(to, along, -min(max(dot(to, along) / dot(along, along), 0), 1)) if a != b else to
    return dot(off, off) <= reach**2


def touches(block, on, p, n, reach, sine):
    """Check that p is on a face [f], an edge [i, j] or a corner [i, i], and n an outward normal there."""
    corners, sides, faces = block[:3]
    if len(on) == 1:
        outline, middle, area = faces[on[0]]
        turn, square = cross(area, n), dot(area, area)
        need(dot(area, n) > 0, "a normal points into its block")
        need(dot(turn, turn) <= sine**2 * square * dot(n, n), "a normal is not that of its face")
        need(dot(area, plus(p, middle, -1)) ** 2 <= reach**2 * square, "a contact is off its face")
        u, v = sorted(range(3), key=lambda k: abs(area[k]))[:2]
        cuts = [(a, b) for a, b in outline if (a[v] > p[v]) != (b[v] > p[v])]
        inside = sum(p[u] < a[u] + (p[v] - a[v]) * (b[u] - a[u]) / (b[v] - a[v]) for a, b in cuts) % 2
        return need(inside or any(near(p, a, b, 2 * reach) for a, b in outline), "a contact is beside its face")
    i, j = on
    need((i == j or (i, j) in sides) and near(p, corners[i], corners[j], reach), "a contact is off its edge or corner")
    along = plus(corners[j], corners[i], -1)
    need(dot(along, n) ** 2 <= sine**2 * dot(along, along) * dot(n, n), "a normal is not square to its edge")
    for away in [plus(corners[q], p, -1) for k, q in sides if k in on and q not in on]:
        need(max(dot(away, n), 0) ** 2 <= 2 * (sine**2 * dot(away, away) + reach**2), "a block crosses its contact")


def admits(law, n, force):
    force = plus(force, n, Q(law.get("apex", 0)))
    head, square, mu = dot(force, n), dot(n, n), law["friction"]
    cone = head > 0 or not any(force) if mu == "inf" else dot(force, force) * square <= (1 + Q(mu) ** 2) * head**2
    return cone and Q(law.get("least", 0)) * square <= head <= Q(law.get("most", "1e99")) * square


def resists(law, n, rate):  # the most power that bounded forces take up, and that of a unit of those without bound
    head, rough, free = dot(rate, n), law["friction"] == "inf", "most" not in law
    slide, mu = dot(rate, rate) * dot(n, n) - head**2, Q(0 if rough else law["friction"])
    root = Q(isqrt(slide.numerator * slide.denominator * 10**60) + 1, slide.denominator * 10**30) if slide else slide
    price = min(mu * root - head, 0 if head >= 0 and head**2 >= mu**2 * slide else 10**99)
    taken = Q(law.get("most", 0) if price > 0 else law.get("least", 0)) * price
    closing = (root if rough else 0) + (price if free and price > 0 else 0)
    return Q(law.get("apex", 0)) * head + taken, closing


def check(file):
    digest = {key: json.dumps(file[key], sort_keys=True, separators=(",", ":")).encode() for key in ("data", "proof")}
    need(file["sha256"] == {k: hashlib.sha256(d).hexdigest() for k, d in digest.items()}, "the hash is another one")
    data, proof, said = file["data"], file["proof"], []
    blocks, contacts, g = [body(b) for b in data["blocks"]], [], numbers(data["gravity"])
    for c in data["contacts"]:
        p, n, (a, b), mu = numbers(c["point"]), numbers(c["normal"]), c["blocks"], c["friction"]
        need(a != b and min(a, b, *c["on"][0], *c["on"][1]) >= 0, "a contact is none")
        need((mu == "inf" or Q(mu) >= 0) and 0 <= Q(c.get("least", 0)) <= Q(c.get("most", "1e99")), "a law is none")
        unit, edges = abs(dot(n, n) - 1) < Q(1, 10**12), min(map(len, map(set, c["on"]))) == 2
        need(unit and (edges or 1 in map(len, c["on"])), "a contact has no normal")
        for block, on, sign in zip((a, b), c["on"], (0, -2), strict=True):
            touches(blocks[block], on, p, plus(n, n, sign), Q(data["distance"]), Q(data["sine"]))
        contacts.append((c, a, b, p, n))
    free, fixed = ([i for i, b in enumerate(data["blocks"]) if b["fixed"] is what] for what in (False, True))
    more, live = ([numbers(b.get(key, [0] * 6), 6) for b in data["blocks"]] for key in ("dead", "live"))
    dead = [plus(own, tuple(b[3] * x for x in g) + cross(b[4], g)) for own, b in zip(more, blocks)]
    varies = any(any(live[i]) for i in free)
    need(free and ("forces" in proof) + ("motion" in proof) in (1, 1 + varies), "not one thing is claimed")
    if "forces" in proof:
        many = Q(proof["multiplier"]) if varies else 0
        left = [plus(own, more, many) for own, more in zip(dead, live)]
        for (c, a, b, p, n), given in zip(contacts, proof["forces"], strict=True):
            acting = numbers(given) + cross(p, numbers(given))
            need(admits(c, n, acting[:3]), "a force is outside its cone")
            left[a], left[b] = plus(left[a], acting, -1), plus(left[b], acting)
        need(not any(any(left[i]) for i in free), "a block is not balanced")
        said.append("PROVED stable" + (f" at {float(many):.12g} times the live load" if varies else ""))
    if "motion" in proof:
        motion = [numbers(u, 6) for u in proof["motion"]]
        need(len(motion) == len(blocks) and not any(any(motion[i]) for i in fixed), "a fixed block moves")
        power, closing = sum(dot(dead[i], motion[i]) for i in free), 0
        for c, a, b, p, n in contacts:
            u = plus(motion[b], motion[a], -1)
            taken, closes = resists(c, n, plus(u[:3], cross(u[3:], p)))
            power, closing = power - taken, max(closing, closes)
        power -= max(Q(proof.get("bound", 1)), 1) * closing * sum(abs(x) for i in free for x in dead[i][:3])
        drive = sum(dot(live[i], motion[i]) for i in free)
        need(drive > 0 if varies else power > 0, "the loads do not drive the motion")
        said.append("PROVED unstable" + (f" beyond {float(-power / drive):.12g} times the live load" if varies else ""))
        said[-1] += f", whatever forces of up to {proof.get('bound', 1)} dead loads resist" if closing else ""
    where = f"contacts within {data['distance']} m and a sine of {data['sine']}, data {file['sha256']['data']}"
    return [*said, f"{len(free)} free blocks, {len(contacts)} {where}"]


if __name__ == "__main__":
    try:
        print(*check(json.load(open(sys.argv[1], encoding="utf-8"))), sep="\n")
    except Exception as reason:
        print(f"REJECTED: {reason}" if type(reason) is ValueError else f"REJECTED: {reason!r}")
        sys.exit(1)
