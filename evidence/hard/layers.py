"""Beds and plates that are thousands of times thinner than what they carry."""

from __future__ import annotations

import numpy as np

from blockstat import Assembly, JointLaw
from evidence.hard.cases import REFUSED, STABLE, UNSTABLE, Case, pushed
from evidence.hard.figures import Figure, Section, at_change, end_of_curve, limit
from evidence.hard.linkages import bedded, first_mechanism
from evidence.scenes.small import assembly, box, hexahedron, stack

WIDE = 0.5  #: of a stone [m]
STONES = 5
BEDS = (1e-3, 1e-4, 1e-5)  #: [m]


def pillar(bed: float, stones: int = STONES, *, cover: float = WIDE, slip: float | None = None) -> Assembly:
    """Stones of 1 m, each on a bed that reaches so far below it, with a friction of its own."""
    blocks, top = [box((-5, -5, -1), (5, 5, 0), name="ground", group="stone")], 0.0
    for k in range(stones):
        blocks.append(box((0, 0, top), (cover, 1, top + bed), name=f"bed{k}", group="bed"))
        blocks.append(box((0, 0, top + bed), (WIDE, 1, top + bed + 1), name=f"stone{k}", group="stone"))
        top += bed + 1
    laws = [] if slip is None else [JointLaw(("bed", "*"), friction=slip)]
    return assembly(blocks, joints=laws)


def tips(bed: float, stones: int = STONES) -> float:
    """Half the width over half the height."""
    return WIDE / (stones * (1 + bed))


def leaning(plates: int, thickness: float, share: float) -> Assembly:
    """Plates of 1 m, the k-th from the top out by a share of 1 / (2 k) over the next one, the last over a table."""
    blocks, end = [box((-9, 0, -1), (0, 1, 0), name="table")], 0.0
    for level, k in enumerate(range(plates, 0, -1)):
        end += share / (2 * k)
        blocks.append(box((end - 1, 0, level * thickness), (end, 1, (level + 1) * thickness), name=f"plate{level}"))
    return assembly(blocks)


def bedded_arch(bed: float, voussoirs: int = 10, thickness: float = 0.2) -> Assembly:
    """A semicircular arch of radius 1 with a bed in every joint, half of it taken from either voussoir."""
    joint, half, feet = np.linspace(np.pi, 0, voussoirs + 1), bed / 2, 0.3

    def wedge(left: float, right: float, name: str):
        rays = [(1 + side * thickness / 2, a) for side, a in ((-1, right), (1, right), (1, left), (-1, left))]
        plan = [(r * np.cos(a), r * np.sin(a)) for r, a in rays]
        return hexahedron([(x, 0.5, z) for x, z in plan], [(x, 0, z) for x, z in plan], name=name)

    blocks = [wedge(np.pi + feet, np.pi + half, "left"), wedge(-half, -feet, "right")]
    blocks += [wedge(a + half, a - half, f"bed{k}") for k, a in enumerate(joint)]
    blocks += [
        wedge(a - half, b + half, f"voussoir{k}") for k, (a, b) in enumerate(zip(joint[:-1], joint[1:], strict=True))
    ]
    return assembly(blocks, supports=[0, 1], friction=0.9)


def first_jump(bed: float) -> float:
    """Mean displacement at which the arch changes its hinges: from one face of a bed to the other."""
    linkage = first_mechanism(bedded(10, 0.2, bed))
    return linkage.displacement(linkage.change()[1])


def last_jump(bed: float) -> float:
    """Mean displacement at which the thrust reaches the extrados near the crown, where no state follows."""
    linkage = first_mechanism(bedded(10, 0.2, bed))
    first, second, third, fourth = linkage.hinges
    linkage = type(linkage)(linkage.ring, (first + 1, second, third, fourth))
    return linkage.displacement(linkage.change(start=0.05)[1])


