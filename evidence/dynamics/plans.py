"""Plans of building: each step in Bullet beside the statics, and orders for published assemblies with two hands.

    python -m evidence.dynamics.plans [--only ROW ...] [--write FILE]

With `--only` the other rows are those that the file has. The arch, the dome and its plans are those of Ziqi Wang
(AssemblyEnv 2024, LearningToAssemble 2025) and are left out where they are absent; the chapel is that of `examples/`.
"""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from time import process_time

from blockstat import Assembly, Plan, assess_plan, build, build_by_courses, find_order, load_scene, read
from blockstat.sequence.plan import read_plan
from dynsim import sequence
from dynsim.comparison.steps import compare_steps
from evidence import results
from evidence.paths import EXAMPLES, SEQUENCES
from evidence.tables import table

PUBLISHED = ("arch", "dome", "dome72", "mario", "tetris-1", "tetris-2", "tetris-4")
PLANS = ("dome_0703origin", "dome_0703start1", "dome_0903shortee")
HANDS, FRICTION = 2, 0.55
BULLET = ("plan", "friction", "steps", "agree", "Coulomb sides with Bullet", "hangs on the joints", "unexplained", "s")
ORDERS = ("assembly", "blocks", "steps", "most held", "states", "ms a state", "s")


def published(name: str) -> Assembly:
    """An assembly of the collection."""
    return read(next(SEQUENCES.rglob(f"{name}.json")))


def small_arch() -> tuple[Assembly, Plan]:
    """Nine stones and an order with two hands."""
    assembly = published("arch").with_(friction=FRICTION)
    plan = find_order(assembly, held_at_most=HANDS).plan
    assert plan is not None
    return assembly, plan


def chapel() -> tuple[Assembly, Plan]:
    """The chapel by courses."""
    assembly = build(load_scene(EXAMPLES / "chapel.toml"))
    plan = build_by_courses(assembly).plan
    assert plan is not None
    return assembly, plan


def dome(name: str, friction: float) -> tuple[Assembly, Plan]:
    """A published plan of the dome."""
    assembly = published("dome72").with_(friction=friction)
    return assembly, read_plan(SEQUENCES / f"{name}.json", assembly)


SITES: dict[str, Callable[[], tuple[Assembly, Plan]]] = {"arch": small_arch, "chapel": chapel}
for _name in PLANS:
    for _friction in (0.7, 0.55):
        SITES[f"{_name} {_friction}"] = lambda name=_name, friction=_friction: dome(name, friction)


def in_bullet(row: str) -> list[str]:
    """What Bullet and statics say of the steps of a plan."""
    assembly, plan = SITES[row]()
    begin = process_time()
    found = sequence(assembly, plan)
    seconds = process_time() - begin
    compared = compare_steps(assembly, found)
    both = [k for k in compared.differ if k not in compared.unexplained]
    hangs = sum(compared.tightness[k] is not None for k in both)
    steps = len(plan.steps)
    agree = steps - len(compared.differ) - len(compared.undecided)
    counts = (steps, agree, len(both) - hangs, hangs, len(compared.unexplained))
    print(compared.explain(), flush=True)
    return [row.split()[0], f"{assembly.friction:g}", *map(str, counts), f"{seconds:.0f}"]


def ordered(name: str) -> list[str]:
    """An order with two hands, each step of it judged again."""
    assembly = published(name).with_(friction=FRICTION)
    begin = process_time()
    found = find_order(assembly, held_at_most=HANDS)
    seconds = process_time() - begin
    assert found.plan is not None, found.outcome.value
    assert assess_plan(assembly, found.plan).outcome.word == "stable"
    each = f"{1e3 * seconds / found.states:.0f}"
    steps, held = str(len(found.plan.steps)), str(found.plan.most_held)
    return [name, str(len(assembly.free)), steps, held, str(found.states), each, f"{seconds:.1f}"]


def known_rows(path: Path | None, part: str) -> list[list[str]]:
    """The rows of a table in a file of results."""
    if path is None or not path.exists():
        return []
    lines = results.load(path)[1].get(part, "").splitlines()[2:]
    return [[cell.strip() for cell in line.strip("|").split("|")] for line in lines]


def main() -> None:
    names = [*SITES, *(f"order {name}" for name in PUBLISHED)]
    parser = results.parser(__doc__)
    parser.add_argument("--only", nargs="+", default=names, choices=names, help="keep the other rows of the file")
    options = parser.parse_args()
    bullet = {f"{row[0]} {row[1]}": row for row in known_rows(options.write, "bullet")}
    orders = {row[0]: row for row in known_rows(options.write, "orders")}
    for name in options.only:
        if name.startswith("order "):
            orders[name.split()[1]] = ordered(name.split()[1])
        else:
            row = in_bullet(name)
            bullet[f"{row[0]} {row[1]}"] = row
        parts = {"bullet": table(BULLET, bullet.values()), "orders": table(ORDERS, orders.values())}
        text = "\n\n".join(parts.values())
        if options.write:
            results.save(options.write, parts, ["--write", str(options.write)])
    print(json.dumps({"bullet": list(bullet.values()), "orders": list(orders.values())}) if options.json else text)


if __name__ == "__main__":
    main()
