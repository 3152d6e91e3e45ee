"""Bullet's import, its engine parameters and its rotations."""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Sequence
from typing import Any

import numpy as np

from blockstat.errors import InputError
from blockstat.typing import Floats, Ints

#: Engine settings, measured: docs/dynamics.md.
ENGINE: dict[str, Any] = {
    "warmStartingFactor": 0.85,
    "contactSlop": 1e-6,
    "contactERP": 0.2,
    "contactBreakingThreshold": 1e-3,
    "solverResidualThreshold": 0.0,
    "enableSAT": 1,
    "enableFileCaching": 0,
}


MISSING = (
    "Bullet needs pybullet: pip install 'blockstat[dynamics]' on Linux x86-64 with Python 3.10 or 3.11, and elsewhere "
    "conda install -c conda-forge pybullet"
)
BROKEN = (
    "pybullet is installed but cannot be imported ({error}); versions before 3.2.7 need numpy below 2: "
    "pip install 'pybullet==3.2.7'"
)


def import_bullet() -> Any:
    """Import pybullet without its greeting, which it writes past Python's own streams.

    Returns
    -------
    module
        The module pybullet.

    Raises
    ------
    InputError
        When pybullet is not installed, or is not of this numpy; it says what to install.
    """
    if "pybullet" in sys.modules:
        return sys.modules["pybullet"]
    sys.stdout.flush()
    kept = [(stream, os.dup(stream)) for stream in (1, 2)]
    nowhere = os.open(os.devnull, os.O_WRONLY)
    try:
        for stream, _ in kept:
            os.dup2(nowhere, stream)
        return importlib.import_module("pybullet")
    except ModuleNotFoundError:
        raise InputError(MISSING) from None
    except ImportError as error:
        raise InputError(BROKEN.format(error=error)) from None
    finally:
        for stream, copy in kept:
            os.dup2(copy, stream)
            os.close(copy)
        os.close(nowhere)


def quaternion(rotation: Floats) -> Floats:
    """Return Bullet's quaternions of rotation matrices.

    Parameters
    ----------
    rotation : array of float, shape (..., 3, 3)
        Rotation matrices.

    Returns
    -------
    array of float, shape (..., 4)
        Quaternions x, y, z, w.
    """
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(rotation).as_quat()


def matrices(quaternion: Floats) -> Floats:
    """Return the rotation matrices of Bullet's quaternions.

    Parameters
    ----------
    quaternion : array of float, shape (..., 4)
        Quaternions x, y, z, w.

    Returns
    -------
    array of float, shape (..., 3, 3)
        Rotation matrices.
    """
    from scipy.spatial.transform import Rotation

    return Rotation.from_quat(quaternion).as_matrix()


def contact_points(bullet: Any, client: int, bodies: Sequence[int]) -> tuple[Ints, Floats, Floats, Floats]:
    """Return Bullet's contact points between some bodies, in its own units.

    Parameters
    ----------
    bullet : module
        The module pybullet.
    client : int
        Bullet's client.
    bodies : sequence of int
        Bodies of the blocks; points on other bodies, such as a floor, are left out.

    Returns
    -------
    pairs : array of int, shape (k, 2)
        Positions of the two bodies in the sequence.
    point : array of float, shape (k, 3)
        Where they touch.
    force : array of float, shape (k, 3)
        Force on the second body, normal and friction together.
    normal : array of float, shape (k, 3)
        Unit normals, out of the second body.
    """
    block = {body: i for i, body in enumerate(bodies)}
    found = [c for c in bullet.getContactPoints(physicsClientId=client) or () if c[1] in block and c[2] in block]
    pairs = np.array([(block[c[1]], block[c[2]]) for c in found], dtype=np.int64).reshape(-1, 2)
    point = np.array([c[6] for c in found]).reshape(-1, 3)
    normal = np.array([c[7] for c in found]).reshape(-1, 3)  # it points to the first body
    on_first = [np.multiply(c[9], c[7]) + np.multiply(c[10], c[11]) + np.multiply(c[12], c[13]) for c in found]
    return pairs, point, -np.array(on_first).reshape(-1, 3), normal
