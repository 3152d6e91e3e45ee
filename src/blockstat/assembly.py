"""The assembly of rigid blocks: geometry, density, supports and groups as plain arrays.

SI units throughout: metres, kilograms, seconds, newtons. Nothing here changes its argument.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from typing import Any
from unicodedata import normalize

import numpy as np

from blockstat.errors import (
    HUGE,
    InputError,
    InputWarning,
    check_density,
    check_friction,
    check_gravity,
    gathered,
    known_options,
    no_such,
)
from blockstat.geometry.polyhedron import Polyhedra, reach_down, read_only
from blockstat.geometry.validity import check_geometry
from blockstat.joint import JointLaw, Tie, check_laws, with_layers
from blockstat.result import counted, names_like
from blockstat.surface.folds import unfolded
from blockstat.system.reading import check_words
from blockstat.typing import Floats, Ints

STANDARD_GRAVITY = (0.0, 0.0, -9.81)
DENSITY = 2691.0  #: kg/m3, the default of the procedural-masonry paper
FRICTION = 0.7
LOWEST = "lowest"  #: stands for the supports that reach down to the lowest corner

# The C library returns freed memory to the system beyond twice the largest piece freed so far (32 MiB at most). Asking
# for it again takes a fifth of a search for joints. A piece to which nothing is written makes the library keep some.
np.empty(31 * 2**20, dtype=np.uint8)


@dataclass(frozen=True)
class Block:
    """One block before it joins an assembly: a closed polyhedron with outward faces.

    Parameters
    ----------
    vertices : array_like, shape (n, 3)
        Corners [m].
    faces : sequence of sequences of int
        Corner indices of each face, counter-clockwise seen from outside.
    name : str, optional
        Unique in the assembly; by default the block's number with "block" before it.
    group : str, optional
        Dotted, as "wall.north": for joint laws, loads and criteria.
    density : float, optional
        [kg/m3]; by default that of the assembly.
    """

    vertices: Any
    faces: Sequence[Sequence[int]]
    name: str = ""
    group: str = ""
    density: float | None = None


#: The fields that give blocks their shapes, and what is computed of these.
GEOMETRY = {own.name for own in fields(Polyhedra)}
OF_SHAPES = {name for name, value in vars(Polyhedra).items() if isinstance(value, cached_property)}


@dataclass(frozen=True, eq=False)
class Assembly(Polyhedra):
    """Rigid blocks, those that are supports, and the data that all joints share.

    Its arrays are read-only (`Rotation.apply` of SciPy needs a copy of them); `with_` returns an assembly with others.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"], density=2000.0)
    >>> assembly.names, assembly.mass[assembly.free].round(6).tolist()
    (('ground', 'block'), [2000.0])
    """

    name: str
    names: tuple[str, ...]  #: one a block, unique
    groups: tuple[str, ...]  #: one a block, dotted, "" for none
    density: Floats  #: shape (n_blocks,) [kg/m3]
    support: np.ndarray  #: shape (n_blocks,) bool, True for a block that cannot move
    friction: float = FRICTION  #: coefficient of Coulomb friction on every joint, may be inf
    gravity: Floats = field(default_factory=lambda: np.array(STANDARD_GRAVITY))  #: shape (3,) [m/s2]
    metadata: dict[str, Any] = field(default_factory=dict)
    joints: tuple[JointLaw, ...] = ()  #: laws of particular joints, none for dry joints of one friction
    ties: tuple[Tie, ...] = ()  #: ties and struts between blocks

    @classmethod
    def from_blocks(
        cls,
        blocks: Iterable[Block],
        *,
        supports: Iterable[int | str] = (),
        name: str = "assembly",
        density: float = DENSITY,
        friction: float = FRICTION,
        gravity: Sequence[float] = STANDARD_GRAVITY,
        metadata: dict[str, Any] | None = None,
        joints: Sequence[JointLaw] = (),
        ties: Sequence[Tie] = (),
    ) -> Assembly:
        """Stack blocks into arrays and check them.

        Parameters
        ----------
        blocks : iterable of Block
            The blocks, at least one.
        supports : iterable of int or str, optional
            Numbers or names of the blocks that cannot move. "lowest" stands for all that reach down to the lowest
            corner, along gravity and within a hundredth of their own height, unless a block has that name.
        name : str, optional
            Name of the assembly.
        density : float, optional
            Of the blocks that have none of their own [kg/m3].
        friction : float, optional
            Coefficient of Coulomb friction of all joints; may be inf.
        gravity : sequence of float, shape (3,), optional
            [m/s2].
        metadata : dict, optional
            Kept as it is.
        joints : sequence of JointLaw, optional
            Laws of particular joints.
        ties : sequence of Tie, optional
            Ties and struts between blocks.

        Returns
        -------
        Assembly
            The assembly, its blocks in the order given, without vertices that no face has.

        Raises
        ------
        InputError
            Naming the block, for bad coordinates, an open or inverted surface, no volume, a repeated name, an unknown
            support, or a bad density, friction or gravity.

        Warns
        -----
        InputWarning
            For a friction that may be an angle in degrees.

        Examples
        --------
        >>> from blockstat import Assembly, box
        >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="cube")]
        >>> assembly = Assembly.from_blocks(blocks, supports=["ground"], density=2000.0)
        >>> assembly.n_blocks, assembly.mass[1].round(6).item()
        (2, 2000.0)
        """
        blocks = list(blocks)
        if not blocks:
            raise InputError("the assembly has no blocks")
        names = _unique_names(blocks)
        check_words("block", tuple(names))
        check_words("the group of block", tuple(str(block.group) for block in blocks))
        check_words("assembly", (name,))
        given = [density if b.density is None else b.density for b in blocks]
        vertices, densities, (support, lowest), rubbing, pull = gathered(
            (
                partial(_vertex_arrays, blocks, names),
                lambda: gathered(partial(check_density, label, own) for label, own in zip(names, given, strict=True)),
                partial(_support_mask, supports, names),
                partial(check_friction, friction, doubted=True),
                partial(check_gravity, gravity),
            )
        )
        vertex_start = np.concatenate([[0], np.cumsum([len(v) for v in vertices])])
        faces = _faces_of_all(blocks, names, [len(own) for own in vertices])
        sides = [sizes for _, sizes in faces]
        corners = np.concatenate([flat + start for (flat, _), start in zip(faces, vertex_start[:-1], strict=True)])
        used, corners = np.unique(corners, return_inverse=True)
        face_start = np.concatenate([[0], np.cumsum(np.concatenate(sides))])
        points, vertex_start = np.concatenate(vertices)[used], np.searchsorted(used, vertex_start)
        assembly = cls(
            name=name,
            vertices=points,
            vertex_start=vertex_start,
            face_vertices=corners,
            face_start=face_start,
            face_block=np.repeat(np.arange(len(blocks)), [len(count) for count in sides]),
            names=tuple(names),
            groups=tuple(b.group for b in blocks),
            density=np.array(densities),
            support=support | reach_down(points, vertex_start, pull) if lowest else support,
            friction=rubbing,
            gravity=pull,
            metadata=dict(metadata or {}),
            joints=_listed("joints", joints, JointLaw),
            ties=_listed("ties", ties, Tie),
        )
        check_geometry(assembly, assembly.names)
        check_laws(assembly.joints, assembly.groups)
        _check_ties(assembly)
        return unfolded(assembly, assembly.names)

    @cached_property
    def mass(self) -> Floats:
        """Mass of each block, shape (n_blocks,) [kg]."""
        return read_only(self.density * self.volume)

    @cached_property
    def inertia(self) -> Floats:
        """Inertia tensor of each block about its centroid, shape (n_blocks, 3, 3) [kg m2]."""
        return read_only(self.density[:, None, None] * self.integrals.inertia)

    @property
    def free(self) -> Ints:
        """Indices of the blocks that can move, ascending."""
        return np.flatnonzero(~self.support)

    @property
    def free_weight(self) -> float:
        """Total weight of the free blocks [N]."""
        return float(self.mass[~self.support].sum() * np.linalg.norm(self.gravity))

    def blocks_named(self, given: Iterable[int | str] | int | str, what: str = "blocks") -> Ints:
        """Return the indices of blocks given by name or number, at least one.

        Parameters
        ----------
        given : str, int, or an iterable of them
            As in `block_indices`. The name of a layer, which is the text before a "::" in the names of blocks, stands
            for all of its blocks where no block has that name.
        what : str, optional
            What the blocks are given for; the message of an error begins with it.

        Returns
        -------
        array of int, shape (n_given,)
            Numbers of the blocks, in the order given; more than are given where one is a layer.

        Raises
        ------
        InputError
            For a name or a number that no block has, or for none at all.

        Examples
        --------
        >>> from blockstat import Assembly, box
        >>> blocks = [box((x, 0, 0), (x + 1, 1, 1), name=f"ARCH::stone {x}") for x in range(3)]
        >>> Assembly.from_blocks(blocks).blocks_named("ARCH").tolist()
        [0, 1, 2]
        """
        found = block_indices(self.names, with_layers(self.names, given), what)
        if not len(found):
            raise InputError(f"{what}: no blocks are given")
        return found

    def in_group(self, group: str) -> Ints:
        """Return the indices of the blocks of a group and of its subgroups.

        Parameters
        ----------
        group : str
            Name of the group; "wall" takes "wall.north" along.

        Returns
        -------
        array of int, shape (n,)
            Numbers of the blocks, in ascending order.

        Raises
        ------
        InputError
            Naming the groups there are when none matches.
        """
        found = [i for i, g in enumerate(self.groups) if g == group or g.startswith(group + ".")]
        if not found:
            raise no_such("group", group, sorted({g for g in self.groups if g}))
        return np.array(found, dtype=np.int64)

    def with_(self, **changes: Any) -> Assembly:
        """Return a copy with some fields replaced.

        Parameters
        ----------
        **changes
            New values of fields. One density counts for all blocks.

        Returns
        -------
        Assembly
            A new assembly; this one stays as it is.

        Raises
        ------
        InputError
            For an unknown field, or a bad friction, gravity, density, support, joint law or tie.
        """
        for name in changes:
            if name not in self.__dataclass_fields__:
                raise no_such("field", name, self.__dataclass_fields__)
        if "friction" in changes:
            changes["friction"] = check_friction(changes["friction"])
        names = changes.get("names", self.names)
        if "density" in changes:
            changes["density"] = _densities(changes["density"], names)
        if "support" in changes:
            changes["support"] = _supported(changes["support"], names)
        if "gravity" in changes:
            changes["gravity"] = check_gravity(changes["gravity"])
        if "joints" in changes:
            changes["joints"] = _listed("joints", changes["joints"], JointLaw)
            check_laws(changes["joints"], changes.get("groups", self.groups))
        if "ties" in changes:
            changes["ties"] = _listed("ties", changes["ties"], Tie)
        changed = replace(self, **changes)
        if not GEOMETRY & changes.keys():
            # The same blocks: what has been computed of their shapes is not computed again.
            vars(changed).update((name, value) for name, value in vars(self).items() if name in OF_SHAPES)
        _check_ties(changed)
        return changed


def check_supports(assembly: Assembly) -> None:
    """Raise InputError for an assembly without supports.

    Parameters
    ----------
    assembly : Assembly
        The blocks.

    Raises
    ------
    InputError
        Saying where they are named.
    """
    if not assembly.support.any():
        raise InputError(f'"{assembly.name}" has no supports; list the blocks that cannot move under "supports"')


def _listed(what: str, given: Any, kind: type) -> tuple[Any, ...]:
    """What is given as a sequence of one kind."""
    found = tuple(given) if isinstance(given, Iterable) else (None,)
    if not all(isinstance(one, kind) for one in found):
        raise InputError(f"{what} is {given!r}; it must be a sequence of {kind.__name__}")
    return found


def _check_ties(assembly: Assembly) -> None:
    """Raise InputError for a tie to a block that does not exist, or of a block to itself."""
    for tie in assembly.ties:
        one, other = block_indices(assembly.names, tie.between, tie.label)
        if one == other:
            same = f'{tie.between!r}, both of them "{assembly.names[one]}"'
            raise InputError(f"{tie.label}: between is {same}; it must be two blocks")


@known_options
def glued(assembly: Assembly, strength: float, *, moment: float | None = None) -> Assembly:
    """Return an assembly with glue in every joint: a bond of so much force, whatever the joint's area.

    Parameters
    ----------
    assembly : Assembly
        The blocks; other laws of their joints stay.
    strength : float
        Tension that each joint holds [N]; with friction mu it holds mu x strength more in shear.
    moment : float, optional
        If given, the bond sits at the centre of the joint and holds `strength` in tension, `strength` in shear and
        `moment` [N m] in bending and in torsion, each by itself (see `JointLaw`).

    Returns
    -------
    Assembly
        A new assembly with the glue.

    Examples
    --------
    A block hangs from its support by a glue that is stronger than its weight.

    >>> from blockstat import Assembly, assess, box, glued
    >>> blocks = [box((0, 0, 1), (1, 1, 2), name="beam"), box((0, 0, 0), (1, 1, 1), name="load")]
    >>> hanging = Assembly.from_blocks(blocks, supports=["beam"], density=1000.0)
    >>> [assess(glued(hanging, strength)).outcome.word for strength in (9000.0, 10000.0)]
    ['unstable', 'stable']
    """
    everywhere = JointLaw(("*", "*"), bond=strength, bond_moment=moment)
    return assembly.with_(
        joints=(everywhere, *(replace(law, bond=strength, bond_moment=moment) for law in assembly.joints))
    )


def _unique_names(blocks: Sequence[Block]) -> list[str]:
    given = {block.name for block in blocks}
    names = [block.name or _free_name(f"block{i}", given) for i, block in enumerate(blocks)]
    seen: set[str] = set()
    for label in names:
        if label in seen:
            raise InputError(f'two blocks are named "{label}"; names must be unique')
        seen.add(label)
    return names


def _free_name(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _vertex_array(block: Block, label: str) -> Floats:
    try:
        vertices = np.array(block.vertices, dtype=float)
    except (TypeError, ValueError):
        raise InputError(f'block "{label}": vertices must be a list of [x, y, z]') from None
    if vertices.ndim != 2 or vertices.shape[1] != 3 or len(vertices) < 4:
        raise InputError(
            f'block "{label}": vertices have shape {vertices.shape}; at least 4 points [x, y, z] are needed'
        )
    return vertices


def _vertex_arrays(blocks: Sequence[Block], names: Sequence[str]) -> list[Floats]:
    found = gathered(partial(_vertex_array, block, label) for block, label in zip(blocks, names, strict=True))
    _check_coordinates(found, names)
    return found


def _check_coordinates(vertices: Sequence[Floats], names: Sequence[str]) -> None:
    if (np.abs(np.concatenate(vertices)) < HUGE).all():
        return
    raise InputError(
        *(
            f'block "{label}": vertex {number} is {corners[number].tolist()}; '
            f"coordinates must be finite and below {HUGE:g}"
            for corners, label in zip(vertices, names, strict=True)
            for number in np.flatnonzero(~(np.abs(corners) < HUGE).all(axis=1))[:1]
        )
    )


def _faces_of_all(
    blocks: Sequence[Block], names: Sequence[str], corners: Sequence[int]
) -> list[tuple[Ints, list[int]]]:
    """The corners of the faces of each block in a row, and how many each face has."""
    checked: dict[tuple[int, int], tuple[Ints, list[int]]] = {}  # bricks share one list of faces

    def read(block: Block, label: str, count: int) -> tuple[Ints, list[int]]:
        kind = id(block.faces), count
        if kind not in checked:
            faces = _face_lists(block, label, count)
            checked[kind] = np.concatenate(faces), [len(face) for face in faces]
        return checked[kind]

    found = gathered(partial(read, *own) for own in zip(blocks, names, corners, strict=True))
    doubled = [label for block, label, own in zip(blocks, names, found, strict=True) if len(own[1]) < len(block.faces)]
    if doubled:
        text = f'{len(doubled)} blocks list faces twice (the first is "{doubled[0]}"); each counts once'
        warnings.warn(InputWarning(text), stacklevel=4)
    return found


def _face_lists(block: Block, label: str, n_vertices: int) -> list[list[int]]:
    """The faces of a block as lists, each once even if it is listed twice."""
    faces: list[list[int]] = []
    seen: set[tuple[int, ...]] = set()
    for number, given in enumerate(block.faces):
        face = _face(label, number, given)
        if len(face) < 3 or len(set(face)) < len(face):
            hole = "; cut a face with a hole into faces without, as into triangles" if len(set(face)) > 5 else ""
            text = f"face {number} is {face}; it needs three or more different corners{hole}"
            raise InputError(f'block "{label}": {text}')
        if min(face) < 0 or max(face) >= n_vertices:
            raise InputError(
                f'block "{label}": face {number} is {face}; corners must lie between 0 and {n_vertices - 1}'
            )
        first = face.index(min(face))
        turned = tuple(face[first:] + face[:first])
        if turned in seen:
            continue
        seen.add(turned)
        faces.append(face)
    if len(faces) < 4:
        thin = '; give a surface a thickness, or delete it and choose supports ("lowest")' if len(faces) < 3 else ""
        given = counted(len(faces), "face")
        raise InputError(f'block "{label}": {given} cannot close a volume; at least 4 are needed{thin}')
    return faces


def _face(label: str, number: int, given: Any) -> list[int]:
    """The corners of one face as whole numbers."""
    try:
        listed = list(given)
        corners = [int(corner) for corner in listed]
        whole = corners == listed
    except (TypeError, ValueError, OverflowError):
        whole = False
    if not whole:
        raise InputError(f'block "{label}": face {number} is {given!r}; it needs the numbers of its corners')
    return corners


def block_indices(names: Sequence[str], given: Iterable[int | str] | int | str, what: str) -> Ints:
    """Return the indices of blocks that are given by name or by number.

    Parameters
    ----------
    names : sequence of str
        Names of all blocks.
    given : str, int, or an iterable of them
        A name, a number, or a number written as text ("3") where no block has that name.
    what : str
        What the blocks are given for; the message of an error begins with it.

    Returns
    -------
    array of int, shape (n_given,)
        Numbers of the blocks, in the order given.

    Raises
    ------
    InputError
        For a name or a number that no block has.
    """
    index = {label: i for i, label in enumerate(names)}

    def number(block: Any) -> int:
        if isinstance(block, str):
            if block not in index and block.isdecimal() and block.isascii() and int(block) < len(names):
                block = names[int(block)]
            if block not in index:  # an umlaut is one character or two, which nobody sees
                block = next((name for name in names if normalize("NFC", name) == normalize("NFC", block)), block)
            if block not in index:
                raise InputError(f'{what}: no block "{block}"; blocks are: {names_like(names, block)}')
            return index[block]
        if isinstance(block, (int, np.integer)) and not isinstance(block, bool):
            if not 0 <= block < len(names):
                raise InputError(f"{what}: no block {block}; blocks are numbered 0 to {len(names) - 1}")
            return int(block)
        raise InputError(f"{what}: {block!r} is neither a block's index nor its name")

    asked = given if isinstance(given, Iterable) and not isinstance(given, str) else [given]
    return np.array(gathered(partial(number, block) for block in asked), dtype=np.int64)


def _support_mask(supports: Iterable[int | str] | int | str, names: Sequence[str]) -> tuple[np.ndarray, bool]:
    """Which blocks are supports by name or number, and whether the lowest are, too."""
    given = list(supports) if isinstance(supports, Iterable) and not isinstance(supports, str) else [supports]
    named = [block for block in given if block != LOWEST or LOWEST in names]
    mask = np.isin(np.arange(len(names)), block_indices(names, with_layers(names, named), "supports"))
    return mask, len(named) < len(given)


def _densities(given: Any, names: Sequence[str]) -> Floats:
    """The density of each block; raises InputError for one that is not positive."""
    try:
        values = np.array(np.broadcast_to(np.asarray(given, dtype=float), len(names)))
    except (TypeError, ValueError):
        raise InputError(f"density must be one number, or one for each of the {len(names)} blocks") from None
    wrong = np.flatnonzero(~((values > 0) & (values < HUGE)))
    gathered(partial(check_density, names[k], values[k].item()) for k in wrong.tolist())
    return values


def _supported(given: Any, names: Sequence[str]) -> np.ndarray:
    values = np.asarray(given)
    if values.shape != (len(names),) or not np.isin(values, (0, 1)).all():
        raise InputError(f"support must be true or false for each of the {len(names)} blocks")
    return values.astype(bool)
