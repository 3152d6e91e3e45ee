"""Bonds and ties in a proof file: rows that follow those of the contacts.

A bond is two rows at the centre of its joint, a force and a couple on block b. Each is h n + t, with n the normal and t
across it, and bounded without a root:

    force:    -bond   <= h <= 0,        |t| <= bond   |n|;
    couple:   -moment <= h <= moment,   |t| <= moment |n|.

A tie is one row, a force h n on block b with least <= h <= greatest. Its n is along the line of its ends, towards block
a, and away from it for a strut. A tie of constant force is a load.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from blockstat.analysis.problem import Problem
from blockstat.contact.cells import centres
from blockstat.contact.point_law import last_law
from blockstat.contact.tolerance import LOOSE
from blockstat.errors import InputError
from blockstat.program.ties import tie_columns, tied_pairs
from blockstat.proof.places import LEAST, on_faces
from blockstat.proof.rational import Exact, exact, text, written
from blockstat.proof.solids import Solid
from blockstat.typing import Floats


@dataclass(frozen=True, eq=False)
class Connector:
    """One row: the force or the couple of a bond, or the force of a tie."""

    blocks: tuple[int, int]  #: a and b
    told: dict[str, Any]  #: where it is, as the file says it
    point: Exact  #: where a force on block b acts, shape (3,) [m]
    normal: Exact  #: shape (3,), unit to rounding
    least: float  #: multiple of the normal [N or N m]
    most: float  #: inf for none [N or N m]
    shear: float = 0.0  #: the most across the normal, 0 for ties [N or N m]
    couple: bool = False
    distance: float = LEAST  #: how far it is off the faces of its blocks, or out of their boxes [m]
    sine: float = LEAST  #: of the angle by which its normal is not that of the faces

    def entry(self) -> dict[str, Any]:
        """Return what a file says of it.

        Returns
        -------
        dict
            Numbers as text.
        """
        entry = {"blocks": list(self.blocks)} | self.told | {"normal": written(self.normal)}
        entry |= {"least": text(exact(self.least)[()])}
        entry |= {"most": text(exact(self.most)[()])} if np.isfinite(self.most) else {}
        entry |= {} if "ends" in self.told else {"shear": text(exact(self.shear)[()])}
        return entry | ({"couple": True} if self.couple else {})


def connectors(problem: Problem, blocks: list[Solid]) -> list[Connector]:
    """Return the bonds and ties of a problem, but for ties of constant force.

    Parameters
    ----------
    problem
        The posed problem.
    blocks
        Its blocks.

    Returns
    -------
    list of Connector
        Two rows for each bond, then one for each tie.

    Raises
    ------
    InputError
        For a bond at the centre of a joint of several patches, which lies on none of them.
    """
    return [*_bonds(problem, blocks), *_ties(problem, blocks)]


def connector_forces(problem: Problem, force: Floats) -> tuple[Floats, Floats]:
    """Return what the rows carry, and by how much it may change.

    Parameters
    ----------
    problem
        The posed problem.
    force
        Of the program, shape (m, 3).

    Returns
    -------
    values : Floats
        Force or couple on block b, shape (n, 3) [N or N m].
    slack : Floats
        Of each row within its bounds, in units of the program, shape (n,); 0 for ties.
    """
    program, laws = problem.program, last_law(problem.assembly, problem.interfaces)
    assert program is not None
    values, slack = [], []
    bonds = problem.to_bonds(force)
    if bonds is not None:
        for k, *own in zip(bonds.interface, bonds.force, bonds.moment, strict=True):
            law, normal = laws[k], problem.interfaces.frame[k, 0]
            assert law is not None
            limits = (-law.bond, 0.0, law.bond), (-law.bond_moment, law.bond_moment, law.bond_moment)
            for value, (least, most, shear), unit in zip(own, limits, (1.0, program.length_unit), strict=True):
                head = float(value @ normal)
                room = min(head - least, most - head, shear - float(np.linalg.norm(value - head * normal)))
                values.append(value if shear else 0.0 * value)
                slack.append(max(room, 0.0) / (unit * program.force_unit))
    tension = problem.to_ties(force)
    if tension is not None:
        lines = tie_columns(problem.assembly, problem.assembly.ties).force[:, 0]
        free = np.array([not tie.constant for tie in problem.assembly.ties])
        values += list((tension[:, None] * lines)[free])
        slack += [0.0] * int(free.sum())
    return np.array(values).reshape(-1, 3), np.array(slack)


def _bonds(problem: Problem, blocks: list[Solid]) -> list[Connector]:
    """The force and the couple of each bond."""
    assembly, interfaces = problem.assembly, problem.interfaces
    laws, found = last_law(assembly, interfaces), []
    for k, centre in zip(problem.bonds, centres(interfaces, problem.bonds), strict=True):
        law, normal, (a, b) = laws[k], interfaces.frame[k, 0], interfaces.pair[k].tolist()
        assert law is not None
        places = on_faces(blocks[a], blocks[b], centre[None], normal)
        distance, sine = (max(LEAST, *(getattr(place, key) for place in places)) for key in ("distance", "sine"))
        if distance > LOOSE * min(blocks[a].size, blocks[b].size):
            names = f'"{assembly.names[a]}" and "{assembly.names[b]}"'
            raise InputError(
                f"the bond of {names} is at the centre of several patches, beside all of them; a proof file needs it "
                "on one: divide the blocks so that each joint is one patch"
            )
        told = {"on": [place.on[0] for place in places], "point": written(exact(centre))}
        where = {"told": told, "point": exact(centre), "normal": exact(normal), "distance": distance, "sine": sine}
        f, m = law.bond, float(law.bond_moment or 0.0)
        found.append(Connector((a, b), least=-f, most=0.0, shear=f, **where))
        found.append(Connector((a, b), least=-m, most=m, shear=m, couple=True, **where))
    return found


def _ties(problem: Problem, blocks: list[Solid]) -> list[Connector]:
    """Each tie whose force is not given."""
    assembly, found = problem.assembly, []
    lines = tie_columns(assembly, assembly.ties).force[:, 0] if assembly.ties else []
    for tie, pair, line in zip(assembly.ties, tied_pairs(assembly), lines, strict=True):
        if tie.constant:
            continue
        ends, out = np.asarray(tie.points, dtype=float), LEAST
        for block, end in zip(pair, ends, strict=True):
            if not assembly.support[block]:  # the ground may be anywhere
                low, high = blocks[block].corners.min(axis=0), blocks[block].corners.max(axis=0)
                out = max(out, float(np.maximum(low - end, end - high).max()))
        a, b = pair.tolist()
        told = {"ends": written(exact(ends))}
        least, most = float(tie.least), float(tie.greatest)
        found.append(Connector((a, b), told, exact(ends[1]), exact(line), least, most, distance=out))
    return found
