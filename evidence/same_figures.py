"""Are the figures still those of before? Every verdict, score, limit and certificate, recorded and compared.

python -m evidence.same_figures record OUT.json [--checkout DIR] [--only TEXT]
python -m evidence.same_figures compare BEFORE.json AFTER.json

record : computes on whatever `blockstat` the path of Python finds, in one thread; the scenes are those of
`evidence.figure_scenes`, with the examples of the checkout (by default the one that holds this file). A run
that was stopped goes on where it was, as long as neither the source nor the scripts have changed. --only : scenes whose
name contains the text. An earlier commit is recorded with its own source and examples:

    PYTHONPATH=EARLIER/src python -m evidence.same_figures record BEFORE.json --checkout EARLIER

compare : counts and largest differences by kind, and every figure that differs by more than 1e-9 of max(1, |value|) or
is on one side only. Exit status 1 if there is any.

Which questions a scene is asked hangs on its size (the limits below), so that a whole run takes some minutes.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import math
import os
import sys
from collections.abc import Callable, Iterator
from inspect import signature
from pathlib import Path
from time import process_time
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import blockstat
    from evidence.figure_scenes import Scene

ROOT = Path(__file__).parents[1]
SAME = 1e-9
SIDE = (1.0, 0.2, 0.0)  #: direction of the limit loads
THREADS = ("OMP_NUM_THREADS", "MKL_NUM_THREADS", "OPENBLAS_NUM_THREADS", "RAYON_NUM_THREADS")

#: The most contact points of a scene that is asked for: a limit load, a Coulomb verdict, tilt and friction limits and
#: thrusts, a Coulomb limit, the literal program.
LIMIT, COULOMB, MARGINS, COULOMB_LIMIT, LITERAL = 22_000, 6_000, 500, 160, 250

#: Kinds of figures by the last word of their name; what is not here is a number of the scene itself.
KINDS = {
    "outcomes": ("outcome", "settles", "solves", "moving"),
    "proven bounds": ("lower", "upper", "stands", "falls", "least", "greatest", "reaction"),
    "coulomb brackets": ("coulomb_lower", "coulomb_upper"),
    "scores": ("score",),
    "certificates": ("residual", "cone_violation", "work", "mechanism_violation", "required_force"),
    "reference values": ("value", "bracket"),
}
KIND = {word: kind for kind, words in KINDS.items() for word in words}

Figures = dict[str, Any]
Ask = Callable[[], Figures]


def word(outcome: Any) -> str:
    return outcome.name.lower()


def verdict_figures(verdict: blockstat.Verdict) -> Figures:
    proof = verdict.certificate
    found = {
        "outcome": word(verdict.outcome),
        "score": verdict.score,
        "residual": proof.residual,
        "cone_violation": proof.cone_violation,
        "work": proof.work,
        "mechanism_violation": proof.mechanism_violation,
        "required_force": proof.required_force,
        "moving": len(verdict.moving),
    }
    if verdict.coulomb is not None:
        found |= {"settles": str(verdict.coulomb.settles), "solves": verdict.coulomb.solves}
    return found


def short_figures(verdict: blockstat.Verdict) -> Figures:
    return {"outcome": word(verdict.outcome), "score": verdict.score}


def limit_figures(limit: blockstat.LimitLoad) -> Figures:
    found = {"outcome": word(limit.outcome), "lower": limit.lower, "upper": limit.upper}
    if limit.coulomb is not None:
        found |= {"coulomb_lower": limit.coulomb[0], "coulomb_upper": limit.coulomb[1]}
    return found


def bracket_figures(bracket: Any) -> Figures:
    return {"stands": bracket.stands, "falls": bracket.falls}


def asked(scene: Scene, assembly: blockstat.Assembly) -> Iterator[tuple[str, Ask]]:
    """The questions to one scene: a name and what answers it."""
    import blockstat as b

    faces = b.find_interfaces(assembly)
    points, given = faces.n_points, {"interfaces": faces, **scene.options}
    flow = {**given, "flow": "coulomb"}
    # An earlier source always goes on to the optimum.
    optimum = {"optimum": True} if "optimum" in signature(b.limit_load).parameters else {}
    yield "scene", lambda: {
        "blocks": assembly.n_blocks, "interfaces": faces.n_interfaces, "points": points,
        "area": float(faces.area.sum()), "mass": float(assembly.mass.sum()),
    }  # fmt: skip
    yield "assess", lambda: verdict_figures(b.assess(assembly, **given))
    if points <= COULOMB:
        yield "assess, coulomb", lambda: verdict_figures(b.assess(assembly, **flow))
    if scene.short:
        return
    for solver, most in (("interior-point", LIMIT), ("clarabel", COULOMB), ("cvxpy", LITERAL)):
        if points <= most:
            yield f"assess, {solver}", lambda s=solver: short_figures(b.assess(assembly, solver=s, **given))
    if points <= LIMIT:
        yield "limit_load", lambda: limit_figures(b.limit_load(assembly, SIDE, **given, **optimum))
    if points <= COULOMB_LIMIT:
        yield "limit_load, coulomb", lambda: limit_figures(b.limit_load(assembly, SIDE, **flow, **optimum))
    if points <= MARGINS:
        own = {key: value for key, value in scene.options.items() if key == "friction"}
        yield "tilt_limit x", lambda: bracket_figures(b.tilt_limit(assembly, "x", **own))
        yield "tilt_limit y", lambda: bracket_figures(b.tilt_limit(assembly, (-0.3, 1.0, 0.0), **own))
        yield "friction_limit", lambda: bracket_figures(b.friction_limit(assembly))
        last = [name for name, support in zip(assembly.names, assembly.support, strict=True) if support][-1:]
        yield "thrust_range", lambda: _thrust(b.thrust_range(assembly, last, (1, 0, 0), **given))
        yield "settlement", lambda: {"reaction": b.settlement(assembly, last, (0, 0, -1), **given).reaction}


def _thrust(found: Any) -> Figures:
    return {"least": found.least, "greatest": found.greatest}


def answered(ask: Ask) -> Figures:
    """The figures of a question; a refusal is an outcome, and so is an error."""
    import blockstat

    try:
        return ask()
    except blockstat.InputError:
        return {"outcome": "refused"}
    except Exception as error:
        return {"outcome": f"error: {type(error).__name__}"}


def questions(checkout: Path) -> Iterator[tuple[str, Callable[[], Figures]]]:
    """Each scene or reference by name, with a function of all its figures by question and word."""
    from evidence.figure_scenes import reference_rows, scenes

    def of_scene(scene: Scene) -> Figures:
        found: Figures = {}

        def build() -> Figures:
            for name, ask in asked(scene, scene.make()):
                found.update({f"{name}: {key}": value for key, value in answered(ask).items()})
            return {}

        return found | {f"scene: {key}": value for key, value in answered(build).items()}

    def of_row(compute: Callable[[], Any]) -> Figures:
        def ask() -> Figures:
            found = compute()
            return {"value": found.ours, "bracket": found.bracket}

        return {f"row: {key}": value for key, value in answered(ask).items()}

    for scene in scenes(checkout):
        yield scene.name, lambda scene=scene: of_scene(scene)
    for name, compute in reference_rows():
        yield name, lambda compute=compute: of_row(compute)


def digest(*folders: Path) -> str:
    """What identifies the code that is measured and that measures."""
    found = hashlib.sha256()
    for folder in folders:
        for path in sorted(folder.rglob("*.py")):
            found.update(path.relative_to(folder).as_posix().encode() + path.read_bytes())
    return found.hexdigest()


def record(out: Path, checkout: Path, only: str) -> None:
    for name in THREADS:
        os.environ[name] = "1"
    import warnings

    import blockstat

    warnings.simplefilter("ignore")
    code = digest(Path(blockstat.__file__).parent, Path(__file__).parent)
    kept = json.loads(out.read_text()) if out.is_file() else {}
    kept = kept if kept.get("code") == code else {"code": code, "seconds": {}, "figures": {}}
    everything = [row for row in questions(checkout) if only in row[0]]
    for number, (name, compute) in enumerate(everything, 1):
        if name in kept["figures"]:
            continue
        begin = process_time()
        figures = compute()
        kept["figures"][name] = {key: _plain(value) for key, value in figures.items()}
        kept["seconds"][name] = round(process_time() - begin, 3)
        _save(out, kept)
        print(f"{number}/{len(everything)} {name}: {kept['seconds'][name]:.2f} s", file=sys.stderr, flush=True)
    every = flat(kept["figures"])
    print(f"{len(every)} figures of {len(kept['figures'])} scenes in {sum(kept['seconds'].values()):.0f} s: {out}")
    for name, value in every.items():
        if str(value).startswith("error") or (name.endswith("| scene: outcome") and value == "refused"):
            print(f"{value}: {name}")


def _plain(value: Any) -> Any:
    """For JSON, which knows neither infinity nor what is not a number."""
    if isinstance(value, (str, bool)):
        return value
    if not math.isfinite(value):
        return str(float(value))
    return int(value) if float(value).is_integer() and abs(value) < 2**53 else float(value)


def _save(out: Path, kept: dict[str, Any]) -> None:
    part = out.with_suffix(".part")
    part.write_text(json.dumps(kept, indent=1))
    part.replace(out)


def difference(before: Any, after: Any) -> float:
    """How far two figures are apart, relative to max(1, |value|); infinite where they are not both numbers."""
    if before == after:
        return 0.0
    if isinstance(before, str) or isinstance(after, str):
        return math.inf
    return abs(after - before) / max(1.0, abs(before), abs(after))


def flat(figures: dict[str, Figures]) -> dict[str, Any]:
    return {f"{scene} | {key}": value for scene, own in figures.items() for key, value in own.items()}


def kind_of(name: str) -> str:
    return KIND.get(name.rpartition(": ")[2], "scenes")


def compare(before: dict[str, Figures], after: dict[str, Figures]) -> tuple[str, bool]:
    """A report on two recordings, and whether all is the same."""
    old, new = flat(before), flat(after)
    apart = {name: difference(old[name], new[name]) for name in old.keys() & new.keys()}
    lines = ["kind | compared | equal to the bit | differ by more than 1e-9 | largest relative difference"]
    for kind in ["scenes", *KINDS]:
        own = {name: apart[name] for name in apart if kind_of(name) == kind}
        worst = max(own, key=lambda name: (own[name], name), default="")
        over = sum(value > SAME for value in own.values())
        largest = f"{own[worst]:.1e} at {worst}" if worst and own[worst] else "0"
        lines.append(f"{kind} | {len(own)} | {sum(not v for v in own.values())} | {over} | {largest}")
    different = sorted((name for name in apart if apart[name] > SAME), key=lambda name: (-apart[name], name))
    lines += [f"differs: {name}: {old[name]} -> {new[name]} ({apart[name]:.1e})" for name in different]
    lines += [f"only before: {name}: {old[name]}" for name in sorted(old.keys() - new.keys())]
    lines += [f"only after: {name}: {new[name]}" for name in sorted(new.keys() - old.keys())]
    same = not different and old.keys() == new.keys()
    lines.append("All figures are the same." if same else f"{len(different)} figures differ.")
    return "\n".join(lines), same


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    commands = parser.add_subparsers(dest="command", required=True)
    recording = commands.add_parser("record")
    recording.add_argument("out", type=Path)
    recording.add_argument("--checkout", type=Path, default=ROOT)
    recording.add_argument("--only", default="")
    comparing = commands.add_parser("compare")
    comparing.add_argument("before", type=Path)
    comparing.add_argument("after", type=Path)
    options = parser.parse_args()
    if options.command == "record":
        record(options.out, options.checkout.resolve(), options.only)
        return
    report, same = compare(*(json.loads(path.read_text())["figures"] for path in (options.before, options.after)))
    print(report)
    sys.exit(not same)


if __name__ == "__main__":
    main()
