"""Meshes: OBJ and GLB with one named object a block, STL and PLY with one solid a block (trimesh reads GLB and STL).

Triangles in one plane are joined to polygons again, so that a brick read from triangles has six faces. GLB is
y-up by its specification; it is turned on the way in and out. Supports, groups, densities and values travel in the
extras of GLB's nodes (Blender's custom properties) and in comments of OBJ, and are lost in STL and PLY.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from io import BytesIO
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import HUGE, InputError, gathered, some
from blockstat.geometry.components import connected_components
from blockstat.geometry.triangulation import triangulate
from blockstat.io.names import distinct_names
from blockstat.io.obj import read_obj, split_solids, write_obj
from blockstat.io.parts import Parts, chosen_supports, friction_said, is_marked, moved_far_away, rounding_of, spacings
from blockstat.io.raw import glb, ply, precision, stl
from blockstat.io.raw.runs import check_corners, closed_parts, closed_runs, with_cavities
from blockstat.system.reading import check_file
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    import trimesh

    from blockstat.assembly import Assembly

#: x, y, z of a z-up scene to x, z, -y of a y-up one.
Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
#: Corners closer than this fraction of a solid's size are one (GLB and STL hold seven digits).
MERGE = 1e-6
#: What trimesh says of a file, in other words; what may quote the file is not passed on.
SAID = {
    "incorrect header on GLB file": ': it does not begin with "glTF"',
    "no initial JSON header!": ": its first part is not JSON",
    "chunk was not expected length!": ": it is cut short",
    "incorrect number of vertices": ": a facet has not three vertices",
}


def mesh_parts(path: Path, *, supports: Iterable[int | str] | None = None) -> Parts:
    """Read one block from each object or solid of a mesh file.

    Parameters
    ----------
    path : Path
        An .obj, .glb, .stl or .ply file.
    supports : iterable of int or str, optional
        Names or numbers of the blocks that cannot move, in place of those that the file marks.

    Returns
    -------
    Parts
        In the unit of the file, z up.

    Raises
    ------
    InputError
        For a file that cannot be read, is cut short or holds no solid, for one that holds what would be left out (such
        as compressed meshes, lines and copies in GLB), for a mark of a support that is no truth value, or without
        supports.

    Warns
    -----
    InputWarning
        Where blocks share a name.
    """
    solids, shared = _solids(path)
    if not solids:
        raise InputError("the file holds no solid")
    marks = gathered(
        partial(is_marked, solid.name or f"block{i}", "support", solid.extras.get("support"))
        for i, solid in enumerate(solids)
    )
    marked = [i for i, mark in enumerate(marks) if mark]
    chosen = chosen_supports(marked, supports, [solid.name for solid in solids], "a mesh")
    names = distinct_names([solid.name for solid in solids], chosen)
    blocks = [
        Block(s.vertices, s.faces, name, str(s.extras.get("group", "")), s.extras.get("density"))
        for name, s in zip(names, solids, strict=True)
    ]
    options = {key: shared[key] for key in ("friction", "gravity") if key in shared}
    up = "y" if path.suffix.lower() == ".glb" else "z"
    far = spacings(path, [solid.vertices for solid in solids])
    apart = [max(own, solid.spacing) for own, solid in zip(far, solids, strict=True)]
    return Parts(blocks, chosen, {"name": path.stem, **options}, up, apart)


@dataclass(frozen=True)
class _Solid:
    name: str
    vertices: Any
    faces: list[list[int]]
    extras: dict[str, Any]
    spacing: float = 0.0  #: of numbers in single precision before the object was moved to its place


def _solids(path: Path) -> tuple[list[_Solid], dict[str, Any]]:
    """Solids in world coordinates, in the order of the file, and what the file says of all of them."""
    import trimesh

    suffix = path.suffix.lower()
    if suffix == ".obj":
        solids, shared = read_obj(path)
        if len(solids) == 1 and "support" not in solids[0].extras:  # not ours: perhaps all blocks put together
            solids = split_solids(solids[0])
        return [_Solid(*solid) for solid in solids], shared
    scene = loaded(path, trimesh.load_scene)
    if suffix == ".glb":
        glb.join_primitives(scene, _n_surfaces)
    number = {geometry: number for number, geometry in enumerate(scene.geometry)}
    order = {
        node: (glb.number_of(node) if suffix == ".glb" else 0, number[scene.graph[node][1]])
        for node in scene.graph.nodes_geometry
    }
    named = _names(scene, path)
    ordered = sorted(order, key=order.__getitem__)
    solids = gathered(partial(_of_node, scene, node, path.suffix, *named[node]) for node in ordered)
    return [solid for own in solids for solid in own], scene.metadata


def _n_surfaces(mesh: trimesh.Trimesh) -> int:
    """How many closed surfaces a mesh is; none where an edge is not between two triangles."""
    if not (np.abs(mesh.vertices) < HUGE).all():
        return 0  # refused later
    mesh = mesh.copy()
    mesh.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=_digits(mesh))
    return connected_components(len(mesh.faces), mesh.face_adjacency)[0] if mesh.is_watertight else 0


def _names(scene: trimesh.Scene, path: Path) -> dict[str, tuple[str, str]]:
    """For each object of a scene the name that the file gives it, and one for an object without a name."""
    geometry = {node: str(scene.graph[node][1]) for node in scene.graph.nodes_geometry}
    said = {node: scene.geometry[own].metadata for node, own in geometry.items()}
    if path.suffix.lower() == ".glb":
        of_nodes = glb.names(path)
        found = {node: of_nodes[glb.number_of(node)] for node in geometry}
        # Each primitive of a mesh of several is an object, and the name of the node is of all of them.
        return {
            node: ("", geometry[node]) if said[node].get("from_gltf_primitive") else (own, mesh or geometry[node])
            for node, (own, mesh) in found.items()
        }
    solids = stl.names(path) if path.suffix.lower() == ".stl" else []
    if len(solids) < 2:
        return {node: ("".join(solids) or path.stem, "") for node in geometry}
    numbers = {node: int(own["name"]) for node, own in said.items()}
    return {node: (solids[k] or f"{path.stem}.{k}", "") for node, k in numbers.items()}


def _of_node(scene: trimesh.Scene, node: str, suffix: str, given: str, otherwise: str) -> list[_Solid]:
    """Solids of one object of a scene, in world coordinates; its names are those of `_names`."""
    import trimesh

    transform, geometry = scene.graph[node]
    mesh = scene.geometry[geometry]
    if not isinstance(mesh, trimesh.Trimesh):
        raise InputError(f'object "{given or otherwise}" is no surface of faces')
    of_glb = suffix.lower() == ".glb"
    mesh = mesh.copy()
    mesh.apply_transform(np.linalg.inv(Y_UP) @ transform if of_glb else transform)
    own, more = _own_extras(scene, node), mesh.metadata.get("extras")
    extras = {**mesh.metadata, **(more if isinstance(more, dict) else {}), **own}
    name = str(own.get("name") or given or extras.get("name") or otherwise)
    _check_vertices(mesh, f'object "{name}"')
    parts = [mesh] if of_glb else _closed_runs(mesh)
    # The corners of a GLB are rounded before they are moved to where the object stands.
    raw, scale = np.asarray(scene.geometry[geometry].vertices), float(np.linalg.norm(transform[:3, :3], 2))
    rounding = [scale * rounding_of(raw)] if of_glb else [rounding_of(np.asarray(part.vertices)) for part in parts]
    for part in parts:
        part.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=_digits(part))
    labels = [f"{name}.{number}" for number in range(len(parts))] if len(parts) > 1 else [name]
    surfaces = map(_polygons, parts, rounding)
    far = precision.spacing(raw, scale) if of_glb else 0.0
    return [_Solid(label, *surface, extras, far) for label, surface in zip(labels, surfaces, strict=True)]


def loaded(path: Path, load: Callable[..., Any]) -> Any:
    """Read a mesh file with trimesh; other files that it names, such as buffers of a GLB, are beside it or refused.

    Parameters
    ----------
    path : Path
        A .glb, .stl or .ply file.
    load : callable
        `trimesh.load_scene` or `trimesh.load_mesh`.

    Returns
    -------
    trimesh.Scene or trimesh.Trimesh
        As `load` returns it.

    Raises
    ------
    InputError
        For a file that cannot be read, is cut short, or holds what would be left out. No message of trimesh is passed
        on, for it may quote any part of the file.
    """
    import trimesh
    from trimesh.resolvers import FilePathResolver

    class Beside(FilePathResolver):
        def get(self, name: str) -> bytes:
            if Path(name).name != name or set(name) & set("/\\:\0") or (path.parent / name).is_symlink():
                raise InputError("it names a file that is not beside it; files that a mesh names must be beside it")
            check_file(path.parent / name)
            return (path.parent / name).read_bytes()

    check_file(path)
    if not path.stat().st_size:
        raise InputError("the file is empty")
    suffix = path.suffix.lower()
    if suffix == ".ply":
        return _of_ply(path, load)
    numbered = {".glb": glb.numbered, ".stl": stl.numbered}[suffix]
    try:
        found = load(
            BytesIO(numbered(path.read_bytes())), file_type=suffix[1:], process=False, resolver=Beside(str(path))
        )
        meshes = dict(found.geometry) if isinstance(found, trimesh.Scene) else {"": found}
    except (InputError, MemoryError):
        raise
    except Exception as error:  # trimesh raises whatever its parsers do
        raise InputError("cannot be read as a mesh" + SAID.get(str(error), "")) from None
    surfaces = {name: mesh for name, mesh in meshes.items() if isinstance(mesh, trimesh.Trimesh) and len(mesh.faces)}
    check_corners({name.removesuffix(path.suffix): (own.vertices, own.faces) for name, own in surfaces.items()})
    return found


def _of_ply(path: Path, load: Callable[..., Any]) -> Any:
    """What `load` would return of a PLY, with its polygons cut in the order of the file."""
    import trimesh

    try:
        vertices, faces = ply.surface(path.read_bytes())
    except InputError as error:
        raise InputError(f"cannot be read as a mesh: {error}") from None
    whole = load is trimesh.load_mesh
    if len(faces):
        check_corners({"" if whole else path.stem: (vertices, faces)})
    triangles = ply.in_triangles(vertices, faces)
    mesh = trimesh.Trimesh(vertices, triangles, process=False) if len(faces) else trimesh.PointCloud(vertices)
    return mesh if whole else trimesh.Scene({path.name: mesh} if len(vertices) else {})


def _check_vertices(mesh: trimesh.Trimesh, label: str) -> None:
    """Raise InputError with the vertices whose coordinates cannot be used."""
    wrong = np.flatnonzero(~(np.abs(mesh.vertices) < HUGE).all(axis=1)).tolist()
    if wrong:
        text = f"coordinates must be finite and below {HUGE:g} (vertex {some(wrong)})"
        raise InputError(f"{label}: {text}" if label else text)


def _closed_runs(mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """Cut a soup of triangles into solids: those that share no corner, and of others one after the other.

    Corners cannot tell all solids apart, because bricks that touch share them: a solid ends where its surface has just
    closed.
    """
    import trimesh

    _, place = np.unique(np.round(mesh.vertices, _digits(mesh)), axis=0, return_inverse=True)
    numbers = [np.arange(len(mesh.vertices)), place.reshape(-1)]
    runs: list[Any] = next(filter(None, (closed_parts(n[mesh.faces].tolist(), len(n)) for n in numbers)), [])
    runs = runs or closed_runs(numbers[1][mesh.faces].tolist())
    solids = []
    for run in with_cavities(np.asarray(mesh.vertices), mesh.faces.tolist(), runs):
        used, faces = np.unique(mesh.faces[run], return_inverse=True)
        solids.append(trimesh.Trimesh(mesh.vertices[used], faces.reshape(-1, 3), process=False))
    return solids


def _digits(mesh: trimesh.Trimesh) -> int:
    return int(np.ceil(-np.log10(MERGE * max(float(mesh.extents.max()), 1e-12))))


def _own_extras(scene: trimesh.Scene, node: str) -> dict[str, Any]:
    """What a file says on the node of an object."""
    above = scene.graph.transforms.parents.get(node)
    return scene.graph.transforms.edge_data[(above, node)].get("metadata") or {}


def read_whole(path: Path) -> tuple[np.ndarray, list[list[int]]]:
    """Read a file that holds one block.

    Parameters
    ----------
    path : Path
        A .ply or .stl file.

    Returns
    -------
    vertices : ndarray, shape (n, 3)
        In the unit of the file.
    faces : list of list of int
        Corners of each face; coplanar triangles are joined.

    Raises
    ------
    InputError
        For a file that cannot be read, or holds no surface.
    """
    import trimesh

    mesh = loaded(path, trimesh.load_mesh)
    if not isinstance(mesh, trimesh.Trimesh) or not len(mesh.faces):
        raise InputError("is no surface of faces")
    _check_vertices(mesh, "")
    mesh.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=_digits(mesh))
    return _polygons(mesh, rounding_of(np.asarray(mesh.vertices)))


def _polygons(mesh: trimesh.Trimesh, rounding: float) -> tuple[np.ndarray, list[list[int]]]:
    """Vertices and faces with triangles that are coplanar but for rounding joined where their outline is one loop."""
    faces: list[list[int]] = []
    joined = np.zeros(len(mesh.faces), dtype=bool)
    for facet in _flat(mesh, rounding):
        triangles = mesh.faces[facet]
        edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
        edges, times = np.unique(edges, axis=0, return_counts=True)
        loop = _loop(triangles, set(map(tuple, edges[times == 1].tolist())))
        if loop:
            faces.append(loop)
            joined[facet] = True
    faces += mesh.faces[~joined].tolist()
    return np.asarray(mesh.vertices), faces


def _flat(mesh: trimesh.Trimesh, rounding: float) -> list[Ints]:
    """Numbers of the triangles that lie in one plane but for rounding [m], for each such plane.

    The facets of trimesh go from neighbour to neighbour by the angle between the two, and so they follow a fine curve.
    Where one does, it is cut into pieces, each in the plane of its largest triangle.
    """
    rounding = max(MERGE * float(mesh.extents.max()), rounding)
    corners = np.asarray(mesh.vertices)[mesh.faces]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    beside: dict[int, list[int]] = defaultdict(list)
    for one, other in mesh.face_adjacency.tolist():
        beside[one].append(other)
        beside[other].append(one)

    def near(triangles: Ints, axis: Floats, point: Floats) -> Ints:
        far = np.abs((corners[triangles] - point) @ axis).max(axis=1)
        return triangles[far <= rounding * np.linalg.norm(axis)]

    found = []
    for facet in map(np.asarray, mesh.facets):
        if len(near(facet, normal[facet].sum(axis=0), corners[facet].mean(axis=(0, 1)))) == len(facet):
            found.append(facet)
            continue
        left = set(facet.tolist())
        for seed in facet[np.argsort(-np.linalg.norm(normal[facet], axis=1), kind="stable")].tolist():
            piece: list[int] = []
            edge = [seed] if seed in left else []
            while edge:
                piece += edge
                left.difference_update(edge)
                around = sorted({other for one in edge for other in beside[one]} & left)
                edge = near(np.array(around, dtype=np.int64), normal[seed], corners[seed, 0]).tolist()
            found += [np.array(piece)] if len(piece) > 1 else []
    return found


def _loop(triangles: np.ndarray, boundary: set[tuple[int, ...]]) -> list[int]:
    """The outline of some triangles as one loop in their orientation; empty if it is not one simple loop."""
    following: dict[int, int] = {}
    for triangle in triangles.tolist():
        for a, b in zip(triangle, triangle[1:] + triangle[:1], strict=True):
            if (min(a, b), max(a, b)) in boundary:
                if a in following:
                    return []
                following[a] = b
    start = next(iter(following), None)
    if start is None:
        return []
    loop, corner = [start], following[start]
    while corner != start:
        if corner not in following or len(loop) > len(following):
            return []
        loop.append(corner)
        corner = following[corner]
    return loop if len(loop) == len(following) else []


def write_mesh(
    assembly: Assembly, path: Path, values: Mapping[str, Any], *, frame: tuple[str, str] = ("m", "z")
) -> None:
    """Write one object a block; STL and PLY hold all blocks as one soup of solids.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    path : Path
        An .obj, .glb, .stl or .ply file.
    values : mapping of str to sequence
        For each key one number or list a block, for GLB and OBJ.
    frame : tuple of str, optional
        Unit of the coordinates and axis that is up, which an OBJ names.

    Raises
    ------
    InputError
        For values in STL or PLY, values that are not one a block, or a key that is taken.

    Notes
    -----
    These formats but OBJ hold seven digits. Far from the origin, the objects of a GLB are moved to where they stand.
    """
    import trimesh

    suffix = path.suffix.lower()
    if values and suffix not in (".glb", ".obj"):
        raise InputError("values are written to .glb and .obj only")
    extras = [_described(assembly, i, values) for i in range(assembly.n_blocks)]
    shared = {"friction": friction_said(assembly.friction), "gravity": assembly.gravity.tolist()}
    if suffix == ".obj":
        write_obj(assembly, path, extras, shared, frame=frame)
        return
    meshes = [block_mesh(assembly, i) for i in range(assembly.n_blocks)]
    if suffix in (".stl", ".ply"):
        trimesh.util.concatenate(meshes).export(path)
        return
    place = np.eye(4)
    if moved_far_away(assembly.vertices):
        place[:3, 3] = assembly.vertices.mean(axis=0)
        for mesh in meshes:
            mesh.vertices = mesh.vertices - place[:3, 3]
    scene = trimesh.Scene()
    scene.metadata.update(shared)
    for name, mesh, own in zip(assembly.names, meshes, extras, strict=True):
        # A node may not be named like the root of the scene.
        node = f"{name}_" if name == scene.graph.base_frame else name
        scene.add_geometry(mesh, node_name=node, geom_name=name, transform=Y_UP @ place, metadata=own)
    scene.export(path)


def block_mesh(assembly: Assembly, block: int) -> trimesh.Trimesh:
    """Return the surface of one block in triangles.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    block : int
        Number of the block.

    Returns
    -------
    trimesh.Trimesh
        In metres.
    """
    import trimesh

    vertices = assembly.block_vertices(block)
    return trimesh.Trimesh(vertices, triangulate(vertices, assembly.faces_of(block)), process=False)


def _described(assembly: Assembly, block: int, values: Mapping[str, Any]) -> dict[str, Any]:
    """What is said of a block beside its surface. Raises InputError for values that are not one a block."""
    extras: dict[str, Any] = {
        "name": assembly.names[block],
        "group": assembly.groups[block],
        "density": float(assembly.density[block]),
        "support": bool(assembly.support[block]),
    }
    for key, given in values.items():
        try:
            array = np.asarray(given, dtype=float)
        except (TypeError, ValueError):
            array = np.empty(0)
        if key in extras or array.shape[:1] != (assembly.n_blocks,) or not np.isfinite(array).all():
            raise InputError(f'values: "{key}" must be a name that is free with one finite number or list a block')
        extras[key] = array[block].tolist()
    return extras
