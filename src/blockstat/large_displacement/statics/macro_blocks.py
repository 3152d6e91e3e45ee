"""Macro-blocks: groups of blocks that move as one rigid body in a motion, and programs condensed to them."""

from __future__ import annotations

import numpy as np

from blockstat.analysis.problem import Problem
from blockstat.analysis.verdict import relative_motion
from blockstat.large_displacement.displaced.pose import displaced_assembly
from blockstat.large_displacement.displaced.structure import Configuration
from blockstat.program.condensed import Bodies, moving_as_one
from blockstat.typing import Floats, Ints


def macro_blocks_of(configuration: Configuration, motion: Floats, tolerance: float) -> Ints:
    """Return which blocks of a displaced structure move as one rigid body in a motion.

    Parameters
    ----------
    configuration
        The displaced structure.
    motion
        Rates of the blocks about their displaced centroids, shape (n_blocks, 6).
    tolerance
        Joints all of whose points move more slowly than this are at rest. Relative to the fastest point of a joint.

    Returns
    -------
    array of int
        Macro-block of each block, -1 for blocks that do not move, shape (n_blocks,).
    """
    faces, _ = configuration.joints
    assembly = configuration.structure.assembly
    rate = relative_motion(displaced_assembly(assembly, configuration.pose), faces, motion)
    return moving_as_one(assembly.support, faces.pair[faces.point_interface], rate, tolerance)


def common_refinement(one: Ints, other: Ints) -> Ints:
    """Return the macro-blocks of blocks that belong together in both of two partitions.

    Parameters
    ----------
    one, other
        Macro-block of each block, -1 for blocks that do not move, shape (n_blocks,).

    Returns
    -------
    array of int
        The same of the common refinement; -1 where a block moves in neither.
    """
    _, number = np.unique(np.column_stack([one, other]), axis=0, return_inverse=True)
    number = np.where((one < 0) & (other < 0), -1, number.reshape(-1))
    return np.unique(np.append(number, -1), return_inverse=True)[1][:-1] - 1


def condensed(problem: Problem, macro_block: Ints | None) -> Bodies | None:
    """Return the program of a problem condensed to macro-blocks.

    Parameters
    ----------
    problem
        The equilibrium problem.
    macro_block
        Macro-block of each block, -1 for blocks that do not move, shape (n_blocks,).

    Returns
    -------
    Bodies or None
        None where each block is one, or none moves.
    """
    program = problem.program
    if macro_block is None or program is None:
        return None
    own = np.concatenate([[-1], macro_block[problem.eq.blocks]])
    number = np.unique(own, return_inverse=True)[1].reshape(-1)[1:] - 1
    if number.max(initial=-1) < 0:
        return None
    return Bodies(program, number, problem.assembly.centroid[problem.eq.blocks] / program.length_unit)
