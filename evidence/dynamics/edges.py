"""Bullet's limits on edges and corners beside the exact ones: prints the section that docs/bullet.md has of them.

python -m evidence.dynamics.edges
"""

from __future__ import annotations

import numpy as np

from dynsim import limit
from evidence.scenes.edges import Pushed, references
from evidence.tables import head, row

WIDTH = 0.01  #: of each bracket, relative


def measured(scene: Pushed) -> dict:
    """The exact limit and the bracket in Bullet."""
    found = limit(scene.scene, scene.direction, width=WIDTH, check=False)
    return {"scene": scene.name, "exact": float(scene.limit), "lower": float(found.lower), "upper": float(found.upper),
            "groove": scene.along_groove}  # fmt: skip


def section(found: list[dict]) -> list[str]:
    """Lines of the page."""
    error = {True: [], False: []}
    for r in found:
        error[r["groove"]].append((r["lower"] + r["upper"]) / 2 / r["exact"] - 1)
    worst = 100 * np.abs(error[False]).max()
    lines = [
        "", "## Edges and corners", "",
        "Blocks that touch on edges and corners, with exact limits of a horizontal push "
        "(`python -m evidence.dynamics.edges`). Concave blocks are cut into convex pieces. Bullet finds "
        f"{len(error[False])} of the {len(found)} limits to {worst:.1f} %.", "",
        "It cannot find the limit of a prism that slides along a groove. Bullet bounds the friction of a contact in "
        "two directions at right angles, one of them along the first slip. In the groove that slip is oblique: the "
        "prism settles into the V before it is pushed along it. Then friction is up to sqrt(2) mu, and the prism "
        f"wedges itself. It stands up to {100 * max(error[True]):.1f} % beyond its limit. On a plane the limit of a "
        "block that slides along the push from the first is exact. One that also tips or turns has oblique slips "
        "there, too, and may stand up to sqrt(2) times its limit; the verdict then has a warning ([friction beyond "
        "Coulomb's](dynamics.md)).", "",
        head(["scene", "exact", "Bullet, from", "to", "error"]),
    ]  # fmt: skip
    for r in found:
        middle = (r["lower"] + r["upper"]) / 2
        lines.append(
            row(
                [r["scene"], f"{r['exact']:.4f}", f"{r['lower']:.4f}", f"{r['upper']:.4f}",
                 f"{100 * (middle / r['exact'] - 1):+.1f} %"]
            )
        )  # fmt: skip
    return lines


def rows() -> list[dict]:
    """Every reference, measured."""
    return [measured(scene) for scene in references()]


if __name__ == "__main__":
    print("\n".join(section(rows())))
