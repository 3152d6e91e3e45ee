"""Write tests/long_tests.txt: the tests that take most of the time of `make test-all`, which `make test` leaves out.

    python -m pytest -n 2 --durations=0 --durations-min=0.1 tests | python extras/long_tests.py

The list is made so that the tests that are left take a third of the time. Of a test of several cases the quickest one
stays, unless it takes long, too. Times are shares of one run, whatever the machine.
"""

from __future__ import annotations

import re
import sys
from collections import defaultdict
from collections.abc import Iterable, Mapping
from pathlib import Path

LIST = Path(__file__).parents[1] / "tests" / "long_tests.txt"
LINE = re.compile(r"([\d.]+)s +(?:call|setup|teardown) +(\S.*)")
SHARE = 1 / 3  #: of the time, that is left
#: The quickest case of a test stays if it takes no more than this, relative to the quickest case that goes.
QUICKEST = 5 / 3


def times(lines: Iterable[str]) -> dict[str, float]:
    """Seconds that each test takes, its fixtures included."""
    found: dict[str, float] = defaultdict(float)
    for line in lines:
        if match := LINE.match(line):
            found[match[2].strip()] += float(match[1])
    return dict(found)


def longest(taken: Mapping[str, float], limit: float) -> list[str]:
    """The tests that take a limit or more."""
    cases = defaultdict(list)
    for name in taken:
        cases[name.split("[")[0]].append(name)
    found = []
    for own in cases.values():
        quickest = min(own, key=lambda name: taken[name])
        spared = quickest if taken[quickest] <= QUICKEST * limit else None
        found += [name for name in own if taken[name] >= limit and name != spared]
    return found


def chosen(taken: Mapping[str, float]) -> list[str]:
    """The longest tests, so that the others take a third of the time."""
    whole = sum(taken.values())
    for limit in sorted(taken.values(), reverse=True):
        found = longest(taken, limit)
        if sum(taken[name] for name in found) >= (1 - SHARE) * whole:
            return sorted(found)
    return sorted(taken)


if __name__ == "__main__":
    LIST.write_text("".join(f"{name}\n" for name in chosen(times(sys.stdin))))
