"""A verdict as attributes of the blocks in a mesh that Blender and Houdini open, or as an object of COMPAS."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from blockstat.errors import check_choice
from blockstat.io.files import warn_of_losses, write

if TYPE_CHECKING:
    from blockstat.analysis.verdict import Verdict


#: What a .json file of a verdict may be.
COMPAS_FORMATS = ("compas-assembly", "compas-model")


def write_verdict(verdict: Verdict, path: str | Path, *, format: str = "compas-assembly") -> Path:
    """Write the blocks of a verdict with what it says of them, for Blender, Houdini or COMPAS.

    Parameters
    ----------
    verdict : Verdict
        The verdict.
    path : str or Path
        A .glb (extras of nodes, custom properties in Blender), a .obj (comments) or a .json of COMPAS.
    format : {"compas-assembly", "compas-model"}, optional
        Of a .json.

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For another suffix, or a directory that does not exist.

    Warns
    -----
    InputWarning
        Where the format does not keep all that the assembly has.

    Notes
    -----
    In a mesh, each block bears its name, group, density [kg/m3] and support, and

    - displacement: how far its fastest corner goes in the mechanism that moves the fastest of all by 1 m [m];
    - mechanism: its velocity [m] and rotation [rad] there, six numbers along the assembly's own axes, z up;
    - demand: how hard friction and strength are used at it, 0 to 1 (see `Verdict.demand`).

    A .json holds the joints with their forces, the displacements and the verdict, where `blockstat.compas.solve` puts
    them.

    Examples
    --------
    >>> from blockstat import Assembly, assess, box, write_verdict
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> verdict = assess(Assembly.from_blocks(blocks, supports=["ground"]))
    >>> write_verdict(verdict, "verdict.obj").name
    'verdict.obj'
    """
    path = Path(path)
    if path.suffix.lower() == ".json":
        check_choice("format", format, COMPAS_FORMATS)
        return _write_compas(verdict, path, format)
    values = {"displacement": verdict.motion, "mechanism": verdict.mechanism, "demand": verdict.demand()}
    return write(verdict.assembly, path, values=values)


def _write_compas(verdict: Verdict, path: Path, format: str) -> Path:
    from blockstat.compas.record import MOTION, joints_of, motion_of
    from blockstat.io.compas.write import write_compas
    from blockstat.system.writing import check_directory, written_whole

    check_directory(path)
    with written_whole(path) as place:
        write_compas(
            verdict.assembly,
            place,
            format,
            joints=joints_of(verdict),
            attributes={"verdict": verdict.summary()},
            motion=motion_of(verdict, MOTION).tolist(),
        )
    warn_of_losses(verdict.assembly, path, format)
    return path
