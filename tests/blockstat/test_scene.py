import json

import numpy as np
import pytest

from blockstat import InputError, build, load_scene, overlaps, parameters, read, with_values, write
from blockstat.spec import Range, scene_from
from blockstat.spec.reading import at_path

SCENE = {
    "name": "hut", "length": 2.7, "span": 2.0,
    "brick": {"length": 0.9, "height": 0.5},
    "wall": {"thickness": {"value": 0.6, "min": 0.2, "max": 0.8, "step": 0.2}, "height": 1.5},
    "vault": {"thickness": 0.3, "voussoirs": 7},
}  # fmt: skip


def refused(change: dict) -> str:
    with pytest.raises(InputError) as error:
        scene_from(SCENE | change)
    assert "\n" not in str(error.value)
    return str(error.value)


def test_numbers_of_numpy_are_numbers():
    window = {"number": np.int64(1), "width": np.float64(0.4), "height": 0.5, "sill": 0.5}
    plain = window | {"number": 1, "width": 0.4}
    pierced = scene_from(SCENE | {"windows": {"south": window}})
    assert pierced == scene_from(SCENE | {"windows": {"south": plain}})
    gate = {"name": "gate", "elements": {"post": {"kind": "box", "size": np.array([1.0, 1.0, 2.0])}}}
    assert build(scene_from(gate)).volume[-1] == 2.0
    assert refused({"span": 2.0 + 1.0j}).startswith("(2+1j) is neither")


def test_unknown_keys_are_refused_with_their_path_and_the_known_ones():
    assert refused({"walls": {}}).startswith("walls: unknown key; keys here are: name, length, span")
    assert refused({"wall": {"thick": 1.0}}) == "wall.thick: unknown key; keys here are: thickness, height"
    message = refused({"windows": {"south": {"width": 1, "height": 1, "sil": 0}}})
    assert "sil: unknown key; keys here are: width, height, sill, number" in message
    message = refused({"wall": {"thickness": {"value": 1, "min": 0, "max": 2, "steps": 1}}})
    assert "wall.thickness.steps: unknown key; keys here are: value, min, max, step" in message


def test_values_out_of_bounds_are_refused_with_their_path():
    assert "wall.thickness" in refused({"wall": {"thickness": -1.0}})
    assert "material.friction" in refused({"material": {"friction": -1.0}})
    assert "value 3 must lie between min 0 and max 2" in refused(
        {"wall": {"thickness": {"value": 3.0, "min": 0.0, "max": 2.0, "step": 1.0}}}
    )
    assert "roof" in refused({"windows": {"roof": {"width": 1, "height": 1}}})
    assert refused({"span": "wide"}).startswith("span: ")


