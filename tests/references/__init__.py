"""Every reference value, with what we compute for it: tests, and the table of docs/validation.md."""

from references import arches, blocks, energies, laws, walls, wedges
from references.row import Row

SECTIONS: dict[str, list[Row]] = {
    "One, two, n blocks": blocks.ROWS,
    "Arches, a barrel and a dome": arches.ROWS,
    "Walls": walls.ROWS,
    "Wedges": wedges.ROWS,
    "Energies": energies.ROWS,
    "Joint laws": laws.ROWS,
}
