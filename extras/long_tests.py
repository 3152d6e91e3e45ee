"""Write tests/long_tests.txt, the tests that `make test` leaves out beside those marked slow.

    python -m pytest -n 2 -m "not slow" --durations=0 --durations-min=0.1 | python extras/long_tests.py

They are the longest, so that those that are left take a third of the time. Of a test of several cases the quickest one
stays. Times are shares of one run, whatever the machine.
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
#: Tests that stay whatever they take: they ask most of the whole.
KEPT = (
    "test_every_case_gets_the_expected_static_verdict",
    "test_the_search_prunes_verifies_and_confirms",
    "test_verify_on_the_command_line",
    "test_the_walk_goes_from_the_scene_to_the_verdict",
    "test_the_blocks_of_a_page_are_the_results",
)


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
    spared = {min(own, key=lambda name: taken[name]) for own in cases.values() if len(own) > 1}
    spared |= {name for test, own in cases.items() if test.endswith(KEPT) for name in own}
    return [name for name, seconds in taken.items() if seconds >= limit and name not in spared]


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
