"""Tables of what the fuzzer found, and its page."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from evidence.fuzz.compare import FAILURES, Category, Result
from evidence.fuzz.generate import FAMILIES
from evidence.fuzz.limits import Limit
from evidence.fuzz.touch import Touch
from evidence.tables import table

SHOWN = [category for category in Category if category is not Category.RIGHT]
MOST = 40  #: failures listed on the page
HEAD = """# Random scenes

Written by `make evidence ONLY=fuzz`. `evidence/fuzz` makes random scenes of two to twelve blocks and judges each with
a contact search and linear programs of its own. It shares nothing with the statics but the solids. The judge finds the
contacts of convex pieces by separating axes. Friction polygons inside the cones prove that a scene stands, polygons
outside prove that it falls; both proofs are checked on the exact cones. A contact without a normal of its own, an edge
along an edge or a corner on a corner, is left out where the judge proves that a scene stands. Where the judge proves
that it falls, the motion must open such a contact along one of the normals that separate the two blocks.

Tolerances are those that the statics state: joints open by less than 1e-2 of the smaller block are closed, contacts
narrower than 1e-6 of it have no normal. What is within a factor of two of a tolerance is counted apart. Each block's
own weight is the unit of every distance from a limit.

"""


def line(result: Result) -> str:
    """One scene."""
    return (
        f"seed {result.seed} ({result.family}): {result.category.value}: the statics say {result.word}, the judge says "
        f"{result.truth.value} (lack {result.lack:.2g}): {result.note}"
    )


def contact(touch: Touch) -> str:
    """One contact that the judge found."""
    state = "certain" if touch.certain else "possible" if touch.unique else "no normal of its own"
    at = " ".join(str(point.round(4).tolist()) for point in touch.points)
    normal = touch.normal.round(4).tolist()
    return f"{touch.a}-{touch.b} {touch.kind} {state}, gap {touch.gap:.2g}, normal {normal}, at {at}"


def bracket_line(found: Limit) -> str:
    """One limit load."""
    return (
        f"seed {found.seed} ({found.family}): limit load {found.word}, {found.lower:.9g} to {found.upper:.9g}; "
        f"polygons {found.inner:.9g} to {found.outer:.9g}"
    )


def counts(results: Sequence[Result]) -> str:
    """A row a family, a column a category that occurs."""
    found = Counter((r.family, r.category) for r in results)
    columns = [c for c in SHOWN if any(r.category is c for r in results)]
    rows = []
    for family in [*FAMILIES, "all"]:
        own = [r for r in results if family in (r.family, "all")]
        number = {c: sum(found[name, c] for name in {r.family for r in own}) for c in Category}
        if own:
            rows.append([family, len(own), number[Category.RIGHT], *[number[c] or "" for c in columns]])
    return table(["family", "scenes", "right", *[c.value for c in columns]], rows)


def summary(results: Sequence[Result], limits: Sequence[Limit]) -> str:
    """The table and what the run took."""
    if not results:
        return "nothing done"
    times = [sum(getattr(r, name) for r in results) / len(results) for name in ("product_time", "judge_time")]
    text = f"{counts(results)}\n\n{len(results):,} scenes; a verdict took {times[0] * 1e3:.0f} ms of process time, "
    text += f"a judgement {times[1] * 1e3:.0f} ms.\n"
    if limits:
        wrong = sum(found.fails for found in limits)
        text += f"\nOf {len(limits)} limit loads, {len(limits) - wrong} agree with the brackets of the polygons.\n"
    return text


def page(results: Sequence[Result], limits: Sequence[Limit]) -> str:
    """docs/fuzz.md."""
    wrong = [result for result in results if result.fails]
    fails = [f"- {line(r)}" for r in sorted(wrong, key=lambda r: (FAILURES.index(r.category), r.seed))]
    fails += [f"- {bracket_line(found)}" for found in limits if found.fails]
    if len(fails) > MOST:
        fails = [*fails[:MOST], f"- and {len(fails) - MOST} more"]
    text = HEAD + summary(results, limits)
    if fails:
        text += "\n## Failures\n\n`python -m evidence.fuzz --only SEED` repeats one.\n\n" + "\n".join(fails) + "\n"
    return text
