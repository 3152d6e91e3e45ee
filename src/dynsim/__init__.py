"""Dynamic verification of masonry in Bullet."""

from dynsim.run import Run, simulate
from dynsim.settings import Settings
from dynsim.verify import DynamicOutcome, DynamicVerdict, verify
from dynsim.world import World

__all__ = ["DynamicOutcome", "DynamicVerdict", "Run", "Settings", "World", "simulate", "verify"]
