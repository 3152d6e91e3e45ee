"""A composition to an assembly: its elements built, put in place and stood on their supports."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from fnmatch import fnmatchcase
from functools import cache, partial
from itertools import product
from math import prod
from operator import eq
from typing import Any, TypeVar

import msgspec
import numpy as np

from blockstat.assembly import Assembly, Block
from blockstat.contact.overlap.penetration import overlaps
from blockstat.errors import InputError, gathered, no_such
from blockstat.joint import JointLaw, check_laws, fits
from blockstat.model.ground import ground
from blockstat.model.placing import moved, rotation
from blockstat.model.size import blocks_asked, check_block_count
from blockstat.spec.chapel import lowered
from blockstat.spec.composition import GROUND, Composition, Plan, resolve
from blockstat.spec.element import Element, Repeat, repeats_of
from blockstat.spec.elements import absent_parts, blocks_of, kind_of
from blockstat.spec.material import KEYS, stages_from
from blockstat.spec.scene import Scene, parameters

T = TypeVar("T")
#: Depth of an overlap of elements that is an error, relative to the smaller block; rounding makes less.
OVERLAP = 1e-4
#: A block stands on the ground when its foot is as near to z = 0 as this, relative to its height.
FOOT = 1e-6


def build(scene: Scene) -> Assembly:
    """The assembly of a scene of either form.

    A block of the element "nave" has names and groups that begin with "nave."; where the element is repeated, its
    copies are "nave.1", "nave.2", ... The groups of a `Building` are those of `lowered`.

    Parameters
    ----------
    scene : Building or Composition
        Its ranges count with their values.

    Returns
    -------
    Assembly
        On its supports.

    Raises
    ------
    InputError
        Naming the element or the key at fault, and two elements that overlap.

    Examples
    --------
    >>> from blockstat import build, scene_from
    >>> post = {"kind": "pier", "size": [0.5, 0.5], "height": 1.0, "courses": 2}
    >>> build(scene_from({"name": "gate", "elements": {"post": post}})).names
    ('ground', 'post.pier.0.0', 'post.pier.1.0')
    """
    plan = _planned(scene)
    blocks = [block for own in _of_each_element(plan, _placed) for block in own]
    if not blocks:
        raise InputError(f'"{plan.name}": no element is present; there is nothing to build')
    if GROUND in plan.supports:
        _check_feet(blocks)
        blocks = [ground(blocks), *blocks]
    moving = [path for path, found in parameters(scene).items() if len(found.steps()) > 1]
    known = all(path.rpartition(".")[2] == "present" for path in moving)  # other ranges may make other parts
    absent = cache(partial(_absent_groups, plan, known=known))
    assembly = Assembly.from_blocks(
        blocks,
        supports=_supports(plan, blocks, absent),
        name=plan.name,
        density=plan.material.density,
        friction=plan.material.friction,
        joints=_laws(plan, dict.fromkeys(block.group for block in blocks), absent),
        ties=plan.ties,
        metadata={
            "parameters": {path: found.value for path, found in parameters(scene).items()},
            # What the blocks do not say themselves: friction and density may be changed after.
            "material": {key: getattr(plan.material, key) for key in ("glue", "rotational_stiffness")},
            **{key: own for key, own in _tables(plan) if own},
        },
    )
    if empty := _empty_groups(plan, assembly, absent, moves=bool(moving)):
        assembly = assembly.with_(metadata={**assembly.metadata, "absent": empty})
    if not plan.no_overlap:
        _check_elements_apart(assembly)
    return assembly


class FreeVolumes:
    """Volumes of scenes that share elements: an element is built once for each set of its keys.

    What elements do to each other is not looked at: a scene may have a volume and not be built, as they overlap.
    """

    def __init__(self) -> None:
        self._known: dict[bytes, dict[str, float]] = {}

    def of(self, scene: Scene) -> float:
        """The volume of the blocks of a scene that are no supports [m3].

        Parameters
        ----------
        scene : Building or Composition
            Its ranges count with their values.

        Returns
        -------
        float
            As of the assembly that `build` makes, to rounding.

        Raises
        ------
        InputError
            Naming the element at fault.
        """
        plan = _planned(scene)
        fixed = [wanted.split(".") for wanted in plan.supports]
        return sum(
            volume
            for groups in _of_each_element(plan, self._by_group)
            for group, volume in groups.items()
            if not any(_within(group.split("."), wanted) for wanted in fixed)
        )

    def _by_group(self, name: str, element: Element) -> dict[str, float]:
        key = msgspec.msgpack.encode((name, element))
        if key not in self._known:
            blocks = _placed(name, element)
            found = dict.fromkeys((block.group for block in blocks), 0.0)
            volumes = Assembly.from_blocks(blocks).volume.tolist() if blocks else []
            for block, volume in zip(blocks, volumes, strict=True):
                found[block.group] += volume
            self._known[key] = found
        return self._known[key]


def _planned(scene: Scene) -> Plan:
    return resolve(scene) if isinstance(scene, Composition) else lowered(scene)


def _of_each_element(plan: Plan, what: Callable[[str, Element], T]) -> list[T]:
    """What there is of each element by its name, or the errors of all in the words of the scene."""
    try:
        _check_numbers(plan)
        return gathered(partial(what, name, element) for name, element in plan.elements.items())
    except InputError as error:
        raise InputError(*(_said(text, plan.keys) for text in error.args)) from None


def _tables(plan: Plan) -> list[tuple[str, Any]]:
    """What a plan says of its loads, their cases, its stages and what is random, for those who judge the assembly."""
    tables = [("loads", plan.loads), ("cases", plan.cases), ("stages", list(plan.stages))]
    return [*tables, ("uncertain", plan.uncertain)]


def _empty_groups(plan: Plan, assembly: Assembly, absent: Callable[[], list[str]], *, moves: bool) -> list[str]:
    """The groups of stages and random variables that are absent by choice: whoever judges takes them for empty.

    InputError for one that is neither there nor absent by choice. Where a range moves, it may be a part of what is
    there at other values: then only who judges the assembly refuses it.
    """
    named = [
        (f'stages.{k} ("{stage.name}")', group)
        for k, stage in enumerate(stages_from(plan.stages))
        for group in (*stage.place, *stage.centring)
    ]
    named += [(f"uncertain.{key}", key.partition(".")[2]) for key in plan.uncertain if key not in KEYS]
    first = {own.split(".")[0] for own in assembly.groups} if moves else set()
    wrong, empty = [], set[str]()
    for where, group in named:
        if any(fits(group, own) for own in assembly.groups):
            continue
        if _is_absent(group, absent(), eq):
            empty.add(group)
        elif group.split(".")[0] not in first:
            wrong.append(str(no_such("group", group, sorted({own for own in assembly.groups if own})).under(where)))
    if wrong:
        raise InputError(*wrong)
    return sorted(empty)


def _said(message: str, keys: Mapping[str, str]) -> str:
    """A message in the words of the scene."""
    for part, key in keys.items():
        message = message.replace(part, key)
    return message


def _check_numbers(plan: Plan) -> None:
    """Refuse a scene of too many blocks before the first is built."""
    total = 0.0
    for name, element in plan.elements.items():
        copies = prod(min(repeat.number, 10**15) for repeat in repeats_of(element))
        own = blocks_asked(kind_of(element), msgspec.structs.asdict(element)) * float(min(copies, 10**100))
        check_block_count(f"elements.{name}", own)
        total += own
    check_block_count("elements", total)


def _placed(name: str, element: Element) -> list[Block]:
    """The blocks of an element and its copies, in place."""
    try:
        own = blocks_of(element)
    except InputError as error:
        raise error.under(f"elements.{name}") from None
    if element.density is not None:  # the scene's word stands before that of a file
        own = [replace(block, density=element.density) for block in own]
    found: list[Block] = []
    repeats = repeats_of(element)
    copies = product(*(range(repeat.number) for repeat in repeats))
    for prefix, steps in zip(_prefixes(name, element), copies, strict=True):
        turn, place = _pose(element, repeats, steps)
        found += moved(own, place, turn=turn, prefix=prefix)
    return found


def _prefixes(name: str, element: Element) -> list[str]:
    """What the names and groups of each copy of an element begin with."""
    copies = prod(repeat.number for repeat in repeats_of(element))
    own = name if element.prefix is None else element.prefix
    numbers = [str(k + 1) for k in range(copies)] if copies > 1 else [""]
    return ["".join(f"{part}." for part in (own, number) if part) for number in numbers]


def _pose(element: Element, repeats: Sequence[Repeat], steps: Sequence[int]) -> tuple[float, list[float]]:
    """Turn [degrees] and place [m] of a copy so many steps on."""
    turn, place = element.turn, np.array(element.at, dtype=float)
    for repeat, k in zip(repeats, steps, strict=True):
        about = np.array([*repeat.about, 0.0])
        place = about + rotation(k * repeat.turn) @ (place - about) + k * np.array(repeat.by)
        turn += k * repeat.turn
    return turn, place.tolist()


def _check_feet(blocks: Sequence[Block]) -> None:
    z = np.concatenate([block.vertices for block in blocks])[:, 2]
    start = np.cumsum([0, *(len(block.vertices) for block in blocks[:-1])])
    low, high = np.minimum.reduceat(z, start), np.maximum.reduceat(z, start)
    room = FOOT * (high - low)
    deepest = int((low + room).argmin())
    if low[deepest] < -room[deepest]:
        raise InputError(
            f'"{blocks[deepest].name}" reaches down to z = {low[deepest]:.4g} m, into the ground; raise its element, '
            'or take "ground" out of supports'
        )
    if not (low <= room).any():
        raise InputError(f"nothing stands on the ground at z = 0; the lowest block is at z = {low.min():.4g} m")


def _absent_groups(plan: Plan, *, known: bool) -> list[str]:
    """Groups that are not there by choice, each with all that is in it; "" where any group may be.

    Of an element that is left out these are the groups of its blocks, and its prefix alone where the groups are not
    `known` because of ranges, or the element cannot be built as long as it is absent.
    """
    found = []
    for name, element in plan.left_out.items():
        prefix = name if element.prefix is None else element.prefix
        groups = _groups_alone(plan, name, element) if known or not prefix else []
        if prefix and (not groups or "" in groups):
            found.append(prefix)
            continue
        found += groups
        found += [own + part for own in _prefixes(name, element) for part in absent_parts(element)]
    for name, element in plan.elements.items():
        if parts := absent_parts(element):
            found += [prefix + part for prefix in _prefixes(name, element) for part in parts]
    return found


def _groups_alone(plan: Plan, name: str, element: Element) -> list[str]:
    """Groups of an absent element, which its blocks alone can tell; "" where it cannot be built."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            _check_numbers(msgspec.structs.replace(plan, elements={name: element}))
            return sorted({block.group for block in _placed(name, element) if block.group})
        except InputError:  # of no concern as long as it is absent
            return [""]


