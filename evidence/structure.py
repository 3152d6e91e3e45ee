"""Counts that say how the source is laid out: rooms, import circles, the walk from scene to verdict, docstrings.

python -m evidence.structure [--source DIR] [--json]

--source : root of the checkout to measure, by default the one that holds this file. Modules are read, not imported,
but for the walk and the public names: those are measured by `evidence.walk` in a process of their own on that source.

A package is a folder of `src`. A room is a folder of modules inside a package. Imports count wherever they stand: at
the top, inside a function, under TYPE_CHECKING. Circles of rooms are those of folders right under a package, with all
they hold, and of single modules of its root.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import re
import subprocess
import sys
from collections import Counter
from collections.abc import Iterable, Iterator
from pathlib import Path
from typing import Any

from evidence.walk import PARAMETERS

ROOT = Path(__file__).parents[1]
LARGEST_ROOM = 12
#: A spec class repeats a builder when the two share at least this part of the names that either has.
REPEATED = 0.75
PATH_EDIT = re.compile(r"sys\.path\s*(\.\s*(insert|append|extend)\b|\[[^]\n]*\]\s*=[^=]|\+?=[^=])")
#: Folders of a checkout that hold no code of the project.
FOREIGN = {"build", "dist", "out", "node_modules", "__pycache__"}

Graph = dict[str, set[str]]
Function = ast.FunctionDef | ast.AsyncFunctionDef


def modules(source: Path) -> dict[str, Path]:
    """Files of a source folder by dotted name; a package goes by the name of its folder."""
    found = {}
    for path in sorted(source.rglob("*.py")):
        parts = path.relative_to(source).with_suffix("").parts
        found[".".join(parts[:-1] if parts[-1] == "__init__" else parts)] = path
    return found


def imports(files: dict[str, Path]) -> Graph:
    """Modules of `files` that each module imports, wherever the import stands."""
    graph: Graph = {name: set() for name in files}
    for name, path in files.items():
        for target, member in _imported(ast.parse(path.read_text()), name, path.stem == "__init__"):
            full = f"{target}.{member}" if member else target
            # `from package import name` may name a module of the package or something the package defines.
            wanted = full if full in files else target
            if wanted in files and wanted != name:
                graph[name].add(wanted)
    return graph


def _imported(tree: ast.AST, name: str, package: bool) -> Iterator[tuple[str, str]]:
    """Module and member of each import; the member is empty for `import module`."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from ((alias.name, "") for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = node.module or ""
            if node.level:
                parts = name.split(".")
                above = parts[: len(parts) - node.level + package]
                base = ".".join([*above, *filter(None, [base])])
            yield from ((base, alias.name) for alias in node.names)


def circles(graph: Graph) -> list[list[str]]:
    """Strongly connected components of more than one node, the largest first (Tarjan 1972)."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found: list[list[str]] = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(graph[node]):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            at = stack.index(node)
            found.append(sorted(stack[at:]))
            del stack[at:]

    for node in sorted(graph):
        if node not in index:
            visit(node)
    return sorted((own for own in found if len(own) > 1), key=lambda own: (-len(own), own))


def unit(name: str) -> str:
    """What an order of rooms ranks: a folder right under a package, or a module of the package's root."""
    return ".".join(name.split(".")[:2])


def rooms_graph(graph: Graph) -> Graph:
    """Imports between rooms. The root `__init__` of a package is its public face and belongs to no room."""
    between: Graph = {unit(name): set() for name in graph if "." in name}
    for name, targets in graph.items():
        if "." in name:
            between[unit(name)] |= {unit(other) for other in targets if "." in other} - {unit(name)}
    return between


def folders(source: Path) -> dict[str, int]:
    """Modules of each room, `__init__` not counted; "package" itself stands for the files of its root, all counted."""
    found: Counter[str] = Counter()
    for path in source.rglob("*.py"):
        folder = path.parent.relative_to(source)
        found[folder.as_posix()] += len(folder.parts) == 1 or path.stem != "__init__"
    return dict(sorted(found.items()))


