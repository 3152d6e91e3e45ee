"""All that may become of an assembly: its random variables by joint, course and block, and single draws of them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.chance.variables import OF_JOINTS, Random, as_strong_as, blocks_of, checked, random_variables
from blockstat.contact.interfaces import GAP, Interfaces
from blockstat.contact.overlap.searched import searched_joints
from blockstat.contact.point_law import kept_by, least_friction
from blockstat.errors import InputError
from blockstat.imperfection.lost_edges import check_edges, without_edges
from blockstat.loads import Loads, WeightedLoads, weighted
from blockstat.sensitivity.moved_corners import MovedCorners
from blockstat.sensitivity.reserve import ReserveMap
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    from blockstat.assembly import Assembly

#: A density below this is this [kg/m3]: blocks have weight.
LIGHT = 1e-3
#: Blocks of a group whose centroids are no further apart in height than this share of the smallest are of one course.
LEVEL = 1e-3


@dataclass(frozen=True, eq=False)
class Draw:
    """One realisation."""

    assembly: Assembly
    interfaces: Interfaces
    rows: Ints  #: which joints of the drawing are left, shape (n_interfaces,)
    loads: WeightedLoads | None  #: permanent loads
    push: float  #: factor on the load in question


@dataclass(frozen=True, eq=False)
class Part:
    """One random variable with its values."""

    key: str
    variable: Random
    first: int  #: of its standard normal variables
    count: int  #: values
    #: the value of each joint, block or shared coordinate, -1 where there is none; shape (n_joints or n_blocks,)
    label: Ints
    least: float = -np.inf  #: values below it, which a normal has, are this

    @property
    def kind(self) -> str:
        """The key without its group."""
        return self.key.partition(".")[0]

    def value(self, normal: Floats) -> Floats:
        """Return the values that count: those below the least are the least.

        Parameters
        ----------
        normal
            All independent standard normal variables.

        Returns
        -------
        Floats
            Shape (count,).
        """
        return np.maximum(self.variable.value(self.standard(normal)), self.least)

    @property
    def shared(self) -> bool:
        """Whether the first of its standard normal variables is common to all values."""
        return self.count > 1 and self.variable.correlation > 0

    @property
    def normals(self) -> int:
        """How many standard normal variables it has."""
        return self.count + self.shared

    @property
    def mixing(self) -> tuple[float, float]:
        """Weights of the common variable and of a value's own."""
        share = self.variable.correlation if self.shared else 0.0
        return math.sqrt(share), math.sqrt(1.0 - share)

    def standard(self, normal: Floats) -> Floats:
        """Return the correlated standard normal variable of each value.

        Parameters
        ----------
        normal
            All independent standard normal variables.

        Returns
        -------
        Floats
            Shape (count,).
        """
        own = normal[self.first : self.first + self.normals]
        common, single = self.mixing
        return common * own[0] + single * own[1:] if self.shared else own


