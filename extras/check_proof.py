"""Check a proof file of blockstat with the standard library alone: python check_proof.py proof.json.

A force on block b is h n + t: n the normal from block a to b, t square to it. It is admissible if h + apex is between
`least` and `most`, and |t| <= (`friction` (h + apex) + `shear`) |n|. Contacts have friction; bonds have shear, for a
force and for a `couple`; ties have neither, and are along their `ends`. PROVED stable: admissible forces balance every
block exactly. PROVED unstable: the loads drive a motion that none of them resist, or none with h of the printed sum.
Contacts and bonds are checked to lie on the surfaces of both blocks, ties to end in the boxes of blocks. Faces bound
a block as triangles about the mean of their corners do; those of contacts are flat, within the printed distance too.
A contact has one normal: next to it a face is on a face, or an edge or a corner on what fills the half-space behind a
face, or edges cross between their ends.
NOT checked: that no contact is missing, and that blocks do not overlap. The data are to be compared with one's own.
"""

import hashlib
import json
import re
import sys
from decimal import ROUND_CEILING, ROUND_FLOOR, Context
from fractions import Fraction as Q
from itertools import chain
from math import isqrt

THIN = Q(1, 10**12)  # what is thinner is no solid [m]


def need(holds, reason):
    if not holds:
        raise ValueError(reason)


def number(given):
    return type(given) is str and re.fullmatch(r"-?[0-9]+(\.[0-9]+|/0*[1-9][0-9]*)?", given)


def friction(given):
    return given == "inf" or number(given)


def text(given):
    return type(given) is str


def truth(given):
    return type(given) is bool


def index(given):
    return type(given) is int and given >= 0


def place(given):  # a face [f], an edge [i, j] or a corner [i, i]
    return fits(given, [index]) or fits(given, [index, index])


def each(form):
    return lambda given: type(given) is list and all(fits(x, form) for x in given)


def fits(given, form):  # a form is a function, a list of forms, or a dictionary of forms; keys with "?" may be absent
    if type(form) is list:
        return type(given) is list and len(given) == len(form) and all(map(fits, given, form))
    if type(form) is not dict:
        return form(given)
    forms = {key.rstrip("?"): own for key, own in form.items() if key[-1] != "?" or key[:-1] in given}
    return type(given) is dict and given.keys() == forms.keys() and all(fits(given[k], own) for k, own in forms.items())


VECTOR, WRENCH = [number] * 3, [number] * 6
ROW = {"blocks": [index] * 2, "normal": VECTOR, "least?": number, "most?": number}
PLACED = ROW | {"on": [place] * 2, "point": VECTOR}
ROWS = {  # contacts, bonds and ties, by the key that tells them apart
    "friction": PLACED | {"friction": friction, "apex?": number},
    "shear": PLACED | {"shear": number, "couple?": truth},
    "ends": ROW | {"ends": [VECTOR] * 2},
}
BLOCK = {"name": text, "fixed": truth, "density": number, "vertices": each(VECTOR), "faces": each(each(index))}
BLOCKS, CONTACTS = each(BLOCK | {"dead?": WRENCH, "live?": WRENCH}), each(lambda row: type(row) is dict)
FILE = {
    "format?": lambda given: given == "blockstat proof 1",
    "data": {"gravity": VECTOR, "distance": number, "sine": number, "blocks": BLOCKS, "contacts": CONTACTS},
    "proof": {"multiplier?": number, "forces?": each(VECTOR), "motion?": each(WRENCH), "bound?": number},
    "sha256": {"data": text, "proof": text},
}


def numbers(given, count=3):
    return tuple(Q(x) for x, _ in zip(given, range(count), strict=True))


def plus(a, b, times=1):
    return tuple(x + times * y for x, y in zip(a, b))


def dot(a, b):
    return sum(x * y for x, y in zip(a, b))


def cross(a, b):
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def area(a, b, c):  # twice that of a triangle
    return cross(plus(b, a, -1), plus(c, a, -1))


