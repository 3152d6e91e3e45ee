"""Pictures of assemblies by the painter's algorithm: what is behind is painted first, with matplotlib, no OpenGL."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.broad import near_pairs
from blockstat.errors import InputError
from blockstat.polyhedron import FacePlanes, Floats, Ints, face_planes
from blockstat.separation import face_separation

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from blockstat.assembly import Assembly
    from blockstat.result import Verdict

STONE = (0.87, 0.83, 0.75)
SUPPORT = (0.72, 0.74, 0.76)
MOVED = "plasma"  #: colour maps that keep their order in grey and for colour-blind readers
DEMAND = "viridis"
#: Faces within this (sine) of being seen edge-on hide nothing.
EDGE_ON = 1e-6


def picture(
    assembly: Assembly,
    path: str | Path,
    *,
    values: Floats | None = None,
    label: str = "",
    colours: str = MOVED,
    top: float | None = None,
    displacement: Floats | None = None,
    rotation: Floats | None = None,
    title: str = "",
    azimuth: float = -55.0,
    elevation: float = 25.0,
    opacity: float = 1.0,
    overlay: Callable[[Figure], None] | None = None,
) -> Path:
    """Draw the blocks in parallel projection and save a PNG (or any format matplotlib writes); returns the path.

    values : one number a block to colour by, shape (n_blocks,), with `label` and its unit on the colour bar;
    top : the end of the bar, by default the largest value.
    displacement, rotation : poses to draw the blocks in, shapes (n_blocks, 3) [m] and (n_blocks, 3, 3).
    azimuth, elevation : from where one looks, in degrees. opacity : of the blocks. overlay : draws on the figure
    before it is saved.
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.collections import PolyCollection
    from matplotlib.colors import Normalize
    from matplotlib.figure import Figure

    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(f"{path}: no such directory: {path.parent}")
    if not path.suffix:
        raise InputError(f"{path}: a picture needs a suffix, such as .png, .svg or .pdf")
    view = _view(azimuth, elevation)
    colour = np.where(assembly.support[:, None], SUPPORT, STONE).astype(float)
    bar = None
    if values is not None:
        scale = Normalize(0.0, top or max(float(np.max(values)), 1e-12))
        bar = ScalarMappable(scale, colormaps[colours])
        painted = bar.to_rgba(np.asarray(values, dtype=float))[:, :3]
        colour = np.where(assembly.support[:, None], SUPPORT, painted)

    polygons, paint = _visible(assembly, _posed(assembly, displacement, rotation), view, colour)
    figure = Figure(figsize=(8, 6), dpi=150, layout="constrained")
    axes = figure.add_subplot()
    axes.add_collection(
        PolyCollection(polygons, facecolors=paint, edgecolors=0.45 * paint, linewidths=0.35, alpha=opacity)
    )
    axes.autoscale_view()
    axes.set_aspect("equal")
    axes.axis("off")
    if title:
        axes.set_title(title, fontsize=11)
    if bar is not None:
        figure.colorbar(bar, ax=axes, label=label, shrink=0.6)
    if overlay is not None:
        overlay(figure)
    try:
        figure.savefig(path)
    except ValueError as error:
        raise InputError(f"{path}: {error}") from None
    return path


def picture_of_verdict(verdict: Verdict, path: str | Path, **options: Any) -> Path:
    """The mechanism of an assembly that moves, else the demand on the joints of one that stands."""
    assembly = verdict.assembly
    if not len(verdict.moving):
        return picture(
            assembly, path, values=verdict.demand(), colours=DEMAND, top=1.0,
            label="friction used at the block's joints (1 = sliding)", title=f"{assembly.name}: stable", **options,
        )  # fmt: skip
    shown, turned = mechanism_pose(verdict)
    word = verdict.outcome.word
    return picture(
        assembly, path, values=verdict.motion, label="speed of the fastest corner, relative",
        displacement=shown, rotation=turned, title=f"{assembly.name}: {word}, first motion exaggerated", **options,
    )  # fmt: skip


