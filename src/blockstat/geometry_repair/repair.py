"""Repair rough geometry on request, and say block by block what was changed.

Real files have vertices listed once a face, corners on edges of faces that lack them, faces turned inwards,
quadrilaterals that are not quite flat, and joints that do not quite close. `repair` merges, inserts, turns, flattens
and closes them. Nothing else in this package changes geometry.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from blockstat.assembly import Assembly, Block
from blockstat.contact.interfaces import GAP, find_interfaces
from blockstat.contact.overlap.penetration import overlaps, tell
from blockstat.contact.tolerance import LOOSE
from blockstat.errors import InputError, NoSupportError, known_options
from blockstat.geometry.polyhedron import merged_vertices
from blockstat.geometry.validity import ON_EDGE, check_geometry, without_advice
from blockstat.geometry_repair.common_planes import common_planes, meet
from blockstat.geometry_repair.shared_corners import settled_faces, shared_corners
from blockstat.geometry_repair.surface import RepairedSurface, repair_surface
from blockstat.io.parts import Parts
from blockstat.joint import JointLaw
from blockstat.result import Result, Sentence, counted, plain
from blockstat.system.old_names import renamed_options
from blockstat.typing import Floats

MERGE = ON_EDGE  #: vertices closer than this, relative to the diagonal of their block's box, are one
WARP = 1e-2  #: faces whose corners are off their plane by no more than this, relative to the block, are made flat
FAR = 4.0  #: a block of which a vertex would move further than this many tolerances is left as it was
FLAT = 1e-6  #: faces further off their plane than this, relative to the block, are not flat
SEEN = 1e-12  #: smaller changes, relative to the block, are rounding and are not reported


@dataclass(frozen=True)
class Change:
    """What was changed of one block."""

    name: str
    merged: int = 0  #: vertices that others stand for now
    spread: float = 0.0  #: the furthest that merging moved a vertex [m]
    dropped: int = 0  #: faces left out: with fewer than three corners, there already, or walls inside the solid
    turned: int = 0  #: faces listed the other way round now
    inserted: int = 0  #: corners put into the edges of other faces that they lie on
    warp: float = 0.0  #: the furthest that a corner was off its face, for faces that are flat now [m]
    joined: int = 0  #: faces that lie in one plane with those of other blocks now
    moved: float = 0.0  #: the furthest that flattening and closing moved a vertex [m]
    left: str = ""  #: what could not be repaired

    @property
    def any(self) -> bool:
        """Whether the block was changed."""
        return replace(self, left="") != Change(self.name)

    def explain(self) -> str:
        """Return the change in words.

        Returns
        -------
        str
            One line.
        """
        said = []
        if self.merged:
            said.append(f"{self.merged} duplicate vertices merged (moved by up to {_mm(self.spread)})")
        if self.dropped:
            said.append(f"{counted(self.dropped, 'face')} dropped")
        if self.turned:
            said.append(f"{counted(self.turned, 'face')} turned")
        if self.inserted:
            said.append(f"{counted(self.inserted, 'corner')} put into the edges that they lie on")
        if self.warp:
            said.append(f"faces flattened that were off by up to {_mm(self.warp)}")
        if self.joined:
            said.append(f"{counted(self.joined, 'face')} brought into common planes")
        if self.moved:
            said.append(f"vertices moved by up to {_mm(self.moved)}")
        return f'block "{self.name}": ' + "; ".join([*said, self.left] if self.left else said)


def _mm(length: float) -> str:
    return f"{plain(1e3 * length, 2)} mm"


class RepairOutcome(Sentence):
    """The answers of `repair`; each value is the sentence a user reads."""

    UNCHANGED = "Unchanged: no block needed repair."
    REPAIRED = "Repaired: the geometry was changed as listed."
    INCOMPLETE = "Incomplete: some of the geometry was left as it was."


@dataclass(frozen=True)
class RepairReport(Result):
    """What `repair` did."""

    changes: tuple[Change, ...]  #: one a block, in order, also for blocks that were not changed
    overlaps: str = ""  #: what of the blocks still overlaps, which no repair takes away
    closed: int = 0  #: joints whose two faces lie in one plane now and did not before

    @property
    def changed(self) -> tuple[Change, ...]:
        """The changes of the blocks that were changed."""
        return tuple(change for change in self.changes if change.any)

    @property
    def outcome(self) -> RepairOutcome:
        """Whether anything was changed, and whether anything was left."""
        if self.overlaps or any(change.left for change in self.changes):
            return RepairOutcome.INCOMPLETE
        return RepairOutcome.REPAIRED if self.changed else RepairOutcome.UNCHANGED

    def explain(self) -> str:
        """Return the outcome, a line for each block that was changed or not repaired, what overlaps, and the sum.

        Returns
        -------
        str
            One fact a line.
        """
        same = len(self.changes) - len(self.changed)
        told = [change.explain() for change in self.changes if change.any or change.left]
        left = [f"left as they were: {self.overlaps}"] if self.overlaps else []
        furthest = max((max(change.moved, change.spread) for change in self.changes), default=0.0)
        total = [f"{same} of {len(self.changes)} blocks unchanged"]
        total += [f"{counted(self.closed, 'joint')} closed"] if self.closed else []
        total += [f"vertices moved by up to {_mm(furthest)}"] if furthest else []
        return "\n".join([self.outcome.value, *told, *left, ", ".join(total)])

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON: the changes of the blocks that were changed or not repaired.

        Returns
        -------
        dict
            Values by name.
        """
        return {
            "outcome": self.outcome.word,
            "sentence": self.outcome.value,
            "changes": [asdict(change) for change in self.changes if change.any or change.left],
            "overlaps": self.overlaps,
            "blocks": len(self.changes),
            "closed": self.closed,
        }


