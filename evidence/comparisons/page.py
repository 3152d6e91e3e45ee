"""The page docs/comparison.md from the verdicts and limits of the long comparison."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from blockstat import Assembly
from dynsim import Comparison, Comparisons
from evidence.comparisons.limits import DOUBTED, FINER, LimitRow
from evidence.comparisons.pictures import LEAST_SHARE, contact_sheet, histogram, scatter
from evidence.comparisons.scenes import FACTORS, SEED, Scene
from evidence.comparisons.tables import by_cause, families, figures, finer_limits, matrix, ratios
from evidence.results import save
from evidence.tables import table

TIMED = ("static", "coulomb", "dynamic")
PAGE = """# Static against dynamic

Written by `make evidence ONLY=comparison`. There are {scenes} scenes of {least} to {most} blocks: {references}
references and {randoms} random scenes (seed {seed}). Each gets three verdicts: by statics with exact friction cones
(`blockstat.assess`), by statics without dilatancy and self-stress (`flow="coulomb"`), and by Bullet (`dynsim.verify`).
`dynsim.compare` makes the same table of any assemblies, and `python -m evidence.comparisons.cases DIRECTORY` makes it
of files. The random families are walls (four without a roof, on tilted ground), huts (four walls and a barrel vault),
chapels (a vaulted nave with openings and buttresses), arches and portals of `evidence/scenes/families.py`. The verdicts
took {seconds} process seconds: force fields {static:.1f}, Coulomb {coulomb:.1f}, Bullet {dynamic:.0f}.

Bullet agrees with force fields alone on {agree} scenes, and with Coulomb friction on {agree_coulomb}. Of {excluded}
scenes that statics exclude, {stood} stood in Bullet. `dynsim` refuses these scenes, so they are not compared:
{refused}.

{static_matrix}

{coulomb_matrix}

{families}

## References

These scenes are built at a multiple of their known limit (`evidence/references/dynamics.py`).

{truths}

## Limits under a push

{limit_count} random scenes that stand are subject to a growing horizontal acceleration. The tables compare
`blockstat.limit_load` with the middle of the bracket by `dynsim.limit`, which is 1 % wide. In the picture a dashed line
marks {share:.0%} of the static limit. "Furthest" is the largest difference of the two limits.

{ratios}

![two plots of dots along a diagonal, those of the right one closer to it]({folder}/limits.png)

*Bullet's limit over the static limit: over that of force fields alone, and over that without dilatancy. On the diagonal
both are equal.*

{doubted} of them carried over {over:.0%} more in Bullet than statics without dilatancy allow. These are the limits in
Bullet with time steps of {finer:g} ms:

{finer_limits}

## The mechanism against the first motion

In {cosines} scenes no force field exists and the blocks fall in Bullet. For these the mechanism of the certificate is
compared with the motion in Bullet. The figure is the cosine between the two fields of twists of the free blocks, in the
scalar product of kinetic energy. The motion is that from release to the first sample at which a block has moved by a
tenth of the threshold, about a three-hundredth of its size. This is far above the noise of the solver, and the joints
have hardly moved. Half of the cosines are above {median:.3f}, and nine of ten are above {tenth:.2f}. The lowest are:
{lowest}.

Two reasons for a cosine of less than 1 are known. The mechanism has an associated flow, in which a sliding block lifts
at the rate of friction: for a single block the cosine is 1 / sqrt(1 + mu^2), {slide:.2f} at mu = 0.7. And where several
mechanisms are nearly critical, as in a stack in which every joint is at its limit, the two may begin with different
ones.

![a histogram with its highest bar at one, stacked in the colours of six families]({folder}/cosines.png)

*How many scenes have which cosine, by family.*

## Every disagreement, by its cause

{disagreements} scenes differ in one of the two comparisons. Scenes of which a verdict is undecided or creeps, and the
others agree, are listed too: {neither}. Further runs look for the cause: runs with small pushes, a run with time steps
of at most half the finest, and a run that lasts ten times as long (`dynsim.comparison.causes`).

{causes}
"""


def page(path: Path, scenes: list[Scene], rows: Comparisons, limits_found: list[LimitRow]) -> None:
    folder = path.with_suffix("")
    folder.mkdir(parents=True, exist_ok=True)
    of = {scene.name: scene.family for scene in scenes}

    def family(row: Comparison) -> str:
        return of[row.name]

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
    save(path.parent / "results" / f"{path.stem}.md", {"summary": summary(rows)})


def summary(rows: Comparisons) -> str:
    """One sentence."""
    excluded = [row for row in rows if row.static == "unstable"]
    stood = sum(row.dynamic == "stands" for row in excluded)
    fields, coulomb = (sum(getattr(row, word) is True for row in rows) for word in ("agree", "agree_coulomb"))
    return (
        f'- Of {len(rows)} scenes, Bullet agrees with force fields alone on {fields} and with `flow="coulomb"` on '
        f"{coulomb}. Of the {len(excluded)} scenes that statics exclude, {stood or 'none'} stood in Bullet."
    )


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


def causes(rows: Comparisons, assemblies: dict[str, Assembly], folder: Path, page: Path) -> str:
    """A section for each cause: what it is, a picture of every assembly, and the figures."""
    folder.mkdir(parents=True, exist_ok=True)
    for old in folder.glob("cause-*.png"):
        old.unlink()
    sections = []
    for cause, own in by_cause(rows).items():
        picture = folder / f"cause-{cause.word.replace('_', '-')}.png"
        contact_sheet([(row, assemblies[row.name]) for row in own], picture)
        title = f"### {cause.word.replace('_', ' ').capitalize()}: {len(own)}"
        alt = "a drawing of a room of blocks" if len(own) == 1 else f"drawings of {len(own)} rooms and walls of blocks"
        link = f"![{alt}]({picture.relative_to(page.parent)})"
        caption = "*At the end of the run in Bullet, or in the fall that statics predict. Red blocks moved furthest.*"
        sections += [title, f"{cause.value[0].upper()}{cause.value[1:]}.", link, caption, figures(own)]
    return "\n\n".join(sections)
