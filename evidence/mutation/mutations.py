"""Places in the source where a mutation is possible, and a random sample of them."""

from __future__ import annotations

import ast
import difflib
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from random import Random
from warnings import catch_warnings

from evidence.paths import ROOT

SOURCE = ROOT / "src"
#: What holds verdicts, bounds, contacts, laws, loads, criteria and files.
ROOMS = (
    "blockstat/analysis", "blockstat/certificate", "blockstat/contact", "blockstat/io", "blockstat/loading",
    "blockstat/program", "blockstat/joint.py", "blockstat/loads.py", "blockstat/assembly.py", "dynsim/judge",
)  # fmt: skip
#: A class without its decorator cannot be imported, so that any test kills it.
LEFT_OUT = ("core/RemoveDecorator", "core/NoOp")
#: Operators are replaced by others of their kind: floats have no bits, and what cannot run flatters the tests.
KINDS = ({"Add", "Sub", "Mul", "Div", "FloorDiv", "Mod", "Pow"}, {"BitOr", "BitAnd", "BitXor", "LShift", "RShift"})
#: Identity replaced by equality.
EQUALITY = ("_Is_Eq", "_IsNot_NotEq")

Span = tuple[tuple[int, int], tuple[int, int]]


@dataclass(frozen=True)
class Mutation:
    """One change of one file."""

    path: str  #: of the file, from src
    operator: str  #: Cosmic Ray's name
    occurrence: int  #: which of the places of the operator in the file
    line: int

    @property
    def room(self) -> str:
        """The entry of `ROOMS` that it belongs to."""
        return next(room for room in ROOMS if self.path.startswith(room))

    @property
    def key(self) -> str:
        """What it is called in files."""
        return f"{self.path}:{self.operator.removeprefix('core/')}:{self.occurrence}"

    def text(self) -> str:
        """The mutated file."""
        from cosmic_ray.mutating import mutate_code
        from cosmic_ray.plugins import get_operator

        text = mutate_code((SOURCE / self.path).read_text(), get_operator(self.operator)(), self.occurrence)
        if text is None:
            raise ValueError(f"no mutation {self.key}")
        return text


def changed_lines(before: str, after: str) -> tuple[str, str]:
    """The lines of a text that a mutation takes out and those that it puts in, without indentation."""
    out, new = [], []
    for line in difflib.ndiff(before.splitlines(), after.splitlines()):
        if line[:2] in ("- ", "+ "):
            (out if line[0] == "-" else new).append(line[2:].strip())
    return "\n".join(out), "\n".join(new)


def files(rooms: Sequence[str] = ROOMS) -> list[Path]:
    """The files of rooms."""
    found = []
    for room in rooms:
        path = SOURCE / room
        found += [path] if path.is_file() else sorted(path.rglob("*.py"))
    return found


def sites(path: Path) -> dict[Span, list[Mutation]]:
    """The mutations of a file by the place that they change, without those that change nothing in any program.

    Annotations are read by nothing. A negative length of `reshape` is the open one, whichever it is. A member of an
    enumeration is equal to itself alone.
    """
    from cosmic_ray.ast import ast_nodes, get_ast
    from cosmic_ray.plugins import get_operator, operator_names

    text = path.read_text()
    nodes = list(ast_nodes(get_ast(text)))
    tree = ast.parse(text)
    unread, members = [*_annotations(tree), *_open_lengths(tree)], list(_comparisons_with_members(tree))
    found: defaultdict[Span, list[Mutation]] = defaultdict(list)
    for name in operator_names():
        if not _is_fair(name) or get_operator(name).arguments():
            continue
        operator = get_operator(name)()
        places = (place for node in nodes for place in operator.mutation_positions(node))
        for occurrence, (start, stop) in enumerate(places):
            nothing = [*unread, *members] if name.endswith(EQUALITY) else unread
            if not any(first <= start and stop <= last for first, last in nothing):
                mutation = Mutation(str(path.relative_to(SOURCE)), name, occurrence, start[0])
                found[start, stop].append(mutation)
    return found


def sample(number: int, seed: int, rooms: Sequence[str] = ROOMS) -> list[Mutation]:
    """Mutations at different places, each place as likely as any other, and one of the mutations of each."""
    random = Random(seed)
    places = [changes for path in files(rooms) for _, changes in sorted(sites(path).items())]
    mixed = (random.sample(changes, len(changes)) for changes in random.sample(places, len(places)))
    chosen = (next(filter(_does_compile, changes), None) for changes in mixed)
    return list(islice(filter(None, chosen), number))


def _does_compile(mutation: Mutation) -> bool:
    """Whether Python takes it: two stars before the options of a call are no power, though they look like one."""
    with catch_warnings(action="ignore", category=SyntaxWarning):
        try:
            compile(mutation.text(), mutation.path, "exec")
        except SyntaxError:
            return False
    return True


def _is_fair(name: str) -> bool:
    """Whether a mutation may run and do something else."""
    kind, *which = name.split("_")
    return name not in LEFT_OUT and (kind != "core/ReplaceBinaryOperator" or any({*which} <= kind for kind in KINDS))


def _annotations(tree: ast.Module) -> Iterator[Span]:
    for node in ast.walk(tree):
        for child in (getattr(node, "annotation", None), getattr(node, "returns", None)):
            if isinstance(child, ast.expr):
                yield _span(child)


def _open_lengths(tree: ast.Module) -> Iterator[Span]:
    """The lengths -1 of `reshape`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Call) and isinstance(node.func, ast.Attribute) and node.func.attr == "reshape":
            for part in ast.walk(node):
                if isinstance(part, ast.UnaryOp) and ast.unparse(part) == "-1":
                    yield _span(part)


def _comparisons_with_members(tree: ast.Module) -> Iterator[Span]:
    """What stands between the sides of a comparison with `Class.MEMBER`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Compare):
            sides = [node.left, *node.comparators]
            for left, right in zip(sides, sides[1:], strict=False):
                if isinstance(right, ast.Attribute) and right.attr.isupper():
                    yield _span(left)[1], _span(right)[0]


def _span(node: ast.expr) -> Span:
    return (node.lineno, node.col_offset), (node.end_lineno or node.lineno, node.end_col_offset or node.col_offset)