@renamed_options(weld="merge")
@known_options
def repair(
    source: Assembly | Iterable[Block] | str | Path,
    *,
    gap: float = GAP,
    merge: float = MERGE,
    warp: float = WARP,
    supports: Iterable[int | str] | None = None,
    units: str | None = None,
    up: str | None = None,
    name: str | None = None,
    density: float | None = None,
    friction: float | None = None,
    gravity: Sequence[float] | None = None,
    metadata: dict[str, Any] | None = None,
    joints: Sequence[JointLaw] | None = None,
) -> tuple[Assembly, RepairReport]:
    """Repair an assembly, blocks that `Assembly.from_blocks` may refuse, or a file of them.

    Parameters
    ----------
    source : Assembly, iterable of Block, str or Path
        What to repair; a file may be of any format that `blockstat.read` takes.
    gap : float, optional
        Faces of neighbours that are apart, or overlap, by no more than this fraction of the size of the smaller block
        are brought into one plane, as `find_interfaces` would take them for one joint. 0 closes nothing.
    merge : float, optional
        Vertices of a block closer than this fraction of the diagonal of its box are merged. Then faces that came to
        nothing are dropped, corners that lie on an open edge of another face, within the same distance, are put into
        it, and faces are turned outwards.
    warp : float, optional
        Faces whose corners are off their plane by no more than this fraction of the size of the block are made flat.
    supports : iterable of str or int, optional
        Names or numbers of the blocks that cannot move, in place of those that the source marks. None are needed.
    units : str, optional
        Of the coordinates in a file, as in `blockstat.read`.
    up : str, optional
        The axis of the file that points up, as in `blockstat.read`.
    name, density, friction, gravity, metadata, joints : optional
        As in `Assembly.from_blocks`, in place of what the source says.

    Returns
    -------
    assembly : Assembly
        The repaired blocks.
    report : RepairReport
        What was changed, block by block.

    Raises
    ------
    InputError
        Naming a block that is no closed solid even after merging and turning, or for an option out of range.

    Examples
    --------
    Two bricks that are 2 mm apart get a joint.

    >>> from blockstat import Assembly, box, find_interfaces, repair
    >>> blocks = [box((0, 0, 0), (1, 1, 1)), box((0, 0, 1.002), (1, 1, 2))]
    >>> repaired, report = repair(blocks, supports=[0])
    >>> report.outcome.word, find_interfaces(repaired, gap=1e-6).n_interfaces
    ('repaired', 1)
    """
    given = {"name": name, "density": density, "friction": friction, "gravity": gravity}
    given |= {"metadata": metadata, "joints": joints}
    options = {key: value for key, value in given.items() if value is not None}
    for key, value, most in (("gap", gap, 0.2), ("merge", merge, 0.1), ("warp", warp, 0.2)):
        if not (isinstance(value, (int, float)) and 0 <= value < most):
            raise InputError(f"{key} is {value!r}; it must be at least 0 and below {most} of the block size")
    with _not_sent_to_itself():
        parts = _parts(source, supports, units, up, options)
        surfaces = [_repaired(block, number, merge) for number, block in enumerate(parts.blocks)]
        blocks = [
            replace(block, vertices=own.vertices, faces=own.faces)
            for block, own in zip(parts.blocks, surfaces, strict=True)
        ]
        rough = replace(parts, blocks=blocks).assembled()
        assembly, changes = close_joints(rough, gap, warp)
        check_geometry(assembly, assembly.names)
    closed = any(change.joined for change in changes) and _open_joints(rough, gap) - _open_joints(assembly, gap)
    told = [
        replace(
            change,
            merged=own.merged,
            spread=own.spread,
            dropped=own.dropped,
            turned=own.turned,
            inserted=own.inserted,
        )
        for change, own in zip(changes, surfaces, strict=True)
    ]
    pairs, depth = overlaps(assembly, gap=gap or GAP)
    left = tell(assembly, pairs, depth) if len(pairs) else ""
    return assembly, RepairReport(tuple(told), left, len(closed) if closed else 0)


@contextmanager
def _not_sent_to_itself() -> Iterator[None]:
    """Tell errors without the advice to repair: a repair has been tried, or comes too late for a mesh of a scene."""
    try:
        yield
    except InputError as error:
        raise without_advice(error) from None


