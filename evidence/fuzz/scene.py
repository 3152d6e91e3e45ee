"""A random scene: solids in local coordinates for the judge, and the assembly at another place for the statics."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from blockstat import Assembly, Block, JointLaw
from evidence.fuzz.solids import Array, Solid


@dataclass(frozen=True)
class Place:
    """Where the statics see a scene: turned, scaled, shifted, its blocks in another order."""

    turn: Array = field(default_factory=lambda: np.eye(3))
    scale: float = 1.0
    shift: Array = field(default_factory=lambda: np.zeros(3))
    order: tuple[int, ...] | None = None


@dataclass(frozen=True)
class Scene:
    """Solids with supports, densities, friction and gravity, in coordinates about a local origin."""

    family: str
    solids: tuple[Solid, ...]
    support: tuple[bool, ...]
    density: tuple[float, ...]
    friction: float
    gravity: Array
    place: Place = field(default_factory=Place)
    sheets: tuple[int, ...] = ()  #: blocks with another friction on all their joints
    sheet_friction: float = 0.0

    def friction_of(self, pair: Array) -> Array:
        """Coefficient of friction between blocks, pair : shape (n, 2)."""
        slips = np.isin(pair, self.sheets).any(axis=1)
        return np.where(slips, self.sheet_friction, self.friction)

    @property
    def weights(self) -> Array:
        """Of each block [N], supports included."""
        return np.array([s.volume * d for s, d in zip(self.solids, self.density, strict=True)]) * np.linalg.norm(
            self.gravity
        )

    def assembly(self, place: Place | None = None) -> Assembly:
        """The assembly that the statics are given."""
        place = self.place if place is None else place
        order: Sequence[int] = range(len(self.solids)) if place.order is None else place.order
        blocks = [
            Block(
                place.scale * self.solids[i].vertices @ place.turn.T + place.shift,
                self.solids[i].faces,
                name=f"{i}",
                group="sheet" if i in self.sheets else "stone",
                density=self.density[i],
            )
            for i in order
        ]
        return Assembly.from_blocks(
            blocks,
            supports=[f"{i}" for i in order if self.support[i]],
            name=self.family,
            friction=self.friction,
            gravity=(place.turn @ self.gravity).tolist(),
            joints=[JointLaw(("sheet", "*"), friction=self.sheet_friction)] if self.sheets else [],
        )
