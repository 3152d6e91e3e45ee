"""The data of a proof file: blocks, contacts and loads as exact numbers."""

from __future__ import annotations

from dataclasses import dataclass, replace
from fractions import Fraction
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.problem import Problem, checked_loads
from blockstat.contact.point_law import PointLaw, point_law
from blockstat.loads import Loads
from blockstat.program.ties import tie_wrenches
from blockstat.proof.connectors import Connector, connectors
from blockstat.proof.places import contact_places
from blockstat.proof.rational import Exact, exact, text, written
from blockstat.proof.solids import Solid, solids
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: Tolerances are written with so many digits, rounded up.
DIGITS = 2


@dataclass(frozen=True, eq=False)
class Structure:
    """Blocks, contacts and loads as a checker reads them; moments and velocities are about the origin.

    The n rows are those of the contact points, and then those of bonds and ties (`blockstat.proof.connectors`).
    """

    data: dict[str, Any]  #: what the file says, numbers as text
    fixed: np.ndarray  #: shape (n_blocks,), which blocks cannot move
    pair: Ints  #: blocks a and b of each row, shape (n, 2)
    point: Exact  #: shape (n, 3) [m]
    normal: Exact  #: from a to b, shape (n, 3)
    friction: Floats  #: shape (n,), inf allowed, 0 for bonds and ties
    dead: Exact  #: shape (n_blocks, 6) [N, N m]
    live: Exact  #: shape (n_blocks, 6) [N, N m]
    law: PointLaw | None  #: of the rows; None where all are dry contacts
    shear: Floats  #: what bonds bear across their normals, 0 for contacts and ties, shape (n,) [N or N m]
    couple: np.ndarray  #: whether the row is a couple and not a force, shape (n,)
    blocks: list[Solid]  #: their corners and faces

    def act(self, left: Exact, rows: Ints, force: Exact) -> None:
        """Add forces, and couples of bonds, to what the blocks have; fixed blocks take anything.

        Parameters
        ----------
        left
            Wrenches about the origin, shape (n_blocks, 6) [N, N m]; changed in place.
        rows
            Shape (k,).
        force
            On blocks b, shape (k, 3) [N or N m].
        """
        wrench = np.hstack([force, np.cross(self.point[rows], force)])
        turning = np.flatnonzero(self.couple[rows])
        wrench[turning] = np.hstack([0 * force[turning], force[turning]])
        np.subtract.at(left, self.pair[rows, 0], wrench)
        np.add.at(left, self.pair[rows, 1], wrench)
        left[self.fixed] = Fraction(0)

    def balance(self, force: Exact, multiplier: Fraction) -> Exact:
        """Return what forces and loads leave over at each block.

        Parameters
        ----------
        force
            Of the rows on their blocks b, shape (n, 3) [N or N m].
        multiplier
            Of the live load.

        Returns
        -------
        Exact
            About the origin, shape (n_blocks, 6) [N, N m]; 0 for fixed blocks.
        """
        left = self.dead + multiplier * self.live
        self.act(left, np.arange(len(self.pair)), force)
        return left


