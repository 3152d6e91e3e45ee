"""A mechanism, or any motion of the blocks, as an animation.

It is a GLB (glTF 2.0, binary) with one node a block, which any viewer plays in a loop.

Sources: Khronos Group, glTF 2.0 Specification, 4.4 (GLB), 3.6 (accessors), 3.11 (animations).
"""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from blockstat.analysis.verdict import corner_speed
from blockstat.errors import InputError, known_options
from blockstat.geometry.triangulation import triangulate
from blockstat.system.writing import check_directory, written_whole
from blockstat.typing import Floats
from blockstat.view.plot import MOVED, SUPPORT, moving_twist

if TYPE_CHECKING:
    from blockstat.analysis.limit_load import LimitLoad
    from blockstat.analysis.verdict import Verdict
    from blockstat.assembly import Assembly

SECONDS = 4.0  #: there and back
KEYS = 33  #: odd, so that one of them is the end of the way there
#: Turn of the root by -90 degrees about x, as a quaternion (x, y, z, w): glTF is y-up.
Y_UP = (-float(np.sqrt(0.5)), 0.0, 0.0, float(np.sqrt(0.5)))
FLOAT, UNSIGNED = 5126, 5125
ARRAY, ELEMENTS = 34962, 34963


def write_mechanism(
    result: Verdict | LimitLoad, path: str | Path, *, amplitude: float | None = None, seconds: float = SECONDS
) -> Path:
    """Write the mechanism of an unstable verdict or of a limit load as an animated GLB.

    Parameters
    ----------
    result : Verdict or LimitLoad
        What has a mechanism.
    path : str or Path
        A .glb in a directory that exists.
    amplitude : float, optional
        How far the fastest corner goes [m]; by default a twelfth of the assembly's extent.
    seconds : float, optional
        Duration of the way there and back [s].

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        When nothing moves, when `amplitude` or `seconds` is not above 0, or for a path that is no .glb in a directory
        that exists.

    Notes
    -----
    Each block is a node at its centroid that goes along its twist (u, w): at time t it is displaced by s(t) amplitude u
    and turned by the rotation vector s(t) amplitude w, with s = (1 - cos(2 pi t / seconds)) / 2. Colours go with the
    speed of each block's fastest corner, as in `plot_mechanism`. The file is y-up, as glTF has it: below the root node
    are the assembly's own axes [m].

    Examples
    --------
    >>> from blockstat import Assembly, assess, box, write_mechanism
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> assembly = Assembly.from_blocks(blocks, supports=["ground"])
    >>> falls = assess(assembly, gravity=(9.0, 0.0, -9.81))
    >>> write_mechanism(falls, "falls.glb", amplitude=0.3).name
    'falls.glb'
    """
    if not (np.isfinite(seconds) and seconds > 0):
        raise InputError(f"seconds is {seconds!r}; it must be above 0")
    assembly = result.assembly
    twist = moving_twist(result, amplitude)
    phase = np.linspace(0.0, 1.0, KEYS)
    share = (1 - np.cos(2 * np.pi * phase))[:, None, None] / 2
    half = share * twist[:, 3:] / 2
    angle = np.linalg.norm(half, axis=2)[..., None]
    # A quaternion (x, y, z, w) from a rotation vector; sinc takes care of no rotation.
    turned = np.concatenate([half * np.sinc(angle / np.pi), np.cos(angle)], axis=2)
    speed = corner_speed(assembly, result.mechanism)
    return write_motion(
        assembly, path, times=seconds * phase, displacement=share * twist[:, :3], quaternion=turned, values=speed,
        name="mechanism",
    )  # fmt: skip


