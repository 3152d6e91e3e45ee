"""Static against dynamic verdicts on hundreds of small scenes: how often they agree, and why they do not.

python examples/compare_scenes.py [--scenes 330] [--limits 40] [--jobs N] [--write PAGE] [--csv FILE] [--json FILE]

References whose limit is known, and random arches, portals, walls, huts and chapels (benchmarks/families.py). What is
done is kept in build/compare.jsonl and not done again, unless a scene or the code that judges it has changed.
--write makes the page and its pictures, docs/comparison.md.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

ROOT = Path(__file__).parents[1]
sys.path[:0] = [str(ROOT / "tests"), str(ROOT / "benchmarks")]

import results
from compare_kept import Kept
from compare_page import (
    LEAST_SHARE,
    LimitRow,
    by_cause,
    causes,
    families,
    finer_limits,
    histogram,
    matrix,
    ratios,
    scatter,
    table,
)
from families import Random, arch, chapel, hut, portal, wall

from blockstat import Assembly, InputError, limit_load
from dynsim import Comparison, Comparisons, DynamicLimit, Settings, limit
from dynsim.comparison.compare import compare_one
from problems import SCENES
from references.dynamics import LIMITS

KEPT = ROOT / "build" / "compare.jsonl"
SEED = 13
#: Multiples of the known limit: the first three stand.
FACTORS = (0.8, 0.9, 0.97, 1.03, 1.1, 1.25)
#: Random families: maker, share of the scenes, direction of the push that brings them down, those with a push first.
RANDOM: dict[str, tuple[Callable[[Random], Assembly], float, tuple[int, int, int]]] = {
    "arch": (arch, 0.26, (1, 0, 0)), "portal": (portal, 0.19, (1, 0, 0)), "wall": (wall, 0.19, (1, 0, 0)),
    "hut": (hut, 0.17, (0, 1, 0)), "chapel": (chapel, 0.19, (0, 1, 0)),
}  # fmt: skip
MOST_BLOCKS = 80
#: Where Bullet carries so much more than statics without dilatancy, it is asked once more with this time step [s].
DOUBTED, FINER = 1.03, 2.5e-4


@dataclass(frozen=True)
class Scene:
    """An assembly whose name begins with its family; stands : what is known of it."""

    family: str
    assembly: Assembly
    stands: bool | None = None
    push: tuple[int, int, int] | None = None

    @property
    def name(self) -> str:
        return self.assembly.name


def references() -> Iterator[Scene]:
    """Scenes on both sides of known limits, and small ones of the tests."""
    for reference in LIMITS:
        for factor in FACTORS:
            name = f"{reference.name} at {factor:g} of its limit"
            yield Scene("reference", reference.scene(factor).with_(name=name), factor < 1)
    for name, make, options in SCENES:
        if np.isfinite(options.get("friction", 0.7)):
            yield Scene("reference", make().with_(name=name, **options))


def randoms(number: int) -> Iterator[Scene]:
    """About that many random scenes of at most `MOST_BLOCKS` blocks."""
    for k, (family, (make, share, push)) in enumerate(RANDOM.items()):
        found, seed = 0, 0
        while found < round(share * number):
            seed += 1
            try:
                assembly = make(np.random.default_rng([SEED, k, seed]))
            except InputError:
                continue
            if assembly.n_blocks <= MOST_BLOCKS:
                found += 1
                yield Scene(family, assembly.with_(name=f"{family} {seed}"), push=push)


def limits(kept: Kept, scenes: list[Scene], rows: Comparisons, number: int, jobs: int | None) -> list[LimitRow]:
    """Limits under a push of random scenes that stand, about the same number of each family."""
    standing = [
        s for s, row in zip(scenes, rows, strict=True)
        if s.push and (row.static, row.coulomb, row.dynamic) == ("stable", "stable", "stands")
    ]  # fmt: skip
    each = -(-number // len(RANDOM))
    chosen = [scene for family in RANDOM for scene in [s for s in standing if s.family == family][:each]]
    bullet = bullet_limits(kept, chosen, Settings(), jobs)
    found = []
    for scene in chosen:
        static = limit_load(scene.assembly, scene.push, flow="coulomb")
        if scene.name in bullet and static.coulomb is not None and np.isfinite(static.upper):
            low, high = static.coulomb
            found.append(
                LimitRow(
                    scene.name, scene.family, scene.assembly.n_blocks, static.upper, (low + high) / 2,
                    bullet[scene.name],
                )
            )  # fmt: skip
    doubted = {row.name for row in found if row.bullet > DOUBTED * row.coulomb}
    finer = bullet_limits(kept, [s for s in chosen if s.name in doubted], Settings(time_step=FINER), jobs)
    return [replace(row, finer=finer.get(row.name)) for row in found]


def bullet_limits(kept: Kept, scenes: list[Scene], settings: Settings, jobs: int | None) -> dict[str, float]:
    """Middle of Bullet's bracket for each scene that has a limit under its push [g]."""
    found: dict[str, float] = {}
    for push in dict.fromkeys(scene.push for scene in scenes):
        own = [scene.assembly for scene in scenes if scene.push == push]
        ask = partial(limit, load=push, settings=settings, check=False)
        for answer in kept.ask(ask, f"limit {push} {settings}", own, DynamicLimit.summary, jobs):
            if answer.get("outcome") == "limit":
                found[answer["name"]] = (answer["lower"] + answer["upper"]) / 2
    return found


