"""A verdict as attributes of the blocks in a mesh that Blender and Houdini open."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from blockstat.io.files import write

if TYPE_CHECKING:
    from blockstat.analysis.verdict import Verdict


def write_verdict(verdict: Verdict, path: str | Path) -> Path:
    """Write the blocks of a verdict as a mesh with attributes that Blender and Houdini read.

    Parameters
    ----------
    verdict : Verdict
        The verdict.
    path : str or Path
        A .glb (extras of nodes, custom properties in Blender) or .obj (comments).

    Returns
    -------
    Path
        The file.

    Raises
    ------
    InputError
        For another suffix, or a directory that does not exist.

    Notes
    -----
    Each block bears its name, group, density [kg/m3] and support, and

    - displacement: how far its fastest corner goes in the mechanism that moves the fastest of all by 1 m [m];
    - mechanism: its velocity [m] and rotation [rad] there, six numbers along the assembly's own axes, z up;
    - demand: how hard friction and strength are used at it, 0 to 1 (see `Verdict.demand`).

    Examples
    --------
    >>> from blockstat import Assembly, assess, box, write_verdict
    >>> blocks = [box((-1, -1, -1), (2, 2, 0), name="ground"), box((0, 0, 0), (1, 1, 2), name="block")]
    >>> verdict = assess(Assembly.from_blocks(blocks, supports=["ground"]))
    >>> write_verdict(verdict, "verdict.obj").name
    'verdict.obj'
    """
    values = {"displacement": verdict.motion, "mechanism": verdict.mechanism, "demand": verdict.demand()}
    return write(verdict.assembly, path, values=values)
