"""Joints in colour: how much of each joint's capacity its forces use, and what a limit load hangs on."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.point_law import joint_friction, point_law
from blockstat.errors import check_choice
from blockstat.typing import Floats
from blockstat.view.painter import looked_at
from blockstat.view.plot import DEMAND, Place, balanced, draw_joints, plot

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from blockstat.analysis.verdict import Verdict
    from blockstat.contact.interfaces import Interfaces
    from blockstat.sensitivity.reserve import ReserveMap

#: Joints that carry less than this fraction of the most loaded one's force count as idle: their ratios are noise.
IDLE = 1e-6
#: Colours of what a limit hangs on, and the share of the largest below which nothing is drawn.
HEAT, FAINT = "YlOrRd", 0.02
#: Label of each map, and by how much its quantity changes: millimetres, or a tenth of a coefficient.
LABELS = {
    "edge": ("change of the limit by 1 mm of edges lost", 1e-3),
    "friction": ("change of the limit by 0.1 of friction", 0.1),
    "corner": ("change of the limit by 1 mm of the corner", 1e-3),
}


def utilisation(verdict: Verdict) -> Floats:
    """Return how near each joint is to sliding or to opening under the forces of a verdict.

    Parameters
    ----------
    verdict : Verdict
        A static verdict.

    Returns
    -------
    array of float, shape (n_interfaces,)
        From 0 to 1, which is the limit.

    Notes
    -----
    The larger of two ratios of the joint's resultant (N, T) on its patch:

    - friction, `|T| / (mu N)`: 1 when the joint slides;
    - eccentricity of the centre of pressure: 0 at the centroid of the patch, 1 on its edge, where the joint is a hinge;
      between them the factor by which the patch may shrink about its centroid and still hold the centre. An edge on a
      face has it along itself: 0 at its middle, 1 at its ends. A corner has none.

    A tension capacity shifts the cones along their axes (see `blockstat.joint`), so N is then the pressure on top of
    it. Joints that carry nothing use nothing. Those that would have to be glued, in an assembly that does not stand,
    use 1. The forces are those of one admissible field: where the structure is statically indeterminate others exist.

    Examples
    --------
    Gravity leans by 3 in 10. The block's centroid is 1 m above the joint, so the resultant meets the joint 0.3 m from
    its centre. The edge is 0.5 m from it.

    >>> from blockstat import Assembly, assess, box, utilisation
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"], friction=0.7)
    >>> [used] = utilisation(assess(assembly, gravity=(3.0, 0.0, -10.0)))
    >>> print(f"{used:.3f}")
    0.600
    """
    faces, assembly = verdict.interfaces, verdict.assembly
    if not faces.n_interfaces:
        return np.empty(0)
    force = verdict.forces.copy()
    force[:, 0] += point_law(assembly, faces).shift - verdict.adhesion
    total = np.add.reduceat(force, faces.start[:-1])
    normal, tangent = total[:, 0], np.hypot(total[:, 1], total[:, 2])
    size = np.add.reduceat(np.linalg.norm(force, axis=1), faces.start[:-1])
    loaded = size > IDLE * size.max()
    pressed = loaded & (normal > 0)
    weighted = np.add.reduceat(force[:, :1] * faces.point, faces.start[:-1])
    centre = weighted / np.where(pressed, normal, 1.0)[:, None]
    with np.errstate(divide="ignore", invalid="ignore"):
        friction = np.where(tangent > 0, tangent / (joint_friction(assembly, faces) * normal), 0.0)
    used = np.maximum(friction, eccentricity(faces, centre))
    return np.where(pressed, np.clip(used, 0.0, 1.0), loaded.astype(float))


def eccentricity(interfaces: Interfaces, point: Floats) -> Floats:
    """Return the gauge of each joint about its centroid at a point in its plane: 0 at the centroid, 1 on the edge.

    Parameters
    ----------
    interfaces : Interfaces
        The joints. Their patches are convex (see `blockstat.contact.interfaces`); edges have two ends, and a corner,
        which is only a point, has the gauge 0.
    point : array of float, shape (n_interfaces, 3)
        One point for each patch [m].

    Returns
    -------
    array of float, shape (n_interfaces,)
        Gauges, above 1 outside the patch.
    """
    result = np.zeros(interfaces.n_interfaces)
    for k, frame in enumerate(interfaces.frame):
        corner = interfaces.outline(k)
        if len(corner) < 3:
            half = (corner[-1] - corner[0]) / 2
            along = abs(float((point[k] - corner[0] - half) @ half))
            result[k] = along / float(half @ half) if half.any() else 0.0
            continue
        flat = (corner - corner[0]) @ frame[1:].T
        edge = np.roll(flat, -1, axis=0) - flat
        twice = flat[:, 0] * np.roll(flat[:, 1], -1) - flat[:, 1] * np.roll(flat[:, 0], -1)
        middle = ((flat + np.roll(flat, -1, axis=0)) * twice[:, None]).sum(axis=0) / (3 * twice.sum())
        outward = np.column_stack([edge[:, 1], -edge[:, 0]]) * np.sign(twice.sum())
        clearance = np.einsum("ij,ij->i", outward, flat - middle)
        reach = outward @ ((point[k] - corner[0]) @ frame[1:].T - middle)
        # An edge of no length, where two corners coincide, bounds nothing.
        real = clearance > 1e-12 * clearance.max()
        result[k] = max(float((reach[real] / clearance[real]).max()), 0.0)
    return result


def plot_utilisation(verdict: Verdict, place: Place, **options: Any) -> Place:
    """Draw the joints coloured by `utilisation`, over blocks that one sees through: patches, lines and dots.

    Parameters
    ----------
    verdict : Verdict
        The verdict.
    place : str, Path or matplotlib Axes
        A file or axes, as in `plot`.
    **options
        Options of `plot`; an `overlay` takes the place of the joints.

    Returns
    -------
    str, Path or matplotlib Axes
        The place.

    Raises
    ------
    InputError
        For a file that cannot be written, or an unknown option.

    Examples
    --------
    >>> from blockstat import Assembly, assess, box, plot_utilisation
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> plot_utilisation(assess(assembly), "joints.png")
    'joints.png'
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    look, view = looked_at(options)
    faces = verdict.interfaces
    bar = ScalarMappable(Normalize(0.0, 1.0), colormaps[DEMAND])
    used = utilisation(verdict)
    depth = np.add.reduceat(faces.point @ view[2], faces.start[:-1]) / np.diff(faces.start) if len(used) else used
    order = np.argsort(depth, kind="stable")

    def draw(axes: Axes) -> None:
        draw_joints(axes, faces, view, order, bar.to_rgba(used[order]))
        axes.figure.colorbar(bar, ax=axes, shrink=0.6, label="capacity of the joint used (1 = sliding or hinging)")

    what = "use of the joints" if balanced(verdict) else "use of the joints by forces that are not in equilibrium"
    title = f"{verdict.assembly.name}: {verdict.outcome.word}, {what}"
    drawn = {"title": title, "opacity": 0.12, "overlay": draw}
    return plot(verdict.assembly, place, **drawn | look)