def _open_joints(assembly: Assembly, gap: float) -> set[tuple[int, int]]:
    """Pairs of blocks whose joint does not quite close."""
    faces = find_interfaces(assembly, gap=gap or GAP)
    loose = faces.gap > LOOSE * assembly.size[faces.pair].min(axis=1)
    return {(int(a), int(b)) for a, b in faces.pair[loose]}


def _parts(
    source: Any, supports: Iterable[int | str] | None, units: str | None, up: str | None, options: dict[str, Any]
) -> Parts:
    if isinstance(source, (str, Path)) and Path(source).suffix.lower() == ".toml":
        from blockstat.spec import read

        source = read(source, supports=supports, units=units, up=up)
    if isinstance(source, (str, Path)):
        from blockstat.io.files import read_parts

        try:
            parts = read_parts(source, supports=supports, units=units).turned(up)
        except NoSupportError:  # what to repair does not hang on them
            parts = read_parts(source, supports=[], units=units).turned(up)
        return replace(parts, options=parts.options | options)
    if units is not None or up is not None:
        raise InputError("units and up are those of a file; blocks are in metres, and z is up")
    if not isinstance(source, Assembly):
        return Parts(list(source), () if supports is None else supports, options)
    blocks = [
        Block(
            source.block_vertices(i),
            [face.tolist() for face in source.faces_of(i)],
            name,
            source.groups[i],
            float(source.density[i]),
        )
        for i, name in enumerate(source.names)
    ]
    marked = np.flatnonzero(source.support).tolist() if supports is None else supports
    kept = {key: getattr(source, key) for key in ("name", "friction", "gravity", "metadata", "joints", "ties")}
    return Parts(blocks, marked, kept | options)


def _repaired(block: Block, number: int, merge: float) -> RepairedSurface:
    label = block.name or f"block{number}"
    try:
        vertices = np.array(block.vertices, dtype=float).reshape(-1, 3)
        faces = [[int(corner) for corner in face] for face in block.faces]
    except (TypeError, ValueError):
        raise InputError(f'block "{label}": vertices must be a list of [x, y, z], faces lists of corners') from None
    if not len(vertices) or not np.isfinite(vertices).all():
        raise InputError(f'block "{label}": vertices must be finite numbers')
    if any(not 0 <= corner < len(vertices) for face in faces for corner in face):
        raise InputError(f'block "{label}": a face has a corner that is not between 0 and {len(vertices) - 1}')
    return repair_surface(vertices, faces, merge * float(np.linalg.norm(np.ptp(vertices, axis=0))))


def close_joints(assembly: Assembly, gap: float = GAP, warp: float = WARP) -> tuple[Assembly, list[Change]]:
    """Make faces flat and close joints, by moving corners.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    gap, warp : float, optional
        As in `repair`.

    Returns
    -------
    assembly : Assembly
        The same blocks, vertices and faces in the same order, with moved vertices.
    changes : list of Change
        What moved, one a block.
    """
    block, size, before = assembly.face_block, assembly.size, assembly.planes.warp
    corner = shared_corners(assembly, gap) if gap > 0 else np.arange(len(assembly.vertices))
    corner = np.unique(corner[merged_vertices(assembly)], return_inverse=True)[1]
    flat = before <= warp * size[block]
    label = common_planes(assembly, gap, np.flatnonzero(flat & ~settled_faces(assembly, corner)))
    moved = meet(assembly, label, corner)
    far = _furthest(assembly, moved)
    wild = far > FAR * max(gap, warp) * size
    still = far <= SEEN * size
    kept = (wild | still)[assembly.vertex_block]
    repaired = assembly.with_(vertices=np.where(kept[:, None], assembly.vertices, moved))
    shared = np.bincount(label[label >= 0], minlength=1)[label] > 1
    after = repaired.planes.warp
    changes = []
    for i, name in enumerate(assembly.names):
        own, bent = (np.flatnonzero((block == i) & chosen) for chosen in (label >= 0, ~flat))
        left = [f"left as it was: a vertex would have moved by {_mm(far[i])}"] if wild[i] else []
        left += [f"{len(bent)} faces are too far from flat and were left"] if len(bent) else []
        if after[own].max(initial=0.0) > FLAT * size[i]:
            left.append(f"faces are still off by up to {_mm(after[own].max())}")
        change = Change(name, left="; ".join(left))
        if not (wild[i] or still[i]):
            flattened = float(before[own].max(initial=0.0))
            change = replace(
                change,
                warp=flattened if flattened > SEEN * size[i] else 0.0,
                joined=int(shared[own].sum()),
                moved=float(far[i]),
            )
        changes.append(change)
    return repaired, changes


def _furthest(assembly: Assembly, vertices: Floats) -> Floats:
    """The furthest that a vertex of each block moved [m], shape (n_blocks,)."""
    return np.maximum.reduceat(np.linalg.norm(vertices - assembly.vertices, axis=1), assembly.vertex_start[:-1])
