"""The native JSON format: one object, exact on the way there and back.

    {name, units: "m", density, friction, gravity: [gx, gy, gz], supports: [index or name],
     joints?: [{between: [group, group], friction?, tension?, bond?, cohesion?, bond_moment?, compression?, cells?}],
     ties?: [{between: [block, block], points: [[x, y, z], [x, y, z]], least?, greatest?, strut?, name?}],
     blocks: [{name, group?, density?, vertices: [[x, y, z]], faces: [[i, j, k, ...]]}]}

The density of the object counts for the blocks without one of their own.

A friction without limit is the text "inf", because JSON has no number for it; the Infinity that 0.2 wrote is read, too.

Other keys of the object itself are kept as metadata, but for those that are nearly one of these ("frction"), which are
refused; those of a block, a joint or a tie are refused.
"""

from __future__ import annotations

import json
import re
from collections.abc import Iterable
from difflib import get_close_matches
from functools import partial
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from blockstat.assembly import DENSITY, FRICTION, STANDARD_GRAVITY, Assembly, Block
from blockstat.errors import InputError, check_positive, gathered
from blockstat.io.names import distinct_names
from blockstat.io.parts import Parts, chosen_supports, friction_said, with_friction
from blockstat.joint import JointLaw, Tie
from blockstat.system.faults import faults


class _BlockRecord(msgspec.Struct, forbid_unknown_fields=True):
    vertices: list[list[float]]
    faces: list[list[int]]
    name: str = ""
    group: str = ""
    density: float | None = None


class _JointRecord(msgspec.Struct, forbid_unknown_fields=True):
    between: tuple[str, str]
    friction: float | None = None
    tension: float = 0.0
    bond: float = 0.0
    cohesion: float | None = None
    bond_moment: float | None = None
    compression: float | None = None
    cells: int = 0


class _TieRecord(msgspec.Struct, forbid_unknown_fields=True):
    between: tuple[int | str, int | str]
    points: tuple[tuple[float, float, float], tuple[float, float, float]]
    least: float = 0.0
    greatest: float = np.inf
    strut: bool = False
    name: str = ""


class _Record(msgspec.Struct):
    blocks: list[_BlockRecord]
    name: str = ""
    units: str = "m"
    density: float = DENSITY
    friction: float = FRICTION
    gravity: tuple[float, float, float] = STANDARD_GRAVITY
    supports: list[int | str] = []
    joints: list[_JointRecord] = []
    ties: list[_TieRecord] = []


KNOWN = tuple(field.name for field in msgspec.structs.fields(_Record))
#: Likeness to a known key, twice the letters in common over those of both, from which another key is it misspelt.
LIKE = 0.8


def native_parts(
    data: Any, name: str, *, supports: Iterable[int | str] | None = None, units: str | None = None
) -> Parts:
    """Read the native format.

    Parameters
    ----------
    data : object
        What the JSON file holds.
    name : str
        Of the assembly where the file has none.
    supports : iterable of int or str, optional
        Names or numbers of the blocks that cannot move, in place of those that the file marks.
    units : str, optional
        Of the coordinates. They must be those that the file names, if it names any; other units than metres are read
        only where they are asked for.

    Returns
    -------
    Parts
        In the unit of the file.

    Raises
    ------
    InputError
        With the key of a bad value, an unknown key of a block, joint or tie, or one that is nearly a known one, or for
        other units than the file's.

    Warns
    -----
    InputWarning
        Where blocks share a name.
    """
    if not isinstance(data, dict):
        raise InputError(f'the file holds a {type(data).__name__}; an object with "blocks" is needed')
    if "blocks" not in data and isinstance(data.get("steps"), list):
        raise InputError("this is a plan of building; give the assembly, and --plan with it to sequence")
    if wrong := _misspelt(data):
        raise InputError(*wrong)
    data = with_friction(data)
    if isinstance(data.get("joints"), list):
        data["joints"] = [with_friction(joint) for joint in data["joints"]]
    try:
        record = msgspec.convert(data, _Record)
    except msgspec.ValidationError:
        raise InputError(*(_in_words(text, data) for text in faults(_Record, data))) from None
    if units is None and record.units != "m":
        raise InputError(f'units are "{record.units}"; only "m" is read unless others are asked for')
    if units is not None and data.get("units", units) != units:
        raise InputError(f'units are "{record.units}" in the file and "{units}" were asked for')
    given = [b.name for b in record.blocks]
    chosen = record.supports if supports is None else chosen_supports([], supports, given, "the file")
    names = distinct_names(given, chosen)
    _, joints, ties = gathered(
        (
            partial(check_positive, "density", data.get("density", DENSITY)),  # also where each block has its own
            lambda: gathered(partial(JointLaw, **msgspec.structs.asdict(joint)) for joint in record.joints),
            lambda: gathered(partial(Tie, **msgspec.structs.asdict(tie)) for tie in record.ties),
        )
    )
    return Parts(
        [Block(b.vertices, b.faces, name, b.group, b.density) for b, name in zip(record.blocks, names, strict=True)],
        chosen,
        {
            "name": record.name or name,
            **{key: getattr(record, key) for key in ("density", "gravity") if key in data},
            "friction": record.friction,
            "metadata": {key: value for key, value in data.items() if key not in KNOWN},
            "joints": joints,
            "ties": ties,
        },
    )


