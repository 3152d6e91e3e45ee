"""Dynamic verification of masonry in Bullet."""

from dynsim.bonds.stiffness import AngularSprings, InertiaScale
from dynsim.comparison.compare import compare
from dynsim.comparison.table import Comparison, Comparisons
from dynsim.engine.world import World
from dynsim.judge.limit import DynamicLimit, limit
from dynsim.judge.run import Run, simulate
from dynsim.judge.verify import DynamicOutcome, DynamicVerdict, verify
from dynsim.loads.ground import Pulse, Ramp, Record
from dynsim.loads.loading import Constant, Push, Removal, Settlement, Tilt
from dynsim.loads.record import read_record
from dynsim.parallel.pool import run_many, verify_many
from dynsim.settings import Settings
from dynsim.view.export import read_run, write_run

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