def plot_reserve_map(found: ReserveMap, what: str, place: Place, **options: Any) -> Place:
    """Draw what a limit load hangs on: where to repoint, where to measure.

    Parameters
    ----------
    found : ReserveMap
        Derivatives of the limit load.
    what : {"edge", "friction", "corner"}
        By what each joint loses along its edges, by the friction of each joint, or by the place of each corner.
    place : str, Path or matplotlib Axes
        A file or axes, as in `plot`.
    **options
        Options of `plot`; an `overlay` takes the place of the joints.

    Returns
    -------
    str, Path or matplotlib Axes
        The place.

    Raises
    ------
    InputError
        For another map, for corners that were not asked for, for a file that cannot be written, or an unknown option.

    Examples
    --------
    >>> from blockstat import Assembly, box, limit_load, plot_reserve_map, reserve_map
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> found = reserve_map(limit_load(assembly, (1, 0, 0)), (1, 0, 0))
    >>> plot_reserve_map(found, "edge", "edges.png")
    'edges.png'
    """
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import Normalize

    check_choice("what", what, tuple(LABELS))
    look, view = looked_at(options)
    faces, (label, step) = found.limit.interfaces, LABELS[what]
    value = step * np.abs(found.by(what))
    least = step * found.floor(what)  # up to here it is rounding
    top = max(float(value.max(initial=0.0)), least, 1e-12)
    bar = ScalarMappable(Normalize(0.0, top), colormaps[HEAT])
    order = np.argsort(value, kind="stable")
    order = order[value[order] > max(FAINT * top, least)]  # the rest would hide what matters

    def draw(axes: Axes) -> None:
        if what == "corner" and found.corner is not None:
            across, up, _ = view @ found.corner.points[order].T
            axes.scatter(across, up, s=3.0 + 60.0 * value[order] / top, c=bar.to_rgba(value[order]), zorder=5)
        else:
            draw_joints(axes, faces, view, order, bar.to_rgba(value[order]))
        if len(order):
            axes.figure.colorbar(bar, ax=axes, shrink=0.6, label=label, format=lambda x, _: f"{x:.2g}")

    said = "what the limit {} hangs on" if len(order) else "the limit {} hangs on no " + what
    title = f"{found.limit.assembly.name}: {said.format(f'{found.value:.4g}')}"
    return plot(found.limit.assembly, place, **{"title": title, "opacity": 0.12, "overlay": draw} | look)
