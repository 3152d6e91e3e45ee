"""The figures of `evidence.benchmarks.solvers` as parts of docs/speed.md."""

from __future__ import annotations

import math
import textwrap

from evidence.tables import head, row, table

HEAD = head(
    ["scene", "blocks", "solver", "seconds", "ratio", "iterations", "residual", "balanced", "score", "verdict", "MB",
     ""]
)  # fmt: skip
STEPS = ("interfaces", "equilibrium", "solve", "certificate")
#: What the page holds the figures against: name, target, the sense in which it is met, whether the large run asks.
TARGETS = (
    ("cvxpy literal primal / blockstat, 1,000-block wall", 40.0, ">=", False),
    ("the same, pushed along itself and so solved in its plane", 40.0, ">=", False),
    ("Clarabel dual / blockstat, 3,000-block wall", 6.0, ">=", False),
    ("Clarabel dual / blockstat, 10,000-block wall", 12.0, ">=", True),
    ("whole assess of the wall that falls / (numeric factorisation x iterations), to the optimum", 4.0, "<=", False),
    ("the same of the chapel of 1,000 that stands", 4.0, "<=", False),
    ("the same of the wall of 1,000 that stands", 4.0, "<=", False),
    ("the chapel's, with the iterations of Clarabel's dual", 4.0, "<=", False),
    ("the wall's, with the iterations of Clarabel's dual", 4.0, "<=", False),
    ("growth exponent of blockstat, wall of 1,000 to the largest", 1.4, "<=", True),
    ("verdicts of the 300-block chapel per second, without earlier certificates", 25.0, ">=", False),
    ("the same, with the certificates of earlier designs", 25.0, ">=", False),
)


def wrapped(text: str) -> str:
    """A paragraph, or an item of a list, in lines of the page's width."""
    return textwrap.fill(text, 118, subsequent_indent="  " if text.startswith("-") else "", break_long_words=False)


def was_run(cell: dict) -> bool:
    """Whether the solver of a cell is installed."""
    return cell.get("word") != "not installed"


def cell_line(cell: dict) -> str:
    """One row of the table."""
    name = [cell["scene"], f"{cell.get('blocks', cell['size']):,}", cell["solver"]]
    if "seconds" not in cell:
        return row([*name, cell["word"], *["-"] * 7, ""])
    loud = "" if cell.get("agrees", True) else "**DISAGREES**"
    ratio = f"{cell['ratio']:.1f}" if "ratio" in cell else "-"
    return row(
        [
            *name, f"{cell['seconds']:.3f}", ratio, cell["iterations"], f"{cell['residual']:.0e}",
            f"{cell['balanced']:.0e}", f"{cell['score']:.3g}", cell["verdict"], f"{cell['memory']:.0f}", loud,
        ]
    )  # fmt: skip


def parts(found: dict) -> dict[str, str]:
    """What a run found, by the names of the parts of its file."""
    wrong = [row for row in found["rows"] if not row.get("agrees", True)]
    lines = {"table": [HEAD, *map(cell_line, filter(was_run, found["rows"]))]}
    lines["table"] += ["", f"**{len(wrong)} cells disagree with blockstat.**"] if wrong else []
    if found["alone"]:
        heads = ["blocks", *STEPS, "iterations", "verdict", "MB"]
        lines["alone"] = [table(heads, map(alone_cells, found["alone"]))]
    if found["profiles"]:
        lines["profiles"] = [profile_text(profile) for profile in found["profiles"]]
    if found.get("resolve"):
        lines["resolve"] = [resolve_text(found["resolve"])]
    lines["targets"] = targets(found)
    if not found["alone"]:
        lines["summary"] = [summary(found["rows"])]
    return {name: "\n".join(own) for name, own in lines.items()}


def summary(rows: list[dict]) -> str:
    """One line each on the largest wall, chapel and falling wall that every solver decided which is installed."""
    kinds = ("wall", "chapel", "falling")
    return "\n".join(largest(scene, [row for row in rows if row["scene"] == scene]) for scene in kinds)


