"""Buttresses standing against a wall."""

from __future__ import annotations

from blockstat.assembly import Block
from blockstat.errors import InputError
from blockstat.model.walling.short_wall import Courses, WallFrame
from blockstat.spec import Buttress, value_of


def build_buttresses(frame: WallFrame, spec: Buttress, course_height: float) -> list[Block]:
    """Blocks of the buttresses of one wall, one block a course.

    The procedural-masonry paper, Eqs. 3-5: DistanceAmongButtresses = LongitudeRow / (number + 1), centred
    between the wall's ends, perpendicular to the wall.
    """
    number, width = round(value_of(spec.number)), value_of(spec.width)
    height, projection = value_of(spec.height), value_of(spec.thickness)
    spacing = frame.length / (number + 1)
    if number and width > spacing:
        raise InputError(
            f"buttresses.{frame.name}: {number} buttresses of {width:.3g} m width "
            f"do not fit a wall of {frame.length:.3g} m"
        )
    courses = Courses.filling(height, course_height)
    sign = 1.0 if frame.outward > 0 else -1.0
    depth = (frame.outward, frame.outward + sign * projection)
    blocks = []
    for k in range(number):
        centre, group = spacing * (k + 1), f"buttress.{frame.name}.{k + 1}"
        for course in range(courses.number):
            z = (course * courses.height, (course + 1) * courses.height)
            blocks.append(frame.block((centre - width / 2, centre + width / 2), depth, z, f"{group}.{course}", group))
    return blocks