def body(block):  # its corners; edges; faces: sides, areas of their triangles, sum, middle, box; mass; mass x centroid
    corners, rings = [numbers(v) for v in block["vertices"]], [list(zip(f, f[1:] + f[:1])) for f in block["faces"]]
    both = sorted(side for ring in rings for side in ring)
    need(both == sorted((j, i) for i, j in both) and all(i != j for i, j in both), "a block is not closed")
    need(len(set(corners)) == len(corners) == len({i for i, _ in both}), "two corners are one, or one is of no face")
    volume, moment, faces, density = Q(0), (Q(0),) * 3, [], Q(block["density"])
    for ring in rings:
        sides = [(corners[i], corners[j]) for i, j in ring]
        middle = tuple(sum(x) / len(ring) for x in zip(*(a for a, _ in sides)))
        areas = [area(middle, a, b) for a, b in sides]
        for (a, b), own in zip(sides, areas):
            part = dot(middle, own) / 6
            volume, moment = volume + part, plus(moment, plus(plus(middle, a), b), part / 4)
        # floats keep the order of numbers
        box = [(float(min(x)), float(max(x))) for x in zip(*(a for a, _ in sides))]
        faces.append((sides, areas, tuple(map(sum, zip(*areas))), middle, box))
        need(any(faces[-1][2]), "a face has no area")
    need(volume > 0 and density > 0, "a block has no mass")
    for sides, areas, whole, middle, _ in faces:
        own, (a, b) = max(zip(areas, sides), key=lambda triangle: dot(triangle[0], whole))
        x = tuple(dot((3, 4, 5), e) / 12 for e in zip(a, b, middle))
        need(set(enclosed(faces, x, own)) <= {0, 1}, "a block is inside out, or in itself")
    return corners, set(both), faces, density * volume, tuple(density * x for x in moment)


def inside(sides, p, u, v):  # of a polygon, seen along the third axis
    cuts = [(a, b) for a, b in sides if (a[v] > p[v]) != (b[v] > p[v])]
    return sum(p[u] < a[u] + (p[v] - a[v]) * (b[u] - a[u]) / (b[v] - a[v]) for a, b in cuts) % 2


def enclosed(faces, x, n):  # how often faces enclose the points next to x along n, and against n
    k = max(range(3), key=lambda axis: abs(n[axis]))
    u, v = [axis for axis in range(3) if axis != k]
    across, along, times = float(x[u]), float(x[v]), [0, 0]
    for sides, areas, _, middle, box in faces:
        if box[u][0] <= across <= box[u][1] and box[v][0] <= along <= box[v][1]:
            for (a, b), own in zip(sides, areas):
                if own[k] and inside([(middle, a), (a, b), (b, middle)], x, u, v):
                    rise, sign = dot(own, plus(middle, x, -1)) / own[k], 1 if own[k] > 0 else -1
                    times = [times[0] + sign * (rise > THIN), times[1] + sign * (rise > -THIN)]
    return times if n[k] > 0 else times[::-1]


def closest(p, a, b):  # point of a line from a to b
    along = plus(b, a, -1)
    return plus(a, along, min(max(dot(plus(p, a, -1), along) / dot(along, along), 0), 1)) if a != b else a


def near(p, a, b, reach):
    off = plus(p, closest(p, a, b), -1)
    return dot(off, off) <= reach**2


def over(face, q, margin):  # whether q is on a face in its plane, off its rim by a margin, or beside it by - margin
    *uv, _ = sorted(range(3), key=lambda k: abs(face[2][k]))
    within, rim = inside(face[0], q, *uv), (near(q, a, b, abs(margin)) for a, b in face[0])
    return within and not any(rim) if margin > 0 else within or any(rim)


def foot(q, face, n):  # of a point in the plane of a face, along n
    return tuple(round(e, 15) for e in plus(q, n, dot(face[2], plus(face[3], q, -1)) / dot(face[2], n)))


def level(face, n):  # the face with its sides in its plane
    return [(foot(a, face, n), foot(b, face, n)) for a, b in face[0]], *face[1:]


def bounds(faces, face, q, n):  # whether over q, seen along n, a face has the solid behind it, and nothing before it
    sides, areas, whole, middle, _ = face
    *uv, _ = sorted(range(3), key=lambda k: abs(whole[k]))
    for (a, b), own in zip(sides, areas):
        if dot(own, whole) > 0 and dot(own, n):
            x = plus(q, n, dot(own, plus(middle, q, -1)) / dot(own, n))
            if inside([(middle, a), (a, b), (b, middle)], x, *uv) and enclosed(faces, x, whole) == [0, 1]:
                return True
    return False


def steps(faces, reach):  # how far beside a point is looked, and what is on a rim: small beside the least of the faces
    size = min(sum(Q(high - low) for low, high in face[4]) for face in faces)
    return [(4 * reach + size / 10**5) / part for part in (1000, 30, 1, 10**5)], min(
        max(reach, size / 10**12), size / 10**7
    )


def spots(p, faces, n, reach):  # points next to p that are on all of these faces, and off their rims
    (offs, margin), faces = steps(faces, reach), [level(face, n) for face in faces]
    ways = [plus(b, a, -1) for face in faces for a, b in face[0] if near(p, a, b, max(offs))]
    ways = [way for d in ways for t in (d, cross(n, d)) for way in (t, plus(t, t, -2))]
    ways = list(
        dict.fromkeys(tuple(Q(round(1000 * float(e) / float(dot(d, d)) ** 0.5), 1000) for e in d) for d in ways)
    )
    aside = (plus(p, plus(d, e), off) for off in offs for k, d in enumerate(ways) for e in ways[k:])
    return (q for q in chain([p], aside) if all(over(face, foot(q, face, n), margin) for face in faces))


