"""The data of a proof file: blocks, contacts and loads as exact numbers."""

from __future__ import annotations

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import numpy as np

from blockstat.analysis.problem import Problem
from blockstat.contact.point_law import PointLaw, point_law
from blockstat.errors import InputError
from blockstat.proof.places import contact_places
from blockstat.proof.rational import Exact, exact, text, written
from blockstat.proof.solids import solids
from blockstat.typing import Floats, Ints

#: Tolerances are written with so many digits, rounded up.
DIGITS = 2


@dataclass(frozen=True, eq=False)
class Structure:
    """Blocks, contacts and loads as a checker reads them; moments and velocities are about the origin."""

    data: dict[str, Any]  #: what the file says, numbers as text
    fixed: np.ndarray  #: shape (n_blocks,), which blocks cannot move
    pair: Ints  #: blocks a and b of each contact, shape (n, 2)
    point: Exact  #: shape (n, 3) [m]
    normal: Exact  #: from a to b, shape (n, 3)
    friction: Floats  #: shape (n,), inf allowed
    dead: Exact  #: shape (n_blocks, 6) [N, N m]
    live: Exact  #: shape (n_blocks, 6) [N, N m]
    law: PointLaw | None  #: of the contacts; None where all are dry

    def act(self, left: Exact, contacts: Ints, force: Exact) -> None:
        """Add forces at contacts to what the blocks have; fixed blocks take anything.

        Parameters
        ----------
        left
            Wrenches about the origin, shape (n_blocks, 6) [N, N m]; changed in place.
        contacts
            Shape (n,).
        force
            On blocks b, shape (n, 3) [N].
        """
        wrench = np.hstack([force, np.cross(self.point[contacts], force)])
        np.subtract.at(left, self.pair[contacts, 0], wrench)
        np.add.at(left, self.pair[contacts, 1], wrench)
        left[self.fixed] = Fraction(0)

    def balance(self, force: Exact, multiplier: Fraction) -> Exact:
        """Return what forces and loads leave over at each block.

        Parameters
        ----------
        force
            Of the contacts on their blocks b, shape (n, 3) [N].
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


def structure(problem: Problem, loads: Floats | None, live: Floats | None) -> Structure:
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
        For ties and for bonds at the centres of joints, which proof files do not know.
    """
    assembly, interfaces = problem.assembly, problem.interfaces
    if len(problem.bonds) or assembly.ties:
        what = "ties" if assembly.ties else "bonds at the centres of joints"
        raise InputError(f'"{assembly.name}" has {what}; proof files know contacts only')
    blocks = solids(assembly)
    law = point_law(assembly, interfaces)
    lawful = bool(law.shift.any() or law.floor.any() or np.isfinite(law.cap).any())
    on, distance, sine = contact_places(blocks, interfaces)
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
            for key, load, total in (("dead", loads, dead), ("live", live, live_exact)):
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
    data = {"gravity": written(gravity), "distance": _above(distance), "sine": _above(sine)}
    data |= {"blocks": told, "contacts": contacts}
    return Structure(
        data, assembly.support, pair, point, normal, law.friction, dead, live_exact, law if lawful else None
    )


def _above(value: float) -> str:
    """The next number of few digits above a value."""
    places = DIGITS - 1 - int(np.floor(np.log10(value)))
    return text(Fraction(int(np.ceil(value * 10.0**places - 1e-9)), 1) / Fraction(10) ** places)
