"""Certified rigid-block statics of masonry: does it stand, and which block moves first?

Lengths are in metres, forces in newtons, z is up unless gravity says otherwise.
"""

from blockstat.analysis import assess
from blockstat.assembly import Assembly, Block
from blockstat.contact import Interfaces, find_interfaces
from blockstat.errors import InputError, InputWarning
from blockstat.io import read, write
from blockstat.io.scene import load_scene
from blockstat.model import build
from blockstat.result import Outcome, Verdict
from blockstat.search import search
from blockstat.spec import Building, parameters, with_values

__version__ = "0.1.0"
__all__ = [
    "Assembly",
    "Block",
    "Building",
    "InputError",
    "InputWarning",
    "Interfaces",
    "Outcome",
    "Verdict",
    "assess",
    "build",
    "find_interfaces",
    "load_scene",
    "parameters",
    "read",
    "search",
    "with_values",
    "write",
]
