"""The COMPAS packages read what we write, and we read what they write.

They are no dependency. Install them where they do not matter and name that Python:

    python3.11 -m venv compas && compas/bin/pip install compas==2.15.1 compas_assembly==0.7.1 compas_model==0.9.3 \
        compas_dem==0.6.0
    BLOCKSTAT_COMPAS_PYTHON=compas/bin/python pytest tests/crosscheck/test_compas.py
"""

import json
import os
import subprocess
from pathlib import Path

import numpy as np
import pytest

from blockstat import Assembly, build, load_scene, read, write
from compas_files import FILES, assert_same
from evidence.scenes.small import box, running_bond

PYTHON = os.environ.get("BLOCKSTAT_COMPAS_PYTHON")
SCRIPTS = Path(__file__).parents[1] / "compas"
pytestmark = pytest.mark.skipif(not PYTHON, reason="BLOCKSTAT_COMPAS_PYTHON names no Python with the COMPAS packages")


def compas(script, *arguments):
    answer = subprocess.run([PYTHON, SCRIPTS / script, *map(str, arguments)], capture_output=True, text=True)
    assert answer.returncode == 0, answer.stderr
    return answer.stdout


@pytest.mark.parametrize("name", FILES)
def test_theirs_read_by_us(tmp_path_factory, name):
    directory = tmp_path_factory.getbasetemp() / "compas"
    if not directory.exists():
        directory.mkdir()
        compas("make_files.py", directory)
    assert_same(read(directory / f"{name}.json"), json.loads((directory / f"{name}.expected.json").read_text()))


def odd_names():
    blocks = [
        box((-1, -1, -1), (2, 2, 0), name="the ground"),
        box((0, 0, 0), (1, 1, 1 / 3), name="камень/1", group="wall.north", density=1800.0),
        box((0, 0, 1 / 3), (1, 1, 1), name="Stone #2\\", group="wall"),
    ]
    return Assembly.from_blocks(blocks, supports=[0], name="odd names", friction=0.55)


MAKERS = {
    "odd names": lambda root: odd_names(),
    "wall": lambda root: running_bond(4, 3),
    "chapel": lambda root: build(load_scene(root / "examples" / "chapel.toml")),
}


@pytest.mark.parametrize("format", ["compas-assembly", "compas-model"])
@pytest.mark.parametrize("make", MAKERS)
def test_ours_read_by_them(tmp_path, root, make, format):
    asm = MAKERS[make](root)
    path = write(asm, tmp_path / "ours.json", format=format)
    theirs = json.loads(compas("describe.py", path))
    assert theirs["dtype"].startswith("compas_dem" if format == "compas-model" else "compas_assembly")
    assert_same(asm, theirs, atol=0.0)
    assert [row["density"] for row in theirs["blocks"]] == asm.density.tolist()


@pytest.mark.parametrize("format", ["compas-assembly", "compas-model"])
def test_ours_saved_again_by_them_and_read_by_us(tmp_path, format):
    asm = odd_names()
    path = write(asm, tmp_path / "ours.json", format=format)
    code = "import sys, compas; compas.json_dump(compas.json_load(sys.argv[1]), sys.argv[1])"
    subprocess.run([PYTHON, "-c", code, str(path)], check=True, capture_output=True)
    back = read(path)
    assert (back.name, back.names, back.groups) == (asm.name, asm.names, asm.groups)
    assert (back.friction, back.density.tolist()) == (asm.friction, asm.density.tolist())
    for field in ("vertices", "face_vertices", "support", "gravity"):
        np.testing.assert_array_equal(getattr(back, field), getattr(asm, field))
