"""The joint laws of an assembly at its contact points."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.errors import InputError
from blockstat.joint import JointLaw, fits
from blockstat.typing import Floats

#: Cohesion needs a cone with an apex, and one not so far away that the forces are lost to rounding.
LEAST_FRICTION = 1e-3


@dataclass(frozen=True, eq=False)
class PointLaw:
    """The laws of contact points, arrays of shape (n_points,)."""

    friction: Floats
    shift: Floats  #: height a of the cone's apex below zero force [N]
    floor: Floats  #: least f'_n = f_n + a [N], 0 where the apex itself cuts off the tension
    cap: Floats  #: greatest f'_n [N], inf without a compressive strength


def joint_friction(assembly: Assembly, interfaces: Interfaces) -> Floats:
    """Return the coefficient of friction of each interface.

    Parameters
    ----------
    assembly : Assembly
        Has the joint laws and the friction of joints without one.
    interfaces : Interfaces
        The interfaces; a friction of their own counts first.

    Returns
    -------
    array of float, shape (n_interfaces,)
        Coefficients of friction; the assembly's where the last law that fits gives none.
    """
    if interfaces.friction is not None:
        return interfaces.friction
    friction = np.full(interfaces.n_interfaces, assembly.friction)
    for law, rows in laws_of(assembly, interfaces):
        friction[rows] = assembly.friction if law.friction is None else law.friction
    return friction


def point_law(assembly: Assembly, interfaces: Interfaces) -> PointLaw:
    """Return the joint law of each contact point.

    Parameters
    ----------
    assembly : Assembly
        Has the joint laws.
    interfaces : Interfaces
        The interfaces with their contact points.

    Returns
    -------
    PointLaw
        Arrays over the points; strengths [N] are shares of those of the joint.

    Raises
    ------
    InputError
        For cohesion on a joint with next to no friction, whose cone has no apex.
    """
    k = interfaces.point_interface
    friction = joint_friction(assembly, interfaces)
    n = interfaces.n_interfaces
    tension, cohesion, compression = np.zeros(n), np.full(n, np.nan), np.full(n, np.inf)
    for law, rows in laws_of(assembly, interfaces):
        # Glue needs a surface: edges and corners have none.
        spread = np.where(interfaces.area[rows] > 0, law.bond if law.bond_moment is None else 0.0, 0.0)
        tension[rows] = law.tension * interfaces.area[rows] + spread
        cohesion[rows] = np.nan if law.cohesion is None else law.cohesion * interfaces.area[rows]
        compression[rows] = np.inf if law.compression is None else law.compression * interfaces.area[rows]
    smooth = (friction < LEAST_FRICTION) & (cohesion > 0)
    if smooth.any():
        law = last_law(assembly, interfaces)[int(np.argmax(smooth))]
        assert law is not None
        label = " and ".join(law.between)
        raise InputError(f"joint law between {label}: cohesion needs a friction of at least {LEAST_FRICTION:g}")
    with np.errstate(divide="ignore", invalid="ignore"):
        apex = np.where(np.isnan(cohesion) | (friction == 0) | np.isinf(friction), tension, cohesion / friction)
    share = interfaces.point_share
    floor = np.maximum(apex - tension, 0.0)
    # Points that stand for no area, such as the ends of an edge beside a foot, bear any pressure where joints do.
    cap = np.where(np.isinf(compression[k]), np.inf, share * np.nan_to_num((compression + apex)[k], posinf=0.0))
    return PointLaw(friction[k], share * apex[k], share * floor[k], cap)


def keeps_friction(assembly: Assembly, interfaces: Interfaces) -> np.ndarray:
    """Return which joints have a friction of their own, whatever that of the assembly is.

    Parameters
    ----------
    assembly : Assembly
        Has the joint laws.
    interfaces : Interfaces
        The interfaces.

    Returns
    -------
    array of bool, shape (n_interfaces,)
        True where the interfaces say it, or else the last law that fits.
    """
    if interfaces.friction is not None:
        return np.ones(interfaces.n_interfaces, dtype=bool)
    return np.array([law is not None and law.friction is not None for law in last_law(assembly, interfaces)], bool)


def kept_friction(assembly: Assembly, interfaces: Interfaces, rows: np.ndarray) -> str:
    """Return what is said of joints for which a friction that is asked for does not count.

    Parameters
    ----------
    assembly : Assembly
        Has the joint laws.
    interfaces : Interfaces
        The interfaces.
    rows : array of bool, shape (n_interfaces,)
        Those joints, of `keeps_friction`.

    Returns
    -------
    str
        As of `kept_by`, with the laws that count for these joints.
    """
    if interfaces.friction is not None:
        return kept_by([])
    return kept_by(law for law, kept in zip(last_law(assembly, interfaces), rows, strict=True) if law and kept)


def kept_by(laws: Iterable[JointLaw]) -> str:
    """Return that joints keep a friction of their own, and whose it is.

    Parameters
    ----------
    laws : iterable of JointLaw
        Those that give it; none where the interfaces do.

    Returns
    -------
    str
        The groups of each law, once.

    Examples
    --------
    >>> kept_by([JointLaw(("wall", "*"), friction=0.5)])
    'keep a friction of their own, by the joint law between "wall" and "*"'
    """
    pairs = list(dict.fromkeys(f'"{one}" and "{two}"' for one, two in (law.between for law in laws)))
    by = f"by the joint law{'s' if len(pairs) > 1 else ''} between {', between '.join(pairs)}"
    return f"keep a friction of their own, {by if pairs else 'which the interfaces give'}"


def least_friction(assembly: Assembly) -> float:
    """Return the least coefficient of friction that the joints of an assembly may have.

    Parameters
    ----------
    assembly : Assembly
        Has the joint laws.

    Returns
    -------
    float
        0, or what cohesion needs where a law has it.
    """
    return LEAST_FRICTION if any(law.cohesion for law in assembly.joints) else 0.0


def laws_of(assembly: Assembly, interfaces: Interfaces) -> list[tuple[JointLaw, np.ndarray]]:
    """Return each joint law with the interfaces that it fits.

    Parameters
    ----------
    assembly : Assembly
        Has the joint laws.
    interfaces : Interfaces
        The interfaces.

    Returns
    -------
    list of (JointLaw, array of bool, shape (n_interfaces,))
        In the order of the laws; the last one that fits a joint counts.
    """
    found = []
    for law in assembly.joints:
        one, two = (np.array([fits(name, group) for group in assembly.groups]) for name in law.between)
        a, b = interfaces.pair.T
        found.append((law, (one[a] & two[b]) | (two[a] & one[b])))
    return found


def last_law(assembly: Assembly, interfaces: Interfaces) -> list[JointLaw | None]:
    """Return the joint law that counts for each interface.

    Parameters
    ----------
    assembly : Assembly
        Has the joint laws.
    interfaces : Interfaces
        The interfaces.

    Returns
    -------
    list of JointLaw or None
        One an interface, None where no law fits.
    """
    chosen: list[JointLaw | None] = [None] * interfaces.n_interfaces
    for law, rows in laws_of(assembly, interfaces):
        for row in np.flatnonzero(rows):
            chosen[row] = law
    return chosen
