"""Problems of compas_dem in files: the model, its friction, its gravity, blocks that are held, and loads.

Up to version 0.5 a problem holds its model and one set of boundary conditions; from 0.6 on it holds several sets, and
an analysis holds the model beside its problems. Each set of boundary conditions that has loads becomes a load case. The
weight acts in every case, as in compas_dem. Cohesion and tension of the contact model are not applied: without them a
building carries less. Elastic stiffnesses play no part between rigid blocks.

Sources: `Problem`, `BoundaryConditions` and `MohrCoulomb` of compas_dem 0.5.0; `Analysis`, `Problem`,
`BoundaryConditionGroup`, `Load`, `Displacement` and `resolve_centroidal_loads` of compas_dem 0.6.0.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import partial
from itertools import count
from typing import Any

import msgspec
import numpy as np

from blockstat.errors import InputError, InputWarning, gathered, no_such, some
from blockstat.io.compas.objects import ANALYSIS, PROBLEM, CompasObject, CompasSolid, as_struct
from blockstat.typing import Floats


class _Contacts(msgspec.Struct):
    contact_model: CompasObject | None = None


class _ContactModel(msgspec.Struct):
    phi: float | None = None  #: [degrees]
    mu: float | None = None
    c: float | None = None
    t_c: float | None = None


class _Conditions(msgspec.Struct):
    """One set of boundary conditions; an entry is a table, or an object that holds one."""

    g: float = 9.81  #: [m/s2], downwards
    name: str | None = None
    body_forces: list[Any] = []
    point_loads: list[dict[str, Any]] = []
    surface_loads: list[dict[str, Any]] = []
    displacements: list[dict[str, Any]] = []

    @property
    def loaded(self) -> bool:
        return bool(self.body_forces or self.point_loads or self.surface_loads)


class _BodyForce(msgspec.Struct):
    acceleration: tuple[float, float, float]  #: [m/s2]


class _PointLoad(msgspec.Struct):
    block_index: int
    force: tuple[float, float, float] | None = None
    moment: tuple[float, float, float] | None = None
    point: tuple[float, float, float] | None = None


class _Polygon(msgspec.Struct):
    points: list[Any]


class _SurfaceLoad(msgspec.Struct):
    block_index: int
    face_index: int | None = None
    load: tuple[float, float, float] | None = None  #: force per area [N/m2]
    polygon: CompasObject | None = None
    magnitude: float = 0.0
    direction: tuple[float, float, float] | None = None


class _Displacement(msgspec.Struct):
    block_index: int
    translation: tuple[float | None, float | None, float | None] | None = None
    rotation: tuple[float | None, float | None, float | None] | None = None


@dataclass(frozen=True)
class FileProblem:
    """A problem as a file holds it."""

    model: CompasObject
    said: dict[str, Any]  #: friction and gravity
    conditions: dict[str, _Conditions]  #: sets of boundary conditions by name

    def supports(self, solids: Sequence[CompasSolid]) -> list[int]:
        """Return the numbers of blocks whose six displacements are prescribed.

        Parameters
        ----------
        solids : sequence of CompasSolid
            Of the model.

        Returns
        -------
        list of int

        Raises
        ------
        InputError
            For a node without a block, or a block that is no support and is held in part.

        Warns
        -----
        InputWarning
            Where a prescribed displacement is not zero: it is not applied.
        """
        held: dict[int, list[float | None]] = {}
        for name, own in self.conditions.items():
            for i, entry in enumerate(own.displacements):
                label = f"{name}: displacements[{i}]"
                given = as_struct(_bare(entry), _Displacement, label)
                parts = held.setdefault(_number(solids, given.block_index, label), [None] * 6)
                for start, values in ((0, given.translation), (3, given.rotation)):
                    for axis, value in enumerate(values or ()):
                        parts[start + axis] = parts[start + axis] if value is None else value
        free = [n for n, parts in held.items() if None in parts and not solids[n].support]
        if free:
            raise InputError(f"prescribed in some directions only, which no rigid support is: {_listed(solids, free)}")
        if moved := [n for n, parts in held.items() if any(parts)]:
            text = "displacements are prescribed and not applied (`blockstat settle` applies them, with --move): "
            warnings.warn(InputWarning(text + _listed(solids, moved)), stacklevel=5)
        return list(held)

    def load_tables(self, solids: Sequence[CompasSolid], names: Sequence[str], supports: Sequence[int]) -> dict:
        """Return the loads as tables of load cases, one case for each set of boundary conditions that has loads.

        Parameters
        ----------
        solids : sequence of CompasSolid
            Of the model, where they stand.
        names : sequence of str
            Their names.
        supports : sequence of int
            Numbers of those that cannot move; loads on them play no part.

        Returns
        -------
        dict
            Metadata of an assembly: the keys "loads" and "cases" of a scene file, or nothing.

        Raises
        ------
        InputError
            Naming each load that cannot be read.
        """
        loads: dict[str, dict[str, Any]] = {}
        cases: dict[str, dict[str, Any]] = {}
        for name, own in self.conditions.items():
            if not own.loaded:
                continue
            factors = {}
            for label, table, factor in gathered(_readings(name, own, solids, names, supports)):
                if table:
                    loads[label], factors[label] = table, factor
            cases[name] = {"factors": factors}
        return {"loads": loads, "cases": cases} if cases else {}


def problem_of(found: CompasObject) -> FileProblem | None:
    """Read a problem or an analysis, as far as it needs no blocks.

    Parameters
    ----------
    found : CompasObject
        What a file holds.

    Returns
    -------
    FileProblem or None
        None for an object of another class.

    Raises
    ------
    InputError
        Without a model, or for problems of one analysis that differ in friction or gravity.

    Warns
    -----
    InputWarning
        Where the contact model has cohesion or tension, which are not applied.
    """
    if found.is_a(ANALYSIS):
        listed = found.data.get("problems") or []
        problems = [as_struct(own, CompasObject, f"problems[{i}]") for i, own in enumerate(listed)]
    elif found.is_a(PROBLEM):
        problems = [found]
    else:
        return None
    if not found.data.get("model"):
        raise InputError("the problem does not hold its model; write the Analysis that has both, or the model")
    model = as_struct(found.data["model"], CompasObject, f"{found.dtype}: model")
    frictions = {_friction(problem) for problem in problems} or {None}
    conditions = _named(problems)
    gravities = {own.g for own in conditions.values()} or {_Conditions().g}
    for what, values in (("friction", frictions), ("gravity", gravities)):
        if len(values) > 1:
            given = ", ".join(str(value) for value in values)
            raise InputError(f"its problems differ in {what} ({given}); write an analysis with one of them")
    said: dict[str, Any] = {"gravity": [0.0, 0.0, -gravities.pop()]}
    friction = frictions.pop()
    return FileProblem(model, said if friction is None else {**said, "friction": friction}, conditions)


def _friction(problem: CompasObject) -> float | None:
    given = problem.data.get("contact_properties")
    if not given:
        return None
    contacts = as_struct(_bare(given), _Contacts, "contact_properties")
    if contacts.contact_model is None:
        return None
    law = as_struct(contacts.contact_model.data, _ContactModel, "contact_model")
    if law.c or law.t_c:
        text = f"cohesion and tension of the contact model are not applied (c = {law.c}, t_c = {law.t_c})"
        warnings.warn(InputWarning(text), stacklevel=6)
    if law.mu is None and law.phi is not None:
        return float(np.tan(np.radians(law.phi)))
    return law.mu


def _named(problems: Sequence[CompasObject]) -> dict[str, _Conditions]:
    """All sets of boundary conditions by distinct names, after their problem where there are several problems."""
    found: dict[str, _Conditions] = {}
    for problem in problems:
        given = problem.data.get("boundary_conditions") or []
        for entry in given if isinstance(given, list) else [given]:
            own = as_struct(_bare(entry), _Conditions, "boundary_conditions")
            title = own.name or (entry.get("name") if isinstance(entry, dict) else None) or "loads"
            if len(problems) > 1 and (of := problem.data.get("name") or problem.name):
                title = f"{of}.{title}"
            trials = (title if i == 1 else f"{title} {i}" for i in count(1))
            found[next(trial for trial in trials if trial not in found)] = own
    return found


def _readings(
    name: str, own: _Conditions, solids: Sequence[CompasSolid], names: Sequence[str], supports: Sequence[int]
) -> Iterator[Any]:
    """What reads each load as (its name, its table or none on a support, its factor)."""
    held = set(supports)

    def on_block(label: str, entry: Any, kind: type[_PointLoad | _SurfaceLoad], table: Any) -> Any:
        given = as_struct(_bare(entry), kind, label)
        block = _number(solids, given.block_index, label)
        return label, {} if block in held else table(label, given, solids[block], names[block]), 1.0

    for i, entry in enumerate(own.body_forces):
        yield partial(_body, f"{name} body force {i}", entry, own.g)
    for i, entry in enumerate(own.point_loads):
        yield partial(on_block, f"{name} point load {i}", entry, _PointLoad, _point)
    for i, entry in enumerate(own.surface_loads):
        yield partial(on_block, f"{name} surface load {i}", entry, _SurfaceLoad, _surface)


def _body(label: str, entry: Any, g: float) -> tuple[str, dict[str, Any], float]:
    bare = _bare(entry)
    given = as_struct(bare if isinstance(bare, dict) else {"acceleration": bare}, _BodyForce, label)
    strength = float(np.linalg.norm(given.acceleration))
    if not strength:
        return label, {}, 0.0
    return label, {"kind": "acceleration", "direction": list(given.acceleration)}, strength / g


def _point(label: str, given: _PointLoad, _: CompasSolid, block: str) -> dict[str, Any]:
    """The table of a force at a point, or at the centroid where none is given."""
    if given.moment and any(given.moment):
        raise InputError(f"{label}: a moment about a centroid is not read; give the point at which the force acts")
    force = list(given.force or (0.0, 0.0, 0.0))
    if given.point is None:
        return {"kind": "body", "force": force, "blocks": [block]}
    return {"kind": "point", "block": block, "point": list(given.point), "force": force}


def _surface(label: str, given: _SurfaceLoad, solid: CompasSolid, block: str) -> dict[str, Any]:
    """The table of an even load on a polygon, or on a face."""
    if given.polygon is not None:
        corners = _corners(given.polygon, label)
        towards = np.array(given.direction) if given.direction else _normal(corners)
        pressure = given.magnitude * towards
    else:
        if str(given.face_index) not in solid.faces or given.load is None:
            raise InputError(f'{label}: it needs a load and the face_index of a face of "{block}"')
        corners = solid.block.vertices[list(solid.block.faces[solid.faces.index(str(given.face_index))])]
        pressure = np.array(given.load)
    return {"kind": "patch", "corners": corners.tolist(), "pressure": pressure.tolist(), "blocks": [block]}


def _corners(polygon: CompasObject, label: str) -> Floats:
    listed = as_struct(polygon.data, _Polygon, f"{label}: polygon").points
    try:
        corners = np.array([_bare(point) for point in listed], dtype=float)
    except (TypeError, ValueError):
        corners = np.empty(0)
    if corners.shape[1:] != (3,) or len(corners) < 3:
        raise InputError(f"{label}: a polygon needs three corners of three coordinates, at least")
    return corners


def _normal(corners: Floats) -> Floats:
    """The unit normal of a plane polygon, about which its corners turn counterclockwise."""
    area = np.cross(corners - corners[0], np.roll(corners, -1, axis=0) - corners[0]).sum(axis=0)
    size = np.linalg.norm(area)
    return area / size if size else area


def _number(solids: Sequence[CompasSolid], node: int, label: str) -> int:
    nodes = [solid.node for solid in solids]
    if str(node) not in nodes:
        known = [own for own in nodes if own is not None]
        raise InputError(f"{label}: block_index: {no_such('block', str(node), known)}")
    return nodes.index(str(node))


def _listed(solids: Sequence[CompasSolid], numbers: Sequence[int]) -> str:
    return "block_index " + some([str(solids[n].node) for n in numbers])


def _bare(entry: Any) -> Any:
    """What an object holds, or the plain table or list that older versions write in its place."""
    return entry["data"] if isinstance(entry, dict) and "dtype" in entry and "data" in entry else entry
