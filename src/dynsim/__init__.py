"""Dynamic verification of masonry in Bullet."""

from dynsim.compare import compare
from dynsim.comparisons import Comparison, Comparisons
from dynsim.export import read_run, write_run
from dynsim.ground import Pulse, Ramp, Record
from dynsim.limit import DynamicLimit, limit
from dynsim.loading import Constant, Push, Removal, Settlement, Tilt
from dynsim.pool import run_many, verify_many
from dynsim.record import read_record
from dynsim.run import Run, simulate
from dynsim.settings import Settings
from dynsim.stiffness import AngularSprings, InertiaScale
from dynsim.verify import DynamicOutcome, DynamicVerdict, verify
from dynsim.world import World

__all__ = [
    "AngularSprings",
    "Comparison",
    "Comparisons",
    "Constant",
    "DynamicLimit",
    "DynamicOutcome",
    "DynamicVerdict",
    "InertiaScale",
    "Pulse",
    "Push",
    "Ramp",
    "Record",
    "Removal",
    "Run",
    "Settings",
    "Settlement",
    "Tilt",
    "World",
    "compare",
    "limit",
    "read_record",
    "read_run",
    "run_many",
    "simulate",
    "verify",
    "verify_many",
    "write_run",
]
