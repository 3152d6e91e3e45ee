"""Meshes: OBJ and GLB with one named object a block, STL and PLY with one solid a block (trimesh reads all but OBJ).

Triangles in one plane are joined to polygons again, so that a brick read from triangles has six faces. GLB is
y-up by its specification; it is turned on the way in and out. Supports, groups, densities and values travel in the
extras of GLB's nodes (Blender's custom properties) and in comments of OBJ, and are lost in STL and PLY.
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.assembly import Block
from blockstat.errors import HUGE, InputError, gathered, some
from blockstat.geometry.triangulation import triangulate
from blockstat.io.names import distinct_names
from blockstat.io.obj import closed_runs, read_obj, split_solids, write_obj
from blockstat.io.parts import Parts, chosen_supports, moved_far_away, rounding_of
from blockstat.system.reading import MOST_BYTES, check_file
from blockstat.typing import Floats, Ints

if TYPE_CHECKING:
    import trimesh

    from blockstat.assembly import Assembly

#: x, y, z of a z-up scene to x, z, -y of a y-up one.
Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
#: Corners closer than this fraction of a solid's size are one (GLB and STL hold seven digits).
MERGE = 1e-6
CORNERS = ("vertex_indices", "vertex_index")  #: what exporters of PLY call the corners of a face
#: What trimesh says of a file, in other words; what may quote the file is not passed on.
SAID = {
    "Not a ply file!": ': its first line is not "ply"',
    "Property defined before any element!": ": its header has a property before the first element",
    "PLY is unexpected length!": ": it is cut short, or its faces differ in their number of corners; "
    "export it in triangles or as text (ASCII)",
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
        For a file that cannot be read or holds no solid, or without supports.

    Warns
    -----
    InputWarning
        Where blocks share a name.
    """
    solids, shared = _solids(path)
    if not solids:
        raise InputError("the file holds no solid")
    marked = [i for i, solid in enumerate(solids) if solid.extras.get("support", False)]
    chosen = chosen_supports(marked, supports, [solid.name for solid in solids], "a mesh")
    names = distinct_names([solid.name for solid in solids], chosen)
    blocks = [
        Block(s.vertices, s.faces, name, str(s.extras.get("group", "")), s.extras.get("density"))
        for name, s in zip(names, solids, strict=True)
    ]
    options = {key: shared[key] for key in ("friction", "gravity") if key in shared}
    up = "y" if path.suffix.lower() == ".glb" else "z"
    return Parts(blocks, chosen, {"name": path.stem, **options}, up)


@dataclass(frozen=True)
class _Solid:
    name: str
    vertices: Any
    faces: list[list[int]]
    extras: dict[str, Any]


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
    order = {geometry: number for number, geometry in enumerate(scene.geometry)}
    nodes = sorted(scene.graph.nodes_geometry, key=lambda node: order[scene.graph[node][1]])
    given = _node_names(path) if suffix == ".glb" else set()
    solids = gathered(partial(_of_node, scene, node, path.suffix, given) for node in nodes)
    return [solid for own in solids for solid in own], scene.metadata


def _of_node(scene: trimesh.Scene, node: str, suffix: str, given: set[str]) -> list[_Solid]:
    """Solids of one object of a scene, in world coordinates; `given` are the names of nodes that the file has."""
    import trimesh

    transform, geometry = scene.graph[node]
    mesh = scene.geometry[geometry]
    if not isinstance(mesh, trimesh.Trimesh):
        raise InputError(f'object "{node}" is no surface of faces')
    glb = suffix.lower() == ".glb"
    mesh = mesh.copy()
    mesh.apply_transform(np.linalg.inv(Y_UP) @ transform if glb else transform)
    own = _own_extras(scene, node)
    extras = {**mesh.metadata, **mesh.metadata.get("extras", {}), **own}
    # trimesh numbers the nodes without a name, and makes one up for each primitive of a mesh of several.
    made_up = not glb or (node.isdecimal() and node not in given) or mesh.metadata.get("from_gltf_primitive")
    name = str(own.get("name") or ("" if made_up else node) or extras.get("name") or geometry).removesuffix(suffix)
    _check_vertices(mesh, f'object "{name}"')
    parts = [mesh] if glb else _closed_runs(mesh)
    # The corners of a GLB are rounded before they are moved to where the object stands.
    raw, scale = np.asarray(scene.geometry[geometry].vertices), float(np.linalg.norm(transform[:3, :3], 2))
    rounding = [scale * rounding_of(raw)] if glb else [rounding_of(np.asarray(part.vertices)) for part in parts]
    for part in parts:
        part.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=_digits(part))
    labels = [f"{name}.{number}" for number in range(len(parts))] if len(parts) > 1 else [name]
    surfaces = map(_polygons, parts, rounding)
    return [_Solid(label, *surface, extras=extras) for label, surface in zip(labels, surfaces, strict=True)]


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
        For a file that cannot be read. The message never quotes what is in a file.
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
    if path.suffix.lower() == ".glb" and (needed := _compressions(path)):
        raise InputError(f"it needs {', '.join(needed)}; export it without compression")
    try:
        found = load(path, process=False, resolver=Beside(str(path)))
        meshes = dict(found.geometry) if isinstance(found, trimesh.Scene) else {"": found}
        surfaces = {name: _as_written(mesh) for name, mesh in meshes.items() if isinstance(mesh, trimesh.Trimesh)}
        lost = {name: _lost(*surface) for name, surface in surfaces.items()}
    except (InputError, MemoryError):
        raise
    except Exception as error:  # trimesh raises whatever its parsers do
        raise InputError("cannot be read as a mesh" + SAID.get(str(error), "")) from None
    wrong = [
        (f'object "{name.removesuffix(path.suffix)}": ' if name else "")
        + f"a face has a corner that does not exist (face {some(faces)})"
        for name, faces in lost.items()
        if faces
    ]
    if wrong:
        raise InputError(*wrong)
    if path.suffix.lower() != ".ply":
        return found
    ordered = {name: trimesh.Trimesh(v, _in_triangles(v, f), process=False) for name, (v, f) in surfaces.items()}
    if not isinstance(found, trimesh.Scene):
        return ordered.get("", found)
    found.geometry.update(ordered)
    return found