def functions(tree: ast.Module) -> Iterator[tuple[str, Function]]:
    """Functions and methods of a module without a leading underscore, not those inside functions."""
    for node in tree.body:
        if isinstance(node, Function) and not node.name.startswith("_"):
            yield node.name, node
        elif isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for own in node.body:
                if isinstance(own, Function) and not own.name.startswith("_"):
                    yield f"{node.name}.{own.name}", own


def takes_arguments(node: Function, method: bool) -> bool:
    options = node.args
    named = [*options.posonlyargs, *options.args, *options.kwonlyargs]
    static = any(isinstance(mark, ast.Name) and mark.id == "staticmethod" for mark in node.decorator_list)
    return len(named) - (method and not static) > 0 or options.vararg is not None or options.kwarg is not None


def lacks_parameters(doc: str | None) -> bool:
    """Whether a docstring has no "Parameters" section in numpy's form."""
    return not PARAMETERS.search(doc or "")


def undocumented(files: dict[str, Path]) -> dict[str, list[str]]:
    """Of all functions and methods of the source that take arguments, those without docstring and without section."""
    found: dict[str, list[str]] = {"all": [], "no_docstring": [], "no_parameters": []}
    for name, path in files.items():
        for own, node in functions(ast.parse(path.read_text())):
            if not takes_arguments(node, "." in own):
                continue
            doc, label = ast.get_docstring(node), f"{name}.{own}"
            found["all"].append(label)
            if doc is None:
                found["no_docstring"].append(label)
            if lacks_parameters(doc):
                found["no_parameters"].append(label)
    return found


def _fields(node: ast.ClassDef) -> set[str]:
    return {own.target.id for own in node.body if isinstance(own, ast.AnnAssign) and isinstance(own.target, ast.Name)}


def repeated_fields(source: Path, spec: str = "blockstat/spec", model: str = "blockstat/model") -> dict[str, list[str]]:
    """Fields that a class of `spec` declares and one builder of `model` declares again, by class.

    A builder is a function with keywords or a dataclass with fields. It repeats a class when the names that both have
    are at least REPEATED of those that either has: names alone decide, so what shares fewer is not seen. "present" is
    no field of a builder and not counted.
    """
    builders: list[set[str]] = []
    for path in sorted((source / model).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, Function):
                builders.append({option.arg for option in [*node.args.args, *node.args.kwonlyargs]} - {"self"})
            elif isinstance(node, ast.ClassDef):
                builders.append(_fields(node))
    found = {}
    for path in sorted((source / spec).rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text())):
            if isinstance(node, ast.ClassDef) and (own := _fields(node) - {"present"}):
                nearest = max(builders, key=lambda names: len(own & names) / len(own | names), default=set())
                if len(own & nearest) >= REPEATED * len(own | nearest):
                    found[f"{path.stem}.{node.name}"] = sorted(own & nearest)
    return found


def project_files(root: Path, *suffixes: str) -> Iterator[Path]:
    for path in sorted(root.rglob("*")):
        parts = path.relative_to(root).parts
        if path.suffix in suffixes and not any(part in FOREIGN or part.startswith(".") for part in parts):
            yield path


def path_edits(root: Path) -> list[str]:
    """Lines that change `sys.path`, in Python files and notebooks."""
    return [
        f"{path.relative_to(root).as_posix()}:{number}"
        for path in project_files(root, ".py", ".ipynb")
        for number, line in enumerate(path.read_text().splitlines(), 1)
        if PATH_EDIT.search(line)
    ]


def calls(files: dict[str, Path], name: str, origin: str) -> list[str]:
    """Places that call a function of that name in modules that import it, or its module, from a library."""
    found = []
    for module, path in files.items():
        tree = ast.parse(path.read_text())
        known = {
            member or target
            for target, member in _imported(tree, module, path.stem == "__init__")
            if target.split(".")[0] == origin
        }
        for node in ast.walk(tree):
            if isinstance(node, ast.Call) and (parts := ast.unparse(node.func).split("."))[-1] == name:
                if parts[0] in known:
                    found.append(f"{module}:{node.lineno}")
    return found


