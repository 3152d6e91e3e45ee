"""A waving vault from a height function."""

import numpy as np

from blockstat import assess
from blockstat.model import assemble, freeform, height_field


def height(x, y):
    """A barrel 4 m wide whose crown waves along x [m]."""
    return (1.6 + 0.2 * np.sin(1.5 * x)) * (1 - (y / 2) ** 4)


def main() -> None:
    points = height_field(height, x=(-3, 3), y=(-2, 2), courses=13, voussoirs=8)
    for thickness in (0.05, 0.15, 0.35):
        verdict = assess(assemble(freeform(points, thickness=thickness, springers=0.4)))
        print(
            f"{thickness:.2f} m: {verdict.assembly.n_blocks} blocks, {verdict.interfaces.n_interfaces} interfaces, "
            f"{verdict.outcome.word}"
        )


if __name__ == "__main__":
    main()
