"""The first part of a GLB, which is JSON: what nodes are called, and what trimesh would leave out or misread.

Sources: glTF 2.0, 3.5 (nodes), 3.6.2 (accessors), 3.7.2 (modes of primitives), 3.12 (extensions) and 4.4 (GLB).
"""

from __future__ import annotations

import json
import re
from collections import defaultdict
from collections.abc import Callable, Iterator
from functools import reduce
from operator import add
from pathlib import Path
from typing import TYPE_CHECKING, Any

from blockstat.errors import InputError, some

if TYPE_CHECKING:
    import trimesh

#: Extensions that change no corner.
HARMLESS = re.compile(r"[A-Z]+_(materials|texture|lights)_\w+")
COMPRESSED = re.compile(r"\w+_(draco|meshopt)_\w+")
COPIES = "EXT_mesh_gpu_instancing"  #: places that many copies of one node stand at
MODES = (4, 5)  #: triangles, and triangles in strips


def numbered(data: bytes) -> bytes:
    """Return a GLB with its nodes named by their numbers, from which `names` tells what they are called.

    trimesh renames nodes that share a name, and lists them in an order of its own.

    Parameters
    ----------
    data : bytes
        The file.

    Returns
    -------
    bytes
        The file as it is where it does not begin as a GLB.

    Raises
    ------
    InputError
        For all that trimesh would leave out or read as something else.
    """
    text = _text(data)
    if not text:
        return data
    content = json.loads(text)
    if wrong := [*_extensions(content), *_meshes(content), *_copies(content), *_scenes(content)]:
        raise InputError(*wrong)
    for number, node in enumerate(content.get("nodes", [])):
        node["name"] = str(number)
    own = json.dumps(content).encode()
    own += b" " * (-len(own) % 4)
    rest = data[20 + len(text) :]
    sizes = (20 + len(own) + len(rest), len(own))
    return data[:8] + b"".join(size.to_bytes(4, "little") for size in sizes) + data[16:20] + own + rest


def names(path: Path) -> list[tuple[str, str]]:
    """Return what the nodes of a GLB and their meshes are called.

    Parameters
    ----------
    path : Path
        A file that `numbered` takes.

    Returns
    -------
    list of (str, str)
        Names of each node and of its mesh, "" for none.
    """
    content = json.loads(_text(path.read_bytes()))
    meshes = [str(mesh.get("name") or "") for mesh in content.get("meshes", [])]
    return [
        (str(node.get("name") or ""), meshes[node["mesh"]] if "mesh" in node else "")
        for node in content.get("nodes", [])
    ]


def places(path: Path) -> set[tuple[float, ...]]:
    """Return the places that the nodes of a GLB move to what they hold, in the unit of the file.

    Parameters
    ----------
    path : Path
        A file that `numbered` takes.

    Returns
    -------
    set of tuple of float
        Each of x, y and z.
    """
    nodes = json.loads(_text(path.read_bytes())).get("nodes", [])
    return {tuple(node.get("translation") or node.get("matrix", [0.0] * 15)[12:15]) for node in nodes}


def number_of(name: str) -> int:
    """Return the number of a node of a GLB that `numbered` returned.

    Parameters
    ----------
    name : str
        As trimesh has it; it adds letters for each primitive of a mesh that has several.

    Returns
    -------
    int

    Examples
    --------
    >>> number_of("12"), number_of("3_XK52D6")
    (12, 3)
    """
    return int(name.partition("_")[0])


def join_primitives(scene: trimesh.Scene, n_surfaces: Callable[[trimesh.Trimesh], int]) -> None:
    """Put primitives of one mesh together, one a material, where only together they are one closed surface.

    Where they would be several, which of them make a stone cannot be told: they stay as they are, open.

    Parameters
    ----------
    scene : trimesh.Scene
        As trimesh read it, with an object for each primitive of a mesh that has several; it is changed.
    n_surfaces : callable
        Of a mesh, the number of its closed surfaces, 0 where it is open.
    """
    primitives: dict[int, set[str]] = defaultdict(set)
    for node in scene.graph.nodes_geometry:
        geometry = str(scene.graph[node][1])
        if scene.geometry[geometry].metadata.get("from_gltf_primitive"):
            primitives[number_of(node)].add(geometry)
    for names in {frozenset(own) for own in primitives.values()}:  # nodes may share a mesh
        parts = [name for name in scene.geometry if name in names and not n_surfaces(scene.geometry[name])]
        if len(parts) < 2:
            continue
        whole = reduce(add, (scene.geometry[name] for name in parts))
        if n_surfaces(whole) == 1:
            # The name of the node is its own again where no other primitive is left.
            whole.metadata["from_gltf_primitive"] = len(parts) < len(names)
            scene.geometry[parts[0]] = whole
            scene.delete_geometry(parts[1:])


def _text(data: bytes) -> bytes:
    """The JSON of a GLB; nothing of another file."""
    size = int.from_bytes(data[12:16], "little")
    return data[20 : 20 + size] if data[:4] == b"glTF" and data[16:20] == b"JSON" else b""


def _extensions(content: dict[str, Any]) -> Iterator[str]:
    needed = [str(name) for name in content.get("extensionsRequired", [])]
    compressed = [name for name in needed if COMPRESSED.fullmatch(name)]
    if compressed:
        yield f"it needs {some(compressed)}; export it without compression"
    if others := [name for name in needed if name not in compressed and not HARMLESS.fullmatch(name)]:
        yield f"it needs {some(others)}; of extensions, it may need those of materials, textures and lights"


def _meshes(content: dict[str, Any]) -> Iterator[str]:
    """Primitives that are no triangles, and numbers that trimesh takes as they are stored."""
    accessors = content.get("accessors", [])
    for number, mesh in enumerate(content.get("meshes", [])):
        label = f'mesh "{mesh.get("name") or number}"'
        modes = {primitive.get("mode", 4) for primitive in mesh["primitives"]}
        if others := sorted(modes.difference(MODES)):
            yield f"{label}: it is drawn in mode {some(others)}; only triangles (4) and strips of them (5) are read"
            continue
        used = [primitive["attributes"]["POSITION"] for primitive in mesh["primitives"]]
        used += [primitive["indices"] for primitive in mesh["primitives"] if "indices" in primitive]
        for kind in ("normalized", "sparse"):
            if any(accessors[k].get(kind) for k in used):
                yield f"{label}: its corners are stored as {kind} numbers; export them as plain ones"


def _copies(content: dict[str, Any]) -> Iterator[str]:
    for number, node in enumerate(content.get("nodes", [])):
        if COPIES in node.get("extensions", {}):
            yield f'object "{node.get("name") or number}": it stands for copies ({COPIES}); export each as an object'


def _scenes(content: dict[str, Any]) -> Iterator[str]:
    """Objects of other scenes than the one that is shown."""
    scenes, nodes = content.get("scenes", []), content.get("nodes", [])
    shown = content.get("scene", 0)

    def of_scene(scene: dict[str, Any]) -> set[int]:
        found: set[int] = set()
        pending = list(scene.get("nodes", []))
        while pending:
            number = pending.pop()
            if number not in found:
                found.add(number)
                pending += nodes[number].get("children", [])
        return {number for number in found if "mesh" in nodes[number]}

    others = set().union(*(of_scene(own) for k, own in enumerate(scenes) if k != shown))
    if left := sorted(others - (of_scene(scenes[shown]) if shown < len(scenes) else set())):
        named = some([f'"{nodes[k].get("name") or k}"' for k in left])
        yield f"objects that are not in the scene that is shown would be left out: {named}; export all in one scene"
