"""Bullet against LMGC90 (non-smooth contact dynamics) on convex assemblies: a second oracle.

    python -m evidence.dynamics.lmgc90 [--python PYTHON] [FILE ...]

LMGC90 comes with `pip install compas_lmgc90` in an environment of its own; `--python` names the Python of it. Without
one there is nothing to compare with and nothing is done. Files are compared as they are; without files, walls pushed
in their plane near the limit without dilatancy.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
from pathlib import Path

import numpy as np

from blockstat import read
from dynsim import verify
from evidence.references.dynamics import wall

STEP, DURATION = 2e-3, 2.0
FACTORS = (0.94, 0.97, 0.99, 1.01, 1.03, 1.06)

#: Run by the other Python: a scene on standard input, displacements [m] on standard output.
CHILD = """
import json, os, sys
import numpy as np
scene = json.load(sys.stdin)
out = os.dup(1)
os.dup2(2, 1)  # its Fortran talks
from compas_lmgc90.solver import Solver
solver = Solver(dt=scene["step"])
solver.geometry_from_v_f(scene["blocks"], density=scene["density"])
for block, fixed in enumerate(scene["supports"]):
    if fixed:
        solver.v_drvdof[block] = {freedom: np.zeros(6) for freedom in range(1, 7)}
solver.contact_law("IQS_CLB", scene["friction"], alert=scene["alert"])
solver.preprocess()
middle = lambda: np.array([np.mean(list(map(list, (m.vertex_coordinates(v) for v in m.vertices()))), axis=0)
                           for m in solver.trimeshes])
solver.run(nb_steps=1)
start = middle()
solver.run(nb_steps=scene["steps"])
moved = np.linalg.norm(middle() - start, axis=1)
os.write(out, json.dumps(moved.tolist()).encode())
"""


def lmgc90(python: str, asm) -> float | None:
    """Largest displacement after two seconds [m]; None where it gave no answer. Its gravity is 9.81 m/s2 down -z."""
    down = asm.gravity / np.linalg.norm(asm.gravity)
    rotation = _turn(down, np.array([0.0, 0.0, -1.0]))
    blocks = [
        {
            "vertices": (asm.block_vertices(b) @ rotation.T).tolist(),
            "faces": [list(map(int, f)) for f in asm.faces_of(b)],
        }
        for b in range(asm.n_blocks)
    ]
    scene = {
        "blocks": blocks, "supports": asm.support.tolist(), "friction": float(asm.friction), "step": STEP,
        "density": asm.density.tolist(), "steps": round(DURATION / STEP), "alert": 0.01 * float(np.median(asm.size)),
    }  # fmt: skip
    answer = subprocess.run([python, "-c", CHILD], input=json.dumps(scene), capture_output=True, text=True)
    return max(json.loads(answer.stdout)) if answer.returncode == 0 and answer.stdout else None


def _turn(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    from scipy.spatial.transform import Rotation

    axis = np.cross(a, b)
    sine = np.linalg.norm(axis)
    if sine < 1e-12:
        return np.eye(3) if a @ b > 0 else Rotation.from_rotvec([np.pi, 0, 0]).as_matrix()
    return Rotation.from_rotvec(axis / sine * np.arctan2(sine, a @ b)).as_matrix()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("files", nargs="*", type=Path, help="assemblies of convex blocks")
    parser.add_argument("--python", help="Python that has compas_lmgc90")
    options = parser.parse_args()
    if options.python is None or subprocess.run([options.python, "-c", "import compas_lmgc90"]).returncode:
        print("no Python with compas_lmgc90 (--python); nothing to compare with", file=sys.stderr)
        return
    scenes = {file.stem: read(file) for file in options.files}
    if not scenes:
        scenes = {f"wall of 8 x 4 in plane, {factor}": wall(8, factor) for factor in FACTORS}
    print(f"{'scene':34} {'blocks':>6} {'LMGC90 mm':>10} {'Bullet mm':>10}  Bullet")
    for name, asm in scenes.items():
        verdict = verify(asm)
        other = lmgc90(options.python, asm)
        text = "-" if other is None else f"{1e3 * other:.3g}"
        print(
            f"{name:34} {asm.n_blocks:6} {text:>10} {1e3 * verdict.max_displacement:10.3g}  {verdict.outcome.word}",
            flush=True,
        )


if __name__ == "__main__":
    main()
