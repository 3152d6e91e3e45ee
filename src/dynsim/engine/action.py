"""What may act on a world while it runs: a load that changes, a bond, a spring."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

if TYPE_CHECKING:
    from dynsim.engine.world import World


class Action(Protocol):
    """Called by the run; everything it does goes through the world's methods, in the scene's own units.

    An action that must act at every time step makes the run step from Python, a little more slowly.
    """

    @property
    def each_step(self) -> bool:
        """True: `act` comes before every time step; False: before every look."""
        ...

    def begin(self, world: World) -> None:
        """Called once, before settling."""
        ...

    def act(self, world: World, time: float) -> None:
        """Called through settling and the free run; time : since release [s], negative while settling."""
        ...


class Load(Action, Protocol):
    """An action that comes to an end, so that what is left can be judged."""

    @property
    def end(self) -> float:
        """Time since release after which the load no longer changes [s]; -inf for one that is there throughout."""
        ...

    @property
    def travel(self) -> float:
        """How far the load itself carries blocks about [m]: not counted as falling."""
        ...
