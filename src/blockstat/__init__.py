"""Certified rigid-block statics of masonry: does it stand, and which block moves first?

Lengths are in metres, forces in newtons, z is up unless gravity says otherwise.
"""

from blockstat.analysis import assess
from blockstat.assembly import Assembly, Block
from blockstat.contact import Interfaces, find_interfaces
from blockstat.errors import InputError, InputWarning
from blockstat.export import write_verdict
from blockstat.heal import heal
from blockstat.io import read, write
from blockstat.io.scene import load_scene
from blockstat.joint import JointLaw, glued
from blockstat.limit import LimitLoad, LoadOutcome, limit_load
from blockstat.load import acceleration, point_load
from blockstat.model import build
from blockstat.reserve import friction_limit, tilt_limit
from blockstat.result import Outcome, Verdict
from blockstat.reuse import Memory
from blockstat.search import search
from blockstat.spec import Building, Composition, parameters, scene_from, with_values
from blockstat.thrust import load_domain, settlement, thrust_range
from blockstat.view3d.page import show

__version__ = "0.1.0"
__all__ = [
    "Assembly",
    "Block",
    "Building",
    "Composition",
    "InputError",
    "InputWarning",
    "Interfaces",
    "JointLaw",
    "LimitLoad",
    "LoadOutcome",
    "Memory",
    "Outcome",
    "Verdict",
    "acceleration",
    "assess",
    "build",
    "find_interfaces",
    "friction_limit",
    "glued",
    "heal",
    "limit_load",
    "load_domain",
    "load_scene",
    "parameters",
    "point_load",
    "read",
    "scene_from",
    "search",
    "settlement",
    "show",
    "thrust_range",
    "tilt_limit",
    "with_values",
    "write",
    "write_verdict",
]
