"""The figures of `solvers.py` as lines of text, and docs/speed.md."""

from __future__ import annotations

import math
import os
import textwrap

TABLE = (
    "| scene | blocks | solver | seconds | to ours | iterations | residual | balanced | score | verdict | MB | |\n"
    "|---|---|---|---|---|---|---|---|---|---|---|---|"
)
STEPS = ("interfaces", "equilibrium", "solve", "certificate")
#: What the page holds the figures against: name, target, unit and the sense in which it is met.
TARGETS = (
    ("cvxpy literal primal / ours, 1,000-block wall", 40.0, ">="),
    ("Clarabel dual / ours, 3,000-block wall", 6.0, ">="),
    ("Clarabel dual / ours, 10,000-block wall", 12.0, ">="),
    ("whole assess / (numeric factorisation x iterations), 1,000-block wall", 4.0, "<="),
    ("growth exponent of ours, wall of 1,000 to the largest", 1.4, "<="),
    ("judgements of the 300-block chapel a second", 25.0, ">="),
)
HEADER = """# Speed

Written by `make solvers`: one run, one machine, process seconds, one thread of every library ({cpus} cores). Compare
ratios, not seconds. Each cell is a process of its own; `-` stands for what did not finish.

- Scenes: a wall pushed out of its plane by a quarter of what tips it, a barrel vault, the chapel of the examples in
  smaller bricks, and a wall that falls. All are solved in space.
- Solvers: the literal penalty program through cvxpy (with its compilation), the same program given to Clarabel
  directly, its dual through Clarabel, its dual through the structured method (`ours`, which stops as soon as its
  forces prove stability, before the optimum), and the rigid-block equilibrium of compas_cra 0.8 by Ipopt (without its
  set-up in Python; an octagon about the friction cone, so that its forces need not prove anything).
- Seconds are those of the solver alone. The residual is that of equilibrium relative to the weight, as the solver left
  it (adhesion included) and after the certificate's correction (forces alone). The verdict is what the certificate
  makes of the solver's own numbers; MB is the largest resident memory of the process.
"""


def wrapped(text: str) -> str:
    """A paragraph, or an item of a list, in lines of the page's width."""
    return textwrap.fill(text, 118, subsequent_indent="  " if text.startswith("-") else "", break_long_words=False)


def cell_line(row: dict) -> str:
    """One row of the table."""
    name = f"| {row['scene']} | {row.get('blocks', row['size']):,} | {row['solver']} "
    if "seconds" not in row:
        return name + f"| {row['word']} " + "| - " * 7 + "| |"
    loud = "" if row.get("agrees", True) else "**DISAGREES**"
    ratio = f"{row['ratio']:.1f}" if "ratio" in row else "-"
    return (
        f"{name}| {row['seconds']:.3f} | {ratio} | {row['iterations']} | {row['residual']:.0e} | {row['balanced']:.0e} "
        f"| {row['score']:.3g} | {row['verdict']} | {row['memory']:.0f} | {loud} |"
    )


def after_table(found: dict) -> str:
    """Everything below the table."""
    wrong = [row for row in found["rows"] if not row.get("agrees", True)]
    lines = [f"**{len(wrong)} cells disagree with ours.**\n"] if wrong else []
    if found["alone"]:
        lines.append("## Larger walls, ours alone\n")
        lines += ["| blocks | " + " | ".join(STEPS) + " | iterations | verdict | MB |", "|---" * 8 + "|"]
        lines += [alone_line(row) for row in found["alone"]]
    if found["profiles"]:
        lines.append("\n## Where the time goes\n")
        lines += [profile_text(profile) for profile in found["profiles"]]
    if found.get("resolve"):
        lines += ["\n## One parameter moved\n", resolve_text(found["resolve"])]
    return "\n".join(lines)


def alone_line(row: dict) -> str:
    if "seconds" not in row:
        return f"| {row['size']:,} | {row['word']} | " + "| " * 6
    steps = " | ".join(f"{row.get(step, row['seconds']):.2f}" for step in STEPS)
    return f"| {row['blocks']:,} | {steps} | {row['iterations']} | {row['verdict']} | {row['memory']:.0f} |"


