"""Strength of joints that have slid: it counts in full while they are shut, and real mortar is sheared by then."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from blockstat.contact.point_law import last_law
from blockstat.large_displacement.displaced.contact_pairs import CORNER_TOLERANCE, pair_points, pairs_at_rest
from blockstat.large_displacement.displaced.pose import free_sizes
from blockstat.large_displacement.displaced.structure import Structure
from blockstat.large_displacement.linkage.path import PathState
from blockstat.result import listed
from blockstat.typing import Floats

#: Joints that a warning names at most. Chosen.
MOST_NAMES = 5


def warning_of_strength(structure: Structure, states: Sequence[PathState]) -> list[str]:
    """Return what must be told of joints that have slid and whose strength still counts.

    Parameters
    ----------
    structure
        The structure at rest.
    states
        Of a path.

    Returns
    -------
    list of str
        One warning that names the joints and their largest slip, or none.
    """
    assembly, interfaces = structure.assembly, structure.interfaces
    strong = np.array([law is not None and law.strong for law in last_law(assembly, interfaces)], dtype=bool)
    if not strong.any():
        return []
    slip = np.max([np.where(strong, _slip_while_shut(state), 0.0) for state in states], axis=0)
    slid = np.flatnonzero(slip > CORNER_TOLERANCE * float(free_sizes(assembly).max()))
    if not len(slid):
        return []
    names = listed(
        [" and ".join(f'"{assembly.names[block]}"' for block in interfaces.pair[k]) for k in slid], MOST_NAMES
    )
    return [
        f"the strength of joints that have slid by up to {1e3 * slip.max():.3g} mm counts in full, as they are still "
        f"shut, though mortar and bonds are sheared by then: {names}. Without it less is carried"
    ]


def _slip_while_shut(state: PathState) -> Floats:
    """How far points of rest are apart in each joint that is shut all over, at most, shape (n_interfaces,) [m]."""
    linkage, point = state.linkage, state.point
    structure = linkage.structure
    faces, contact = linkage.configuration(point.pose, point.parameter).joints
    whole = linkage.contacts.joint[contact[faces.start[:-1]][faces.area > 0]]
    contacts = pairs_at_rest(structure.assembly, structure.interfaces)
    drive = np.zeros_like(contacts.drive)
    for joint in np.unique(whole):
        drive[contacts.joint == joint] = linkage.contacts.drive[linkage.contacts.joint == joint][0]
    there = pair_points(structure.assembly, contacts, point.pose, 0.0) + point.parameter * drive
    apart = np.linalg.norm(there[:, 1] - there[:, 0], axis=1)
    slip = np.zeros(structure.interfaces.n_interfaces)
    np.maximum.at(slip, contacts.joint, apart)
    slip[~np.isin(np.arange(len(slip)), whole)] = 0.0
    return slip