def measured(root: Path) -> dict[str, Any]:
    """Walk and public names of a checkout, by `evidence.walk` in a process that imports that checkout."""
    environment = {**os.environ, "PYTHONPATH": str(root / "src"), "OMP_NUM_THREADS": "1", "MKL_NUM_THREADS": "1"}
    command = [sys.executable, "-m", "evidence.walk", str(root)]
    answer = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True, check=False)
    if answer.returncode:
        raise SystemExit(f"the walk failed on {root}:\n{answer.stderr}")
    return json.loads(answer.stdout.splitlines()[-1])


def counts(root: Path) -> dict[str, Any]:
    """Everything this script measures about a checkout."""
    source = root / "src"
    files = modules(source)
    graph = imports(files)
    sizes = folders(source)
    within = {name: number for name, number in sizes.items() if "/" in name}
    run = measured(root)
    return {
        "modules": len(files),
        "package_roots": {name: number for name, number in sizes.items() if "/" not in name},
        "rooms": within,
        "large_rooms": {name: number for name, number in within.items() if number > LARGEST_ROOM},
        "module_circles": circles(graph),
        "room_circles": circles(rooms_graph(graph)),
        "walk": run["walk"],
        "public": run["public"],
        "functions": undocumented(files),
        "repeated_fields": repeated_fields(source),
        "path_edits": path_edits(root),
        "connected_components": calls(files, "connected_components", "scipy"),
        "shadowed": [
            name for name in run["public"]["functions"] if name in files and name.count(".") == 1
        ],
    }  # fmt: skip


def _listed(title: str, names: Iterable[str], *, show: bool = True) -> str:
    """A count with what it counts below it."""
    names = list(names)
    return f"{title}: {len(names)}" + "".join(f"\n    {name}" for name in names if show)


def page(found: dict[str, Any]) -> str:
    """The counts as text."""
    walk, public, every, repeated = found["walk"], found["public"], found["functions"], found["repeated_fields"]
    return "\n".join(
        [
            f"modules: {found['modules']}",
            *(f"files in the root of {name}: {number}" for name, number in found["package_roots"].items()),
            _listed("rooms", (f"{name}: {number}" for name, number in found["rooms"].items())),
            _listed(f"rooms over {LARGEST_ROOM} modules", found["large_rooms"]),
            _listed("import circles of modules", map(", ".join, found["module_circles"])),
            _listed("import circles of rooms", map(", ".join, found["room_circles"])),
            _listed("files on the walk from scene to verdict", walk["files"]),
            _listed("of these in assess alone", walk["assess_files"], show=False),
            _listed("types constructed in assess, in order", walk["types"]),
            _listed("public functions", public["functions"], show=False),
            _listed("public classes", public["classes"], show=False),
            _listed("their methods and properties", public["methods"], show=False),
            _listed("public without a docstring", public["no_docstring"]),
            _listed("public with arguments, without a Parameters section", public["no_parameters"]),
            _listed("functions of the source with arguments, no leading underscore", every["all"], show=False),
            _listed("of these without a docstring", every["no_docstring"], show=False),
            _listed("of these without a Parameters section", every["no_parameters"], show=False),
            f"duplicated declarations: {sum(map(len, repeated.values()))}",
            _listed("in classes", (f"{name}: {len(own)}" for name, own in repeated.items())),
            _listed("edits of sys.path", found["path_edits"]),
            _listed("calls of scipy's connected_components", found["connected_components"]),
            _listed("public functions that share the name of a module", found["shadowed"]),
        ]
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--source", type=Path, default=ROOT)
    parser.add_argument("--json", action="store_true")
    options = parser.parse_args()
    if not (options.source / "src").is_dir():
        parser.error(f"no src in {options.source}")
    found = counts(options.source.resolve())
    print(json.dumps(found, indent=1) if options.json else page(found))


if __name__ == "__main__":
    main()
