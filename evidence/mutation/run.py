"""Put small bugs into the source, one at a time, and count those that a test notices: `make mutants`.

    python -m evidence.mutation.run [--sample 300] [--seed 1] [--jobs 2] [--seconds 60] [--minutes 110] [--again]

What has been judged is kept in out/mutation, and a second run goes on where the first one ended. `--again` judges the
survivors anew, after tests were added. The extra "mutation" has what it needs.
"""

from __future__ import annotations

import argparse
import hashlib
import json
from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict
from pathlib import Path
from threading import Lock
from time import time

import tomllib

from evidence.mutation.judge import KILLED, UNREACHED, Judgement, Jury
from evidence.mutation.mutations import ROOMS, Mutation, files, sample
from evidence.mutation.reach import OUT, reach, test_files
from evidence.run.stamps import measured_now
from evidence.tables import table

EQUIVALENTS = Path(__file__).with_name("equivalents.toml")
HEAD = """# Tests that catch

This page is printed by `make mutants`. It puts small bugs into the source, one at a time: another operator, another
number, a condition turned round, a loop that does not run. A mutant is killed when a test fails that passes without it.
The mutations are those of [Cosmic Ray](https://cosmic-ray.readthedocs.io). The sample is random: each place in the
source is as likely as any other, and gets one of its mutations. Arithmetic is replaced by arithmetic and bits by bits,
as what cannot run is killed by any test. Coverage says which tests reach a line, but not in processes that tests start.
They run in the order of their time, up to {seconds:g} s of tests a mutant. A mutant that takes five times as long
hangs, and counts as killed. "At first sight" is what the tests killed before any was written for a survivor of the
sample: it says how the tests do on mutants that nobody has looked at.

[Equivalent mutants](mutants_equivalent.md) do nothing, so no test can notice them. That page has each of them with the
reason.

The tables below are of {tests} tests in {files} of {all} test files. `make mutants SEED=2` takes another sample.
"""
EQUIVALENT_HEAD = """# Equivalent mutants

This page is printed by `make mutants`. These mutants of [the samples](mutants.md) survive, because they do nothing.
Each has its reason (`evidence/mutation/equivalents.toml`), its place in `src` and the number of tests that reach it.
"""


