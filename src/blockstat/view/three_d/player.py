"""Blocks that move on the page: a mechanism to and fro, or a trajectory played once."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import Any

import numpy as np

from blockstat.typing import Floats
from blockstat.view.painter import posed
from blockstat.view.three_d.page import mechanism_vertices

FRAME = 1 / 12  #: [s] between two pictures
SWING = 3.0  #: [s] of a mechanism, there and back
HOLD = 1.5  #: [s] a trajectory rests at its end before it is over


class Player:
    """Shows vertices as a function of time, a picture at a time.

    Parameters
    ----------
    pose : callable
        Draws vertices, shape (n_vertices, 3) [m].
    """

    def __init__(self, pose: Callable[[Floats], None]) -> None:
        self._pose = pose
        self._film: Callable[[float], Floats] | None = None
        self._seconds = np.inf
        self._began = self._last = 0.0

    @property
    def playing(self) -> bool:
        """Whether a film runs."""
        return self._film is not None

    def play(self, film: Callable[[float], Floats], seconds: float = np.inf) -> None:
        """Show a film until it is over or stopped.

        Parameters
        ----------
        film : callable
            The vertices, shape (n_vertices, 3) [m], as a function of the time since its beginning [s].
        seconds : float, optional
            How long it lasts [s]; by default it has no end.
        """
        self._film, self._seconds, self._began, self._last = film, seconds, monotonic(), -np.inf

    def stop(self) -> None:
        """Stop the film."""
        self._film = None

    def tick(self) -> None:
        """Draw the next picture if it is time for it."""
        now = monotonic()
        if self._film is None or now - self._last < FRAME:
            return
        self._last = now
        time = now - self._began
        film = self._film
        if time > self._seconds:
            self._film, time = None, self._seconds
        self._pose(film(time))


def swing(result: Any, amplitude: float) -> Callable[[float], Floats]:
    """Return the film of a mechanism that goes to and fro.

    Parameters
    ----------
    result : Verdict or LimitLoad
        What has a mechanism.
    amplitude : float
        How far the fastest corner goes [m].

    Returns
    -------
    callable
        The vertices, shape (n_vertices, 3) [m], as a function of time [s].
    """

    def film(time: float) -> Floats:
        return mechanism_vertices(result, (1 - np.cos(2 * np.pi * time / SWING)) / 2, amplitude=amplitude)

    return film


def trajectory(
    assembly: Any, times: Floats, displacement: np.ndarray, rotation: np.ndarray
) -> Callable[[float], Floats]:
    """Return the film of blocks along a trajectory: the last pose at or before each time.

    Parameters
    ----------
    assembly : Assembly
        The blocks.
    times : array of float, shape (n_frames,)
        Of the poses, ascending [s].
    displacement : array of float, shape (n_frames, n_blocks, 3)
        Displacements of the centroids [m].
    rotation : array of float, shape (n_frames, n_blocks, 3, 3)
        Rotation matrices about the centroids.

    Returns
    -------
    callable
        The vertices, shape (n_vertices, 3) [m], as a function of time [s].
    """

    def film(time: float) -> Floats:
        frame = max(int(np.searchsorted(times, time, side="right")) - 1, 0)
        return posed(assembly, displacement[frame], rotation[frame])

    return film
