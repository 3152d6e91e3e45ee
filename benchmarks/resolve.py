"""How often a second the chapel of some 300 blocks is judged again after one parameter moved; prints JSON.

Building the blocks is left out: it counts interfaces, equilibrium, solve and certificate of the rebuilt assembly.
"""

from __future__ import annotations

import json
from collections import defaultdict
from time import process_time

import numpy as np
from scenes import chapel_scene

from blockstat import assess, build, with_values

BLOCKS = 300
MOVED = "wall.thickness"
VALUES = np.linspace(0.8, 0.6, 21)


def rate() -> dict:
    """Seconds by step, and judgements a second."""
    scene = chapel_scene(BLOCKS)
    assess(build(scene))
    seconds: defaultdict[str, float] = defaultdict(float)
    verdict = None
    for value in VALUES:
        begin = process_time()
        assembly = build(with_values(scene, {MOVED: float(value)}))
        seconds["build"] += process_time() - begin
        begin = process_time()
        verdict = assess(assembly)
        seconds["assess"] += process_time() - begin
        for step in ("interfaces", "equilibrium", "solve", "certificate"):
            seconds[step] += verdict.timings[step]
    assert verdict is not None
    mean = {step: value / len(VALUES) for step, value in seconds.items()}
    return {"blocks": assembly.n_blocks, "moved": MOVED, "rate": 1.0 / mean["assess"], "solver": verdict.solver, **mean}


if __name__ == "__main__":
    print(json.dumps(rate()))