def main() -> None:
    parser = argparse.ArgumentParser(
        prog="python -m evidence.mutation.run",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--sample", type=int, default=300, help="how many mutants")
    parser.add_argument("--seed", type=int, nargs="+", default=[1], help="of the sample; several for a table of each")
    parser.add_argument("--jobs", type=int, default=2, help="mutants at a time")
    parser.add_argument("--seconds", type=float, default=60.0, help="of tests a mutant at most")
    parser.add_argument("--minutes", type=float, default=110.0, help="no mutant begins later than this")
    parser.add_argument("--rooms", nargs="+", default=ROOMS, choices=ROOMS, metavar="ROOM", help=", ".join(ROOMS))
    parser.add_argument("--tests", type=Path, nargs="+", metavar="FILE", help="these test files alone; by default all")
    parser.add_argument("--again", action="store_true", help="judge the survivors anew that are not equivalent")
    parser.add_argument("--write", type=Path, metavar="FILE", help="put the page here")
    options = parser.parse_args()
    paths = [path.resolve() for path in options.tests] if options.tests else test_files()
    tests = reach(paths, options.jobs)
    jury = Jury(tests, options.seconds)
    kept = Kept(again=options.again)
    begin = time()

    def one(mutation: Mutation) -> Judgement | None:
        if mutation.key not in kept.found and time() - begin < 60 * options.minutes:
            kept.add(jury.judge(mutation))
        return kept.found.get(mutation.key)

    used = sum(seconds >= 0 for seconds in tests.seconds.values())
    parts = [HEAD.format(seconds=options.seconds, tests=used, files=len(paths), all=len(test_files()))]
    judged: list[Judgement] = []
    for seed in options.seed:
        with ThreadPoolExecutor(options.jobs) as pool:
            found = [result for result in pool.map(one, sample(options.sample, seed, options.rooms)) if result]
        parts.append(page(found, options.sample, seed, equivalents(), kept.first))
        judged += found
    text, same = "\n".join(parts), equivalents_page(judged, equivalents())
    print(text, same, sep="\n")
    if options.write:
        foot = f"\n{measured_now()}\n"
        options.write.write_text(text + foot)
        options.write.with_stem(f"{options.write.stem}_equivalent").write_text(same + foot)


class Kept:
    """The judgements of the source as it is, in a file of one line each."""

    def __init__(self, *, again: bool) -> None:
        state = hashlib.sha256(b"".join(path.read_bytes() for path in files())).hexdigest()[:12]
        self._path, self._lock = OUT / f"judged.{state}.jsonl", Lock()
        lines = self._path.read_text().splitlines() if self._path.is_file() else []
        rows = [Judgement(**json.loads(line)) for line in lines]
        #: judgements by the key of the mutation, the last one of each and the first one
        self.found = {row.key: row for row in rows}
        self.first = {row.key: row for row in reversed(rows)}
        if again:
            known = equivalents()
            self.found = {key: row for key, row in self.found.items() if row.outcome == KILLED or _named(row) in known}

    def add(self, row: Judgement) -> None:
        """Keep a judgement."""
        with self._lock:
            self.found[row.key] = row
            self.first.setdefault(row.key, row)
            with self._path.open("a") as file:
                file.write(json.dumps(asdict(row)) + "\n")
        print(f"{row.outcome:9} {row.key} ({row.seconds:.0f} s)\n", end="", flush=True)


def equivalents(path: Path = EQUIVALENTS) -> dict[tuple[str, str, str], str]:
    """Reasons why mutants do nothing, by the file, the lines before and those after."""
    return {
        (row["file"], row["before"].strip(), row["after"].strip()): row["reason"]
        for row in tomllib.loads(path.read_text())["equivalent"]
    }


def page(
    found: Sequence[Judgement],
    asked: int,
    seed: int,
    known: Mapping[tuple[str, str, str], str],
    first: Mapping[str, Judgement],
) -> str:
    """The table of a sample by room, and the survivors as diffs that are not equivalent.

    `first` are the first judgements by the key of the mutation, for those that were judged again.
    """
    same = [row for row in found if row.outcome != KILLED and _named(row) in known]
    left = [row for row in found if row.outcome != KILLED and _named(row) not in known]
    rooms = [room for room in ROOMS if any(row.room == room for row in found)]
    rows = [_counts(f"`{room}`", [row for row in found if row.room == room], same, first) for room in rooms]
    names = [
        "room", "mutants", "killed", "survived", "no test reaches it", "equivalent", "killed of the others",
        "at first sight",
    ]  # fmt: skip
    text = f"## Sample {seed}\n\n{len(found)} of {asked} mutants were judged.\n\n"
    text += table(names, [*rows, _counts("all", found, same, first)]) + "\n"
    if left:
        text += f"\n### Survivors of sample {seed}\n" + "".join(f"\n{_diff(row)}" for row in left)
    return text


def equivalents_page(found: Sequence[Judgement], known: Mapping[tuple[str, str, str], str]) -> str:
    """The equivalent mutants as diffs, those of one reason together."""
    reasons: dict[str, list[Judgement]] = {}
    for row in {row.key: row for row in found}.values():  # two samples may share some
        if row.outcome != KILLED and _named(row) in known:
            reasons.setdefault(known[_named(row)], []).append(row)
    parts = [EQUIVALENT_HEAD]
    for reason, rows in reasons.items():
        diffs = "\n".join(f"@@ {_place(row)}; {_reached(row)} @@\n{_changed(row)}" for row in rows)
        parts.append(f"{reason}\n\n```diff\n{diffs}\n```\n")
    return "\n".join(parts)


def _named(row: Judgement) -> tuple[str, str, str]:
    """What an equivalent mutant is found by."""
    return row.key.split(":")[0], row.before, row.after


def _counts(
    name: str, rows: Sequence[Judgement], same: Iterable[Judgement], first: Mapping[str, Judgement]
) -> list[object]:
    killed = sum(row.outcome == KILLED for row in rows)
    at_once = sum(first.get(row.key, row).outcome == KILLED for row in rows)
    equal = sum(row in same for row in rows)
    unreached = sum(row.outcome == UNREACHED and row not in same for row in rows)
    others = len(rows) - equal
    shares = [f"{100 * number / others:.1f} %" if others else "-" for number in (killed, at_once)]
    return [name, len(rows), killed, others - killed - unreached, unreached, equal, *shares]


def _diff(row: Judgement) -> str:
    name, line = _place(row).split(", ")
    return f"`{name}`, {line}; {_reached(row)}:\n\n```diff\n{_changed(row)}\n```\n"


def _place(row: Judgement) -> str:
    return f"{row.key.split(':')[0]}, line {row.line}"


def _reached(row: Judgement) -> str:
    return f"{row.tests} tests reach it, {row.tried} were run" if row.tests else "no test reaches it"


def _changed(row: Judgement) -> str:
    return "\n".join([f"-{line}" for line in row.before.splitlines()] + [f"+{line}" for line in row.after.splitlines()])


if __name__ == "__main__":
    main()