def solid(sides, p, n, reach):  # whether next to p faces of blocks bound them
    found = spots(p, [face for _, face in sides], n, reach)
    return any(all(bounds(block[2], face, foot(q, face, n), n) for block, face in sides) for q in found)


def behind(block, q, n, reach, sine, margin):  # whether all of a surface near q, `reach` along n, is behind n
    squash, ways = min(margin / reach / 2 - 1, 0) if reach else 0, []
    for sides, _, whole, _, box in block[2]:
        if all(Q(low) - 3 * reach <= e <= Q(high) + 3 * reach for e, (low, high) in zip(q, box)):
            for (a, b), (_, c) in zip(sides, sides[1:] + sides[:1]):
                x, y = (plus(e, n, squash * dot(n, plus(e, q, -1))) for e in (a, b))
                if (end := near(q, y, y, margin)) or (near(q, x, y, margin) and not near(q, x, x, margin)):
                    one, two = plus(b, a, -1), plus(c, b, -1) if end else plus(b, a, -1)
                    ways += plus(a, b, -1), two
                    if dot(one, two) >= 0 or dot(cross(one, two), whole) <= 0:  # else the corner of the face is acute
                        ways += cross(whole, one), cross(whole, two)
    return all(max(dot(way, n), 0) ** 2 <= 2 * sine**2 * dot(way, way) for way in ways)


def touches(block, on, p, n, reach, sine):  # p is on a face [f], an edge [i, j] or a corner [i, i], n outward there
    corners, edges, faces = block[:3]
    if on is None:
        return need(all(min(x) - reach <= e <= max(x) + reach for e, x in zip(p, zip(*corners))), "a tie ends nowhere")
    if len(on) == 1:
        sides, _, whole, middle, _ = faces[on[0]]
        turn, square = cross(whole, n), dot(whole, whole)
        need(dot(whole, n) > 0 and dot(turn, turn) <= sine**2 * square * dot(n, n), "a normal is not that of its face")
        off = [dot(whole, plus(x, middle, -1)) ** 2 <= reach**2 * square for x in (p, *(a for a, _ in sides))]
        need(off[0], "a contact is off its face")
        need(all(off), "a face with a contact is not flat")
        return need(over(faces[on[0]], p, -2 * reach), "a contact is beside its face")
    (i, j), along = on, plus(corners[on[1]], corners[on[0]], -1)
    need((i == j or (i, j) in edges) and near(p, corners[i], corners[j], reach), "a contact is off its edge or corner")
    need(dot(along, n) ** 2 <= sine**2 * dot(along, along) * dot(n, n), "a normal is not square to its edge")


def meet(blocks, on, p, n, reach, sine):  # whether blocks overlap as soon as they come nearer along n at p
    ends = [[block[0][k] for k in place] if len(place) == 2 else [] for block, place in zip(blocks, on)]
    own = [  # the faces at p: the one of the place, or those around the edge or the corner
        [face for face in b[2] if any({*e} <= {*side} for side in face[0])] if e else [b[2][place[0]]]
        for b, e, place in zip(blocks, ends, on)
    ]
    if not any(ends) and solid([(b, face) for b, (face,) in zip(blocks, own)], p, n, reach):
        return  # next to p they share more than a line
    for block, faces in zip(blocks, own):
        need(any(solid([(block, face)], p, face[2], reach) for face in faces), "a contact is on no solid")
    need(any(ends), "faces meet at their rims alone")
    offs, margin = steps(own[0] + own[1], reach)
    for k, out in enumerate((n, plus(n, n, -2))):
        if ends[k]:
            (a, b), (face, *_), more = ends[k], own[1 - k], (out, reach, sine, margin)
            x, along = closest(p, a, b), plus(b, a, -1)
            aside = [off / Q(float(dot(along, along)) ** 0.5) for off in offs] if a != b and not ends[1 - k] else []
            trials = [closest(plus(x, along, t), a, b) for t in (0, *aside, *(-t for t in aside))]
            ahead = [(q, plus(q, out, offs[0])) for q in trials if behind(blocks[k], q, *more)]
            trials = [q for q, x in ahead if enclosed(blocks[k][2], x, out) == [0, 0]]
            need(trials, "a block crosses its contact")
            if ends[1 - k]:  # edges cross, each between its ends
                need(not near(x, a, a, margin) and not near(x, b, b, margin), "an edge is met at its end")
            else:  # it is on what fills the half-space behind a face
                feet = [q for q in (foot(q, face, n) for q in trials) if over(level(face, n), q, -margin)]
                need(any(behind(blocks[1 - k], q, *more) for q in feet), "a contact is on the rim of its face")


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
    most = law.get("most", law.get("apex", 0))  # of a force without bound the part that is cohesion
    taken = Q(most if price > 0 else law.get("least", 0)) * price + Q(law.get("shear", 0)) * root
    return Q(law.get("apex", 0)) * head + taken, (root if rough else 0) + (max(price, 0) if free else 0)