@dataclass(frozen=True, eq=False)
class Population:
    """The realisations of an assembly, as functions of independent standard normal variables."""

    assembly: Assembly  #: as drawn
    interfaces: Interfaces  #: its joints, without cells
    loads: Loads | None  #: permanent loads, as in `blockstat.reliability`
    uncertain: Mapping[str, Random]  #: the random variables (see `blockstat.reliability`)
    gap: float | str = GAP  #: tolerance of the joint search, as in `blockstat.assess`

    def __post_init__(self) -> None:
        checked(self.assembly, self.uncertain, self.loads)
        if "edge" in self.uncertain:
            check_edges('uncertain "edge"', self.interfaces)
        if "friction" in self.uncertain and self.interfaces.friction is not None:
            raise InputError(f'uncertain "friction": joints {kept_by([])}; leave it out where friction is random')
        if empty := [part.key for part in self.parts if not part.count]:
            raise InputError(f'uncertain "{empty[0]}": the scene has nothing that it is a property of')
        if "corner" in self.uncertain and ("edge" in self.uncertain or self.assembly.joints) and self.interfaces.parts:
            first, second = (self.assembly.names[block] for block in self.interfaces.pair[min(self.interfaces.parts)])
            raise InputError(
                f'uncertain "corner": blocks "{first}" and "{second}" touch in several patches, which do not follow '
                'the corners; leave out "corner", or "edge" and joint laws'
            )

    @cached_property
    def parts(self) -> list[Part]:
        """The random variables in their order."""
        found, first = [], 0
        least = {"friction": least_friction(self.assembly), "edge": 0.0, "density": LIGHT}
        for key, variable in self.uncertain.items():
            label = self._labels(key, variable.each)
            kind = key.partition(".")[0]
            part = Part(key, variable, first, int(label.max(initial=-1)) + 1, label, least.get(kind, -np.inf))
            found.append(part)
            first += part.normals
        return found

    @property
    def size(self) -> int:
        """Number of independent standard normal variables."""
        return sum(part.normals for part in self.parts)

    @cached_property
    def corners(self) -> MovedCorners:
        """What moves with the shared corners of the blocks."""
        return MovedCorners(self.assembly, self.interfaces)

    def realise(self, normal: Floats) -> Draw:
        """Return the assembly, joints and loads for values of the standard normal variables.

        Parameters
        ----------
        normal
            One value for each of them, shape (size,).

        Returns
        -------
        Draw
            Negative friction, losses and densities, which a normal distribution may give, count as none; beside
            cohesion, as the least friction that it may go with.
        """
        assembly, joints, push = self.assembly, self.interfaces, 1.0
        density = assembly.density.copy()
        given = None if self.loads is None else weighted(self.loads)
        acting = None if given is None else given.beside.copy()
        lost, rows = None, np.arange(joints.n_interfaces)
        for part in self.parts:
            value = part.value(normal)
            kind, held = part.kind, part.label >= 0
            if kind == "friction" and part.count == 1:
                assembly = assembly.with_(friction=float(value[0]))
            elif kind == "friction":
                joints = replace(joints, friction=value[part.label])
            elif kind == "edge":
                lost = value[part.label]
            elif kind == "corner":
                moved, joints = self.corners.moved(value.reshape(-1, 3), joints)
                assembly = assembly.with_(vertices=moved.vertices)
            elif kind == "push":
                push = float(value[0])
            elif kind == "density":
                density[held] = value[part.label[held]]
            elif acting is not None:
                acting[held] *= value[part.label[held], None]
        if lost is not None:
            joints, rows = without_edges(joints, lost, assembly)
        changed = assembly.with_(density=density) if (density != assembly.density).any() else assembly
        loads = None if given is None or acting is None else replace(given, beside=acting)
        return Draw(changed, joints, rows, loads, push)

    def drawn(self, normal: Floats) -> dict[str, float | list[float]]:
        """Return what values of the standard normal variables make of each random variable.

        Parameters
        ----------
        normal
            One value for each of them, shape (size,).

        Returns
        -------
        dict of str to float or list of float
            By key; the least, the mean and the greatest of a variable with several values.
        """
        values = {part.key: part.value(normal) for part in self.parts}
        return {
            key: float(own[0]) if len(own) == 1 else [float(own.min()), float(own.mean()), float(own.max())]
            for key, own in values.items()
        }

    def gradient(
        self, normal: Floats, draw: Draw, found: ReserveMap | None, twist: Floats, push: float = -1.0
    ) -> Floats:
        """Return the derivative of limit load less push by the standard normal variables.

        Parameters
        ----------
        normal
            Where, shape (size,).
        draw
            The realisation there.
        found
            Derivatives of its limit load; joints that are gone have none. None where there is no limit.
        twist
            Mechanism on which the load does work 1, shape (n_blocks, 6).
        push
            Derivative by the push; 1 where the limit is that of the opposite load.

        Returns
        -------
        Floats
            Shape (size,).
        """
        gradient = np.zeros(self.size)
        for number, part in enumerate(self.parts):
            kind, variable = part.kind, part.variable
            if kind == "push":
                by = np.array([push])
            elif found is None:
                continue
            elif kind in OF_JOINTS:
                by = np.zeros(self.interfaces.n_interfaces)
                by[draw.rows] = found.friction if kind == "friction" else found.edge
            elif kind == "corner":
                assert found.corner is not None
                by = self.corners.gathered(found.corner)
            elif kind == "density":
                later = [other.label >= 0 for other in self.parts[number + 1 :] if other.kind == kind]
                by = np.where(np.any(later, axis=0), 0.0, found.density)  # the last key that names a block counts
            else:
                assert self.loads is not None
                by = -(twist * weighted(self.loads).beside).sum(axis=1)
                for other in self.parts:
                    if other.kind == kind and other is not part:
                        both = other.label >= 0
                        by[both] *= other.value(normal)[other.label[both]]
            held = part.label >= 0
            own = np.bincount(part.label[held], by[held], part.count)
            standard = part.standard(normal)
            own *= variable.slope(standard)
            own[variable.value(standard) < part.least] = 0.0
            common, single = part.mixing
            gradient[part.first : part.first + part.normals] = (
                np.concatenate([[common * own.sum()], single * own]) if part.shared else own
            )
        return gradient

    def _labels(self, key: str, each: str) -> Ints:
        """Which value each joint, block or coordinate has."""
        kind, _, group = key.partition(".")
        if kind == "push":
            return np.zeros(1, np.int64)
        if kind == "corner":
            return np.arange(3 * self.corners.count)
        assembly, n = self.assembly, self.interfaces.n_interfaces
        if kind in OF_JOINTS:
            if each in ("all", "joint"):
                return np.arange(n) if each == "joint" else np.zeros(n, np.int64)
            height = assembly.centroid @ -assembly.gravity
            upper = height[self.interfaces.pair].argmax(axis=1)
            return _dense(self._blocks(each)[self.interfaces.pair[np.arange(n), upper]])
        return _dense(np.where(blocks_of(assembly, group) & ~assembly.support, self._blocks(each), -1))

    def _blocks(self, each: str) -> Ints:
        """The group, the course or the number of each block."""
        assembly = self.assembly
        if each in ("all", "block"):
            return np.arange(assembly.n_blocks) if each == "block" else np.zeros(assembly.n_blocks, np.int64)
        group = np.unique(np.array(assembly.groups), return_inverse=True)[1].reshape(-1)
        if each == "group":
            return group
        height = assembly.centroid @ -assembly.gravity / np.linalg.norm(assembly.gravity)
        order = np.lexsort([height, group])
        rises = np.diff(height[order]) > LEVEL * float(assembly.size.min())
        course = np.empty_like(group)
        course[order] = np.concatenate([[0], np.cumsum(rises | (np.diff(group[order]) > 0))])
        return course