def _is_absent(wanted: str, absent: Sequence[str], same: Callable[[str, str], bool]) -> bool:
    """Whether a group is one that is absent by choice, a part of it, or one that it would be a part of."""
    parts = wanted.split(".")
    return any(not group or all(map(same, group.split("."), parts)) for group in absent)


def _laws(plan: Plan, groups: Collection[str], absent: Callable[[], list[str]]) -> list[JointLaw]:
    """The joint laws but for those about a group that is absent by choice: they are void."""
    laws = [JointLaw(**msgspec.structs.asdict(joint)) for joint in plan.joints]
    unknown = {name for law in laws for name in law.between if not any(fits(name, group) for group in groups)}
    void = {name for name in unknown if _is_absent(name, absent(), eq)}
    if void:  # the other group of a law that is void must be one all the same
        others = [tuple("*" if name in void else name for name in law.between) for law in laws]
        check_laws([replace(law, between=pair) for law, pair in zip(laws, others, strict=True)], list(groups))
    return [law for law in laws if void.isdisjoint(law.between)]


def _supports(plan: Plan, blocks: Sequence[Block], absent: Callable[[], list[str]]) -> list[int | str]:
    """Indices of the blocks in the groups that cannot move."""
    fixed = {i for found in gathered(partial(_held, wanted, blocks, absent) for wanted in plan.supports) for i in found}
    if not fixed:
        raise InputError('supports: there are none; write "ground" or groups that cannot move')
    return sorted(fixed)


