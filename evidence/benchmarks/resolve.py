"""How often a second the chapel of some 300 blocks is judged again after one parameter moved; prints JSON.

Building the blocks is left out: it counts interfaces, equilibrium, solve and certificate of the rebuilt assembly.
"""

from __future__ import annotations

import json
from collections import defaultdict
from time import process_time

import numpy as np

from blockstat import assess, build, with_values
from blockstat.analysis.certificate_cache import Memory
from blockstat.spec import Building
from evidence.scenes.sized import chapel_scene

BLOCKS = 300
MOVED = "wall.thickness"
REPEATS = 3  #: series of which the fastest counts
VALUES = np.linspace(0.8, 0.6, 21)


def rate() -> dict:
    """Seconds by step, and judgements a second, without and with the evidence of earlier designs."""
    scene = chapel_scene(BLOCKS)
    assess(build(scene))
    fresh = min((_judged(scene, None) for _ in range(REPEATS)), key=lambda found: found["each"])
    remembered = min((_judged(scene, Memory()) for _ in range(REPEATS)), key=lambda found: found["each"])
    rates = {"rate": 1 / fresh.pop("each"), "remembered": 1 / remembered["each"]}
    return {"moved": MOVED, **rates, **fresh, "memory": remembered["memory"]}


def _judged(scene: Building, memory: Memory | None) -> dict:
    """Seconds a design, built anew, and those of its steps."""
    begin = process_time()
    designs = [build(with_values(scene, {MOVED: float(value)})) for value in VALUES]
    building = (process_time() - begin) / len(designs)
    seconds: defaultdict[str, float] = defaultdict(float)
    begin = process_time()
    for design in designs:
        verdict = assess(design, memory=memory)
        for step, value in verdict.timings.items():
            seconds[step] += value
    each = (process_time() - begin) / len(designs)
    steps = {step: value / len(designs) for step, value in seconds.items()}
    statistics = memory.statistics if memory else None
    return {"blocks": designs[0].n_blocks, "build": building, "each": each, "memory": statistics, **steps}


if __name__ == "__main__":
    print(json.dumps(rate()))
