"""Verdicts without dilatancy and self-stress beside those of Bullet and LMGC90.

    python -m evidence.comparisons.coulomb [--engines NAMES] [--most BLOCKS] [--minutes M] [--resolution SHARE]
                                           [--random N] [--write FILE]
    python -m evidence.comparisons.coulomb --monotone
    python -m evidence.comparisons.coulomb --cost

Real assemblies of other projects, the scenes of examples/, the elements of the gallery and random domes, groin, sail
and fan vaults about as thick as the least they need. What was found is kept in build/coulomb.json with the hash of the
sources (`evidence.run.sources`), and a run finds what is missing there or comes from other sources, so one that was
interrupted goes on where it stopped: statics always, and the columns of `--engines` ("bullet", "lmgc90", which needs
the extra of that name, both separated by a comma, or none) for assemblies of up to `--most` blocks; an engine that
takes more than `--minutes` of process time for one assembly is ended, and that is kept as its answer. `--write` makes
the page and docs/results/coulomb.json, of which the answers of LMGC90, no part of these sources, are taken again.

`--monotone` judges the assemblies of other projects at friction of .4 to 1.5 and counts those that are stable at one
and held by self-stress at a greater one. `--cost` times the verdict on vaults and chapels of some sizes.
"""

from __future__ import annotations

import argparse
import json
import resource
import statistics
import warnings
from collections.abc import Iterator, Sequence
from multiprocessing import Pipe, get_context
from multiprocessing.connection import Connection
from pathlib import Path
from time import perf_counter, process_time
from typing import Any

import numpy as np

from blockstat import Assembly, InputError, Outcome, assess, build, limit_load, load_scene, read, tilt_limit
from blockstat.model import dome, fan_vault, groin_vault, sail_vault
from dynsim import Settings, verify
from dynsim.engine.lmgc90 import import_lmgc90
from evidence.pages.elements import ELEMENTS
from evidence.paths import CASES, DOCS, EXAMPLES
from evidence.references.walls import ZERO_DILATANCY, wall
from evidence.references.wedges import WEDGES, wedge
from evidence.results import save
from evidence.run.sources import digest
from evidence.scenes.sized import SCENES
from evidence.tables import table

SEED = 20
FRICTIONS = [round(0.1 * tenth, 1) for tenth in range(4, 16)]
LETTER = {
    Outcome.STABLE: "S", Outcome.STABLE_ONLY_BY_SELF_STRESS: "s", Outcome.UNSTABLE: "u", Outcome.UNDECIDED: "?",
}  # fmt: skip
ON_PAGES = DOCS / "results" / "coulomb.json"
KEPT = DOCS.parent / "build" / "coulomb.json"
ENGINES = {"bullet": "Bullet", "lmgc90": "LMGC90"}
FIELDS = "force fields"
RESOLUTION = "resolution of Bullet"
HEAD = ["", "blocks", FIELDS, "Coulomb", *ENGINES.values(), "held so", "programs", "times the plain verdict"]
#: Programs of a search at which it is said to settle at once, and in all.
AT_ONCE, MOST = 5, 40
#: What `--cost` times: a scene of `evidence.scenes.sized` and its blocks, about.
SIZES = [("vault", 100), ("vault", 400), ("chapel", 335), ("chapel", 1000)]
Found = dict[str, Any]


