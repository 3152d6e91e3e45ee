"""The paper's buttress loop: buttresses are added to the walls that crack, until none does.

This is procedural masonry, section 4, as read here. All buttresses are cleared. If the building cracks, each wall gets
one. Cracks are then counted wall by wall, and a wall that cracks gets one more, spaced anew by Eqs. 3-5
(`blockstat.model.walling.run.spaced`). Where no more fit side by side, the buttresses of that wall grow by a
step of their thickness and their number starts again at one. Each wall ends with a number and a thickness of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import asdict, dataclass
from typing import Any

import msgspec

from blockstat.assembly import Assembly
from blockstat.errors import InputError, known_options
from blockstat.result import Result, Sentence
from blockstat.spec import Building, Range, build, value_of
from dynsim.judge.verdict import DynamicVerdict

#: Walls from which a barrel vault springs: cracks of the vault alone are theirs.
SPRINGING: tuple[str, ...] = ("south", "north")


@dataclass(frozen=True)
class ButtressStep:
    """One building of the loop."""

    number: dict[str, int]  #: of buttresses, by wall
    thickness: dict[str, float]  #: of the buttresses, by wall [m]
    cracks: dict[str, int]  #: cracked joints, by wall; only walls that crack
    blocks: int
    outcome: str  #: word of the dynamic verdict
    process_seconds: float


class ButtressOutcome(Sentence):
    """How the loop ended; the value of each is the sentence that a user reads."""

    SOUND = "Sound: the last building stands and no joint of it cracks."
    CRACKED = "Cracked: walls crack, and none of them takes more or thicker buttresses."


@dataclass(frozen=True)
class ButtressResult(Result):
    """The buildings of the loop, and whether the last one has no crack."""

    steps: tuple[ButtressStep, ...]
    building: Building  #: the last one
    sound: bool  #: False where walls crack that have no room for more

    @property
    def outcome(self) -> ButtressOutcome:
        """How the loop ended."""
        return ButtressOutcome.SOUND if self.sound else ButtressOutcome.CRACKED

    def explain(self) -> str:
        """Return the answer and the buttresses of each building, one building a line.

        Returns
        -------
        str
            One fact a line.
        """
        lines = [self.outcome.value]
        for step in self.steps:
            sizes = (f"{wall} {n} of {step.thickness[wall]:g} m" for wall, n in step.number.items() if n)
            cracks = ", ".join(f"{wall} {n}" for wall, n in step.cracks.items()) or "none"
            lines.append(f"Buttresses: {', '.join(sizes) or 'none'}. Bullet: {step.outcome}. Cracks: {cracks}.")
        return "\n".join(lines)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "steps": [asdict(step) for step in self.steps],
        }


@known_options
def buttress_loop(
    building: Building,
    verify: Callable[[Assembly], DynamicVerdict],
    *,
    progress: Callable[[ButtressStep], None] | None = None,
) -> ButtressResult:
    """Give each wall of a building the buttresses it needs to stand without a crack.

    Parameters
    ----------
    building : Building
        Its `buttresses` say which walls may have some, their width and height, and their thickness: a number, or a
        range to go through from its smallest value up. Whether they are present is for the loop to say.
    verify : callable
        Gives the dynamic verdict on an assembly. Its cracks count; a fall without any counts as one of the walls from
        which the vault springs.
    progress : callable, optional
        Called with each `ButtressStep`.

    Returns
    -------
    ButtressResult
        All buildings of the loop, and whether the last one has no crack.

    Raises
    ------
    InputError
        When no wall may have buttresses. Also for an option that does not exist.
    """
    sizes = {wall: sorted(_sizes(spec.thickness)) for wall, spec in building.buttresses.items()}
    if not sizes:
        raise InputError(f'"{building.name}" has no buttresses to set; write them as [buttresses.south] and so on')
    number, place = dict.fromkeys(sizes, 0), dict.fromkeys(sizes, 0)
    steps: list[ButtressStep] = []
    while True:
        tried = _with(building, number, {wall: sizes[wall][place[wall]] for wall in sizes})
        steps.append(_judged(tried, verify))
        if progress is not None:
            progress(steps[-1])
        if not steps[-1].cracks and steps[-1].outcome == "stands":
            return ButtressResult(tuple(steps), tried, True)
        failing = sizes if not any(number.values()) else [wall for wall in steps[-1].cracks if wall in sizes]
        if not [wall for wall in failing if _strengthened(building, wall, number, place, sizes)]:
            return ButtressResult(tuple(steps), tried, False)


def _sizes(thickness: float | Range) -> list[float]:
    return thickness.steps() if isinstance(thickness, Range) else [thickness]


def _strengthened(
    building: Building, wall: str, number: dict[str, int], place: dict[str, int], sizes: dict[str, list[float]]
) -> bool:
    """Put one more buttress to a wall, or thicker ones; False if there is no room for either."""
    for count, size in ((number[wall] + 1, place[wall]), (1, place[wall] + 1)):
        if size >= len(sizes[wall]):
            continue
        try:
            build(_with(building, {wall: count}, {wall: sizes[wall][size]}))
        except InputError:
            continue
        number[wall], place[wall] = count, size
        return True
    return False


def _with(building: Building, number: dict[str, int], thickness: dict[str, float]) -> Building:
    """Return the building with so many buttresses, so thick, at the walls named, and none at the others."""
    buttresses = {
        wall: msgspec.structs.replace(spec, number=number[wall], thickness=thickness[wall], present=True)
        for wall, spec in building.buttresses.items()
        if number.get(wall)
    }
    return msgspec.structs.replace(building, buttresses=buttresses)


def _judged(building: Building, verify: Callable[[Assembly], DynamicVerdict]) -> ButtressStep:
    assembly = build(building)
    verdict = verify(assembly)
    cracks = cracks_by_wall(verdict.cracks.per_group())
    if not cracks and verdict.outcome.word != "stands":
        cracks = {wall: 1 for wall in SPRINGING}
    return ButtressStep(
        number={wall: int(value_of(spec.number)) for wall, spec in building.buttresses.items()},
        thickness={wall: float(value_of(spec.thickness)) for wall, spec in building.buttresses.items()},
        cracks=cracks,
        blocks=assembly.n_blocks,
        outcome=verdict.outcome.word,
        process_seconds=verdict.run.process_seconds,
    )


def cracks_by_wall(per_group: dict[str, int]) -> dict[str, int]:
    """Return the cracks of each wall, its buttresses and what rests on it.

    Parameters
    ----------
    per_group : dict of str to int
        Cracks by group, as `Cracks.per_group` gives them.

    Returns
    -------
    dict of str to int
        Cracks by wall; those of the vault alone are those of the walls from which it springs.
    """
    found: dict[str, int] = {}
    for groups, count in per_group.items():
        walls = {w for group in groups.split(" | ") for w in _wall_of(group)}
        for wall in walls or SPRINGING:
            found[wall] = found.get(wall, 0) + count
    return found


def _wall_of(group: str) -> Iterable[str]:
    kind, _, rest = group.partition(".")
    return [rest.split(".")[0]] if kind in ("wall", "buttress") else []
