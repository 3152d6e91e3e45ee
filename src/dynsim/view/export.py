"""A run as a file: an animated GLB, a compact NPZ that can be read back, a moving picture, a film strip."""

from __future__ import annotations

import tempfile
import zipfile
import zlib
from dataclasses import fields
from pathlib import Path

import numpy as np

from blockstat.assembly import Assembly
from blockstat.errors import InputError
from blockstat.io.files import write
from blockstat.spec import read
from blockstat.system.writing import check_directory, written_whole
from blockstat.view.animation import quaternions, write_motion
from dynsim.judge.run import Contacts, Run
from dynsim.view.film import MOVING, film_strip, mp4_program, write_movie

KEYS = 240  #: of an animation, at most
#: Which suffix is written how.
PICTURES = (".png", ".svg", ".pdf")
FORMAT = 1  #: of the NPZ


def write_run(run: Run, path: str | Path) -> Path:
    """Write a run as a file.

    Parameters
    ----------
    run : Run
        What `simulate` returns, or the `run` of a verdict.
    path : str or Path
        Its suffix says how: .glb (animation), .npz (everything), .gif or .mp4 (moving picture), or .png, .svg, .pdf
        (film strip).

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        As `check_path`.
    """
    path = check_path(path)
    if path.suffix.lower() == ".glb":
        return write_glb(run, path)
    if path.suffix.lower() == ".npz":
        return write_npz(run, path)
    if path.suffix.lower() in MOVING:
        return write_movie(run, path)
    return film_strip(run, path)


def check_path(path: str | Path) -> Path:
    """Return the path if `write_run` can write there; better asked before a long run than after.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For an unknown suffix, a directory that does not exist or takes no file, or an MP4 without the package
        imageio-ffmpeg.
    """
    path = Path(path)
    suffixes = (".glb", ".npz", *MOVING, *PICTURES)
    if path.suffix.lower() not in suffixes:
        raise InputError(f'{path}: cannot write "{path.suffix}"; a run is written as: {", ".join(suffixes)}')
    check_directory(path)
    if path.suffix.lower() == ".mp4":
        mp4_program()
    return path


def write_glb(run: Run, path: str | Path) -> Path:
    """Write a run as an animated GLB in its own time, coloured by how far each block moves.

    Parameters
    ----------
    run : Run
        What is written.
    path : str or Path
        The file.

    Returns
    -------
    Path
        The file.
    """
    keys = np.unique(np.linspace(0, len(run.times) - 1, KEYS).round().astype(np.int64))
    length = np.linalg.norm(run.since_release, axis=2).max(axis=0)
    length[run.assembly.support] = 0.0
    return write_motion(
        run.assembly, path, times=run.times[keys], displacement=run.displacement[keys],
        quaternion=quaternions(run.rotation[keys]), values=length, gone=run.removed, come=run.placed, name="run",
    )  # fmt: skip


def write_npz(run: Run, path: str | Path) -> Path:
    """Write a run, its assembly included, as a file that `read_run` reads.

    Poses are kept in single precision (displacement and quaternion), all else in double.

    Parameters
    ----------
    run : Run
        What is written.
    path : str or Path
        The file.

    Returns
    -------
    Path
        The file.
    """
    path = check_path(path)
    with written_whole(path) as place, place.open("wb") as file:
        np.savez_compressed(
            file,
            format=FORMAT,
            assembly=_packed(run.assembly),
            displacement=run.displacement.astype(np.float32),
            quaternion=quaternions(run.rotation).astype(np.float32),
            **{f"contact_{name}": value for name, value in vars(run.contacts).items() if value is not None},
            **{name: getattr(run, name) for name in _others() if getattr(run, name) is not None},
        )
    return path


def read_run(path: str | Path) -> Run:
    """Read a run that `write_run` wrote as .npz.

    Parameters
    ----------
    path : str or Path
        The file.

    Returns
    -------
    Run
        The run; its poses are those of single precision.

    Raises
    ------
    InputError
        For a file that is no run.

    Examples
    --------
    >>> from blockstat import Assembly, box
    >>> from dynsim import read_run, simulate, write_run
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (0.5, 0.5, 2), name="pillar")]
    >>> pillar = Assembly.from_blocks(blocks, supports=["ground"])
    >>> path = write_run(simulate(pillar), "pillar.npz")
    >>> read_run(path).assembly.names
    ('ground', 'pillar')
    """
    from scipy.spatial.transform import Rotation

    path = Path(path)
    try:
        with np.load(path, allow_pickle=False) as data:
            kept = {name: data[name] for name in data.files}
    except OSError as error:
        raise InputError(f"{path}: {error.strerror or error}") from None
    except (ValueError, EOFError, zlib.error, zipfile.BadZipFile, AttributeError, TypeError):
        raise InputError(f"{path}: not an NPZ file") from None
    if int(kept.get("format", 0)) != FORMAT:
        raise InputError(f"{path}: not a run of this version of dynsim")
    quaternion = kept["quaternion"].astype(float)
    rotation = Rotation.from_quat(quaternion.reshape(-1, 4)).as_matrix().reshape(*quaternion.shape[:2], 3, 3)
    names = [field.name for field in fields(Contacts) if f"contact_{field.name}" in kept]
    contacts = Contacts(**{name: kept[f"contact_{name}"] for name in names})
    others = {name: kept[name] if kept[name].ndim else kept[name].item() for name in _others() if name in kept}
    return Run(
        assembly=_unpacked(kept["assembly"]), displacement=kept["displacement"].astype(float), rotation=rotation,
        contacts=contacts, **others,
    )  # fmt: skip


def _others() -> list[str]:
    """Fields of a run that are kept as they are: arrays and numbers."""
    separately = ("assembly", "displacement", "rotation", "contacts")
    return [field.name for field in fields(Run) if field.name not in separately]


def _packed(assembly: Assembly) -> np.ndarray:
    """Return the assembly in the native format, as bytes."""
    with tempfile.TemporaryDirectory(prefix="dynsim-") as directory:
        return np.frombuffer(write(assembly, Path(directory) / "assembly.json").read_bytes(), dtype=np.uint8)


def _unpacked(data: np.ndarray) -> Assembly:
    with tempfile.TemporaryDirectory(prefix="dynsim-") as directory:
        path = Path(directory) / "assembly.json"
        path.write_bytes(data.tobytes())
        return read(path)