def _held(wanted: str, blocks: Sequence[Block], absent: Callable[[], list[str]]) -> list[int]:
    """Indices of the blocks of a support; none where it is absent by choice."""
    parts = wanted.split(".")
    found = [i for i, block in enumerate(blocks) if _within(block.group.split("."), parts)]
    if not found and not _is_absent(wanted, absent(), fnmatchcase):
        known = ", ".join(sorted({GROUND, *(block.group for block in blocks if block.group)}))
        raise InputError(f'supports: no group "{wanted}"; groups are: {known}')
    return found


def _within(group: list[str], wanted: list[str]) -> bool:
    """Whether a group is the wanted one or a part of it."""
    return len(group) >= len(wanted) and all(map(fnmatchcase, group, wanted))


def _check_elements_apart(assembly: Assembly) -> None:
    """Raise InputError for two elements, or two copies of one, that overlap."""
    pairs, depth = overlaps(assembly, gap=OVERLAP)
    if len(pairs):
        worst = int(depth.argmax())
        first, second = (assembly.names[i] for i in pairs[worst])
        a, b = (_element_of(name) for name in (first, second))
        label = f'elements "{a}" and "{b}" overlap' if a != b else f'element "{a}" overlaps with itself'
        raise InputError(f'{label}: blocks "{first}" and "{second}" by {depth[worst]:.3g} m')


def _element_of(name: str) -> Any:
    return name.split(".")[0]
