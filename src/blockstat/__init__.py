"""Certified rigid-block statics of masonry."""

from blockstat.analysis import assess
from blockstat.assembly import Assembly, Block
from blockstat.contact import Interfaces, find_interfaces
from blockstat.errors import InputError, InputWarning
from blockstat.result import Outcome, Verdict

__version__ = "0.1.0"
__all__ = ["Assembly", "Block", "InputError", "InputWarning", "Interfaces", "Outcome", "Verdict", "assess", "find_interfaces"]
