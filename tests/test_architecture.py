"""Imports run one way through the rooms, and modules stay small."""

import ast
import importlib
import io
import re
import subprocess
import sys
import tokenize
from itertools import pairwise
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src"
#: The rooms of both packages from the ground up. A room imports itself and what stands before it. A module of a package
#: root is a room of its own; a package without a module name is its `__init__`, which hands names to users.
ORDER = """
    blockstat.typing blockstat.errors blockstat.system blockstat.result blockstat.geometry
    blockstat.surface blockstat.joint blockstat.assembly blockstat.loads blockstat.contact blockstat.imperfection
    blockstat.loading blockstat.io.raw blockstat.io blockstat.model.quantities blockstat.model.size
    blockstat.model.expression blockstat.model.solids blockstat.model.placing blockstat.model.arches
    blockstat.model.walling
    blockstat.model.vaults blockstat.model.buttresses blockstat.model blockstat.spec
    blockstat.geometry_repair blockstat.linear_algebra blockstat.program blockstat.certificate blockstat.solve
    blockstat.analysis blockstat.compas blockstat.sensitivity blockstat.proof blockstat.chance
    blockstat.large_displacement.displaced blockstat.large_displacement.overlap blockstat.large_displacement.statics
    blockstat.large_displacement.linkage blockstat.large_displacement.finite_steps
    blockstat.large_displacement blockstat.studies blockstat.reinforcement blockstat.traffic
    blockstat.code_check blockstat.sequence blockstat.sequence.taking_down blockstat.design_search blockstat.view
    blockstat.view.three_d blockstat.view.building blockstat.view.report blockstat blockstat.app blockstat.cli
    dynsim.settings dynsim.checks dynsim.engine dynsim.loads dynsim.bonds dynsim.judge dynsim.parallel
    dynsim.earthquake dynsim.comparison dynsim.design_search dynsim.view dynsim.panel dynsim.cli dynsim
""".split()
RANK = {room: rank for rank, room in enumerate(ORDER)}
FILES = sorted(SOURCE.rglob("*.py"))
MOST_IN_ROOM, MOST_IN_ROOT = 12, 8


def name_of(path: Path) -> str:
    parts = path.relative_to(SOURCE).with_suffix("").parts
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


MODULES = {name_of(path): path for path in FILES}


def imported(path: Path) -> set[str]:
    """Modules of ours that a file imports: at the top, inside functions and for types alike."""
    names = set()
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            whole = {f"{node.module}.{alias.name}" for alias in node.names}
            names |= {name if name in MODULES else node.module for name in whole}
    return names & set(MODULES)


def room_of(module: str) -> str:
    """The longest name in ORDER that the module stands in; the root of a package counts for itself alone."""
    parts = module.split(".")
    while len(parts) > 1:
        if ".".join(parts) in RANK:
            return ".".join(parts)
        parts.pop()
    assert module in RANK, f"{module} has no room"
    return module


@pytest.mark.parametrize("module", sorted(MODULES))
def test_imports_run_from_later_rooms_to_earlier_ones(module):
    if module.endswith("__main__"):
        return
    for other in imported(MODULES[module]):
        assert RANK[room_of(other)] <= RANK[room_of(module)], f"{module} imports {other}"


def test_no_modules_import_each_other_in_a_circle():
    imports = {name: imported(path) - {name} for name, path in MODULES.items()}
    left = dict(imports)
    while free := [name for name, others in left.items() if not others & set(left)]:
        left = {name: others for name, others in left.items() if name not in free}
    assert not left


@pytest.mark.parametrize("library", ["pybullet", "compas_lmgc90"])
def test_only_the_engine_imports_an_engine(library):
    importing = [name for name, path in MODULES.items() if library in _imported_anywhere(path)]
    assert importing
    assert all(room_of(module) == "dynsim.engine" for module in importing)


def _imported_anywhere(path: Path) -> set[str]:
    tree = ast.parse(path.read_text())
    names = {node.value for node in ast.walk(tree) if isinstance(node, ast.Constant) and isinstance(node.value, str)}
    names |= {alias.name for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names}
    names |= {node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module}
    return {name.split(".")[0] for name in names}