def random_vault(kind: str, seed: int) -> Assembly:
    """A dome or vault about as thick as the least it needs, on springers, with a friction from .4 to .9."""
    random = np.random.default_rng([SEED, seed])
    span, friction = random.uniform(3.0, 6.0), float(random.uniform(0.4, 0.9))
    thickness = float(span * random.uniform(0.03, 0.09))
    options: dict = {"thickness": thickness, "springers": 0.3}
    if kind == "dome":
        blocks = dome(span=span, rings=int(random.integers(3, 6)), voussoirs=int(random.integers(6, 13)), **options)
    elif kind == "groin":
        blocks = groin_vault(spans=[span, span], voussoirs=int(random.integers(5, 9)), brick=span / 4, **options)
    elif kind == "sail":
        rise = span / random.uniform(2.5, 5)
        blocks = sail_vault(spans=[span, span], rise=rise, courses=4, voussoirs=2, **options)
    else:
        blocks = fan_vault(spans=[span, span], rise=span / 2, foot=span / 8, rings=3, voussoirs=4, **options)
    supports = [block.name for block in blocks if "springer" in block.name]
    return Assembly.from_blocks(blocks, supports=supports, friction=friction, name=f"{kind} {seed}")


def randoms(number: int) -> Iterator[Assembly]:
    """So many vaults, the four kinds by turns; dimensions that make no building are left out."""
    kinds = ("dome", "groin", "sail", "fan")
    found = seed = 0
    while found < number:
        try:
            vault = random_vault(kinds[found % 4], seed)
        except InputError:
            vault = None
        seed += 1
        if vault is not None:
            found += 1
            yield vault


def cases() -> Iterator[Assembly]:
    """Assemblies of other projects."""
    for path in sorted(CASES.glob("*.json")):
        if path.stem != "expected":
            yield read(path).with_(name=path.stem)


def assemblies(number: int) -> Iterator[Assembly]:
    """Everything that is compared."""
    yield from cases()
    for path in sorted(EXAMPLES.glob("*.toml")):
        yield build(load_scene(path)).with_(name=path.stem)
    for name, _, build_element, _ in ELEMENTS:
        yield build_element().with_(name=name)
    yield from randoms(number)


def rows_of(path: Path) -> dict[str, Found]:
    """What was found of each assembly, by name."""
    return json.loads(path.read_text()) if path.is_file() else {}


