"""Form-find the middle surface of examples/canopy.toml by force densities and write it as canopy.obj."""

from pathlib import Path

import numpy as np

CELLS, SPAN, RISE, FOOT = 14, 8.0, 2.4, 2  #: cells a side, side and rise [m], cells that each foot takes of both sides


def surface() -> tuple[np.ndarray, list[list[int]]]:
    """Corners, shape (n, 3) [m], and quadrilaterals of a net in compression over a square, on its four corners."""
    n = CELLS + 1
    place = np.linspace(-SPAN / 2, SPAN / 2, n)
    x, y = (a.ravel() for a in np.meshgrid(place, place, indexing="ij"))
    index = np.arange(n * n).reshape(n, n)
    edges = np.concatenate([np.stack([index[:-1], index[1:]], -1).reshape(-1, 2),
                            np.stack([index[:, :-1], index[:, 1:]], -1).reshape(-1, 2)])  # fmt: skip
    rim = (np.abs(np.column_stack([x, y])) > SPAN / 2 - 1e-9)[edges].all(axis=1).any(axis=1)
    density = np.where(rim, 3.0, 1.0)  # stronger edges span between the feet
    near = SPAN / 2 - FOOT * SPAN / CELLS - 1e-9
    corner = (np.abs(x) > near) & (np.abs(y) > near)
    fixed = (
        corner
        & (np.abs(x) + np.abs(y) > SPAN / 2 + near - 1e-9)
        & ((np.abs(x) > SPAN / 2 - 1e-9) | (np.abs(y) > SPAN / 2 - 1e-9))
    )
    # Schek (1974): C' Q C z = p, horizontal positions kept.
    laplace = np.zeros((n * n, n * n))
    for (a, b), q in zip(edges, density, strict=True):
        laplace[[a, b], [a, b]] += q
        laplace[[a, b], [b, a]] -= q
    free = ~fixed
    z = np.zeros(n * n)
    z[free] = np.linalg.solve(laplace[np.ix_(free, free)], np.ones(free.sum()))
    z *= RISE / z.max()
    quads = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    kept = [list(map(int, quad)) for quad in quads if z[quad].max() > 1e-9]
    return np.column_stack([x, y, z]), kept


def main() -> None:
    corners, faces = surface()
    lines = ["# middle surface of canopy.toml, metres, z up; made by canopy.py"]
    lines += ["v " + " ".join(f"{c:.9g}" for c in corner) for corner in corners]
    lines += ["f " + " ".join(str(k + 1) for k in face) for face in faces]
    Path(__file__).with_suffix(".obj").write_text("\n".join(lines) + "\n")
    print(f"{len(faces)} faces")


if __name__ == "__main__":
    main()