def mechanism_pose(verdict: Verdict, *, amplitude: float | None = None) -> tuple[Floats, Floats]:
    """Blocks moved along the mechanism: displacements (n, 3) [m] and finite rotations (n, 3, 3).

    amplitude : how far the fastest corner goes [m]; by default a twelfth of the assembly's extent.
    """
    from scipy.spatial.transform import Rotation

    lower, upper = verdict.assembly.bounds
    free = ~verdict.assembly.support
    if amplitude is None:
        amplitude = float((upper[free].max(axis=0) - lower[free].min(axis=0)).max()) / 12
    twist = amplitude * verdict.mechanism
    return twist[:, :3], Rotation.from_rotvec(twist[:, 3:]).as_matrix()


def _view(azimuth: float, elevation: float) -> Floats:
    """Rows: right, up, towards the eye."""
    a, e = np.deg2rad([azimuth, elevation])
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return np.stack([right, np.cross(eye, right), eye])


def _posed(assembly: Assembly, displacement: Floats | None, rotation: Floats | None) -> Floats:
    if displacement is None and rotation is None:
        return assembly.vertices
    block = np.repeat(np.arange(assembly.n_blocks), np.diff(assembly.vertex_start))
    arm = assembly.vertices - assembly.centroid[block]
    if rotation is not None:
        arm = np.einsum("nij,nj->ni", rotation[block], arm)
    moved = 0.0 if displacement is None else displacement[block]
    return assembly.centroid[block] + arm + moved


def _visible(assembly: Assembly, vertices: Floats, view: Floats, colour: Floats) -> tuple[list[Floats], Floats]:
    """Faces towards the eye, hidden ones first: polygons on the picture plane and their shaded colours."""
    corners = vertices[assembly.face_vertices]
    planes = face_planes(corners, assembly.face_start)
    rank = np.empty(assembly.n_blocks, dtype=np.int64)
    rank[paint_order(assembly, vertices, planes, view)] = np.arange(assembly.n_blocks)
    front = np.flatnonzero(planes.normal @ view[2] > 1e-9)
    order = front[np.lexsort((planes.centre[front] @ view[2], rank[assembly.face_block[front]]))]
    light = np.array([0.35, -0.5, 0.8]) / np.linalg.norm([0.35, -0.5, 0.8])
    shade = 0.62 + 0.38 * np.clip(planes.normal[order] @ light, 0, 1)
    flat = corners @ view[:2].T
    polygons = [flat[assembly.face_start[f] : assembly.face_start[f + 1]] for f in order]
    return polygons, np.clip(colour[assembly.face_block[order]] * shade[:, None], 0, 1)


def paint_order(assembly: Assembly, vertices: Floats, planes: FacePlanes, view: Floats) -> list[int]:
    """Blocks from back to front: exact for convex blocks that do not hide one another in a circle.

    Of two blocks that overlap in the picture, one lies beyond a face of the other; if that face looks towards
    the eye, what lies beyond it is painted later. Where faces of both kinds separate them, no ray meets both and
    the order is free. Circles are cut at the block that is furthest away.
    """
    n = assembly.n_blocks
    flat = vertices @ view.T
    first = assembly.vertex_start[:-1]
    lower, upper = np.minimum.reduceat(flat, first), np.maximum.reduceat(flat, first)
    depth = (lower[:, 2] + upper[:, 2]) / 2
    lower[:, 2] = upper[:, 2] = 0.0
    pairs = near_pairs(lower, upper, np.zeros(n))
    slope = planes.normal @ view[2]

    def beyond(which: Ints, faces: np.ndarray) -> Floats:
        return face_separation(vertices, assembly.vertex_start, planes, assembly.face_block, which, faces)

    swapped, towards, away = pairs[:, ::-1], slope > -EDGE_ON, slope < EDGE_ON
    second_later = np.maximum(beyond(pairs, towards), beyond(swapped, away))
    first_later = np.maximum(beyond(pairs, away), beyond(swapped, towards))
    touching = -1e-6 * assembly.size[pairs].min(axis=1)
    tied = np.minimum(second_later, first_later) < touching
    a, b = pairs[tied].T
    second = (second_later > first_later)[tied]
    return _topological(n, np.where(second, a, b), np.where(second, b, a), depth)