def _misspelt(data: Iterable[Any]) -> list[str]:
    """What is wrong with keys that are none of the format's, but nearly so: they would be kept and not heeded."""
    near = {str(key): get_close_matches(str(key).lower(), KNOWN, 1, LIKE) for key in data if key not in KNOWN}
    return [f'"{key}" is not a key of the file; did you mean "{found[0]}"?' for key, found in near.items() if found]


def _in_words(text: str, data: dict[str, Any]) -> str:
    """A fault with "blocks[3].faces" turned into the block's name."""
    found = re.match(r"blocks\[(\d+)\]\.?(.*?): (.*)", text, flags=re.DOTALL)
    if found is None:
        return text
    index, rest, message = found.groups()
    block = data["blocks"][int(index)]
    label = block.get("name") or f"block{index}" if isinstance(block, dict) else f"block{index}"
    return f'block "{label}": {rest or "entry"}: {message}'


def _law(law: JointLaw) -> dict[str, Any]:
    """A joint law as the file says it."""
    said = law.as_dict()
    return said | {"friction": friction_said(law.friction)} if law.friction is not None else said


def write_json(assembly: Assembly, path: Path, *, units: str = "m") -> None:
    """Write the native format; floats keep all their digits.

    Parameters
    ----------
    assembly : Assembly
        The blocks, with its metadata.
    path : Path
        The file.
    units : str, optional
        Of the vertices and of the points of ties, which the file names.

    Raises
    ------
    InputError
        For metadata that JSON cannot hold, or whose key is nearly one of the format's, which no reader would take.
    """
    if wrong := _misspelt(assembly.metadata):
        raise InputError(*(f"metadata: {text}" for text in wrong))
    blocks, same = [], bool((assembly.density == assembly.density[0]).all())
    for i, name in enumerate(assembly.names):
        block: dict[str, Any] = {"name": name}
        if assembly.groups[i]:
            block["group"] = assembly.groups[i]
        if not same:
            block["density"] = float(assembly.density[i])
        block["vertices"] = assembly.block_vertices(i).tolist()
        block["faces"] = [face.tolist() for face in assembly.faces_of(i)]
        blocks.append(block)
    data = {
        **assembly.metadata,
        "name": assembly.name,
        "units": units,
        **({"density": float(assembly.density[0])} if same else {}),
        "friction": friction_said(assembly.friction),
        "gravity": assembly.gravity.tolist(),
        "supports": np.flatnonzero(assembly.support).tolist(),
        **({"joints": [_law(law) for law in assembly.joints]} if assembly.joints else {}),
        **({"ties": [tie.as_dict() for tie in assembly.ties]} if assembly.ties else {}),
        "blocks": blocks,
    }
    try:
        text = json.dumps(data, allow_nan=False)
    except (TypeError, ValueError) as error:
        raise InputError(f"the metadata cannot be written as JSON ({error})") from None
    path.write_text(text, encoding="utf-8")
