"""Certified rigid-block statics of masonry: does it stand, and which block moves first?

Lengths are in metres, forces in newtons, z is up unless gravity says otherwise.
"""

from blockstat.analysis.assess import assess
from blockstat.analysis.certificate_cache import Memory
from blockstat.analysis.limit_load import LimitLoad, LoadOutcome, limit_load
from blockstat.analysis.thrust import load_domain, settlement, thrust_range
from blockstat.analysis.tilt_friction import friction_limit, tilt_limit
from blockstat.analysis.verdict import Outcome, Verdict
from blockstat.assembly import Assembly, Block, glued
from blockstat.contact.interfaces import Interfaces, find_interfaces
from blockstat.design_search.search import search
from blockstat.errors import InputError, InputWarning
from blockstat.geometry_repair.repair import heal
from blockstat.io.files import write
from blockstat.joint import JointLaw
from blockstat.loads import acceleration, point_load
from blockstat.spec import Building, Composition, build, load_scene, parameters, read, scene_from, with_values
from blockstat.view.attributes import write_verdict
from blockstat.view.three_d.page import show

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
