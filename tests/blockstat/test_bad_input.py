"""Bad input gets one line that names the block or the key."""

import json

import numpy as np
import pytest

from blockstat import Assembly, Block, InputError, Plan, Step, Tie, assess, capacity, moving_load, read, write
from blockstat.spec.files import load_file
from evidence.scenes.small import assembly, box, stack

CUBE = box((0, 0, 0), (1, 1, 1), name="cube")


def build(vertices=None, faces=None):
    return Assembly.from_blocks(
        [
            Block(
                CUBE.vertices if vertices is None else vertices,
                CUBE.faces if faces is None else faces,
                "cube",
            )
        ],
        supports=[0],
    )


def message(error) -> str:
    text = str(error.value)
    assert "\n" not in text
    return text


def test_open_mesh():
    with pytest.raises(InputError) as error:
        build(faces=CUBE.faces[:-1])
    assert 'block "cube": its surface is open (4 edges' in message(error)


def test_inverted_face():
    faces = [list(f) for f in CUBE.faces]
    faces[3] = faces[3][::-1]
    with pytest.raises(InputError) as error:
        build(faces=faces)
    assert 'block "cube": face 3 is inverted' in message(error)


def test_block_inside_out():
    with pytest.raises(InputError) as error:
        build(faces=[f[::-1] for f in CUBE.faces])
    assert 'block "cube": all its faces point inwards' in message(error)


def test_zero_volume():
    with pytest.raises(InputError) as error:
        build(vertices=CUBE.vertices * [1, 1, 0])
    assert 'block "cube"' in message(error)
    assert "flat" in message(error)


def test_nan_coordinate():
    vertices = CUBE.vertices.astype(float).copy()
    vertices[5, 1] = np.nan
    with pytest.raises(InputError) as error:
        build(vertices=vertices)
    assert 'block "cube": vertex 5 is' in message(error)


def test_overlapping_blocks():
    asm = assembly([box((0, 0, -1), (1, 1, 0), name="base"), box((0, 0, -0.4), (1, 1, 0.6), name="sunk")])
    with pytest.raises(InputError) as error:
        assess(asm)
    assert 'blocks "base" and "sunk" overlap by 0.4 m' in message(error)


def test_a_block_that_touches_nothing_is_named_and_falls():
    asm = assembly([box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (1, 1, 1)), box((0, 0, 3), (1, 1, 4), name="lost")])
    verdict = assess(asm)
    assert verdict.outcome.word == "unstable"
    assert verdict.warnings == ('block "lost" touches nothing',)
    assert [asm.names[i] for i in verdict.floating] == ["lost"]
    np.testing.assert_allclose(verdict.mechanism[2], [0, 0, -1, 0, 0, 0], atol=1e-12)
    assert verdict.certificate.required_force == np.inf


def test_no_supports():
    with pytest.raises(InputError, match='"assembly" has no supports'):
        assess(assembly([CUBE], supports=[]))


@pytest.mark.parametrize("friction", [-1, float("nan"), "rough", True])
def test_bad_friction(friction):
    with pytest.raises(InputError, match="friction is"):
        assess(stack(1), friction=friction)


@pytest.mark.parametrize("gravity", [(0, 0), (0, 0, 0), (0, 0, float("inf")), "down"])
def test_bad_gravity(gravity):
    with pytest.raises(InputError, match="gravity is"):
        assess(stack(1), gravity=gravity)


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"supports": [7]}, "supports: no block 7; blocks are numbered 0 to 0"),
        ({"supports": ["base"]}, 'supports: no block "base"; blocks are: cube'),
        ({"friction": -1}, "friction is -1"),
        ({"units": "mm"}, 'units are "mm"; only "m" is read'),
        ({"gravity": [0, 0]}, "gravity"),
        ({"density": -5}, "bad.json: density is -5; it must be above 0"),
        ({"blocks": []}, "no blocks"),
        ({"blocks": [{"name": "x", "vertices": "none", "faces": []}]}, 'block "x": vertices'),
        (
            {"blocks": [{"name": "x", "vertices": [[0, 0, 0]], "faces": [[0, 1, 2]]}]},
            'block "x": vertices have shape',
        ),
    ],
)
def test_bad_native_file(tmp_path, change, expected):
    data = {
        "supports": [0],
        "blocks": [{"name": "cube", "vertices": CUBE.vertices.tolist(), "faces": CUBE.faces}],
    }
    path = tmp_path / "bad.json"
    path.write_text(json.dumps(data | change))
    with pytest.raises(InputError) as error:
        read(path)
    assert message(error).startswith(str(path))
    assert expected in message(error)


@pytest.mark.parametrize(
    ("key", "meant"),
    [
        ("frction", "friction"), ("Friction", "friction"), ("joint", "joints"), ("tie", "ties"), ("densty", "density"),
        ("gravty", "gravity"), ("bloks", "blocks"), ("support", "supports"), ("unit", "units"),
    ],
)  # fmt: skip
def test_a_misspelt_key_of_a_native_file_is_refused(tmp_path, key, meant):
    path = tmp_path / "bad.json"
    data = {"blocks": [{"vertices": np.array(CUBE.vertices).tolist(), "faces": CUBE.faces}], "supports": [0]}
    path.write_text(json.dumps({"source": "a survey", **data, key: 0.1}))
    with pytest.raises(InputError) as error:
        read(path)
    assert message(error) == f'{path}: "{key}" is not a key of the file; did you mean "{meant}"?'


