"""Random vaulted huts: statics, statics with Coulomb friction, and Bullet, counted against each other.

python -m evidence.comparisons.huts [--scenes 60] [--seed 7] [--json] [--write FILE]
"""

from __future__ import annotations

from collections import Counter

import numpy as np

from blockstat import InputError, assess
from dynsim import Settings, verify
from evidence import results
from evidence.scenes.families import hut
from evidence.tables import table


def parts(counts: Counter[tuple[str, str, str]], careful: dict[str, tuple[str, str]]) -> dict[str, str]:
    """Verdicts against each other, and how many huts each way of statics gets wrong.

    `careful` has both verdicts of Bullet, by default and with the careful preset, on huts on which Coulomb differs.
    """
    rows = ([static, coulomb.replace("_", " "), bullet, n] for (static, coulomb, bullet), n in sorted(counts.items()))
    too_bold = sum(n for (static, _, bullet), n in counts.items() if (static, bullet) == ("stable", "falls"))
    differ = sum(n for (_, coulomb, bullet), n in counts.items() if (coulomb == "stable") != (bullet == "stands"))
    excluded = sum(n for (static, _, bullet), n in counts.items() if (static, bullet) == ("unstable", "stands"))
    summary = [
        f"Of {counts.total()} random vaulted huts (one family, one seed):",
        "",
        f"- {too_bold} fall in Bullet and are stable by force fields alone,",
        f'- {differ} have different verdicts by Bullet and by `flow="coulomb"`,',
        f"- {excluded or 'none'} stand in Bullet and are excluded by statics.",
    ]
    if careful:
        again = (
            f"{name} {default} by default and {finer} with the careful preset"
            for name, (default, finer) in careful.items()
        )
        summary += ["", f'Where Bullet and `flow="coulomb"` differ: {"; ".join(again)}.']
    return {
        "table": table(["static", "with Coulomb friction", "Bullet", "scenes"], rows),
        "summary": "\n".join(summary),
    }


def main() -> None:
    parser = results.parser(__doc__)
    parser.add_argument("--scenes", type=int, default=60)
    parser.add_argument("--seed", type=int, default=7)
    options = parser.parse_args()
    rng = np.random.default_rng(options.seed)
    counts: Counter[tuple[str, str, str]] = Counter()
    careful: dict[str, tuple[str, str]] = {}
    for number in range(options.scenes):
        try:
            assembly = hut(rng, walls=(0.25, 0.8), vaults=(0.15, 0.4), name=f"hut {number}")
        except InputError:
            continue
        words = [assess(assembly, flow=flow).outcome.word for flow in ("associated", "coulomb")]
        bullet = verify(assembly).outcome.word
        counts[(words[0], words[1], bullet)] += 1
        if (words[1] == "stable") != (bullet == "stands"):
            finer = verify(assembly, settings=Settings.named("careful")).outcome.word
            careful[assembly.name] = bullet, finer
    figures = [{"static": s, "coulomb": c, "bullet": d, "scenes": n} for (s, c, d), n in counts.items()]
    results.report(options, figures, parts(counts, careful))


if __name__ == "__main__":
    main()
