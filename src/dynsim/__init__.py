"""Dynamic verification of masonry in Bullet."""

from dynsim.run import Run, simulate
from dynsim.settings import Settings
from dynsim.stiffness import AngularSprings, InertiaScale
from dynsim.verify import DynamicOutcome, DynamicVerdict, verify
from dynsim.world import World

__all__ = [
    "AngularSprings",
    "DynamicOutcome",
    "DynamicVerdict",
    "InertiaScale",
    "Run",
    "Settings",
    "World",
    "simulate",
    "verify",
]
