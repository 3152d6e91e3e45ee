"""Decentring: how blocks follow a centring that is lowered by a little, and which joints open.

Props that are lowered by d along their lines allow blocks to sink by d there and no more. With rigid blocks the loads
do the most work that joints and props allow::

    maximise w'u   subject to   A'u in K*,   B'u >= -d,

which is the dual of the least total force of the props, d sum r. So u are the multipliers of equilibrium in that
program (`blockstat.sequence.props`): a prop that carries a force lets its block sink by d, and w'u = d sum r. What
stands by itself needs no force and does not move: the centring comes free. Joints hinge at the points where they keep
touching.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.errors import InputError, check_positive, known_options
from blockstat.geometry.polyhedron import point_velocity
from blockstat.result import Result, plain
from blockstat.sequence.props import Falsework, FalseworkOutcome, Prop, held_by_props
from blockstat.sequence.states import State
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Joints that open by less than this share of the lowering are closed: the accuracy of the program.
CLOSED = 1e-4


@dataclass(frozen=True, eq=False)
class Decentring(Result):
    """What moves when a centring is lowered."""

    assembly: Assembly
    interfaces: Interfaces  #: the joints of the state
    falsework: Falsework  #: the least forces of the props before
    lowering: float  #: [m]
    displacement: Floats  #: of the centroids, and rotations, shape (n_blocks, 6) [m, rad]
    opening: Floats  #: of each joint where it opens most, shape (n_interfaces,) [m]
    hinges: Ints  #: joints that open at some points and keep touching at others

    @property
    def moving(self) -> Ints:
        """Blocks that follow the centring."""
        reach = np.abs(self.displacement[:, :3]).max(axis=1) + np.abs(self.displacement[:, 3:]).max(axis=1)
        return np.flatnonzero(reach > CLOSED * self.lowering)

    def summary(self) -> dict[str, Any]:
        """Return plain values for JSON.

        Returns
        -------
        dict
            With the blocks that follow the centring and the joints that hinge.
        """
        names = self.assembly.names
        return {
            "lowering": self.lowering,
            "total": self.falsework.total,
            "moving": [names[k] for k in self.moving],
            "hinges": [
                {"between": [names[k] for k in self.interfaces.pair[j]], "opening": float(self.opening[j])}
                for j in self.hinges
            ],
        }

    def explain(self) -> str:
        """Return the result in words.

        Returns
        -------
        str
            One fact a line.
        """
        if not len(self.moving):
            return "The centring comes free: the blocks stand without it."
        names = self.assembly.names
        lines = [f"Lowered by {1e3 * self.lowering:g} mm, {len(self.moving)} blocks follow the centring."]
        for joint in self.hinges:
            a, b = (names[k] for k in self.interfaces.pair[joint])
            lines.append(f'"{a}" and "{b}" hinge: their joint opens by {plain(1e3 * float(self.opening[joint]))} mm.')
        return "\n".join(lines)


@known_options
def decentring(
    assembly: Assembly,
    state: State,
    props: Sequence[Prop],
    *,
    lowering: float = 0.001,
    friction: float | None = None,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> Decentring:
    """Lower all props of a state by a small amount.

    Parameters
    ----------
    assembly : Assembly
        All blocks, with dry joints.
    state : (sequence of str, sequence of str)
        Blocks that are present, and those among them that are held, as of `assess_states`.
    props : sequence of Prop
        Under blocks that are present and free.
    lowering : float, optional
        How far each prop gives way along its line [m].
    friction, gap, interfaces
        As of `assess_states`.

    Returns
    -------
    Decentring
        The displacements and the joints that open. Where several motions do the same work it is one of them.

    Raises
    ------
    InputError
        For a prop under a block that is not present or held, a lowering that is not a finite length above 0, or props
        that cannot hold the state.

    Examples
    --------
    A block on nothing sinks with its prop; one on the ground needs none.

    >>> from blockstat import Assembly, box, decentring, hoists
    >>> blocks = [box((-2, 0, -1), (-1, 1, 0), name="ground"), box((0, 0, 1), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> found = decentring(assembly, (["block"], []), hoists(assembly, ["block"]), lowering=0.01)
    >>> found.displacement[1, 2].round(6).item()
    -0.01
    """
    check_positive("lowering", lowering)
    options: dict[str, Any] = {"friction": friction, "gap": gap, "interfaces": interfaces}
    problem, found, twist = held_by_props(assembly, state, props, least="total", **options)
    if found.outcome is FalseworkOutcome.NOT_HELD:
        raise InputError("decentring: no forces in these props balance the blocks, so there is nothing to lower")
    displacement = lowering * problem.to_blocks(twist)
    faces = problem.interfaces
    joint = faces.point_interface
    one, two = (point_velocity(assembly, displacement, faces.pair[joint, side], faces.point) for side in (0, 1))
    gaps = np.einsum("nj,nj->n", faces.frame[joint, 0], two - one)
    most, least = np.zeros(faces.n_interfaces), np.full(faces.n_interfaces, np.inf)
    np.maximum.at(most, joint, gaps)
    np.minimum.at(least, joint, gaps)
    hinges = np.flatnonzero((most > CLOSED * lowering) & (least <= CLOSED * lowering))
    return Decentring(assembly, faces, found, lowering, displacement, most, hinges)