def test_bad_toml_names_file_and_line(tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text('name = "x"\nlength = = 3\n')
    with pytest.raises(InputError, match=r"bad\.toml: not valid TOML: .*line 2"):
        load_scene(path)
    with pytest.raises(InputError, match=r"none\.toml: no such file"):
        load_scene(tmp_path / "none.toml")
    with pytest.raises(InputError, match=r"wall\.obj: a scene file \(\.toml\) is needed"):
        load_scene(path.rename(tmp_path / "wall.obj"))
    path.write_text('name = "x"\nlength = 3.0\nspan = 2.0\nroof = "flat"\n')
    with pytest.raises(InputError, match=r"bad\.toml: roof: unknown key"):
        load_scene(path)


def test_ranges_step_down_to_their_minimum():
    assert Range(0.5, 0.2, 0.8, 0.2).steps() == [0.8, 0.6, 0.4, 0.2]
    assert Range(0.5, 0.25, 0.8, 0.2).steps() == [0.8, 0.6, 0.4, 0.25]
    assert Range(1, 1, 1, 1).steps() == [1]


def test_steps_stay_between_bounds_that_have_no_last_digit():
    assert Range(value=0.5, min=1 / 3, max=2 / 3, step=1 / 3).steps() == [2 / 3, 1 / 3]
    assert Range(value=-0.5, min=-2 / 3, max=-1 / 3, step=1 / 3).steps() == [-1 / 3, -2 / 3]


def test_parameters_move_by_path():
    building = scene_from(SCENE)
    assert list(parameters(building)) == ["wall.thickness"]
    thin = with_values(building, {"wall.thickness": 0.2})
    assert parameters(thin)["wall.thickness"].value == 0.2
    assert parameters(building)["wall.thickness"].value == 0.6
    with pytest.raises(InputError, match=r'no parameter "wall\.height" to move; ranges are: wall\.thickness'):
        with_values(building, {"wall.height": 2.0})
    with pytest.raises(InputError, match="value 5 must lie between"):
        with_values(building, {"wall.thickness": 5.0})


def test_intrinsic_parameters_default_to_the_paper():
    material = scene_from(SCENE).material
    assert (material.density, material.friction, material.glue, material.rotational_stiffness) == (
        2691,
        0.7,
        10,
        7000,
    )
    assembly = build(scene_from(SCENE))
    assert assembly.density[0] == 2691
    assert assembly.friction == 0.7
    assert assembly.metadata["material"] == {"glue": 10, "rotational_stiffness": 7000}


def test_a_file_names_the_friction_and_the_density_of_its_blocks_alone(tmp_path):
    """A design that is judged with another friction than the scene's is written with that one."""
    path = write(build(scene_from(SCENE)).with_(friction=0.9), tmp_path / "hut.json")
    data = json.loads(path.read_text())
    assert data["friction"] == 0.9
    assert not {"friction", "density"} & set(data["material"])
    assert read(path).friction == 0.9


@pytest.mark.parametrize(
    ("change", "expected"),
    [
        ({"windows": {"south": {"width": 0.5, "height": 2.0}}}, "windows.south: sill and height reach"),
        (
            {"windows": {"south": {"width": 0.9, "height": 0.5, "number": 3}}},
            "windows.south: 3 openings of 0.9 m",
        ),
        (
            {
                "windows": {"west": {"width": 0.5, "height": 0.5}},
                "doors": {"west": {"width": 0.5, "height": 0.5}},
            },
            "windows.west",
        ),
        (
            {"buttresses": {"south": {"number": 4, "thickness": 0.5, "width": 0.8, "height": 1.0}}},
            "buttresses.south: 4 buttresses",
        ),
        ({"wall": {"thickness": 1.4, "height": 1.5}}, "wall.thickness: end walls of 1.4 m overlap"),
    ],
)
def test_parts_that_do_not_fit_name_their_key(change, expected):
    with pytest.raises(InputError) as error:
        build(scene_from(SCENE | change))
    assert expected in str(error.value)


@pytest.mark.parametrize(("thickness", "height"), [(0.8, 2.4), (0.4, 3.3), (0.8, 3.3)])
def test_a_buttress_under_a_vault_thicker_than_its_wall_is_no_higher_than_the_wall(thickness, height):
    # The back of the vault is 0.8 m from the room, over 0.4 m of the buttress, from 2.4 m up.
    data = {
        "name": "hut", "length": 4.0, "span": 3.0, "wall": {"thickness": 0.4, "height": 2.4},
        "vault": {"thickness": thickness, "voussoirs": 9},
        "buttresses": {"south": {"number": 1, "thickness": 0.5, "width": 0.6, "height": height}},
    }  # fmt: skip
    if thickness > 0.4 and height > 2.4:
        with pytest.raises(InputError, match=r"buttresses.south.height: it is 3.3 m; .* up to 2.4 m high"):
            build(scene_from(data))
    else:
        assert len(overlaps(build(scene_from(data)), gap=1e-6)[0]) == 0


@pytest.mark.parametrize("name", ["value", "min", "max", "step"])
@pytest.mark.parametrize("value", [np.inf, np.nan])
def test_a_range_is_finite(name, value):
    with pytest.raises(ValueError, match="value, min, max and step must be finite"):
        Range(**{"value": 1.0, "min": 0.0, "max": 2.0, "step": 1.0} | {name: value})


@pytest.mark.parametrize("data", [[1], "hut", 3.0, None])
def test_a_scene_is_a_table(data):
    with pytest.raises(InputError) as error:
        scene_from(data)
    assert str(error.value) == f"a scene is a table of keys, not {data!r}"


@pytest.mark.parametrize("up", ["x", "y", "-z"])
def test_a_scene_has_z_up(tmp_path, up):
    path = tmp_path / "post.toml"
    path.write_text('[elements.post]\nkind = "box"\nsize = [1, 1, 2]\n')
    with pytest.raises(InputError, match=r"post\.toml: a scene has z up; another axis cannot be chosen for it"):
        read(path, up=up)
    assert read(path, up="z").names == read(path).names


def test_a_range_may_have_a_key_with_dots_above_it(tmp_path):
    path = tmp_path / "post.toml"
    path.write_text("""
name = "post"
[elements.post]
kind = "box"
size = [0.5, 0.5, { value = 1.0, min = 0.5, max = 2.0, step = 0.5 }]
[uncertain.density."wall.north"]
kind = "normal"
mean = { value = 2000, min = 1800, max = 2200, step = 100 }
deviation = 100
""")
    scene = load_scene(path)
    names = ["elements.post.size.2", "uncertain.density.wall.north.mean"]
    assert list(parameters(scene)) == names
    moved = with_values(scene, dict(zip(names, (1.5, 1900.0), strict=True)))
    assert [found.value for found in parameters(moved).values()] == [1.5, 1900.0]


def test_of_keys_that_a_path_begins_with_the_longest_is_meant():
    data = {"wall": {"north": {"mean": 1}, "mean": 3}, "wall.north": {"mean": 2}}
    for path, value in (("wall.north.mean", 2), ("wall.mean", 3)):
        table, key = at_path(data, path)
        assert table[key] == value


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("span = 4,0", "a number is written with a decimal point: 4.0"),
        ("wall = { height = -12,25 }", "a number is written with a decimal point: -12.25"),
        ("span = 4.0 m", "a number stands without a unit: lengths are in metres"),
        ("span = 4 mm", "a number stands without a unit: lengths are in metres"),
        ("span = 1e3 ]", ""),
        ("span = [1, 2", ""),
    ],
)
def test_numbers_in_words_of_other_notations_are_told(tmp_path, line, hint):
    path = tmp_path / "bad.toml"
    path.write_text(f'name = "bad"\n{line}\n')
    with pytest.raises(InputError) as refused:
        load_scene(path)
    assert str(refused.value).endswith(f"; {hint}" if hint else ")")


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ("4.0 m", "it must be a number, not a text; write it without quotes and without a unit: lengths are in metres"),
        ("30mm", "it must be a number, not a text; write it without quotes and without a unit: lengths are in metres"),
        ("4,5", "it must be a number, not a text; write 4.5 without quotes, with a decimal point"),
        ("t", 'it must be a number, not a text; write "= t" for the value of the parameter'),
        ("wide", "it must be a number, not a text"),
        (True, "it must be a number, not true or false"),
        (0, "it must be a number above 0"),
    ],
)
def test_what_is_no_number_is_told_in_words(given, told):
    ring = {"kind": "arch", "span": given, "thickness": 0.3, "depth": 1.0, "voussoirs": 9}
    with pytest.raises(InputError) as refused:
        scene_from({"name": "gate", "parameters": {"t": 2.0}, "elements": {"ring": ring}})
    assert str(refused.value) == f"elements.ring.span: {told}"


def test_a_whole_number_is_asked_for_in_words():
    ring = {"kind": "arch", "span": 2.0, "thickness": 0.3, "depth": 1.0, "voussoirs": 9.5}
    with pytest.raises(InputError, match=r"voussoirs: it must be a whole number, not one with a decimal point$"):
        scene_from({"name": "gate", "elements": {"ring": ring}})