def test_keys_unlike_those_of_the_native_format_are_kept(tmp_path):
    path = tmp_path / "kept.json"
    data = {"blocks": [{"vertices": np.array(CUBE.vertices).tolist(), "faces": CUBE.faces}], "supports": [0]}
    noted = {"note": "n", "time": 3, "source": [1], "interfaces": {}, "title": "t", "frame": "f", "cases": 2}
    path.write_text(json.dumps(data | noted))
    found = read(path)
    assert found.metadata == noted
    assert read(write(found, tmp_path / "again.json")).metadata == noted
    with pytest.raises(InputError, match=r'metadata: "frction" is not a key of the file; did you mean "friction"\?'):
        write(found.with_(metadata={"frction": 0.1}), tmp_path / "not.json")
    assert not (tmp_path / "not.json").exists()


def test_a_face_with_a_corner_that_does_not_exist():
    with pytest.raises(InputError, match='block "cube": face 0 is'):
        build(faces=[[0, 3, 2, 9], *CUBE.faces[1:]])


def test_broken_json_names_the_line(tmp_path):
    path = tmp_path / "bad.json"
    path.write_text('{"name": "x",\n "blocks": [}\n')
    with pytest.raises(InputError, match="line 2, column 13: not valid JSON"):
        read(path)


def test_missing_file(tmp_path):
    with pytest.raises(InputError, match=r"gone\.json: no such file"):
        read(tmp_path / "gone.json")
    with pytest.raises(InputError, match=r"^the name of a file is empty$"):
        read("")


def test_a_file_of_loads_without_a_line_is_empty(tmp_path):
    path = tmp_path / "loads.toml"
    path.write_text("# none\n")
    with pytest.raises(InputError) as error:
        load_file(path)
    assert message(error) == f"{path}: the file is empty"


def test_unknown_format(tmp_path):
    with pytest.raises(InputError, match=r'cannot read "\.dwg"; formats are: \.json'):
        read(tmp_path / "plan.dwg")


def test_mesh_without_supports_says_what_to_do(tmp_path):
    from blockstat import write

    path = write(stack(2), tmp_path / "stack.obj")
    path.write_text("\n".join(line for line in path.read_text().splitlines() if not line.startswith("#")))
    with pytest.raises(InputError, match="a mesh does not say which blocks are supports"):
        read(path)
    assert assess(read(path, supports=["ground"])).outcome.word == "stable"
    lowest = read(path, supports=["lowest"])
    assert [lowest.names[i] for i in np.flatnonzero(lowest.support)] == ["ground"]


@pytest.mark.parametrize(("wrong", "words"), [
    (lambda: Step("cube"), "step: install is 'cube'; it must be a list of names"),
    (lambda: Plan((Step(("cube",)),), boundary="cube"), "plan: boundary is 'cube'; it must be a list of names"),
    (lambda: Plan(Step(("cube",))), "they must be a tuple of Step"),
    (lambda: stack(2).with_(ties=Tie((0, 1), ((0, 0, 0), (0, 0, 1)))), "ties is Tie.*; it must be a sequence of Tie"),
    (lambda: stack(2).with_(joints=["dry"]), "joints is .'dry'.; it must be a sequence of JointLaw"),
    (lambda: moving_load(stack(2), [(0.0, 1.0)], [(0, 0), (1, 0)], tolerance="a"), "tolerance is 'a'; it must be from"),
    (lambda: capacity(stack(2), (1, 0, 0)).at("a"), "displacement is 'a'; it must be a finite number"),
])  # fmt: skip
def test_one_where_several_stand_and_text_where_a_number_does(wrong, words):
    with pytest.raises(InputError, match=words):
        wrong()


@pytest.mark.parametrize("top", [-5, 0])
def test_a_density_of_the_file_is_checked_where_each_block_has_its_own(tmp_path, top):
    blocks = [{"name": "cube", "density": 2000, "vertices": CUBE.vertices.tolist(), "faces": CUBE.faces}]
    path = tmp_path / "own.json"
    path.write_text(json.dumps({"density": top, "supports": [0], "blocks": blocks}))
    with pytest.raises(InputError, match=f"density is {top}; it must be above 0"):
        read(path)
    path.write_text(json.dumps({"density": 1500, "supports": [0], "blocks": blocks}))
    assert read(path).density.tolist() == [2000.0]


@pytest.mark.parametrize("densities", [[1800.0, 1800.0], [1800.0, 0.1 + 0.2]])
def test_a_written_file_says_each_density_in_one_place(tmp_path, densities):
    two = stack(1).with_(density=densities)
    data = json.loads(write(two, tmp_path / "two.json").read_text())
    assert ("density" in data) is (len(set(densities)) == 1)
    assert all(("density" in block) is ("density" not in data) for block in data["blocks"])
    assert read(tmp_path / "two.json").density.tolist() == densities
