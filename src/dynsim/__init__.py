"""Dynamic verification of masonry in Bullet: simulate rigid blocks, and judge how far they move.

Lengths are in metres, forces in newtons, times in seconds of the scene.

A room is imported when one of its names is first asked for, so that SIGINT can be heeded before anything else is done.
"""

from blockstat.system.on_demand import on_demand

TYPE_CHECKING = False  # as typing has it, which takes longer to import than all of this module
if TYPE_CHECKING:
    from dynsim.bonds.glue import bonds_of
    from dynsim.bonds.stiffness import AngularSprings, InertiaScale
    from dynsim.comparison.causes import Cause, find_cause, likely_reason
    from dynsim.comparison.compare import compare
    from dynsim.comparison.first_motion import first_motion_cosine
    from dynsim.comparison.table import Agreement, Comparison, Comparisons
    from dynsim.design_search.buttress_loop import ButtressOutcome, ButtressResult, ButtressStep, buttress_loop
    from dynsim.design_search.optimise import optimise
    from dynsim.earthquake.analysis import IncrementalAnalysis, IncrementalCurve, IncrementalOutcome, incremental
    from dynsim.earthquake.fragility import Fragility, FragilityOutcome, fit_fragility
    from dynsim.earthquake.runs import ScaledRun
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
    from dynsim.view.earthquake import plot_incremental
    from dynsim.view.export import read_run, write_run
    from dynsim.view.film import film_strip, past_verdict, write_movie

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
    "Fragility",
    "FragilityOutcome",
    "IncrementalAnalysis",
    "IncrementalCurve",
    "IncrementalOutcome",
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
    "ScaledRun",
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
    "fit_fragility",
    "group_box_centre",
    "incremental",
    "likely_reason",
    "limit",
    "optimise",
    "past_verdict",
    "plot_incremental",
    "read_record",
    "read_run",
    "run_many",
    "sequence",
    "simulate",
    "verify",
    "verify_many",
    "write_movie",
    "write_run",
]

#: The module of each name.
_HOMES = {
    name: module
    for module, names in {
        "bonds.glue": "bonds_of",
        "bonds.stiffness": "AngularSprings InertiaScale",
        "comparison.causes": "Cause find_cause likely_reason",
        "comparison.compare": "compare",
        "comparison.first_motion": "first_motion_cosine",
        "comparison.table": "Agreement Comparison Comparisons",
        "design_search.buttress_loop": "ButtressOutcome ButtressResult ButtressStep buttress_loop",
        "design_search.optimise": "optimise",
        "earthquake.analysis": "IncrementalAnalysis IncrementalCurve IncrementalOutcome incremental",
        "earthquake.fragility": "Fragility FragilityOutcome fit_fragility",
        "earthquake.runs": "ScaledRun",
        "engine.world": "Action World",
        "judge.cracks": "CrackOutcome Cracks find_cracks",
        "judge.criteria": "drops group_box_centre",
        "judge.limit": "DynamicLimit LimitOutcome Trial limit",
        "judge.replay": "DynamicSequence StepRun sequence",
        "judge.run": "Contacts Run simulate",
        "judge.verdict": "DynamicOutcome DynamicVerdict",
        "judge.verify": "verify",
        "loads.ground": "Pulse Ramp Record",
        "loads.load": "Load",
        "loads.loading": "Constant Push Removal Settlement Tilt",
        "loads.record": "read_record",
        "parallel.pool": "Row Rows run_many verify_many",
        "parallel.speculative": "SpeculativeRuns",
        "settings": "PRESETS Settings",
        "view.earthquake": "plot_incremental",
        "view.export": "read_run write_run",
        "view.film": "film_strip past_verdict write_movie",
    }.items()
    for name in names.split()
}
__getattr__ = on_demand(__name__, _HOMES, globals())


def __dir__() -> list[str]:
    return sorted({*globals(), *__all__})
