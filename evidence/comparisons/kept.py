"""Results of long comparisons in a file, so that a run goes on where the last one was stopped."""

from __future__ import annotations

import hashlib
import json
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from blockstat import Assembly
from dynsim import run_many
from dynsim.parallel.pool import Row
from evidence.paths import ROOT

SOURCE = ROOT / "src"


class Kept:
    """Results in a file of JSON lines, found again by the scene, the question, and the code that answers."""

    def __init__(self, path: Path) -> None:
        self._path = path
        path.parent.mkdir(parents=True, exist_ok=True)
        text = path.read_text() if path.is_file() else ""
        whole = text[: text.rfind("\n") + 1]
        if whole != text:
            path.write_text(whole)  # the last line was cut short
        self._rows = dict(_line(line) for line in whole.splitlines())
        code = hashlib.sha256()
        for file in sorted(SOURCE.rglob("*.py")):
            code.update(file.read_bytes())
        self._code = code.hexdigest()

    def ask(
        self, question: Callable[[Assembly], Any], word: str, assemblies: Sequence[Assembly], plain: Callable,
        jobs: int | None,
    ) -> list[dict]:  # fmt: skip
        """A plain row for each assembly, asked for in processes of their own where it is not known yet."""
        keys = [self._key(word, assembly) for assembly in assemblies]
        new = [i for i, key in enumerate(keys) if key not in self._rows]
        done = 0

        def keep(index: int, row: Row) -> None:
            nonlocal done
            done += 1
            key, name = keys[new[index]], assemblies[new[index]].name
            self._rows[key] = {"note": row.error} if row.result is None else plain(row.result)
            if row.result is not None:
                with self._path.open("a") as file:
                    file.write(json.dumps({"key": key, "row": self._rows[key]}) + "\n")
            print(f"{done}/{len(new)} {word.split(' Settings')[0]}: {name}", file=sys.stderr)

        if new and not run_many(question, [assemblies[i] for i in new], jobs=jobs, progress=keep).finished:
            raise KeyboardInterrupt
        return [{**self._rows[key], "name": a.name} for key, a in zip(keys, assemblies, strict=True)]

    def _key(self, word: str, assembly: Assembly) -> str:
        values = (assembly.vertices, assembly.density, assembly.gravity, assembly.support, assembly.friction)
        content = b"".join(np.ascontiguousarray(value).tobytes() for value in values)
        return hashlib.sha256(f"{self._code} {word}".encode() + content).hexdigest()[:16]


def _line(text: str) -> tuple[str, dict]:
    data = json.loads(text)
    return data["key"], data["row"]
