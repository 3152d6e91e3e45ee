"""Dynamic verification of masonry in Bullet: simulate rigid blocks, and judge how far they move.

Lengths are in metres, forces in newtons, times in seconds of the scene.
"""

from dynsim.bonds.glue import bonds_of
from dynsim.bonds.stiffness import AngularSprings, InertiaScale
from dynsim.comparison.causes import Cause, find_cause, likely_reason
from dynsim.comparison.compare import compare
from dynsim.comparison.first_motion import first_motion_cosine
from dynsim.comparison.table import Agreement, Comparison, Comparisons
from dynsim.design_search.buttress_loop import ButtressOutcome, ButtressResult, ButtressStep, buttress_loop
from dynsim.design_search.optimise import optimise
from dynsim.engine.world import Action, World
from dynsim.judge.cracks import CrackOutcome, Cracks, find_cracks
from dynsim.judge.criteria import drops, group_box_centre
from dynsim.judge.limit import DynamicLimit, LimitOutcome, Trial, limit
from dynsim.judge.replay import DynamicSequence, StepRun, sequence
from dynsim.judge.run import Contacts, Run, simulate
from dynsim.judge.verdict import DynamicOutcome, DynamicVerdict
from dynsim.judge.verify import verify
from dynsim.loads.ground import Pulse, Ramp, Record
from dynsim.loads.load import Load
from dynsim.loads.loading import Constant, Push, Removal, Settlement, Tilt
from dynsim.loads.record import read_record
from dynsim.parallel.pool import Row, Rows, run_many, verify_many
from dynsim.parallel.speculative import SpeculativeRuns
from dynsim.settings import PRESETS, Settings
from dynsim.view.export import read_run, write_run
from dynsim.view.film import film_strip

__all__ = [
    "PRESETS",
    "Action",
    "Agreement",
    "AngularSprings",
    "ButtressOutcome",
    "ButtressResult",
    "ButtressStep",
    "Cause",
    "Comparison",
    "Comparisons",
    "Constant",
    "Contacts",
    "CrackOutcome",
    "Cracks",
    "DynamicLimit",
    "DynamicOutcome",
    "DynamicSequence",
    "DynamicVerdict",
    "InertiaScale",
    "LimitOutcome",
    "Load",
    "Pulse",
    "Push",
    "Ramp",
    "Record",
    "Removal",
    "Row",
    "Rows",
    "Run",
    "Settings",
    "Settlement",
    "SpeculativeRuns",
    "StepRun",
    "Tilt",
    "Trial",
    "World",
    "bonds_of",
    "buttress_loop",
    "compare",
    "drops",
    "film_strip",
    "find_cause",
    "find_cracks",
    "first_motion_cosine",
    "group_box_centre",
    "likely_reason",
    "limit",
    "optimise",
    "read_record",
    "read_run",
    "run_many",
    "sequence",
    "simulate",
    "verify",
    "verify_many",
    "write_run",
]