CASES = (
    *(
        Case("thin beds", f"{STONES} stones of 1 m on beds of {bed:.0e} m, 1 {sign} 1e-06 of the limit",
             pushed(lambda bed=bed: pillar(bed), tips(bed) * (1 + factor * 1e-6)), right, "b / (n (1 + t))")
        for bed in BEDS for sign, factor, right in (("-", -1, STABLE), ("+", 1, UNSTABLE))
    ),
    *(
        Case("thin beds", f"stone on a bed of {bed:.0e} m that ends {end} its centroid",
             lambda bed=bed, cover=cover: pillar(bed, 1, cover=cover), right, "weight inside the bed or not")
        for bed in BEDS[::2] for end, cover, right in (("1 mm beyond", 0.251, STABLE), ("1 mm before", 0.249, UNSTABLE))
    ),
    Case("thin beds", "stone on a bed of 1e-07 m", lambda: pillar(1e-7, 1), REFUSED, "stated: it is flat"),
    *(
        Case("thin plates", f"50 plates of {thickness:.0e} m that lean out by 1 {sign} 1e-06 of the harmonic series",
             lambda thickness=thickness, share=1 + factor * 1e-6: leaning(50, thickness, share), right, "H(50) / 2")
        for thickness in BEDS for sign, factor, right in (("-", -1, STABLE), ("+", 1, UNSTABLE))
    ),
    *(
        Case("thin plates", f"{number} plates of 1e-03 m, pushed by 1 {sign} 1e-06 of the limit",
             pushed(lambda number=number: stack(number, 1.0, 1e-3), 1e3 / number * (1 + factor * 1e-6)), right,
             "b / (n t)", {"friction": np.inf}, near=number > 100)
        for number in (100, 300) for sign, factor, right in (("-", -1, STABLE), ("+", 1, UNSTABLE))
    ),
)  # fmt: skip
FIGURES = (
    *(
        Figure(f"limit load of {STONES} stones on beds of {bed:.0e} m", limit(lambda bed=bed: pillar(bed), (1, 0, 0)),
               tips(bed), "b / (n (1 + t))")
        for bed in BEDS
    ),
    *(
        Figure(f"the same with a friction of 0.05 on beds of {bed:.0e} m",
               limit(lambda bed=bed: pillar(bed, slip=0.05), (1, 0, 0)), 0.05, "slides on a bed")
        for bed in BEDS[::2]
    ),
    *(
        Figure(f"three stones on beds of {bed:.0e} m turn until the whole is over its toe",
               end_of_curve(lambda bed=bed: pillar(bed, 3), (1, 0, 0), "mean"), WIDE / 2, "b / 2", word="zero",
               bracket=False)
        for bed in BEDS[2:]
    ),
    *(
        Figure(f"limit load of {number} plates of 1e-04 m",
               limit(lambda number=number: stack(number, 1.0, 1e-4, friction=np.inf), (1, 0, 0)), 1e4 / number,
               "b / (n t)")
        for number in (30, 100)
    ),
    *(
        Figure(f"arch with beds of {bed:.0e} R: hinge to the other face of its bed",
               at_change(lambda bed=bed: bedded_arch(bed), (1, 0, 0), "mean"), lambda bed=bed: first_jump(bed),
               "four-bar linkage", word="jump", bracket=False, slow=True)
        for bed in (1e-2, 1e-4)
    ),
    *(
        Figure(f"arch with beds of {bed:.0e} R: collapse",
               end_of_curve(lambda bed=bed: bedded_arch(bed), (1, 0, 0), "mean"), lambda bed=bed: last_jump(bed),
               "four-bar linkage", word="collapse", bracket=False, slow=True)
        for bed in (1e-2, 1e-4, 1e-5, 5e-6)
    ),
)  # fmt: skip
SECTION = Section(
    "Thin layers",
    """A pillar whose joints stay shut tips about its toe: half its width over half its height, beds and all. A joint
beside a bed is open, however little, so a stone whose weight passes beside the end of its bed tips. Plates lean out as
far as the harmonic series, which does not know how thick they are. An arch with beds is a four-bar linkage at first:
`evidence/hard/linkages.py` computes where the thrust reaches the next joint, without blockstat. With a bed in each
joint that is the other face of the same bed, so hinges change between joints that are as close as the bed is thick.""",
    CASES,
    FIGURES,
)
