"""How often a second the chapel of some 300 blocks is judged again after one parameter moved; prints JSON.

Building the blocks is left out: it counts interfaces, equilibrium, solve and certificate of the rebuilt assembly.
"""

from __future__ import annotations

import json
from collections import defaultdict
from time import process_time

import numpy as np
from scenes import chapel_scene

from blockstat import Assembly, assess, build, with_values
from blockstat.reuse import Memory

BLOCKS = 300
MOVED = "wall.thickness"
VALUES = np.linspace(0.8, 0.6, 21)


def rate() -> dict:
    """Seconds by step, and judgements a second, without and with the evidence of earlier designs."""
    scene = chapel_scene(BLOCKS)
    assess(build(scene))
    begin = process_time()
    designs = [build(with_values(scene, {MOVED: float(value)})) for value in VALUES]
    building = (process_time() - begin) / len(designs)
    seconds: defaultdict[str, float] = defaultdict(float)
    fresh = _judged(designs, None, seconds)
    memory = Memory()
    remembered = _judged(designs, memory, defaultdict(float))
    return {
        "blocks": designs[0].n_blocks, "moved": MOVED, "build": building,
        "rate": 1 / fresh, "remembered": 1 / remembered,
        **{step: value / len(designs) for step, value in seconds.items()}, "memory": memory.statistics,
    }  # fmt: skip


def _judged(designs: list[Assembly], memory: Memory | None, seconds: defaultdict[str, float]) -> float:
    """Seconds a design; those of its steps are added up."""
    begin = process_time()
    for design in designs:
        verdict = assess(design, memory=memory)
        for step, value in verdict.timings.items():
            seconds[step] += value
    return (process_time() - begin) / len(designs)


if __name__ == "__main__":
    print(json.dumps(rate()))