def _topological(n: int, behind: Ints, before: Ints, depth: Floats) -> list[int]:
    """Order in which every `behind` comes ahead of its `before`; the deepest first where that leaves a choice."""
    import heapq

    waits = np.bincount(before, minlength=n)
    by_block = np.argsort(behind, kind="stable")
    start = np.searchsorted(behind[by_block], np.arange(n + 1))
    ready = [(depth[i], i) for i in np.flatnonzero(waits == 0)]
    heapq.heapify(ready)
    circle = iter(np.argsort(depth))
    done = np.zeros(n, dtype=bool)
    order: list[int] = []
    while len(order) < n:
        block = heapq.heappop(ready)[1] if ready else next(int(i) for i in circle if not done[i])
        if done[block]:
            continue
        done[block] = True
        order.append(int(block))
        for follower in before[by_block[start[block] : start[block + 1]]]:
            waits[follower] -= 1
            if waits[follower] == 0 and not done[follower]:
                heapq.heappush(ready, (depth[follower], follower))
    return order


def picture_of_forces(verdict: Verdict, path: str | Path, **options: Any) -> Path:
    """The resultant of each joint as a line through its centre of pressure, over pale blocks; returns the path.

    The lines' lengths go with the forces; in an arch they join up to its thrust line. Joints in tension, in an
    assembly that does not stand, are dashed.
    """

    azimuth, elevation = options.pop("azimuth", -55.0), options.pop("elevation", 25.0)
    view = _view(azimuth, elevation)
    point, force, tension = resultants(verdict)
    size = np.linalg.norm(force, axis=1)
    lower, upper = verdict.assembly.bounds
    free = ~verdict.assembly.support
    reach = 0.06 * float((upper[free].max(axis=0) - lower[free].min(axis=0)).max()) / max(float(size.max()), 1e-300)

    def draw(figure: Figure) -> None:
        axes = figure.axes[0]
        for middle, pull, torn in zip(point, force, tension, strict=True):
            ends = np.array([middle - reach * pull, middle + reach * pull]) @ view[:2].T
            axes.plot(*ends.T, color="#b2182b", linewidth=1.2, linestyle=":" if torn else "-")

    name = verdict.assembly.name
    title = f"{name}: joint forces, longest {size.max():.3g} N"
    return picture(
        verdict.assembly, path, title=title, azimuth=azimuth, elevation=elevation, opacity=0.35, overlay=draw, **options
    )


def resultants(verdict: Verdict) -> tuple[Floats, Floats, np.ndarray]:
    """Centre of pressure [m], force on block b [N] and whether it is a tension, of each joint that carries any."""
    faces = verdict.interfaces
    net = verdict.forces - verdict.adhesion[:, None] * np.array([1.0, 0.0, 0.0])
    k = faces.point_interface
    world = np.einsum("nij,ni->nj", faces.frame[k], net)
    first = faces.start[:-1]
    if not faces.n_interfaces:
        return np.empty((0, 3)), np.empty((0, 3)), np.empty(0, dtype=bool)
    force = np.add.reduceat(world, first)
    normal = np.add.reduceat(net[:, 0], first)
    share = np.abs(net[:, 0])
    total = np.add.reduceat(share, first)
    point = np.add.reduceat(share[:, None] * faces.point, first) / np.where(total > 0, total, 1.0)[:, None]
    carries = np.linalg.norm(force, axis=1) > 1e-6 * max(float(np.linalg.norm(force, axis=1).max()), 1e-300)
    return point[carries], force[carries], normal[carries] < 0