def structure(problem: Problem, loads: Loads | None, live: Floats | None) -> Structure:
    """Write down a problem exactly.

    Parameters
    ----------
    problem
        The posed problem.
    loads
        Wrench on each block beside the weight, about its centroid, shape (n_blocks, 6) [N, N m]; None for none.
    live
        The load of a multiplier, likewise.

    Returns
    -------
    Structure
        With floats taken for the decimals that Python prints.

    Raises
    ------
    InputError
        For a bond that lies on no face, as `blockstat.proof.connectors.connectors`.
    """
    assembly, interfaces = problem.assembly, problem.interfaces
    blocks = solids(assembly)
    more = connectors(problem, blocks)
    law = point_law(assembly, interfaces)
    lawful = bool(law.shift.any() or law.floor.any() or np.isfinite(law.cap).any())
    on, distance, sine = contact_places(blocks, interfaces)
    acting = _with_given_ties(assembly, None if loads is None else checked_loads(assembly, loads))
    pair = interfaces.pair[interfaces.point_interface]
    point, normal = exact(interfaces.point), exact(interfaces.frame[:, 0])[interfaces.point_interface]
    gravity, density, centre = exact(assembly.gravity), exact(assembly.density), exact(assembly.centroid)
    dead = np.full((assembly.n_blocks, 6), Fraction(0), dtype=object)
    live_exact = dead.copy()
    told = []
    for k, solid in enumerate(blocks):
        entry: dict[str, Any] = {"name": assembly.names[k], "fixed": bool(assembly.support[k])}
        entry |= {"density": text(density[k]), "vertices": written(exact(solid.corners)), "faces": solid.faces}
        if not assembly.support[k]:
            mass, moment = solid.weigh(density[k])
            dead[k] = np.concatenate([mass * gravity, np.cross(moment, gravity)])
            for key, load, total in (("dead", acting, dead), ("live", live, live_exact)):
                if load is not None and load[k].any():
                    force, couple = exact(load[k]).reshape(2, 3)
                    wrench = np.concatenate([force, couple + np.cross(centre[k], force)])
                    entry[key], total[k] = written(wrench), total[k] + wrench
        told.append(entry)
    contacts = []
    for i in range(len(pair)):
        mu = law.friction[i]
        entry = {"blocks": pair[i].tolist(), "on": on[i], "point": written(point[i]), "normal": written(normal[i])}
        entry["friction"] = "inf" if np.isinf(mu) else text(exact(mu)[()])
        if lawful:
            entry |= {"apex": text(exact(law.shift[i])[()]), "least": text(exact(law.floor[i])[()])}
            entry |= {"most": text(exact(law.cap[i])[()])} if np.isfinite(law.cap[i]) else {}
        contacts.append(entry)
    distance, sine = max([distance, *(row.distance for row in more)]), max([sine, *(row.sine for row in more)])
    rows = [*contacts, *(row.entry() for row in more)]
    sides = [side for row in rows for side in zip(row["blocks"], row.get("on", []), strict=False)]
    distance = max([distance, *(float(blocks[k].uneven[place[0]]) for k, place in sides if len(place) == 1)])
    data = {"gravity": written(gravity), "distance": _above(distance), "sine": _above(sine)}
    data |= {"blocks": told, "contacts": rows}
    own, none = (data, assembly.support, pair, point, normal, law.friction, dead, live_exact), np.zeros(len(pair))
    found = Structure(*own, law=law if lawful else None, shear=none, couple=none > 0, blocks=blocks)
    return _with_connectors(found, law, more) if more else found


def with_normals_of_faces(found: Structure) -> Structure:
    """Put the exact normals of faces in place of those of frames, which are rounded.

    Parameters
    ----------
    found
        The structure.

    Returns
    -------
    Structure
        The same, with normals in the direction of the face of block a on which a contact lies, or of block b.
    """
    normal = found.normal.copy()
    told = [dict(entry) for entry in found.data["contacts"]]
    for i, entry in enumerate(told):
        sides = [(side, place[0]) for side, place in enumerate(entry.get("on", [])) if len(place) == 1]
        if sides:
            side, face = sides[0]
            normal[i] = (-1) ** side * found.blocks[entry["blocks"][side]].normal(face)
            entry["normal"] = written(normal[i])
    return replace(found, data=found.data | {"contacts": told}, normal=normal)


def _with_given_ties(assembly: Assembly, loads: Floats | None) -> Floats | None:
    """Loads with those of the ties whose forces are given."""
    given = [tie for tie in assembly.ties if tie.constant]
    if not given:
        return loads
    own = tie_wrenches(assembly, given, np.array([tie.least for tie in given]))
    return own if loads is None else loads + own


def _with_connectors(found: Structure, law: PointLaw, more: list[Connector]) -> Structure:
    """A structure with rows of bonds and ties after those of its contacts."""
    none = np.zeros(len(more))
    least, most, shear = (np.array([getattr(row, key) for row in more]) for key in ("least", "most", "shear"))
    joined = (law.friction, none), (law.shift, none), (law.floor, least), (law.cap, most)
    law = PointLaw(*(np.concatenate(parts) for parts in joined))
    return replace(
        found,
        pair=np.concatenate([found.pair, [row.blocks for row in more]]),
        point=np.concatenate([found.point, [row.point for row in more]]),
        normal=np.concatenate([found.normal, [row.normal for row in more]]),
        friction=law.friction,
        law=law,
        shear=np.concatenate([found.shear, shear]),
        couple=np.concatenate([found.couple, [row.couple for row in more]]),
    )


def _above(value: float) -> str:
    """The next number of few digits above a value."""
    places = DIGITS - 1 - int(np.floor(np.log10(value)))
    return text(Fraction(int(np.ceil(value * 10.0**places - 1e-9)), 1) / Fraction(10) ** places)
