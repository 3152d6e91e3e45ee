"""Check a proof file of blockstat with the standard library alone: python check_proof.py proof.json.

A force on block b is h n + t: n the normal from block a to b, t square to it. It is admissible if h + apex is between
`least` and `most`, and |t| <= (`friction` (h + apex) + `shear`) |n|. Contacts have friction; bonds have shear, for a
force and for a `couple`; ties have neither, and are along their `ends`. PROVED stable: admissible forces balance every
block exactly. PROVED unstable: the loads drive a motion that none of them resist, or none with h of the printed sum.
Contacts and bonds are checked to lie where blocks touch, ties to end in the boxes of blocks; not that none is missing.
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


def touches(block, on, p, n, reach, sine):  # p is on a face [f], an edge [i, j] or a corner [i, i], n outward there
    corners, sides, faces = block[:3]
    if on is None:
        return need(all(min(x) - reach <= e <= max(x) + reach for e, x in zip(p, zip(*corners))), "a tie ends nowhere")
    if len(on) == 1:
        outline, middle, area = faces[on[0]]
        turn, square = cross(area, n), dot(area, area)
        need(dot(area, n) > 0 and dot(turn, turn) <= sine**2 * square * dot(n, n), "a normal is not that of its face")
        need(dot(area, plus(p, middle, -1)) ** 2 <= reach**2 * square, "a contact is off its face")
        u, v = sorted(range(3), key=lambda k: abs(area[k]))[:2]
        cuts = [(a, b) for a, b in outline if (a[v] > p[v]) != (b[v] > p[v])]
        inside = sum(p[u] < a[u] + (p[v] - a[v]) * (b[u] - a[u]) / (b[v] - a[v]) for a, b in cuts) % 2
        return need(inside or any(near(p, a, b, 2 * reach) for a, b in outline), "a contact is beside its face")
    (i, j), along = on, plus(corners[on[1]], corners[on[0]], -1)
    need((i == j or (i, j) in sides) and near(p, corners[i], corners[j], reach), "a contact is off its edge or corner")
    need(dot(along, n) ** 2 <= sine**2 * dot(along, along) * dot(n, n), "a normal is not square to its edge")
    for away in [plus(corners[q], p, -1) for k, q in sides if k in on and q not in on]:
        need(max(dot(away, n), 0) ** 2 <= 2 * (sine**2 * dot(away, away) + reach**2), "a block crosses its contact")


def admits(law, n, force):  # a friction of 1e50 stands for an infinite one: its cone is within that of the other
    force, mu = plus(force, n, Q(law.get("apex", 0))), Q(law.get("friction", "0").replace("inf", "1e50"))
    head, square = dot(force, n), dot(n, n)
    bounded = Q(law.get("least", 0)) * square <= head <= Q(law.get("most", "1e99")) * square
    return bounded and dot(force, force) * square - head**2 <= (mu * head + Q(law.get("shear", 0)) * square) ** 2


def resists(law, n, rate):  # the most power that bounded forces take up, and that of a unit of those without bound
    head, rough, free = dot(rate, n), law.get("friction") == "inf", "most" not in law
    slide, mu = dot(rate, rate) * dot(n, n) - head**2, Q(0 if rough else law.get("friction", 0))
    root = Q(isqrt(slide.numerator * slide.denominator * 10**60) + 1, slide.denominator * 10**30) if slide else slide
    price = min(mu * root - head, 0 if head >= 0 and head**2 >= mu**2 * slide else 10**99)
    taken = Q(law.get("most", 0) if price > 0 else law.get("least", 0)) * price + Q(law.get("shear", 0)) * root
    return Q(law.get("apex", 0)) * head + taken, (root if rough else 0) + (max(price, 0) if free else 0)


def check(file):
    digest = {key: json.dumps(file[key], sort_keys=True, separators=(",", ":")).encode() for key in ("data", "proof")}
    need(file["sha256"] == {k: hashlib.sha256(d).hexdigest() for k, d in digest.items()}, "the hash is another one")
    data, proof, said, contacts = file["data"], file["proof"], [], []
    blocks, g = [body(b) for b in data["blocks"]], numbers(data["gravity"])
    free, fixed = ([i for i, b in enumerate(data["blocks"]) if b["fixed"] is what] for what in (False, True))
    for c in data["contacts"]:
        n, (a, b), tie, mu = numbers(c["normal"]), c["blocks"], "ends" in c, c.get("friction", "0")
        (p, q), on = map(numbers, c["ends"] if tie else [c["point"]] * 2), c.get("on", [[0], [0]])
        least, sine, line, kinds = Q(c.get("least", 0)), Q(data["sine"]), plus(q, p, -1), {"friction", "shear", "ends"}
        unit, turn, shear = abs(dot(n, n) - 1) < Q(1, 10**12), cross(line, n), Q(c.get("shear", 0))
        need(a != b and min(a, b, *on[0], *on[1]) >= 0, "a contact is none")
        need(least <= Q(c.get("most", "1e99")) and shear >= 0 and (mu == "inf" or Q(mu) >= 0), "a law is none")
        need(len(kinds & c.keys()) == 1 and ("shear" in c or (least >= 0 and "couple" not in c)), "a law is none")
        need(unit and (1 in map(len, on) or min(map(len, map(set, on))) == 2), "a contact has no normal")
        need(dot(turn, turn) <= sine**2 * dot(line, line) and any(line) is tie, "a tie is not along its ends")
        for k, place, end, sign in zip((a, b), on, (p, q), (0, -2), strict=True):
            if not tie or k in free:
                touches(blocks[k], None if tie else place, end, plus(n, n, sign), Q(data["distance"]), sine)
        contacts.append((c, a, b, q, n))
    more, live = ([numbers(b.get(key, [0] * 6), 6) for b in data["blocks"]] for key in ("dead", "live"))
    dead = [plus(own, tuple(b[3] * x for x in g) + cross(b[4], g)) for own, b in zip(more, blocks)]
    varies, many = any(any(live[i]) for i in free), Q(proof.get("multiplier", 0))
    need(free and ("forces" in proof) + ("motion" in proof) in (1, 1 + varies), "not one thing is claimed")
    if "forces" in proof:
        left = [plus(own, more, many) for own, more in zip(dead, live)]
        for (c, a, b, p, n), given in zip(contacts, proof["forces"], strict=True):
            need(admits(c, n, numbers(given)), "a force is outside its cone")
            acting = (Q(0),) * 3 + numbers(given) if "couple" in c else numbers(given) + cross(p, numbers(given))
            left[a], left[b] = plus(left[a], acting, -1), plus(left[b], acting)
        need(not any(any(left[i]) for i in free), "a block is not balanced")
        said.append("PROVED stable" + (f" at {float(many):.12g} times the live load" if varies else ""))
    if "motion" in proof:
        motion = [numbers(u, 6) for u in proof["motion"]]
        need(len(motion) == len(blocks) and not any(any(motion[i]) for i in fixed), "a fixed block moves")
        power, drive, closing = *(sum(dot(load[i], motion[i]) for i in free) for load in (dead, live)), 0
        for c, a, b, p, n in contacts:
            u = plus(motion[b], motion[a], -1)
            taken, closes = resists(c, n, u[3:] if "couple" in c else plus(u[:3], cross(u[3:], p)))
            power, closing = power - taken, max(closing, closes)
        power -= max(Q(proof.get("bound", 1)), 1) * closing * sum(abs(x) for i in free for x in dead[i][:3])
        need(drive > 0 if varies else power > 0, "the loads do not drive the motion")
        said.append("PROVED unstable" + (f" beyond {float(-power / drive):.12g} times the live load" if varies else ""))
        said[-1] += f", whatever forces of up to {proof.get('bound', 1)} dead loads resist" if closing else ""
    where = f"within {data['distance']} m and a sine of {data['sine']}, data {file['sha256']['data']}"
    other = sum("friction" not in c for c in data["contacts"])
    return [*said, f"{len(free)} free blocks, {len(contacts)} contacts ({other} of bonds and ties) {where}"]


if __name__ == "__main__":
    try:
        print(*check(json.load(open(sys.argv[1], encoding="utf-8"))), sep="\n")
    except Exception as reason:
        sys.exit(print(f"REJECTED: {reason if type(reason) is ValueError else repr(reason)}") or 1)
