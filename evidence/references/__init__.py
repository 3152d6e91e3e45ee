"""Every reference value, with what we compute for it: for the tests, and for the table of docs/validation.md."""

from types import ModuleType

from evidence.references import arches, blocks, energies, laws, walls, wedges

#: Modules with ROWS.
SECTIONS: dict[str, ModuleType] = {
    "One, two, n blocks": blocks,
    "Arches, a barrel and a dome": arches,
    "Walls": walls,
    "Wedges": wedges,
    "Energies": energies,
    "Joint laws": laws,
}
