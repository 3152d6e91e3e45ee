"""Static against dynamic verdicts on the assemblies of a directory.

    python -m evidence.comparisons.cases DIRECTORY [--most 200] [--friction MU] [--quick] [--jobs N] [--csv FILE]
        [--json FILE] [--pictures DIRECTORY]

Reads every file that `blockstat.read` knows. --most : files of more blocks are left out. --quick : no further runs to
find the cause of a difference. --pictures : one PNG for each cause of differences.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

from blockstat import Assembly, InputError, read
from dynsim import compare
from evidence.comparisons.pictures import contact_sheet
from evidence.comparisons.tables import by_cause, matrix


def assemblies(folder: Path, most: int, friction: float | None) -> list[Assembly]:
    """What can be read and is small enough, named after its file."""
    found = []
    for file in sorted(path for path in folder.iterdir() if path.is_file()):
        try:
            assembly = read(file).with_(name=file.stem)
        except InputError as error:
            print(f"left out: {error}", file=sys.stderr)
            continue
        if assembly.n_blocks > most:
            print(f"left out: {file.name} has {assembly.n_blocks} blocks", file=sys.stderr)
            continue
        found.append(assembly if friction is None else assembly.with_(friction=friction))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("directory", type=Path)
    parser.add_argument("--most", type=int, default=200)
    parser.add_argument("--friction", type=float)
    parser.add_argument("--quick", action="store_true")
    parser.add_argument("--jobs", type=int)
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--json", type=Path)
    parser.add_argument("--pictures", type=Path)
    options = parser.parse_args()
    if not options.directory.is_dir():
        parser.error(f"no such directory: {options.directory}")
    designs = assemblies(options.directory, options.most, options.friction)
    if not designs:
        parser.error(f"no assembly in {options.directory}")
    rows = compare(
        designs, closely=not options.quick, jobs=options.jobs,
        progress=lambda index, row: print(f"{designs[index].name}: {_word(row)}", file=sys.stderr),
    )  # fmt: skip
    print(matrix(rows, "static"), matrix(rows, "coulomb"), sep="\n\n")
    for row in rows:
        if row.note:
            print(f"\n{row.name}: {row.static} / {row.coulomb} / {row.dynamic}: {row.note}")
    if options.csv:
        rows.write_csv(options.csv)
    if options.json:
        rows.write_json(options.json)
    if options.pictures:
        options.pictures.mkdir(parents=True, exist_ok=True)
        of = dict(zip((design.name for design in designs), designs, strict=True))
        for cause, own in by_cause(rows).items():
            contact_sheet([(row, of[row.name]) for row in own], options.pictures / f"{cause.word}.png")


def _word(row) -> str:
    return row.result.dynamic if row.result is not None else row.error


if __name__ == "__main__":
    main()