def profile_text(profile: dict) -> str:
    """Steps and parts of one assessment, most expensive first."""
    if "word" in profile:
        return profile["word"]
    parts = sorted(profile["parts"].items(), key=lambda item: -item[1])
    solve = profile["steps"]["solve"]
    steps = ", ".join(f"{name} {seconds:.2f}" for name, seconds in profile["steps"].items())
    shares = ", ".join(f"{name} {seconds / solve:.0%}" for name, seconds in parts if seconds > 0.005 * solve)
    return wrapped(
        f"- **{profile['scene']} of {profile['blocks']:,}, {profile['backend']}**: {profile['total']:.2f} s in all "
        f"({steps}), {profile['iterations']} iterations, {profile['total'] / factored(profile):.1f} times the numeric "
        f"factorisations ({1000 * profile['numeric']:.1f} ms each). Of the solve: {shares}."
    )


def factored(profile: dict) -> float:
    """Seconds of one numeric factorisation an iteration."""
    return profile["numeric"] * profile["iterations"]


def resolve_text(resolve: dict) -> str:
    if "word" in resolve:
        return resolve["word"]
    steps = ", ".join(f"{step} {1000 * resolve[step]:.0f} ms" for step in STEPS)
    return wrapped(
        f"The chapel of {resolve['blocks']} blocks is judged {resolve['rate']:.1f} times a second of process time "
        f"after `{resolve['moved']}` moved ({steps}; building its blocks, {1000 * resolve['build']:.0f} ms, is "
        f"left out), and {resolve['remembered']:.1f} times with the evidence of earlier designs (`blockstat.reuse`)."
    )


def reached(found: dict) -> tuple[float | None, ...]:
    """What this run reached of each target, None where it did not ask."""
    rows = {(r["scene"], r["size"], r["solver"]): r for r in [*found["rows"], *found["alone"]] if "seconds" in r}

    def ratio(solver: str, size: int) -> float | None:
        return rows.get(("wall", size, solver), {}).get("ratio")

    def whole(row: dict) -> float:
        return row["seconds"] + sum(row[step] for step in STEPS if step != "solve")

    walls = {size: row for (scene, size, solver), row in rows.items() if (scene, solver) == ("wall", "ours")}
    exponent = None
    if 1000 in walls and max(walls) > 1000:
        small, large = walls[1000], walls[max(walls)]
        exponent = math.log(whole(large) / whole(small)) / math.log(large["blocks"] / small["blocks"])
    small_profile = next((p for p in found["profiles"] if p.get("size") == 1000), None)
    return (
        ratio("cvxpy", 1000),
        ratio("clarabel-dual", 3000),
        ratio("clarabel-dual", 10_000),
        small_profile and small_profile["total"] / factored(small_profile),
        exponent,
        found.get("resolve", {}).get("rate"),
    )


def targets_text(found: dict) -> str:
    """Each target with what was reached."""
    lines = ["| | target | reached | |", "|---|---|---|---|"]
    for (name, target, sense), value in zip(TARGETS, reached(found), strict=True):
        met = value is not None and (value >= target if sense == ">=" else value <= target)
        word = "not run" if value is None else "met" if met else "missed"
        lines.append(f"| {name} | {sense} {target:g} | {'-' if value is None else f'{value:.3g}'} | {word} |")
    return "\n".join(lines)


def conclusion(found: dict) -> str:
    """Two sentences about the targets."""
    words = [line.rsplit("|", 2)[1].strip() for line in targets_text(found).splitlines()[2:]]
    counts = ", ".join(f"{words.count(word)} {word}" for word in ("met", "missed", "not run"))
    text = (
        f"Of the six targets: {counts}; the ratio to Clarabel's dual grows with the size, because its factor fills in "
    )
    text += "faster than one in the order of the contact graph. "
    cvxpy = next((r for r in found["rows"] if (r["scene"], r["size"], r["solver"]) == ("wall", 1000, "cvxpy")), {})
    small = next((p for p in found["profiles"] if p.get("size") == 1000), None)
    if small and "seconds" in cvxpy:
        text += f"At 1,000 blocks our numeric factorisations alone take 1/{cvxpy['seconds'] / factored(small):.0f} of "
        text += "cvxpy's time, so what is left to win there is what is not factorisation: joints, set-up, and numpy "
        text += "in between."
    return wrapped(text) + "\n"


def page(found: dict) -> str:
    """docs/speed.md."""
    parts = [
        HEADER.format(cpus=os.cpu_count()) + found.get("note", ""),
        "## Solvers\n",
        "\n".join([TABLE, *map(cell_line, found["rows"])]) + "\n",
        after_table(found),
        "\n## Against the targets\n",
        targets_text(found) + "\n",
        conclusion(found),
    ]
    return "\n".join(parts)