def largest(scene: str, rows: list[dict]) -> str:
    """The largest of the scenes of a kind that every solver decided which is installed."""
    decided = {row["size"]: [r for r in rows if r["size"] == row["size"] and "seconds" in r] for row in rows}
    solvers = {row["solver"] for row in rows if was_run(row)}
    sizes = [size for size, found in decided.items() if {row["solver"] for row in found} == solvers]
    name = {"falling": "wall that falls"}.get(scene, f"{scene} that stands")
    if not sizes:
        return f"- No {name} was decided by every solver."
    best = {row["solver"]: row for row in decided[max(sizes)]}
    own = best["blockstat"]
    others = [(name, f"{row['ratio']:.1f} times") for name, row in best.items() if name != "blockstat"]
    (first, ratio), *rest = others
    times = ", ".join([f"{first} takes {ratio} as long", *map(" ".join, rest)])
    return f"- A {name}, {own['blocks']:,} blocks: blockstat takes {own['seconds']:.2f} s; {times}."


def alone_cells(cell: dict) -> list:
    """A line of the walls that only blockstat is asked for."""
    if "seconds" not in cell:
        return [f"{cell['size']:,}", cell["word"], *[""] * (len(STEPS) + 2)]
    steps = [f"{cell.get(step, cell['seconds']):.2f}" for step in STEPS]
    return [f"{cell['blocks']:,}", *steps, cell["iterations"], cell["verdict"], f"{cell['memory']:.0f}"]


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
        f"({steps}), iterations: {profile['iterations']}, {profile['total'] / factored(profile):.1f} times the numeric "
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
        f"After a change of `{resolve['moved']}`, the chapel of {resolve['blocks']} blocks is assessed "
        f"{resolve['rate']:.1f} times per second of process time ({steps}; without {1000 * resolve['build']:.0f} ms "
        "for building its blocks). With the certificates of earlier designs "
        f"(`blockstat.analysis.certificate_cache`) it is assessed {resolve['remembered']:.1f} times per second."
    )


def reached(found: dict) -> tuple[float | None, ...]:
    """What this run reached of each target, None where it did not ask."""
    rows = {(r["scene"], r["size"], r["solver"]): r for r in found["rows"] if "seconds" in r}

    def ratio(solver: str, size: int, scene: str = "wall") -> float | None:
        return rows.get((scene, size, solver), {}).get("ratio")

    def whole(row: dict) -> float:
        return row["seconds"] + sum(row[step] for step in STEPS if step != "solve")

    walls = [row for row in found["alone"] if "seconds" in row]
    exponent = None
    if len(walls) > 1:
        small, large = walls[0], walls[-1]
        exponent = math.log(whole(large) / whole(small)) / math.log(large["blocks"] / small["blocks"])
    profiles = {(p.get("scene"), p.get("size"), p.get("backend")): p for p in found["profiles"]}

    def overhead(scene: str, solver: str = "") -> float | None:
        profile = profiles.get((scene, 1000, "pardiso"), {})
        iterations = (rows.get((scene, 1000, solver), {}) if solver else profile).get("iterations")
        return profile["total"] / (profile["numeric"] * iterations) if profile and iterations else None

    return (
        ratio("cvxpy", 1000),
        ratio("cvxpy", 1000, "along"),
        ratio("clarabel-dual", 3000),
        ratio("clarabel-dual", 10_000),
        overhead("falling"),
        overhead("chapel"),
        overhead("wall"),
        overhead("chapel", "clarabel-dual"),
        overhead("wall", "clarabel-dual"),
        exponent,
        found.get("resolve", {}).get("rate"),
        found.get("resolve", {}).get("remembered"),
    )


def targets(found: dict) -> list[str]:
    """Each target of this run with what was reached."""
    lines = [head(["", "target", "reached", ""])]
    for (name, target, sense, large), value in zip(TARGETS, reached(found), strict=True):
        if large == bool(found["alone"]):
            met = value is not None and (value >= target if sense == ">=" else value <= target)
            word = "not run" if value is None else "met" if met else "missed"
            lines.append(row([name, f"{sense} {target:g}", "-" if value is None else f"{value:.3g}", word]))
    return lines