@known_options
def write_motion(
    assembly: Assembly,
    path: str | Path,
    *,
    times: Floats,
    displacement: Floats,
    quaternion: Floats,
    values: Floats,
    gone: Floats | None = None,
    come: Floats | None = None,
    name: str = "motion",
) -> Path:
    """Write a motion of the blocks as an animated GLB, with one node a block, y-up.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    path : str or Path
        A .glb in a directory that exists.
    times : array of float, shape (k,)
        Times of the keys, ascending [s]. A viewer interpolates linearly between them.
    displacement : array of float, shape (k, n_blocks, 3)
        Displacements of the centroids [m].
    quaternion : array of float, shape (k, n_blocks, 4)
        Rotations about the centroids, (x, y, z, w).
    values : array of float, shape (n_blocks,)
        One number a block to colour by, from 0.
    gone : array of float, shape (n_blocks,), optional
        Time from which a block is not shown [s], inf for none.
    come : array of float, shape (n_blocks,), optional
        Time from which a block is shown [s]; 0 from the beginning.
    name : str, optional
        Name of the animation in the file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For a path that is no .glb in a directory that exists.

    Examples
    --------
    >>> import numpy as np
    >>> from blockstat import Assembly, box, write_motion
    >>> assembly = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))])
    >>> lifted = np.array([[[0.0, 0.0, 0.0]], [[0.0, 0.0, 0.5]]])
    >>> level = np.tile([0.0, 0.0, 0.0, 1.0], (2, 1, 1))
    >>> path = write_motion(
    ...     assembly, "lifted.glb", times=np.array([0.0, 1.0]), displacement=lifted, quaternion=level, values=np.ones(1)
    ... )
    >>> path.name
    'lifted.glb'
    """
    path = Path(path)
    if path.suffix.lower() != ".glb":
        raise InputError(f"{path}: an animated {name} is written as .glb")
    check_directory(path)
    buffer = _Buffer()
    meshes, nodes = _blocks(assembly, _colours(assembly, values), buffer)
    root = {"name": assembly.name, "rotation": Y_UP, "children": list(range(1, assembly.n_blocks + 1))}
    content = {
        "asset": {"version": "2.0", "generator": "blockstat"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [root, *nodes],
        "meshes": meshes,
        "materials": [{"name": "stone", "pbrMetallicRoughness": {"metallicFactor": 0.0, "roughnessFactor": 0.9}}],
    }
    animation = _animation(
        assembly, times, displacement, quaternion, _shown(assembly, float(times[-1]), come, gone), buffer
    )
    if animation["channels"]:
        content["animations"] = [{"name": name, **animation}]
    with written_whole(path) as place:
        place.write_bytes(_glb(content | buffer.described(), buffer.data))
    return path


def quaternions(rotation: Floats) -> Floats:
    """Return quaternions of rotations through time, signs without jumps.

    Parameters
    ----------
    rotation : array of float, shape (k, n_blocks, 3, 3)
        Rotation matrices.

    Returns
    -------
    array of float, shape (k, n_blocks, 4)
        (x, y, z, w), as `write_motion` takes them.
    """
    from scipy.spatial.transform import Rotation

    found = Rotation.from_matrix(rotation.reshape(-1, 3, 3)).as_quat().reshape(*rotation.shape[:2], 4)
    turn = np.einsum("tni,tni->tn", found[1:], found[:-1])
    sign = np.cumprod(np.where(turn < 0, -1.0, 1.0), axis=0)
    found[1:] *= sign[..., None]
    return found


class _Buffer:
    """The binary chunk as it grows: arrays of one kind share a view."""

    def __init__(self) -> None:
        self._views: dict[str, dict[str, Any]] = {}
        self._parts: dict[str, list[bytes]] = {}
        self._accessors: list[dict[str, Any]] = []

    def add(self, view: str, values: Any, *, target: int | None = None, bounds: bool = False) -> int:
        """Append an array to a view.

        Parameters
        ----------
        view : str
            Name of the view.
        values : array, shape (n,) or (n, k)
            The numbers.
        target : int, optional
            `ARRAY` for vertex data, `ELEMENTS` for indices.
        bounds : bool, optional
            Whether the accessor says the least and the largest value.

        Returns
        -------
        int
            Index of the accessor.
        """
        array = np.ascontiguousarray(values, dtype="<u4" if target == ELEMENTS else "<f4")
        parts = self._parts.setdefault(view, [])
        fields = {"target": target} if target else {}
        # Accessors of vertex data that share a view need a stride.
        fields |= {"byteStride": array.itemsize * array.shape[1]} if target == ARRAY else {}
        self._views.setdefault(view, {"buffer": 0, **fields})
        accessor = {
            "bufferView": list(self._views).index(view),
            "byteOffset": sum(map(len, parts)),
            "componentType": UNSIGNED if target == ELEMENTS else FLOAT,
            "count": len(array),
            "type": "SCALAR" if array.ndim == 1 else f"VEC{array.shape[1]}",
        }
        if bounds:
            flat = array.reshape(len(array), -1).astype(float)
            accessor |= {"min": flat.min(axis=0).tolist(), "max": flat.max(axis=0).tolist()}
        parts.append(array.tobytes())
        self._accessors.append(accessor)
        return len(self._accessors) - 1

    @property
    def data(self) -> bytes:
        """All views one after the other."""
        return b"".join(part for parts in self._parts.values() for part in parts)

    def described(self) -> dict[str, Any]:
        """Return the glTF fields that say what is where.

        Returns
        -------
        dict
            The accessors, views and the buffer.
        """
        views, offset = [], 0
        for name, fields in self._views.items():
            length = sum(map(len, self._parts[name]))
            views.append({"name": name, "byteOffset": offset, "byteLength": length, **fields})
            offset += length
        return {"accessors": self._accessors, "bufferViews": views, "buffers": [{"byteLength": offset}]}


def _colours(assembly: Assembly, values: Floats) -> Floats:
    """Colour of each block in linear RGB, as glTF wants vertex colours, shape (n_blocks, 3)."""
    from matplotlib import colormaps

    shown = np.asarray(colormaps[MOVED](values / max(values.max(), 1e-300)))[:, :3]
    shown = np.where(assembly.support[:, None], SUPPORT, shown)
    return np.where(shown <= 0.04045, shown / 12.92, ((shown + 0.055) / 1.055) ** 2.4)


def _blocks(assembly: Assembly, colours: Floats, buffer: _Buffer) -> tuple[list[Any], list[Any]]:
    """Meshes and nodes of the blocks; each face has its own vertices, so that it is shaded flat."""
    meshes, nodes = [], []
    normal = np.split(assembly.planes.normal, np.searchsorted(assembly.face_block, np.arange(1, assembly.n_blocks)))
    for i, name in enumerate(assembly.names):
        faces = assembly.faces_of(i)
        corners = assembly.block_vertices(i)[np.concatenate(faces)] - assembly.centroid[i]
        count = [len(face) for face in faces]
        own = np.split(np.arange(len(corners)), np.cumsum(count)[:-1])
        attributes = {
            "POSITION": buffer.add("positions", corners, target=ARRAY, bounds=True),
            "NORMAL": buffer.add("normals", np.repeat(normal[i], count, axis=0), target=ARRAY),
            "COLOR_0": buffer.add("colours", np.tile(colours[i], (len(corners), 1)), target=ARRAY),
        }
        indices = buffer.add("triangles", triangulate(corners, own).reshape(-1), target=ELEMENTS)
        meshes.append({"name": name, "primitives": [{"attributes": attributes, "indices": indices, "material": 0}]})
        nodes.append({"name": name, "mesh": i, "translation": assembly.centroid[i].tolist()})
    return meshes, nodes


def _shown(
    assembly: Assembly, end: float, come: Floats | None, gone: Floats | None
) -> dict[int, tuple[list[float], list[float]]]:
    """When each block that is not always shown appears and goes: times, and its size from then on.

    The last of the times is the end, so that a film in which nothing moves shows its last state, too.
    """
    n = assembly.n_blocks
    come, gone = (np.zeros(n) if come is None else come), (np.full(n, np.inf) if gone is None else gone)
    found = {}
    for i in np.flatnonzero((come > 0) | np.isfinite(gone)):
        sizes = {0.0: 0.0 if come[i] > 0 else 1.0}
        if 0 < come[i] < np.inf:
            sizes[float(come[i])] = 1.0
        if np.isfinite(gone[i]):
            sizes[float(gone[i])] = 0.0
        if end > max(sizes):
            sizes[end] = sizes[max(sizes)]
        found[int(i)] = list(sizes), list(sizes.values())
    return found


def _animation(
    assembly: Assembly,
    times: Floats,
    displacement: Floats,
    quaternion: Floats,
    shown: dict[int, tuple[list[float], list[float]]],
    buffer: _Buffer,
) -> dict[str, Any]:
    """Translation and rotation of every block that moves; a block that comes or goes changes its size at once."""
    samplers, channels = [], []

    def add(block: int, kind: str, keys: int, values: Floats, interpolation: str = "LINEAR") -> None:
        channels.append({"sampler": len(samplers), "target": {"node": block + 1, "path": kind}})
        output = buffer.add(f"{kind}s", values)
        samplers.append({"input": keys, "output": output, "interpolation": interpolation})

    moves = displacement.any(axis=(0, 2)) | quaternion[:, :, :3].any(axis=(0, 2))
    keys = buffer.add("times", times, bounds=True) if moves.any() else -1
    for i in np.flatnonzero(moves):
        add(int(i), "translation", keys, assembly.centroid[i] + displacement[:, i])
        add(int(i), "rotation", keys, quaternion[:, i])
    for i, (when, size) in shown.items():
        add(i, "scale", buffer.add("times", when, bounds=True), np.outer(size, np.ones(3)), "STEP")
    return {"samplers": samplers, "channels": channels}


def _glb(content: dict[str, Any], data: bytes) -> bytes:
    """Header, JSON chunk padded with spaces, binary chunk (whole words already: all numbers have four bytes)."""
    text = json.dumps(content, separators=(",", ":")).encode()
    text += b" " * (-len(text) % 4)
    chunks = struct.pack("<I4s", len(text), b"JSON") + text + struct.pack("<I4s", len(data), b"BIN\0") + data
    return struct.pack("<4sII", b"glTF", 2, 12 + len(chunks)) + chunks
