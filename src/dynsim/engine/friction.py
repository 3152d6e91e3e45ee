"""The friction of each joint from one coefficient a block.

Bullet multiplies the coefficients of two bodies that touch. With one friction mu everywhere, each block has sqrt(mu).
Where joint laws or the interfaces give joints their own friction, coefficients m with m_a m_b = mu_ab are found for all
pairs that touch as built. Pairs that meet later have the product of their coefficients.
"""

from __future__ import annotations

import numpy as np

from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.contact.point_law import joint_friction
from blockstat.errors import InputError
from blockstat.typing import Floats

STICKY = 100.0  #: Bullet's stand-in for infinite friction
EXACT = 1e-9  #: largest relative error of a product


def has_own_friction(assembly: Assembly, interfaces: Interfaces | None = None) -> bool:
    """Return whether a joint has a friction other than the assembly's.

    Parameters
    ----------
    assembly : Assembly
        Its joint laws are looked at.
    interfaces : Interfaces, optional
        Joints of the assembly; a friction of their own counts before the laws.

    Returns
    -------
    bool
        True where blocks may need coefficients of their own.
    """
    if interfaces is not None and interfaces.friction is not None:
        return bool((interfaces.friction != assembly.friction).any())
    return any(law.friction not in (None, assembly.friction) for law in assembly.joints)


def common_friction(assembly: Assembly) -> Floats:
    """Return the coefficient of each block where all joints have the friction of the assembly.

    Parameters
    ----------
    assembly : Assembly
        Its friction counts.

    Returns
    -------
    array of float, shape (n_blocks,)
        The square root of the friction, the same for all blocks.
    """
    return np.full(assembly.n_blocks, np.sqrt(min(assembly.friction, STICKY)))


def block_friction(assembly: Assembly, interfaces: Interfaces) -> Floats:
    """Return the coefficient of each block where joints differ in friction.

    Parameters
    ----------
    assembly : Assembly
        Blocks and joint laws.
    interfaces : Interfaces
        Joints of the assembly.

    Returns
    -------
    array of float, shape (n_blocks,)
        Coefficients whose product over two blocks that touch is the friction of their joint.

    Raises
    ------
    InputError
        Naming two groups, when no such coefficients exist.
    """
    wanted = np.minimum(joint_friction(assembly, interfaces), STICKY)
    found = common_friction(assembly)
    rough = np.zeros(assembly.n_blocks, dtype=bool)
    rough[interfaces.pair[wanted > 0]] = True
    smooth = np.zeros(assembly.n_blocks, dtype=bool)
    smooth[interfaces.pair[wanted == 0]] = True
    found[smooth & ~rough] = 0.0
    rows = np.flatnonzero(wanted > 0)
    if len(rows):
        logarithms = _logarithms(assembly.n_blocks, interfaces.pair[rows], np.log(wanted[rows]))
        found[rough] = np.exp(logarithms[rough])
    error = np.abs(np.prod(found[interfaces.pair], axis=1) - wanted) > EXACT * np.maximum(wanted, EXACT)
    if error.any():
        worst = int(np.argmax(error))
        a, b = (assembly.groups[block] or assembly.names[block] for block in interfaces.pair[worst])
        raise InputError(
            f"friction {wanted[worst]:g} between {a} and {b}: Bullet multiplies one number a block, and none fit all "
            "joint laws, or all frictions of the interfaces, at once"
        )
    return found


def _logarithms(n: int, pair: np.ndarray, value: Floats) -> Floats:
    """Least-norm x with x_a + x_b = value for every pair, in the sense of least squares."""
    from scipy.sparse import csr_array
    from scipy.sparse.linalg import lsqr

    row = np.repeat(np.arange(len(pair)), 2)
    matrix = csr_array((np.ones(2 * len(pair)), (row, pair.reshape(-1))), shape=(len(pair), n))
    return lsqr(matrix, value, atol=1e-14, btol=1e-14, iter_lim=20 * n)[0]