def put(path: Path, rows: dict[str, Found]) -> None:
    """Write what was found of each assembly."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps(rows, indent=1) + "\n")


def statics(asm: Assembly) -> Found:
    """Both verdicts of one assembly, what holds it, and the cost."""
    start = process_time()
    plain = assess(asm)
    middle = process_time()
    verdict = assess(asm, flow="coulomb", interfaces=plain.interfaces)
    end, state = process_time(), verdict.coulomb
    return {
        "blocks": asm.n_blocks, "interfaces": plain.interfaces.n_interfaces,
        FIELDS: plain.outcome.word, "Coulomb": verdict.outcome.word,
        "held so": "" if state is None or state.settles else f"{100 * state.share:.3g} %",
        "programs": None if state is None else state.solves,
        "times": None if state is None else round((end - middle) / max(middle - start, 1e-3), 2),
        "seconds": round(end - middle, 2),
    }  # fmt: skip


def _ask(asm: Assembly, engine: str, seconds: int, settings: Settings, answer: Connection) -> None:
    """Send the word of a dynamic verdict, or why there is none; ends with this process after so many seconds."""
    resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds))
    start = perf_counter()
    try:
        said = verify(asm, engine=engine, settings=settings).outcome.word
    except (InputError, RuntimeError) as error:
        said = f"no verdict: {error}"
    if perf_counter() - start < seconds:  # LMGC90 runs in a process of its own, which the limit has ended otherwise
        answer.send(said)


def engine_says(asm: Assembly, engine: str, minutes: float, settings: Settings) -> str:
    """The word of a dynamic verdict, or why there is none."""
    receive, send = Pipe(duplex=False)
    process = get_context("fork").Process(target=_ask, args=(asm, engine, round(60 * minutes), settings, send))
    process.start()
    send.close()
    try:
        said: str = receive.recv()
    except EOFError:
        said = f"no verdict: not ended after {minutes:g} min of process time"
    process.join()
    return said


def fill(
    number: int, engines: Sequence[str], most: int, minutes: float, settings: Settings, largest: int | None
) -> dict[str, Found]:
    """Find what is missing, keep it, and return what there is of all assemblies."""
    rows, shown, names, sources = rows_of(KEPT), rows_of(ON_PAGES), [], digest("evidence.comparisons.coulomb")
    for asm in assemblies(number):
        if largest is not None and asm.n_blocks > largest:
            continue
        names.append(asm.name)
        own = rows.setdefault(asm.name, {})
        if own.get("sources") != sources:
            kept = {**shown.get(asm.name, {}), **own}
            own = rows[asm.name] = {"sources": sources} | statics(asm)
            if "lmgc90" in kept:
                own["lmgc90"] = kept["lmgc90"]
        missing = [name for name in engines if name not in own and asm.n_blocks <= most]
        if missing:
            own.update({name: engine_says(asm, name, minutes, settings) for name in missing})
            if "bullet" in missing and settings != Settings():
                own[RESOLUTION] = settings.resolution
        put(KEPT, rows)
        print(asm.name, *own.values(), flush=True)
    return {name: rows[name] for name in names}


def summary(rows: dict[str, Found]) -> str:
    """How far the verdicts agree, and what they cost."""
    whole = [row for row in rows.values() if "Coulomb" in row]
    told = [row for row in whole if row[FIELDS] == "stable"]
    agree = {"stable": "stands", "stable_only_by_self_stress": "falls", "unstable": "falls"}
    lines = []
    for engine, name in ENGINES.items():
        judged = [row for row in whole if row.get(engine) in ("stands", "falls") and row["Coulomb"] in agree]
        same = sum(row[engine] == agree[row["Coulomb"]] for row in judged)
        lines.append(f"- {name} and Coulomb agree on {same} of {len(judged)} that both decide.")

    def both(word: str, verdict: str) -> str:
        found = [
            name for name, row in rows.items()
            if all(row.get(engine) == word for engine in ENGINES) and row.get("Coulomb") == verdict
        ]  # fmt: skip
        return f"{len(found)}{': ' if found else ''}{', '.join(found)}"

    ran = sum(all(row.get(engine) in ("stands", "falls", "creeps") for engine in ENGINES) for row in rows.values())
    solves = [row["programs"] for row in told if row["programs"] and row["Coulomb"] == "stable"]
    return "\n".join(
        [
            f"- {len(rows)} assemblies, of which {ran} ran in both engines.",
            *lines,
            f"- Held by self-stress, but standing in both engines: {both('stands', 'stable_only_by_self_stress')}.",
            f"- Stable, but falling in both engines: {both('falls', 'stable')}.",
            f"- {sum(n <= AT_ONCE for n in solves)} of {len(solves)} states were found within {AT_ONCE} programs, "
            f"{sum(n == 1 for n in solves)} by the first; the most that a verdict took is "
            f"{max(row['programs'] or 0 for row in told)} of {MOST}.",
            f"- The verdict takes {statistics.median(row['times'] for row in told if row['times'] is not None):.2g} "
            "times as long as the plain one (median), joints found before.",
        ]
    )


def verdicts(row: Found) -> list[str]:
    """What statics and the engines say: "-" for nothing."""
    said = [row.get(key, "-").replace("_", " ") for key in (FIELDS, "Coulomb")]
    return said + [str(row.get(engine, "-")).partition(":")[0] for engine in ENGINES]


def cells(row: Found) -> list[object]:
    """A row of the table."""
    figures = ["" if row.get(key) is None else row[key] for key in ("held so", "programs", "times")]
    return [row["blocks"], *verdicts(row), *figures]


def silent(rows: dict[str, Found]) -> str:
    """Why an engine gave no verdict, and what one resolves where that is not the default."""
    lines = [
        f"- {ENGINES[engine]}, {name}: {row[engine].partition(': ')[2]}"
        for name, row in rows.items() for engine in ENGINES if str(row.get(engine)).startswith("no verdict")
    ]  # fmt: skip
    lines += [
        f"- {ENGINES['bullet']}, {name}: {row['bullet']}; an imbalance of {row[RESOLUTION]:g} of the weight would have "
        f"shown, that of other rows is {Settings().resolution:g}."
        for name, row in rows.items() if RESOLUTION in row
    ]  # fmt: skip
    return "\n".join(lines) or "- none"


def limits() -> str:
    """Limits without dilatancy for each kind of joints beside published ones."""
    cells = []
    for name, published in ZERO_DILATANCY.items():
        load = limit_load(wall(name), (1, 0, 0), flow="coulomb")
        kinds = [f"{(low + high) / 2:.4f}" for low, high in load.coulomb_kinds]
        cells.append([f"wall {name} of Ferris & Tin-Loi, push [g]", published, f"{load.upper:.4f}", *kinds])
    for case, axis, mu, published, *_ in WEDGES:
        tilt = tilt_limit(wedge(case, mu), axis, flow="coulomb")
        whole = tilt_limit(wedge(case, mu), axis)
        kinds = [f"{stands:.2f}" for stands, _ in tilt.kinds]
        cells.append([f"wedge {case}-{axis}, mu {mu}, tilt [deg]", published, f"{whole.stands:.2f}", *kinds])
    return table(["", "published", "force fields", "stiff joints", "elastic joints", "both"], cells)


def monotone() -> None:
    """A letter for each friction: S stable, s by self-stress, u unstable, ? undecided; and who loses by more of it."""
    losing, count = [], 0
    for asm in cases():
        plain = assess(asm)
        words = [assess(asm, friction=mu, flow="coulomb", interfaces=plain.interfaces).outcome for mu in FRICTIONS]
        letters = "".join(LETTER[word] for word in words)
        count += 1
        losing += [asm.name] * ("s" in letters[letters.find("S") :] and "S" in letters)
        print(f"{asm.name:32} {letters}", flush=True)
    print(f"{count} assemblies; less stable by more friction: {len(losing)} {', '.join(losing)}")


def cost() -> None:
    """What both verdicts say of the benchmarks' vaults and chapels, and the seconds of that without dilatancy."""
    for kind, blocks in SIZES:
        asm = SCENES[kind](blocks)
        found = statics(asm)
        words = f"{found[FIELDS]}, {found['Coulomb']}, programs: {found['programs']}"
        print(f"{kind:8} {found['blocks']:5} blocks {found['seconds']:7.2f} s  {words}", flush=True)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--engines", default="none")
    parser.add_argument("--most", type=int, default=250)
    parser.add_argument("--minutes", type=float, default=20.0)
    parser.add_argument("--resolution", type=float, default=Settings().resolution)
    parser.add_argument("--random", type=int, default=60)
    parser.add_argument("--largest", type=int, metavar="BLOCKS", help="leave out larger assemblies")
    parser.add_argument("--write", type=Path, metavar="FILE")
    parser.add_argument("--monotone", action="store_true")
    parser.add_argument("--cost", action="store_true")
    options = parser.parse_args()
    engines = [] if options.engines == "none" else options.engines.split(",")
    if wrong := [name for name in engines if name not in ENGINES]:
        parser.error(f'no engine "{wrong[0]}"; engines are: {", ".join(ENGINES)}')
    if "lmgc90" in engines:
        import_lmgc90()  # or say what is missing before anything is kept
    warnings.simplefilter("ignore")
    if options.monotone:
        monotone()
        return
    if options.cost:
        cost()
        return
    settings = Settings(resolution=options.resolution)
    rows = fill(options.random, engines, options.most, options.minutes, settings, options.largest)
    whole = table(HEAD, [[name, *cells(row)] for name, row in rows.items()])
    parts = {"summary": summary(rows), "verdicts": whole, "silent": silent(rows), "limits": limits()}
    print("\n\n".join(parts.values()))
    if options.write:
        put(ON_PAGES, rows)
        save(options.write, parts)


if __name__ == "__main__":
    main()
