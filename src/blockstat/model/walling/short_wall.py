"""Walls of one leaf with openings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model.solids import box
from blockstat.model.walling.short_bond import Lintel, Void, brick_length, lay_row
from blockstat.spec import Opening, value_of

Point = tuple[float, float, float]


@dataclass(frozen=True)
class WallFrame:
    """Where a wall stands: `place(s, d, z)` takes a length along it and a depth into it to x, y, z."""

    name: str
    length: float
    thickness: float
    height: float
    place: Callable[[float, float, float], Point]
    outward: float  #: depth of the outer face, 0 or the thickness

    def block(
        self, s: tuple[float, float], d: tuple[float, float], z: tuple[float, float], name: str, group: str
    ) -> Block:
        """A box between two lengths, two depths and two heights."""
        corners = [self.place(s[i], d[i], z[i]) for i in (0, 1)]
        lower = tuple(min(a, b) for a, b in zip(*corners, strict=True))
        upper = tuple(max(a, b) for a, b in zip(*corners, strict=True))
        return box(lower, upper, name=name, group=group)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Courses:
    """Equal courses that fill a height."""

    number: int
    height: float

    @classmethod
    def filling(cls, height: float, nominal: float) -> Courses:
        number = max(round(height / nominal), 1)
        return cls(number, height / number)


def build_wall(frame: WallFrame, brick: tuple[float, float], openings: Sequence[tuple[str, Opening]]) -> list[Block]:
    """Bricks of a wall. brick : nominal length and height; openings : (path in the scene, opening)."""
    courses = Courses.filling(frame.height, brick[1])
    length = brick_length(frame.length, brick[0])
    gaps: list[list[Void | Lintel]] = [[] for _ in range(courses.number)]
    for path, opening in openings:
        _cut_openings(frame, courses, length, path, opening, gaps)
    group = f"wall.{frame.name}"
    uncut = [lay_row(frame.length, length, course) for course in (0, 1)]
    blocks = []
    for course, cuts in enumerate(gaps):
        z = (course * courses.height, (course + 1) * courses.height)
        row = lay_row(frame.length, length, course, cuts) if cuts else uncut[course % 2]
        for i, stretch in enumerate(row):
            blocks.append(frame.block(stretch, (0.0, frame.thickness), z, f"{group}.{course}.{i}", group))
    return blocks


def _cut_openings(
    frame: WallFrame,
    courses: Courses,
    brick: float,
    path: str,
    opening: Opening,
    gaps: list[list[Void | Lintel]],
) -> None:
    """Mark the voids and the lintel of evenly spaced openings in the courses they touch."""
    number, width = round(value_of(opening.number)), value_of(opening.width)
    bottom = round(value_of(opening.sill) / courses.height)
    top = max(round((value_of(opening.sill) + value_of(opening.height)) / courses.height), bottom + 1)
    if number and top >= courses.number:
        raise InputError(
            f"{path}: sill and height reach {top * courses.height:.3g} m, the wall is {frame.height:.3g} m high; "
            "leave one course for the lintel"
        )
    for k in range(number):
        centre = frame.length * (k + 1) / (number + 1)
        void = Void(centre - width / 2, centre + width / 2)
        lintel = Lintel(void.start - brick / 2, void.end + brick / 2)
        for course, gap in [(c, void) for c in range(bottom, top)] + [(top, lintel)]:
            clash = any(gap.start < other.end and other.start < gap.end for other in gaps[course])
            if clash or gap.start < 0 or gap.end > frame.length:
                raise InputError(
                    f"{path}: {number} openings of {width:.3g} m with their lintels do not fit a wall of "
                    f"{frame.length:.3g} m, or meet another opening"
                )
            gaps[course].append(gap)
