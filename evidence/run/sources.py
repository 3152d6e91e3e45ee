"""The files that a job's figures depend on, and a hash of what they say.

A job depends on its own module and on every module of ours that this one imports, directly or through others, inside
functions too. A name that a package hands on counts as the module where it is defined. Comments, docstrings and layout
do not count, and neither do imports that only types need.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterator
from functools import cache
from pathlib import Path

from evidence.paths import EXAMPLES, ROOT

PLACES = {"blockstat": ROOT / "src", "dynsim": ROOT / "src", "evidence": ROOT}


def file_of(module: str) -> Path | None:
    """The file of a module of ours; None for any other."""
    place = PLACES.get(module.split(".")[0])
    if place is None:
        return None
    path = place.joinpath(*module.split("."))
    return next((p for p in (path.with_suffix(".py"), path / "__init__.py") if p.is_file()), None)


def dependencies(module: str) -> list[Path]:
    """All files that a module depends on, itself among them, in the order of their paths."""
    found: set[str] = set()
    left = [module]
    while left:
        one = left.pop()
        if one not in found:
            found.add(one)
            left += used_by(one)
    files = {path for one in found if (path := file_of(one))}
    if any("EXAMPLES" in path.read_text() for path in files):
        files |= set(EXAMPLES.glob("*.toml"))
    return sorted(files)


def digest(module: str) -> str:
    """A hash of all that a module depends on."""
    whole = hashlib.sha256()
    for path in dependencies(module):
        whole.update(f"{path.relative_to(ROOT)} {statements(path)}\n".encode())
    return whole.hexdigest()[:16]


@cache
def used_by(module: str) -> frozenset[str]:
    """The modules of ours in which the names that a module uses are defined."""
    path = file_of(module)
    if path is None:
        return frozenset()
    tree = _tree(path)
    names = {name for name in _imported(tree)}
    aliases = {own: whole for whole, own in names if file_of(whole)}
    wholes = {whole for whole, _ in names}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name) and node.value.id in aliases:
            wholes.add(f"{aliases[node.value.id]}.{node.attr}")
        elif isinstance(node, ast.Constant) and str(node.value).startswith("evidence.") and file_of(node.value):
            wholes.add(node.value)  # the module of a process that is started
    return frozenset(home for whole in wholes if (home := defined_in(whole)) and home != module)


def defined_in(whole: str) -> str | None:
    """The module that defines a name given with its package, or that is this name; None for what is not ours."""
    if (path := file_of(whole)) is not None:
        # A package by itself hands on names; which of them are used is seen where they are.
        return None if path.name == "__init__.py" else whole
    package, _, name = whole.rpartition(".")
    path = file_of(package) if package else None
    if path is None:
        return None
    if path.name == "__init__.py":
        for other, own in _imported(_tree(path), types=True):
            if own == name and other != whole:
                return defined_in(other)
    return package


def _imported(tree: ast.Module, types: bool = False) -> Iterator[tuple[str, str]]:
    """What is imported, with its package, and under which name; what only types need if it is asked for."""
    left: list[ast.AST] = [tree]
    while left:
        node = left.pop()
        if isinstance(node, ast.Import):
            yield from ((alias.name, alias.asname or alias.name) for alias in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            yield from ((f"{node.module}.{alias.name}", alias.asname or alias.name) for alias in node.names)
        elif isinstance(node, ast.If) and isinstance(node.test, ast.Name) and node.test.id == "TYPE_CHECKING":
            left += node.body if types else node.orelse
        else:
            left += ast.iter_child_nodes(node)


@cache
def _tree(path: Path) -> ast.Module:
    return ast.parse(path.read_text())


@cache
def statements(path: Path) -> str:
    """A hash of a file's statements; of the text of what is not Python."""
    text = path.read_text()
    if path.suffix == ".py":
        tree = ast.parse(text)
        for node in ast.walk(tree):
            if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(node) is not None:
                node.body = node.body[1:]
        text = ast.dump(tree)
    return hashlib.sha256(text.encode()).hexdigest()
