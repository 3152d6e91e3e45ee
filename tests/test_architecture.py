"""Imports run one way, modules stay small."""

import ast
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[1] / "src"
LAYERS = [
    {"errors", "polyhedron", "checks", "separation", "clip", "broad"},
    {"geometry_check", "spec", "joint", "assembly"},
    {"faces", "concave", "merge", "contact", "overlap", "model", "io"},
    {"cells", "equilibrium", "mend", "snap", "weld"},
    {"heal"},
    {"planar", "bonds"},
    {"program"},
    {"solve"},
    {"coulomb"},
    {"result", "load"},
    {"problem", "proof", "edges", "export"},
    {"reuse"},
    {"analysis"},
    {"bounds", "limit"},
    {"reserve", "thrust"},
    {"sensitivity"},
    {"vertex_sensitivity"},
    {"search", "sweep"},
    {"paint"},
    {"plot"},
    {"animate", "utilisation"},
    {"view3d"},
    {"report"},
    {"app"},
    {"cli_options"},
    {"cli"},
]
RANK = {name: rank for rank, names in enumerate(LAYERS) for name in names}
FILES = sorted(SOURCE.rglob("*.py"))


def imported(path: Path) -> set[str]:
    """Modules imported anywhere in a file, except those only types need."""
    tree = ast.parse(path.read_text())
    skipped = {
        id(node)
        for block in ast.walk(tree)
        if isinstance(block, ast.If) and "TYPE_CHECKING" in ast.unparse(block.test)
        for node in ast.walk(block)
    }
    names = set()
    for node in ast.walk(tree):
        if id(node) in skipped:
            continue
        if isinstance(node, ast.Import):
            names |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            names |= {node.module} | {f"{node.module}.{alias.name}" for alias in node.names}
    return names


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SOURCE)))
def test_imports_run_one_way(path):
    package, module = path.relative_to(SOURCE).parts[0], path.relative_to(SOURCE).with_suffix("").parts[1]
    modules = imported(path)
    if package == "blockstat":
        assert not any(name.split(".")[0] in ("dynsim", "pybullet") for name in modules)
        if module == "__init__":
            return
        for name in modules:
            parts = name.split(".")
            if parts[0] == "blockstat" and len(parts) > 1 and parts[1] in RANK and parts[1] != module:
                assert RANK[parts[1]] <= RANK[module], f"{module} imports {parts[1]}"
    elif module != "world":
        assert "pybullet" not in modules


@pytest.mark.parametrize("path", FILES, ids=lambda p: str(p.relative_to(SOURCE)))
def test_modules_and_functions_stay_small(path):
    text = path.read_text()
    assert len(text.splitlines()) <= 300
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.FunctionDef):
            assert node.end_lineno - node.lineno < 70, node.name


def test_importing_blockstat_leaves_the_heavy_libraries_alone():
    import subprocess
    import sys

    heavy = ("cvxpy", "clarabel", "trimesh", "matplotlib", "pybullet", "shapely")
    code = f"import sys, blockstat; print([m for m in {heavy} if m in sys.modules])"
    answer = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert answer.stdout.strip() == "[]"
