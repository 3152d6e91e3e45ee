"""Verdicts without dilatancy and self-stress against Bullet and, where it is installed, LMGC90.

    python -m evidence.comparisons.coulomb --monotone
    python -m evidence.comparisons.coulomb [--write FILE] [--most BLOCKS] [--random N] [--engines NAMES]

Real assemblies of other projects, the scenes of examples/ and random domes, groin, sail and fan vaults of which about
half stand. `--engines` are "bullet", "lmgc90" (which needs the extra of that name), both or none, separated by commas.
Assemblies of more blocks than `--most` are judged by statics alone. Rows that are in FILE already are not made again,
so a run that was interrupted goes on where it stopped. `--monotone` judges the assemblies of other projects at friction
of .4 to 1.5 and counts those that are stable at one and held by self-stress at a greater one.
"""

from __future__ import annotations

import argparse
import warnings
from collections.abc import Iterator, Sequence
from pathlib import Path
from time import process_time

import numpy as np

from blockstat import Assembly, InputError, Outcome, assess, build, load_scene, read
from blockstat.model import dome, fan_vault, groin_vault, sail_vault
from dynsim import verify
from evidence.paths import CASES, ROOT

SEED = 20
FRICTIONS = [round(0.1 * tenth, 1) for tenth in range(4, 16)]
LETTER = {
    Outcome.STABLE: "S", Outcome.STABLE_ONLY_BY_SELF_STRESS: "s", Outcome.UNSTABLE: "u", Outcome.UNDECIDED: "?",
}  # fmt: skip
HEAD = (
    "| | blocks | Coulomb | held by self-stress | programs | times the plain verdict | Bullet | LMGC90 |",
    "|---|---|---|---|---|---|---|---|",
)


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


def assemblies(number: int) -> Iterator[Assembly]:
    """Everything that is compared."""
    for path in sorted(CASES.glob("*.json")):
        if path.stem != "expected":
            yield read(path).with_(name=path.stem)
    for path in sorted((ROOT / "examples").glob("*.toml")):
        yield build(load_scene(path)).with_(name=path.stem)
    yield from randoms(number)


def row(asm: Assembly, most: int, engines: Sequence[str]) -> str:
    """Verdicts of one assembly as a row of the table."""
    start = process_time()
    plain = assess(asm)
    middle = process_time()
    verdict = assess(asm, flow="coulomb", interfaces=plain.interfaces)
    factor = (process_time() - middle) / max(middle - start, 1e-3)
    state = verdict.coulomb
    bullet, other = (
        engine_says(asm, name) if name in engines and asm.n_blocks <= most else "" for name in ("bullet", "lmgc90")
    )
    solves = "" if state is None else str(state.solves)
    share = "" if state is None or state.settles else f"{100 * state.share:.2g} %"
    said = verdict.outcome.word.replace("_", " ")
    return f"| {asm.name} | {asm.n_blocks} | {said} | {share} | {solves} | {factor:.1f} | {bullet} | {other} |"


def engine_says(asm: Assembly, engine: str) -> str:
    """The word of a dynamic verdict, or why there is none."""
    try:
        return verify(asm, engine=engine).outcome.word
    except (InputError, RuntimeError) as error:
        return f"no verdict: {error}"


def monotone() -> None:
    """A letter for each friction: S stable, s by self-stress, u unstable, ? undecided; and who loses by more of it."""
    losing, count = [], 0
    for path in sorted(CASES.glob("*.json")):
        if path.stem == "expected":
            continue
        asm = read(path)
        plain = assess(asm)
        words = [assess(asm, friction=mu, flow="coulomb", interfaces=plain.interfaces).outcome for mu in FRICTIONS]
        letters = "".join(LETTER[word] for word in words)
        count += 1
        losing += [path.stem] * ("s" in letters[letters.find("S") :] and "S" in letters)
        print(f"{path.stem:32} {letters}", flush=True)
    print(f"{count} assemblies; less stable by more friction: {len(losing)} {', '.join(losing)}")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--write", type=Path)
    parser.add_argument("--engines", default="bullet")
    parser.add_argument("--most", type=int, default=250)
    parser.add_argument("--random", type=int, default=60)
    parser.add_argument("--monotone", action="store_true")
    options = parser.parse_args()
    if options.monotone:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            monotone()
        return
    engines = options.engines.split(",")
    lines = list(HEAD)
    if options.write is not None and options.write.exists():
        lines = options.write.read_text().splitlines()
    done = {line.split("|")[1].strip() for line in lines}
    print("\n".join(lines), flush=True)
    for asm in assemblies(options.random):
        if asm.name in done:
            continue
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            try:
                lines.append(row(asm, options.most, engines))
            except InputError as error:
                lines.append(f"| {asm.name} | {asm.n_blocks} | {error} | | | | | |")
        print(lines[-1], flush=True)
        if options.write is not None:
            options.write.write_text("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
