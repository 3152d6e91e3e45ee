"""Proof files of all reference values, shared cases and the chapel, checked by extras/check_proof.py; size and seconds.

    python -m evidence.checks.proofs [--only rows cases sizes] [--largest BLOCKS] [--write docs/results/proofs.md]

A reference value is taken for proved if each kind of answer that its computation gave (stable, unstable, a bracket) has
an accepted proof: of the answer nearest the value that has one. Values that are no such answer are counted by
themselves: thrusts, scores, and limits without dilatancy.
"""

from __future__ import annotations

import functools
import importlib.util
import inspect
import json
import sys
import warnings
from collections import Counter
from time import process_time
from types import ModuleType
from typing import Any

import blockstat
from blockstat import InputError, InputWarning, Outcome, build, load_scene, prove_limit, prove_verdict, read
from blockstat.analysis.assess import judged
from evidence.paths import CASES, EXAMPLES, ROOT
from evidence.references import SECTIONS
from evidence.results import parser, report
from evidence.scenes.sized import falling_wall, pushed_wall
from evidence.tables import table

#: Answers before the last one of its kind that are tried: each bisection halves the distance to the limit.
BACK = 20
#: Blocks of the walls that are judged, proved and checked with their seconds.
SIZES = (10, 30, 100, 300, 1000)


def checker() -> ModuleType:
    """The checker, as a module."""
    spec = importlib.util.spec_from_file_location("check_proof", ROOT / "extras" / "check_proof.py")
    assert spec is not None
    assert spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


CHECK = checker()
Answers = list[tuple[str, Any, dict[str, Any]]]


def accepted(proof: blockstat.ProofFile) -> list[str]:
    """What the checker says of a file, through JSON."""
    return CHECK.check(json.loads(json.dumps(proof.content)))


def listen(answers: Answers) -> None:
    """Put every verdict and limit load into the list, wherever the functions that give them have been imported to."""

    def heard(function, kind):
        signature = inspect.signature(function)

        @functools.wraps(function)
        def and_kept(*args, **options):
            result = function(*args, **options)
            answers.append((kind, result, dict(signature.bind(*args, **options).arguments)))
            return result

        return and_kept

    for original, kind in ((blockstat.assess, "assess"), (judged, "assess"), (blockstat.limit_load, "limit_load")):
        name, replacement = original.__name__, heard(original, kind)
        for module in list(sys.modules.values()):
            ours = getattr(module, "__name__", "").split(".")[0] in ("blockstat", "evidence")
            if ours and vars(module).get(name) is original:
                setattr(module, name, replacement)


def proved(kind: str, result: Any, given: dict[str, Any]) -> list[str]:
    """What the checker says of the proof of an answer."""
    loads = given.get("loads")
    if kind == "assess":
        return accepted(prove_verdict(result, loads=loads))
    return accepted(prove_limit(result, given["load"], loads=loads))


def proved_row(answers: Answers) -> str:
    """What became of the answers of one row: "" if there are none, "proved", or the error of one without a proof."""
    kinds: dict[tuple[str, str], Answers] = {}
    for answer in answers:
        kinds.setdefault((answer[0], answer[1].outcome.word), []).append(answer)
    kinds = {key: own for key, own in kinds.items() if key[1] != "undecided"}
    for own in kinds.values():
        error = ""
        for answer in own[::-1][:BACK]:
            try:
                proved(*answer)
                break
            except (InputError, ValueError) as reason:
                error = error or str(reason)
        else:
            return error
    return "proved" if kinds else ""


def rows() -> dict[str, str]:
    """What became of each reference value."""
    answers: Answers = []
    listen(answers)
    found = {}
    for module in SECTIONS.values():
        for row in module.ROWS:
            if row.missing:
                continue
            answers.clear()
            row.compute()
            found[row.test] = proved_row(list(answers))
            print(f"{found[row.test] or 'no verdict':<10} {row.test}", file=sys.stderr)
    return found


def cases() -> dict[str, str]:
    """What became of each shared case, and of the chapel."""
    found = {}
    paths = [path for path in [*CASES.glob("*.json"), *CASES.glob("rubble/*.json")] if path.stem not in NO_CASE]
    for name, scene in {**{path.stem: path for path in sorted(paths)}, "chapel": EXAMPLES / "chapel.toml"}.items():
        assembly = build(load_scene(scene)) if scene.suffix == ".toml" else read(scene)
        verdict = blockstat.assess(assembly)
        if verdict.outcome is Outcome.UNDECIDED:
            found[name] = ""
            continue
        try:
            said = accepted(prove_verdict(verdict))
            assert said[0] == f"PROVED {verdict.outcome.word}"
            found[name] = "proved"
        except InputError as reason:
            found[name] = str(reason)
        print(f"{found[name] or 'undecided':<10} {name}", file=sys.stderr)
    return found


NO_CASE = ("expected", "contacts")


def sizes(largest: int) -> list[list[object]]:
    """Blocks, contacts, seconds to judge and to prove, megabytes and seconds to check, by the size of a wall."""
    found: list[list[object]] = []
    for blocks in (size for size in SIZES if size <= largest):
        for word, make in (("stable", pushed_wall), ("unstable", falling_wall)):
            wall = make(blocks)
            start = process_time()
            verdict = blockstat.assess(wall)
            judged = process_time()
            proof = prove_verdict(verdict)
            made = process_time()
            text = json.dumps(proof.content, separators=(",", ":"))
            said = CHECK.check(json.loads(text))
            checked = process_time()
            assert said[0] == f"PROVED {word}"
            seconds = [f"{s:.2f}" for s in (judged - start, made - judged, checked - made)]
            contacts = len(proof.content["data"]["contacts"])
            found.append([wall.n_blocks, word, contacts, *seconds[:2], f"{len(text) / 1e6:.2f}", seconds[2]])
            print(*found[-1], file=sys.stderr)
    return found


def counted(what: str, found: dict[str, str], without: str) -> str:
    """How many are proved, and those that are not with the reason. without : what those are that ask for no proof."""
    count = Counter("proved" if value == "proved" else "" if not value else "no proof" for value in found.values())
    asked = count["proved"] + count["no proof"]
    lines = [f"{count['proved']} of {asked} {what} have a proof file that the checker accepts."]
    lines += [f"- {name}: {reason}" for name, reason in found.items() if reason not in ("", "proved")]
    lines += [f"- {count['']} more {without}."] if count[""] else []
    return "\n".join(lines)


if __name__ == "__main__":
    options = parser(__doc__)
    options.add_argument("--only", nargs="+", choices=["rows", "cases", "sizes"], default=["rows", "cases", "sizes"])
    options.add_argument("--largest", type=int, default=max(SIZES), metavar="BLOCKS", help="of the walls")
    chosen = options.parse_args()
    warnings.simplefilter("ignore", InputWarning)
    figures: dict[str, Any] = {}
    parts: dict[str, str] = {}
    if "sizes" in chosen.only:  # before answers are listened to
        figures["sizes"] = sizes(chosen.largest)
        names = ("blocks", "verdict", "contacts", "verdict [s]", "proof [s]", "file [MB]", "check [s]")
        parts["sizes"] = table(names, figures["sizes"])
    if "cases" in chosen.only:
        figures["cases"] = cases()
        parts["cases"] = counted("shared cases that are decided, with the chapel,", figures["cases"], "are undecided")
    if "rows" in chosen.only:
        figures["rows"] = rows()
        what = "rows of the validation page that rest on verdicts or limit loads"
        parts["rows"] = counted(what, figures["rows"], "are thrusts or other values that are neither")
    report(chosen, figures, parts)