def truths(scenes: list[Scene], rows: Comparisons) -> str:
    """Verdicts beside known limits, by the distance from them."""
    lines = []
    for factor in FACTORS:
        own = [
            row for scene, row in zip(scenes, rows, strict=True)
            if scene.stands is not None and f"at {factor:g} of" in row.name
        ]  # fmt: skip
        if not own:
            continue
        stands = factor < 1
        right = "stable" if stands else "unstable"
        lines.append(
            [
                f"{factor:g}", "stands" if stands else "falls", len(own), sum(row.static == right for row in own),
                sum((row.coulomb == "stable") == stands for row in own),
                sum(row.dynamic == ("stands" if stands else "falls") for row in own),
                "; ".join(f"{row.name.split(' at ')[0]} {row.dynamic}" for row in own
                          if row.dynamic != ("stands" if stands else "falls")),
            ]
        )  # fmt: skip
    head = ["times the limit", "truth", "scenes", "force fields right", "Coulomb right", "Bullet right", "Bullet wrong"]
    return table(head, lines)


PAGE = """# Static against dynamic

Written by `make comparison`: {scenes} scenes of {least} to {most} blocks, {references} of them references and {randoms}
random (seed {seed}). Statics with exact friction cones (`blockstat.assess`), statics without dilatancy and self-stress
(`flow="coulomb"`), and Bullet (`dynsim.verify`) judge each. `dynsim.compare` makes the same table of any assemblies,
and `python examples/compare_cases.py DIRECTORY` of files. The verdicts took {seconds} process seconds: force fields
{static:.1f}, Coulomb {coulomb:.1f}, Bullet {dynamic:.0f}.

Bullet agrees with force fields alone on {agree} scenes and with Coulomb friction on {agree_coulomb}. Of {excluded}
scenes that statics exclude, {stood} stood in Bullet. Refused by Bullet, so not compared: {refused}.

{static_matrix}

{coulomb_matrix}

{families}

## References

Scenes made to be a multiple of their known limit (tests/references/dynamics.py).

{truths}

## Limits under a push

{limit_count} random scenes that stand, under a growing horizontal acceleration: `blockstat.limit_load` against the
middle of Bullet's bracket (`dynsim.limit`, bracket of 1 %). A dashed line marks {share:.0%} of the static limit.

{ratios}

![Bullet's limit over the static limits]({folder}/limits.png)

{doubted} of them carried over {over:.0%} more in Bullet than statics without dilatancy allow. Asked again with time
steps of {finer:g} ms, Bullet says:

{finer_limits}

## The mechanism against the first motion

Where force fields do not exist and Bullet falls ({cosines} scenes), the mechanism of the certificate is set beside
Bullet's motion: the cosine between the two fields of twists in the scalar product of kinetic energy, over free blocks.
The motion is that from release to the first look at which a block has moved by a tenth of the threshold, about a
three-hundredth of its size: far above what the solver trembles, and the joints are still where they were. Of the
cosines half are above {median:.3f} and nine of ten above {tenth:.2f}. The lowest: {lowest}.

Two reasons for less than 1 are known. The mechanism is one of associated flow, in which a sliding block lifts at the
rate of friction: for a single one the cosine is 1 / sqrt(1 + mu^2), {slide:.2f} at mu = 0.7. And where several
mechanisms are nearly as good, as in a stack of which every joint is at its limit, the two need not begin with the same.

![histogram of the cosines]({folder}/cosines.png)

## Every disagreement, by its cause

{disagreements} scenes differ in one of the two comparisons, and {neither} have a verdict that says neither. A cause is
looked for with small pushes, with a run of time steps half as long as the finest or less, and with one that lasts ten
times as long (`dynsim.comparison.causes`). Pictures show where Bullet's fall has brought the blocks, or how they
would have to fall by statics.

{causes}
"""