def population_of(
    assembly: Assembly,
    uncertain: Mapping[str, Random] | None,
    load: Any,
    loads: Loads | None,
    *,
    gap: float | str = GAP,
    interfaces: Interfaces | None = None,
) -> tuple[Population, Any]:
    """Return what is drawn, and the load in question.

    Parameters
    ----------
    assembly, uncertain, load, loads, gap, interfaces
        As in `blockstat.reliability`.

    Returns
    -------
    population : Population
        Checked.
    load : object
        Given, or as the scene says it; None for none.

    Raises
    ------
    InputError
        For a variable that there is not, for a random "push" without a load, and for blocks that overlap as drawn.
    """
    own, direction = random_variables(assembly)
    uncertain = dict(own if uncertain is None else uncertain)
    if load is None and direction is not None:
        uncertain.setdefault("push", own["push"])
        load, uncertain = direction, as_strong_as(uncertain, float(np.linalg.norm(direction)))
    if "push" in uncertain and load is None:
        raise InputError('uncertain "push" is a factor on load=, which is not given')
    joints = searched_joints(assembly, gap)[0] if interfaces is None else interfaces
    return Population(assembly, joints, loads, uncertain, gap), load


def _dense(label: Ints) -> Ints:
    """The same classes numbered from 0; -1 stays."""
    found = np.full(len(label), -1)
    held = label >= 0
    found[held] = np.unique(label[held], return_inverse=True)[1].reshape(-1)
    return found
