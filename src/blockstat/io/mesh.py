"""Meshes through trimesh: OBJ and GLB with one named object a block, STL and PLY with one solid a block.

Triangles in one plane are joined to polygons again, so that a brick read from a mesh has six faces. GLB is
y-up by its specification; it is turned on the way in and out. Supports, groups and density travel in GLB's
custom attributes and are lost in the other formats.
"""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.assembly import DENSITY, Assembly, Block
from blockstat.errors import InputError
from blockstat.io.names import distinct_names
from blockstat.io.triangles import triangulate

if TYPE_CHECKING:
    import trimesh

#: x, y, z of a z-up scene to x, z, -y of a y-up one.
Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
#: Corners closer than this fraction of a solid's size are one (GLB and STL hold seven digits).
WELD = 1e-6


def read_mesh(path: Path, *, supports: Iterable[int | str] | None = None) -> Assembly:
    """Read one block from each object or solid of a mesh file; coordinates are metres."""
    meshes, shared = _solids(path, path.suffix.lower())
    if not meshes:
        raise InputError("the file holds no solid")
    marked = [i for i, (_, mesh) in enumerate(meshes) if _extra(mesh, "support", False)]
    chosen = marked if supports is None else list(supports)
    if not chosen:
        some = ", ".join(name for name, _ in meshes[:8])
        raise InputError(f"a mesh does not say which blocks are supports; give their names or numbers (blocks: {some})")
    names = distinct_names([name for name, _ in meshes], chosen)
    blocks = [
        Block(*_polygons(mesh), name=name, group=str(_extra(mesh, "group", "")), density=_extra(mesh, "density", None))
        for name, (_, mesh) in zip(names, meshes, strict=True)
    ]
    options = {key: shared[key] for key in ("friction", "gravity") if key in shared}
    return Assembly.from_blocks(blocks, supports=chosen, name=path.stem, density=DENSITY, **options)


def _solids(path: Path, suffix: str) -> tuple[list[tuple[str, trimesh.Trimesh]], dict[str, Any]]:
    """Named solids in world coordinates, in the order of the file, and what the file says of all of them."""
    import trimesh

    options = {"split_objects": True, "group_material": False, "maintain_order": True} if suffix == ".obj" else {}
    try:
        scene = trimesh.load_scene(path, process=False, **options)
    except Exception as error:
        raise InputError(f"cannot be read as a mesh: {error}") from None
    found = []
    for node in scene.graph.nodes_geometry:
        transform, geometry = scene.graph[node]
        mesh = scene.geometry[geometry]
        if not isinstance(mesh, trimesh.Trimesh):
            raise InputError(f'object "{node}" is no surface of faces')
        mesh = mesh.copy()
        mesh.apply_transform(np.linalg.inv(Y_UP) @ transform if suffix == ".glb" else transform)
        parts = _closed_runs(mesh) if suffix in (".stl", ".ply") else [mesh]
        for number, part in enumerate(parts):
            part.merge_vertices(merge_tex=True, merge_norm=True, digits_vertex=_digits(part))
            name = str(mesh.metadata.get("name") or geometry).removesuffix(path.suffix)
            found.append((f"{name}.{number}" if len(parts) > 1 else name, part))
    order = {name: i for i, name in enumerate(_object_names(path) if suffix == ".obj" else scene.geometry)}
    return sorted(found, key=lambda item: order.get(item[0], 0)), scene.metadata


def _object_names(path: Path) -> list[str]:
    return [line[2:].strip() for line in path.read_text(errors="replace").splitlines() if line.startswith("o ")]


def _closed_runs(mesh: trimesh.Trimesh) -> list[trimesh.Trimesh]:
    """Cut a soup of triangles into solids: a solid ends where its surface has just closed.

    Corners cannot tell solids apart, because bricks that touch share them.
    """
    import trimesh

    _, corner = np.unique(np.round(mesh.vertices, _digits(mesh)), axis=0, return_inverse=True)
    open_edges: set[tuple[int, int]] = set()
    runs, first = [], 0
    for number, (a, b, c) in enumerate(corner.reshape(-1)[mesh.faces].tolist()):
        for edge in ((a, b), (b, c), (c, a)):
            if edge[::-1] in open_edges:
                open_edges.remove(edge[::-1])
            else:
                open_edges.add(edge)
        if not open_edges:
            runs.append(range(first, number + 1))
            first = number + 1
    if first < len(mesh.faces):
        runs.append(range(first, len(mesh.faces)))
    solids = []
    for run in runs:
        used, faces = np.unique(mesh.faces[run.start : run.stop], return_inverse=True)
        solids.append(trimesh.Trimesh(mesh.vertices[used], faces.reshape(-1, 3), process=False))
    return solids


def _digits(mesh: trimesh.Trimesh) -> int:
    return int(np.ceil(-np.log10(WELD * max(float(mesh.extents.max()), 1e-12))))


def _extra(mesh: trimesh.Trimesh, key: str, default: Any) -> Any:
    return mesh.metadata.get(key, mesh.metadata.get("extras", {}).get(key, default))


def _polygons(mesh: trimesh.Trimesh) -> tuple[np.ndarray, list[list[int]]]:
    """Vertices and faces with coplanar triangles joined where their outline is one loop."""
    faces: list[list[int]] = []
    joined = np.zeros(len(mesh.faces), dtype=bool)
    for facet, boundary in zip(mesh.facets, mesh.facets_boundary, strict=True):
        loop = _loop(mesh.faces[facet], {tuple(sorted(map(int, edge))) for edge in boundary})
        if loop:
            faces.append(loop)
            joined[facet] = True
    faces += mesh.faces[~joined].tolist()
    return np.asarray(mesh.vertices), faces


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


def write_mesh(assembly: Assembly, path: Path) -> None:
    """Write one object a block; STL and PLY hold all blocks as one soup of solids."""
    import trimesh

    if path.suffix.lower() == ".obj":
        path.write_text(_obj(assembly))
        return
    meshes = [_mesh(assembly, i) for i in range(assembly.n_blocks)]
    if path.suffix.lower() in (".stl", ".ply"):
        trimesh.util.concatenate(meshes).export(path)
        return
    scene = trimesh.Scene()
    scene.metadata.update({"friction": assembly.friction, "gravity": assembly.gravity.tolist()})
    for name, mesh in zip(assembly.names, meshes, strict=True):
        scene.add_geometry(mesh, node_name=name, geom_name=name, transform=Y_UP)
    scene.export(path)


def _mesh(assembly: Assembly, block: int) -> trimesh.Trimesh:
    import trimesh

    vertices = assembly.block_vertices(block)
    extras = {
        "name": assembly.names[block],
        "group": assembly.groups[block],
        "density": float(assembly.density[block]),
        "support": bool(assembly.support[block]),
    }
    return trimesh.Trimesh(vertices, triangulate(vertices, assembly.faces_of(block)), process=False, metadata=extras)


def _obj(assembly: Assembly) -> str:
    """Wavefront OBJ with polygons and all digits; names may not hold blanks there."""
    lines = [f"# {assembly.name}: {assembly.n_blocks} blocks, metres, z up"]
    offset = 1
    for block, name in enumerate(assembly.names):
        vertices = assembly.block_vertices(block)
        lines.append(f"o {'_'.join(name.split())}")
        lines += ["v " + " ".join(repr(float(x)) for x in vertex) for vertex in vertices]
        lines += ["f " + " ".join(str(int(corner) + offset) for corner in face) for face in assembly.faces_of(block)]
        offset += len(vertices)
    return "\n".join(lines) + "\n"
