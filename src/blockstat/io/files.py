"""Files in and out: the format is picked by the suffix, and of JSON by the content."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Iterable, Mapping, Sized
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from blockstat.assembly import DENSITY, FRICTION, STANDARD_GRAVITY
from blockstat.errors import InputError, InputWarning, known_options
from blockstat.system.reading import check_file, json_of
from blockstat.system.writing import check_directory, written_whole

if TYPE_CHECKING:
    from blockstat.assembly import Assembly
    from blockstat.io.parts import Parts

T = TypeVar("T")
MESHES = (".obj", ".glb", ".stl", ".ply")
READABLE = (".json", ".toml", *MESHES)
WRITABLE = (".json", *MESHES)
#: What a .json file and a directory may be written as, the default first.
FORMATS = {".json": ("native", "compas-assembly", "compas-model"), "": ("ply", "stl")}
#: What .obj, .glb and the formats of COMPAS keep beside the surfaces of blocks, and what a directory keeps of it.
KEPT = ("supports", "names of blocks", "groups", "densities", "friction", "gravity")
KEPT_IN_DIRECTORY = ("names of blocks", "groups")
BUILT_FROM = ("parameters", "material")  #: metadata of a scene that its blocks stand for; nothing reads them


def read_parts(path: str | Path, *, supports: Iterable[int | str] | None = None, units: str | None = None) -> Parts:
    """Read blocks and all else that a file says, not yet checked to be closed solids.

    Parameters
    ----------
    path : str or Path
        A file of any format but a scene, or a directory.
    supports : iterable of int or str, optional
        Names or numbers of the blocks that cannot move, in place of those that the file marks.
    units : str, optional
        Of the coordinates in the file, by default metres.

    Returns
    -------
    Parts
        In metres.

    Raises
    ------
    InputError
        Naming a file that does not exist or cannot be read, or is so far from the origin that single precision loses
        its joints.

    Warns
    -----
    InputWarning
        Where single precision opens joints, or the digits of a text are too few for them.
    """
    path = Path(path)
    if not path.is_dir() and path.suffix.lower() not in READABLE:
        raise InputError(f'{path}: cannot read "{path.suffix.lower()}"; formats are: {", ".join(READABLE)}')
    if not path.exists():
        raise InputError(f"{path}: no such file")
    return blaming(path, lambda: _parts(path, supports, units))


def _parts(path: Path, supports: Iterable[int | str] | None, units: str | None) -> Parts:
    from blockstat.io.parts import metres_in

    metres = metres_in(units)
    if path.is_dir():
        from blockstat.io.folder import folder_files, folder_parts

        return _checked(path, folder_files(path), folder_parts(path, supports=supports), metres)
    check_file(path)
    if not path.stat().st_size:
        raise InputError("the file is empty")
    if path.suffix.lower() == ".json":
        from blockstat.io.compas.read import compas_parts, is_compas
        from blockstat.io.native import native_parts

        data = json_of(path)
        if is_compas(data):
            return compas_parts(data, path.stem, supports=supports).scaled(metres)
        return native_parts(data, path.stem, supports=supports, units=units).scaled(metres)
    from blockstat.io.mesh import mesh_parts

    return _checked(path, [path], mesh_parts(path, supports=supports), metres)


def _checked(path: Path, files: list[Path], parts: Parts, metres: float) -> Parts:
    """The same in metres, where single precision leaves its joints, and digits of a text are told that may not."""
    from blockstat.io.raw.digits import check_digits
    from blockstat.io.raw.precision import check_spacing

    scaled = parts.scaled(metres)
    if scaled.spacing:
        check_spacing(path, scaled.blocks, scaled.spacing)
    check_digits(path, files, parts.blocks, metres)
    return scaled


def blaming(path: Path, call: Callable[[], T]) -> T:
    """Call a function, and put the name of a file in front of what it refuses.

    Parameters
    ----------
    path : Path
        The file.
    call : callable
        Without arguments.

    Returns
    -------
    object
        What the function returns.

    Raises
    ------
    InputError
        As the function does, with the name of the file.
    """
    try:
        return call()
    except InputError as error:
        told = (text if str(text).startswith(str(path)) else f"{path}: {text}" for text in error.args)
        raise type(error)(*told) from None


@known_options
def write(
    assembly: Assembly,
    path: str | Path,
    *,
    format: str | None = None,
    values: Mapping[str, Any] | None = None,
    units: str | None = None,
    up: str | None = None,
) -> Path:
    """Write an assembly as a file of blocks, or into a directory with one file a block.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    path : str or Path
        A .json (exact), a mesh (.obj, .glb, .stl, .ply) with one named object a block, or a directory (no suffix).
    format : str, optional
        Of a .json file "native" (the default), "compas-assembly" (compas_assembly) or "compas-model" (a block model of
        compas_dem); of a directory "ply" (the default) or "stl".
    values : mapping of str to sequence, optional
        For each key one number or list a block, kept as custom attributes of the objects of a .glb or .obj.
    units : str, optional
        Of the coordinates in the file, by default metres.
    up : str, optional
        The axis of the file that points up, by default z, and y in GLB. `blockstat.read` with the same units and axis
        gives the same blocks.

    Returns
    -------
    Path

    Raises
    ------
    InputError
        For a format that cannot be written, a directory that does not exist, or a unit or an axis that is not known.
        Also for an option that does not exist.

    Warns
    -----
    InputWarning
        Where the format does not keep all that the assembly has, or where an .stl or .ply is so far from the origin
        that its seven digits move corners.

    Examples
    --------
    >>> from blockstat import Assembly, box, read, write
    >>> cube = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1))], supports=[0])
    >>> read(write(cube, "cube.json")).volume.tolist()
    [1.0]
    >>> read(write(cube, "cube.obj", units="mm", up="y"), units="mm", up="y").volume.round(9).tolist()
    [1.0]
    """
    from blockstat.io.parts import in_frame, own_up

    path = Path(path)
    suffix = "" if path.is_dir() else path.suffix.lower()
    if suffix not in ("", *WRITABLE):
        raise InputError(f'{path}: cannot write "{suffix}"; formats are: {", ".join(WRITABLE)}')
    formats = FORMATS.get(suffix, ())
    if format is not None and format not in formats:
        raise InputError(f'{path}: cannot be written as "{format}"; it can be: {", ".join(formats) or suffix}')
    check_directory(path)
    if values and suffix in FORMATS:
        raise InputError(f"{path}: values are written to .glb and .obj only")
    own = own_up(suffix)
    given, assembly = assembly, in_frame(assembly, units, up, own)
    frame = (units or "m", up or own)
    if not suffix:
        from blockstat.io.folder import write_folder

        write_folder(assembly, path, f".{format or formats[0]}")
    else:
        with written_whole(path) as place:
            blaming(path, lambda: _write_file(assembly, place, format, values or {}, frame))
    warn_of_losses(given, path, format)
    if suffix in ("", ".stl", ".ply"):
        _warn_of_rounding(assembly, path, frame[0])
    return path


def warn_of_losses(assembly: Assembly, path: Path, format: str | None) -> None:
    """Warn of what a file does not keep of an assembly that was written to it.

    Parameters
    ----------
    assembly : Assembly
        In metres, z up.
    path : Path
        The file, or a directory.
    format : str or None
        As in `write`.

    Warns
    -----
    InputWarning
        Naming the file and what it does not keep.
    """
    suffix = "" if path.is_dir() else path.suffix.lower()
    if lost := _lost(assembly, suffix, format):
        place = f"{format} in .json" if suffix == ".json" else suffix or "a directory"
        others = ".obj, .glb and .json do" if set(lost) <= set(KEPT) else "only a native .json does"
        listed = ", ".join(lost[:-1]) + " and " * (len(lost) > 1) + lost[-1]
        warnings.warn(InputWarning(f"{path}: {place} does not keep {listed}; {others}"), stacklevel=4)


def _warn_of_rounding(assembly: Assembly, path: Path, unit: str) -> None:
    """Warn where the seven digits of .stl and .ply move the corners of blocks that are far from the origin."""
    from blockstat.io.parts import moved_far_away

    if moved := moved_far_away(assembly.vertices):
        text = f"{path}: .stl and .ply hold seven digits, so corners moved by up to {moved:.2g} {unit}; "
        text += "move the blocks to the origin, or write .obj, .glb or .json"
        warnings.warn(InputWarning(text), stacklevel=4)


def _lost(assembly: Assembly, suffix: str, format: str | None) -> list[str]:
    """What a format does not keep of an assembly; what a reader takes without being told is no loss."""
    if suffix == ".json" and format in (None, "native"):
        return []
    numbered = all(
        name in (f"block{i}", f"{assembly.name}.{i}", assembly.name) for i, name in enumerate(assembly.names)
    )
    noted = [
        key
        for key, value in assembly.metadata.items()
        if key not in BUILT_FROM and value is not None and not (isinstance(value, Sized) and not len(value))
    ]
    has = {
        "supports": assembly.support.any(),
        "names of blocks": not numbered,
        "groups": any(assembly.groups),
        "densities": (assembly.density != DENSITY).any(),
        "friction": assembly.friction != FRICTION,
        "gravity": not np.array_equal(assembly.gravity, STANDARD_GRAVITY),
        "joint laws": assembly.joints,
        "ties": assembly.ties,
        f"metadata ({', '.join(noted)})": noted,
    }
    kept = {"": KEPT_IN_DIRECTORY, ".stl": (), ".ply": ()}.get(suffix, KEPT)
    return [what for what, there in has.items() if there and what not in kept]


def _write_file(
    assembly: Assembly, path: Path, format: str | None, values: Mapping[str, Any], frame: tuple[str, str]
) -> None:
    if format in ("compas-assembly", "compas-model"):
        from blockstat.io.compas.write import write_compas

        write_compas(assembly, path, format)
    elif path.suffix.lower() == ".json":
        from blockstat.io.native import write_json

        write_json(assembly, path, units=frame[0])
    else:
        from blockstat.io.mesh import write_mesh

        write_mesh(assembly, path, values, frame=frame)