def _header(path: Path) -> bytes:
    """The JSON of a GLB; nothing of another file."""
    with path.open("rb") as file:
        head = file.read(20)
        size = int.from_bytes(head[12:16], "little")
        return file.read(min(size, MOST_BYTES)) if head[:4] == b"glTF" and head[16:20] == b"JSON" else b""


def _node_names(path: Path) -> set[str]:
    """Names that the nodes of a GLB have, which has been read."""
    return {str(node["name"]) for node in json.loads(_header(path)).get("nodes", []) if "name" in node}


def _compressions(path: Path) -> list[str]:
    """Compressions of surfaces that a GLB cannot be read without (glTF 2.0, 3.12)."""
    found = re.search(rb'"extensionsRequired"\s*:\s*\[([^\]]*)\]', _header(path))
    return re.findall(r"\w+_(?:draco|meshopt)_\w+", found[1].decode("ascii", "ignore")) if found else []


def _as_written(mesh: trimesh.Trimesh) -> tuple[Floats, Ints | list[Ints]]:
    """Vertices and faces as a PLY has them: trimesh puts the halves of quads and other polygons last.

    One array where all faces have as many corners; these are not yet checked to exist.
    """
    raw: dict[str, Any] = mesh.metadata.get("_ply_raw") or {}
    data = raw.get("face", {}).get("data")
    names = list(data) if isinstance(data, dict) else list(getattr(data, "dtype", np.dtype(int)).names or ())
    found = [name for name in CORNERS if name in names] or names
    if not found:
        return np.asarray(mesh.vertices), np.asarray(mesh.faces).reshape(-1, 3)
    rows = data[found[0]] if isinstance(data, dict) else data[found[0]]["f1"]
    vertices = np.column_stack([raw["vertex"]["data"][axis] for axis in "xyz"]).astype(float)
    if np.ndim(rows) == 2:
        return vertices, np.asarray(rows, dtype=np.int64)
    return vertices, [np.asarray(row, dtype=np.int64).reshape(-1) for row in rows]


def _in_triangles(vertices: Floats, faces: Ints | list[Ints]) -> Ints:
    """Triangles that follow one another as their faces do, and use every edge of these."""
    if isinstance(faces, np.ndarray) and faces.shape[1] == 3:
        return faces
    vertices = np.where(np.abs(vertices) < HUGE, vertices, 0.0)  # others are refused later
    triangles = [_cut(vertices, face) for face in faces if len(face) > 2]
    return np.concatenate(triangles) if triangles else np.empty((0, 3), dtype=np.int64)


def _cut(vertices: Floats, face: Ints) -> Ints:
    """Triangles of one face: by ears, or as a fan where these leave out a corner that is in line with others."""
    if len(face) == 3:
        return face[None]
    ears = triangulate(vertices, [face])
    if len(ears) == len(face) - 2:
        return ears
    return np.column_stack([np.full(len(face) - 2, face[0]), face[1:-1], face[2:]])


def _lost(vertices: Floats, faces: Ints | list[Ints]) -> list[int]:
    """Numbers of the faces with a corner that does not exist."""
    corners = np.ravel(faces) if isinstance(faces, np.ndarray) else np.concatenate(faces)
    owner = np.repeat(np.arange(len(faces)), [len(face) for face in faces])
    return np.unique(owner[(corners < 0) | (corners >= len(vertices))]).tolist()


def _check_vertices(mesh: trimesh.Trimesh, label: str) -> None:
    """Raise InputError with the vertices whose coordinates cannot be used."""
    wrong = np.flatnonzero(~(np.abs(mesh.vertices) < HUGE).all(axis=1)).tolist()
    if wrong:
        text = f"coordinates must be finite and below {HUGE:g} (vertex {some(wrong)})"
        raise InputError(f"{label}: {text}" if label else text)


def _closed_runs(mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """Cut a soup of triangles into solids: a solid ends where its surface has just closed.

    Corners cannot tell solids apart, because bricks that touch share them.
    """
    import trimesh

    _, corner = np.unique(np.round(mesh.vertices, _digits(mesh)), axis=0, return_inverse=True)
    solids = []
    for run in closed_runs(corner.reshape(-1)[mesh.faces].tolist()):
        used, faces = np.unique(mesh.faces[run.start : run.stop], return_inverse=True)
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
    shared = {"friction": assembly.friction, "gravity": assembly.gravity.tolist()}
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