@pytest.mark.parametrize("folder", sorted({path.parent for path in FILES}), ids=lambda p: str(p.relative_to(SOURCE)))
def test_rooms_are_small_and_say_what_they_are_for(folder):
    most = MOST_IN_ROOT if folder.parent == SOURCE else MOST_IN_ROOM
    assert len(list(folder.glob("*.py"))) <= most
    doc = ast.get_docstring(ast.parse((folder / "__init__.py").read_text()))
    assert doc
    if folder.parent != SOURCE:
        assert stated_imports(folder.relative_to(SOURCE).parts[0], doc) == real_imports(folder)


def real_imports(folder: Path) -> set[str]:
    """Rooms that the modules of a room import; a package alone is its root, with all modules outside its rooms."""
    here = folder.relative_to(SOURCE).parts
    found = set()
    for other in {other for path in folder.rglob("*.py") for other in imported(path)}:
        room = room_of(other).split(".")[: len(here)]
        is_root = not SOURCE.joinpath(*room[:2], "__init__.py").exists()
        found.add(room[0] if is_root else ".".join(room))
    return found - {".".join(here)}


def stated_imports(package: str, doc: str) -> set[str]:
    """Rooms that the sentence "This room imports ..." names; those after "of `blockstat`" are of that package."""
    sentence = re.search(r"This room imports\b.*?\.(?=\s|$)", " ".join(doc.split()))
    assert sentence
    own, _, other = sentence[0].partition("of `blockstat`")
    stated = set()
    for part, owner in ((own, package), (other, "blockstat")):
        stated |= {f"{owner}.{name}" for name in re.findall(r"`([^`]+)`", part)}
        stated |= {owner} if re.search(r"\bthe root\b", part) else set()
    return stated


def lines_of_code(text: str) -> int:
    """Lines that hold code: no blank ones, comments or docstrings."""
    tree = ast.parse(text)
    documented = (ast.Module, ast.ClassDef, ast.FunctionDef)
    docstrings = {
        line
        for node in ast.walk(tree)
        if isinstance(node, documented) and ast.get_docstring(node) is not None
        for line in range(node.body[0].lineno, (node.body[0].end_lineno or 0) + 1)
    }
    beside = (tokenize.COMMENT, tokenize.NL, tokenize.NEWLINE, tokenize.INDENT, tokenize.DEDENT, tokenize.ENDMARKER)
    lines = set()
    for token in tokenize.generate_tokens(io.StringIO(text).readline):
        if token.type not in beside:
            lines |= set(range(token.start[0], token.end[0] + 1))
    return len(lines - docstrings)


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SOURCE)))
def test_modules_and_functions_stay_small(path):
    text = path.read_text()
    assert lines_of_code(text) <= 300
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            body = ast.get_source_segment(text, node) or ""
            assert lines_of_code(ast.unparse(node) if node.decorator_list else body.strip()) <= 60, node.name


def test_no_function_handed_to_users_has_the_name_of_a_module():
    import blockstat
    import dynsim

    for package in (blockstat, dynsim):
        for name in package.__all__:
            assert f"{package.__name__}.{name}" not in MODULES


@pytest.mark.parametrize("package", ["blockstat", "dynsim"])
def test_every_public_name_has_one_home(package):
    made = importlib.import_module(package)
    declared = {}
    for node in ast.walk(ast.parse(MODULES[package].read_text())):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(f"{package}."):
            declared |= {alias.name: node.module.removeprefix(f"{package}.") for alias in node.names}
    declared.pop("on_demand", None)
    assert declared == made._HOMES
    assert sorted(declared) == sorted(made.__all__)
    for name in made.__all__:
        assert getattr(made, name) is not None
    with pytest.raises(AttributeError, match="has no attribute 'nothing'"):
        made.nothing  # noqa: B018


def test_the_order_names_rooms_that_exist():
    for earlier, later in pairwise(ORDER):
        assert earlier != later
    assert set(ORDER) <= set(MODULES)


def test_importing_blockstat_leaves_the_heavy_libraries_alone():
    heavy = ("cvxpy", "clarabel", "trimesh", "matplotlib", "pybullet", "shapely")
    code = f"import sys, blockstat; print([m for m in {heavy} if m in sys.modules])"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"