def page(path: Path, scenes: list[Scene], rows: Comparisons, limits_found: list[LimitRow]) -> None:
    folder = path.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    of = {scene.name: scene.family for scene in scenes}
    family = lambda row: of[row.name]  # noqa: E731
    histogram(rows, family, folder / "cosines.png")
    scatter(limits_found, folder / "limits.png")
    cosines = [row.cosine for row in rows if row.cosine is not None]
    blocks = [scene.assembly.n_blocks for scene in scenes]
    seconds = {what: sum(getattr(row, f"{what}_seconds") or 0.0 for row in rows) for what in TIMED}
    excluded = [row for row in rows if row.static == "unstable"]
    apart = sorted((row.cosine, row.name) for row in rows if row.cosine is not None)[:5]
    lowest = ", ".join(f"{name} {cosine:.2f}" for cosine, name in apart)
    text = PAGE.format(
        scenes=len(rows), least=min(blocks), most=max(blocks), seed=SEED,
        references=sum(s.family == "reference" for s in scenes), randoms=sum(s.family != "reference" for s in scenes),
        seconds=f"{sum(seconds.values()):.0f}", **seconds,
        agree=sum(row.agree is True for row in rows), agree_coulomb=sum(row.agree_coulomb is True for row in rows),
        excluded=len(excluded), stood=sum(row.dynamic == "stands" for row in excluded),
        refused=", ".join(row.name for row in rows if row.dynamic is None) or "none",
        static_matrix=matrix(rows, "static"), coulomb_matrix=matrix(rows, "coulomb"), families=families(rows, family),
        truths=truths(scenes, rows), limit_count=len(limits_found), share=LEAST_SHARE, ratios=ratios(limits_found),
        doubted=sum(row.finer is not None for row in limits_found), over=DOUBTED - 1, finer=1e3 * FINER,
        finer_limits=finer_limits(limits_found),
        folder=folder.name, cosines=len(cosines), median=np.median(cosines), tenth=np.quantile(cosines, 0.1),
        lowest=lowest, slide=1 / np.hypot(1, 0.7), disagreements=len(rows.disagreements),
        neither=sum(bool(row.cause) for row in rows) - len(rows.disagreements),
        causes=causes(rows, {s.name: s.assembly for s in scenes}, folder, path),
    )  # fmt: skip
    path.write_text(text)
    results.save(path.parent / "results" / f"{path.stem}.md", {"summary": summary(rows)})


def summary(rows: Comparisons) -> str:
    """One sentence."""
    excluded = [row for row in rows if row.static == "unstable"]
    stood = sum(row.dynamic == "stands" for row in excluded)
    fields, coulomb = (sum(getattr(row, word) is True for row in rows) for word in ("agree", "agree_coulomb"))
    return (
        f'- Of {len(rows)} scenes Bullet agrees with force fields alone on {fields} and with `flow="coulomb"` on '
        f"{coulomb}; of the {len(excluded)} that statics exclude it lets {stood or 'none'} stand."
    )


TIMED = ("static", "coulomb", "dynamic")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scenes", type=int, default=330, help="about that many, references included")
    parser.add_argument("--limits", type=int, default=40, help="scenes whose limit under a push is looked for")
    parser.add_argument("--jobs", type=int, help="processes; one a core by default")
    parser.add_argument("--write", type=Path, metavar="PAGE")
    parser.add_argument("--csv", type=Path)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    known = list(references())
    known = known[:: max(1, 2 * len(known) // options.scenes)]  # a small sample has some of them
    scenes = [*known, *randoms(options.scenes - len(known))]
    kept = Kept(KEPT)
    ask = partial(compare_one, closely=True)
    answers = kept.ask(ask, "verdicts", [scene.assembly for scene in scenes], asdict, options.jobs)
    rows = Comparisons(tuple(Comparison(**answer) for answer in answers))
    print(matrix(rows, "static"), matrix(rows, "coulomb"), sep="\n\n")
    for cause, own in by_cause(rows).items():
        print(f"\n{cause.word}: {', '.join(row.name for row in own)}")
    for row in rows:
        if row.static is None:
            print(f"\n{row.name}: no verdict: {row.note}")
    if options.csv:
        rows.write_csv(options.csv)
    if options.json:
        rows.write_json(options.json)
    found = limits(kept, scenes, rows, options.limits, options.jobs)
    if found:
        print(f"\n{ratios(found)}")
    if options.write:
        if not found or all(row.cosine is None for row in rows):
            parser.error("too few scenes for a page: some have to fall, and some to have a limit")
        page(options.write, scenes, rows, found)


if __name__ == "__main__":
    main()
