"""What statics prove about an assembly, and how much a run then has to resolve."""

from __future__ import annotations

from functools import cached_property

from blockstat.analysis.assess import assess
from blockstat.analysis.limit_load import limit_load
from blockstat.analysis.verdict import Outcome
from blockstat.assembly import Assembly
from blockstat.contact.interfaces import Interfaces
from blockstat.studies.directions import horizontal

#: Bullet's own error of limits, as a share of the weight (docs/bullet.md): what has more reserve does not fall by it.
OWN_ERROR = 0.02
#: Resolution of a run where statics do not prove that much.
FINE = 1e-4
#: Relative width of the brackets of the sideways limits.
TOLERANCE = 1e-2


class StaticReserve:
    """Two facts about an assembly under its weight, each found when it is first asked for."""

    def __init__(self, assembly: Assembly, interfaces: Interfaces) -> None:
        self._assembly, self._interfaces = assembly, interfaces

    @cached_property
    def equilibrium(self) -> bool:
        """Whether there is a certified equilibrium with Coulomb friction."""
        return assess(self._assembly, flow="coulomb", interfaces=self._interfaces).outcome is Outcome.STABLE

    @cached_property
    def sideways(self) -> float:
        """Least horizontal acceleration [g] that force fields carry towards +x, -x, +y and -y."""
        least = float("inf")
        for axis in horizontal(self._assembly):
            for direction in (axis, -axis):
                found = limit_load(self._assembly, direction, interfaces=self._interfaces, tolerance=TOLERANCE)
                least = min(least, found.lower)
        return least

    def resolution(self, asked: float) -> float:
        """Return the imbalance that a run has to be able to see.

        Parameters
        ----------
        asked : float
            What was asked for, as a share of the weight.

        Returns
        -------
        float
            The same where an equilibrium with Coulomb friction is proven and the reserve to the sides exceeds Bullet's
            own error, so that a slow collapse is excluded by statics; at most `FINE` elsewhere.
        """
        return asked if self.sideways >= OWN_ERROR and self.equilibrium else min(asked, FINE)