def printed(value, rounding):  # with twelve digits, to the side on which the statement stays true
    return Context(12, rounding).divide(value.numerator, value.denominator)


def check(file):
    need(fits(file, FILE), "the file is not of the format")
    digest = {key: json.dumps(file[key], sort_keys=True, separators=(",", ":")).encode() for key in ("data", "proof")}
    need(file["sha256"] == {k: hashlib.sha256(d).hexdigest() for k, d in digest.items()}, "the hash is another one")
    data, proof, said, contacts = file["data"], file["proof"], [], []
    blocks, g = [body(b) for b in data["blocks"]], numbers(data["gravity"])
    free, fixed = ([i for i, b in enumerate(data["blocks"]) if b["fixed"] is what] for what in (False, True))
    reach, sine = Q(data["distance"]), Q(data["sine"])
    need(reach >= 0 and 0 <= sine < 1, "a tolerance is none")
    for c in data["contacts"]:
        kinds = [key for key in ROWS if key in c]
        need(len(kinds) == 1, "a law is none")
        need(fits(c, ROWS[kinds[0]]), "a contact is not of the format")
        n, (a, b), tie, mu = numbers(c["normal"]), c["blocks"], "ends" in c, c.get("friction", "0")
        (p, q), on = map(numbers, c["ends"] if tie else [c["point"]] * 2), c.get("on", [[0], [0]])
        least, line = Q(c.get("least", 0)), plus(q, p, -1)
        unit, turn, shear = abs(dot(n, n) - 1) < Q(1, 10**12), cross(line, n), Q(c.get("shear", 0))
        need(a != b, "a contact is none")
        need(least <= Q(c.get("most", "1e99")) and shear >= 0 and (mu == "inf" or Q(mu) >= 0), "a law is none")
        need(("shear" in c or least >= 0) and c.get("couple", True), "a law is none")
        ridges = [plus(*(blocks[k][0][i] for i in ends), -1) for k, ends in zip((a, b), on) if len(ends) == 2]
        skew = cross(*ridges) if len(ridges) == 2 else None
        need(
            unit and (not skew or dot(skew, skew) > sine * dot(*ridges[:1] * 2) * dot(*ridges[1:] * 2)),
            "a contact has no normal",
        )
        need(dot(turn, turn) <= sine**2 * dot(line, line) and any(line) is tie, "a tie is not along its ends")
        for k, place, end, sign in zip((a, b), on, (p, q), (0, -2), strict=True):
            if not tie or k in free:
                touches(blocks[k], None if tie else place, end, plus(n, n, sign), reach, sine)
        if not tie:
            meet((blocks[a], blocks[b]), on, p, n, reach, sine)
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
        said.append("PROVED stable" + (f" at {printed(many, ROUND_FLOOR)} times the live load" if varies else ""))
    if "motion" in proof:
        motion = [numbers(u, 6) for u in proof["motion"]]
        need(len(motion) == len(blocks) and not any(any(motion[i]) for i in fixed), "a fixed block moves")
        power, drive, closing = *(sum(dot(load[i], motion[i]) for i in free) for load in (dead, live)), 0
        for c, a, b, p, n in contacts:
            u = plus(motion[b], motion[a], -1)
            taken, closes = resists(c, n, u[3:] if "couple" in c else plus(u[:3], cross(u[3:], p)))
            power, closing = power - taken, max(closing, closes)
        need(Q(proof.get("bound", 1)) >= 1, "a bound is none")
        power -= Q(proof.get("bound", 1)) * closing * sum(abs(x) for i in free for x in dead[i][:3])
        need(drive > 0 if varies else power > 0, "the loads do not drive the motion")
        said.append(
            "PROVED unstable"
            + (f" beyond {printed(-power / drive, ROUND_CEILING)} times the live load" if varies else "")
        )
        said[-1] += f", whatever forces of up to {proof.get('bound', 1)} dead loads resist" if closing else ""
    where = f"within {data['distance']} m and a sine of {data['sine']}, data {file['sha256']['data']}"
    other = sum("friction" not in c for c in data["contacts"])
    return [*said, f"{len(free)} free blocks, {len(contacts)} contacts ({other} of bonds and ties) {where}"]


def once(pairs):
    need(len(dict(pairs)) == len(pairs), "a key is given twice")
    return dict(pairs)


if __name__ == "__main__":
    try:
        print(*check(json.load(open(sys.argv[1], encoding="utf-8"), object_pairs_hook=once)), sep="\n")
    except Exception as reason:
        sys.exit(print(f"REJECTED: {reason if type(reason) is ValueError else repr(reason)}") or 1)
