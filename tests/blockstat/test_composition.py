"""The language of compositions: parameters, arithmetic, presence, placing, supports, and what is refused."""

import numpy as np
import pytest

from blockstat import InputError, assess, build, load_scene, parameters, scene_from, scene_text, search, with_values
from blockstat.spec import compose
from blockstat.spec.composition import resolve
from blockstat.spec.files import load_file
from blockstat.spec.material import uncertain_of
from elements import sound

GATE = {
    "name": "gate",
    "parameters": {"t": {"value": 0.5, "min": 0.1, "max": 0.5, "step": 0.2}, "span": 2.0, "half": "= span / 2"},
    "elements": {
        "piers": {
            "kind": "pier", "size": ["= t", 0.8], "height": 1.5, "courses": 3, "at": ["= -half - t / 2", 0, 0],
            "repeat": {"number": 2, "by": ["= span + t", 0, 0]},
        },
        "ring": {"kind": "arch", "span": "= span", "thickness": "= t", "depth": 0.8, "voussoirs": 9, "at": [0, 0, 1.5]},
    },
}  # fmt: skip

PIER = {"kind": "pier", "size": [0.5, 0.5], "height": 1.0, "courses": 2}


def changed(**elements):
    return GATE | {"elements": GATE["elements"] | elements}


def refused(data, *, errors=1) -> str:
    with pytest.raises(InputError) as error:
        build(scene_from(data))
    assert len(str(error.value).splitlines()) == errors
    return str(error.value)


def test_elements_meet_where_their_keys_put_them():
    assembly = build(scene_from(GATE))
    faces = sound(assembly, convex=True)
    assert set(assembly.groups) == {"ground", "piers.1.pier", "piers.2.pier", "ring.arch"}
    assert assembly.names[int(np.flatnonzero(assembly.support)[0])] == "ground"
    # Joints: 2 x (ground + 2 beds) of the piers, 8 of the ring and two springings.
    assert faces.n_interfaces == 6 + 8 + 2
    assert assembly.volume[assembly.in_group("piers")].sum() == pytest.approx(2 * 0.5 * 0.8 * 1.5)


def test_parameters_move_by_their_path():
    scene = scene_from(GATE)
    assert list(parameters(scene)) == ["parameters.t"]
    thin = with_values(scene, {"parameters.t": 0.3})
    assert parameters(thin)["parameters.t"].value == 0.3
    assert parameters(scene)["parameters.t"].value == 0.5
    assembly = build(thin)
    sound(assembly)
    assert assembly.volume[assembly.in_group("piers")].sum() == pytest.approx(2 * 0.3 * 0.8 * 1.5)
    assert assembly.metadata["parameters"] == {"parameters.t": 0.3}


def test_a_range_may_stand_at_any_number_of_an_element():
    lift = {"value": 0.0, "min": 0.0, "max": 1.0, "step": 0.5}
    scene = scene_from(changed(stone={"kind": "box", "size": [1, 1, 1], "at": [9, 0, lift]}))
    assert list(parameters(scene)) == ["parameters.t", "elements.stone.at.2"]
    high = build(with_values(scene, {"elements.stone.at.2": 0.5}))
    assert high.bounds[0][high.in_group("stone"), 2] == pytest.approx([0.5])


def test_an_absent_element_makes_no_block():
    tie = {"kind": "box", "size": [1, 1, 1], "at": [9, 0, 0]}
    assert "tie" in build(scene_from(changed(tie=tie))).groups
    without = scene_from(changed(tie=tie | {"present": False}))
    assert "tie" not in build(without).groups
    sought = scene_from(changed(tie=tie | {"present": "search"}))
    assert list(parameters(sought)) == ["parameters.t", "elements.tie.present"]
    assert "tie" in build(sought).groups
    assert "tie" not in build(with_values(sought, {"elements.tie.present": 0})).groups


def test_presence_may_be_a_parameter_and_a_comparison():
    tie = {"kind": "box", "size": [1, 1, 1], "at": [9, 0, 0], "present": "= ties"}
    data = changed(tie=tie, more=tie | {"at": [12, 0, 0], "present": "= span > 3"})
    data["parameters"] = GATE["parameters"] | {"ties": "search"}
    scene = scene_from(data)
    assert list(parameters(scene)) == ["parameters.t", "parameters.ties"]
    assert "tie" in build(scene).groups
    assert "more" not in build(scene).groups
    assert "tie" not in build(with_values(scene, {"parameters.ties": 0})).groups


CHAPEL = {
    "name": "hut", "length": 2.7, "span": 2.0, "wall": {"thickness": 0.6, "height": 1.5},
    "vault": {"thickness": 0.3, "voussoirs": 7, "present": "search"},
    "windows": {"south": {"width": 0.4, "height": 0.5, "sill": 0.5, "present": False}},
    "buttresses": {"south": {"number": 1, "thickness": 0.5, "width": 0.5, "height": 1.0, "present": "search"}},
}  # fmt: skip


def test_presence_in_the_short_form():
    scene = scene_from(CHAPEL)
    assert list(parameters(scene)) == ["buttresses.south.present", "vault.present"]
    assembly = build(scene)
    assert {"vault", "buttress.south.1"} <= set(assembly.groups)
    assert assembly.volume[assembly.in_group("wall.south")].sum() == pytest.approx(2.7 * 0.6 * 1.5)  # no window
    bare = build(with_values(scene, {"vault.present": 0, "buttresses.south.present": 0}))
    assert {group.partition(".")[0] for group in bare.groups} == {"ground", "wall"}


class Standing:
    """A verifier that believes the statics."""

    class outcome:
        word = "stands"


@pytest.mark.parametrize(("thickness", "needed"), [(0.2, 1.0), (1.2, 0.0)])
def test_the_search_keeps_an_element_only_where_it_is_needed(thickness, needed):
    # A barrel pushes its walls outward: thin ones need the buttress, thick ones do not.
    data = CHAPEL | {
        "wall": {"thickness": thickness, "height": 1.5},
        "vault": CHAPEL["vault"] | {"present": True},
        "buttresses": {
            side: {"number": 2, "thickness": 0.9, "width": 0.6, "height": 1.5, "present": present}
            for side, present in (("south", "search"), ("north", True))
        },
    }
    result = search(scene_from(data), static=assess, verify=lambda assembly: Standing())
    assert result.best_parameters == {"buttresses.south.present": needed}


def test_both_strategies_leave_out_an_element_whose_only_run_is_absent():
    run = {"path": [[3, 0], [5, 0]], "thickness": 0.3, "height": 1.0, "present": "search"}
    post = {"kind": "pier", "size": [0.5, 0.5], "height": 1.0, "courses": 2}
    walls = {"kind": "walls", "brick": [1.0, 0.5], "runs": {"south": run}}
    scene = scene_from({"name": "yard", "elements": {"post": post, "walls": walls}})
    for strategy in ("paper", "pruned"):
        found = search(scene, over="grid", strategy=strategy, verify=None)
        assert found.best_parameters == {"elements.walls.runs.south.present": 0.0}


def test_repeats_multiply_and_turn():
    post = {"kind": "box", "size": [0.5, 0.5, 1], "at": [3, 0, 0]}
    ring = build(
        scene_from(changed(posts=post | {"at": [3, 5, 0], "repeat": {"number": 8, "turn": 45, "about": [0, 5]}}))
    )
    blocks = ring.in_group("posts")
    assert len(blocks) == 8
    np.testing.assert_allclose(np.hypot(*(ring.centroid[blocks, :2] - (0, 5)).T), 3.0)
    grid = post | {"at": [5, 0, 0], "repeat": [{"number": 3, "by": [1, 0, 0]}, {"number": 2, "by": [0, 2, 0]}]}
    grid = build(scene_from(changed(posts=grid)))
    found = {tuple(p) for p in grid.centroid[grid.in_group("posts"), :2].round(9).tolist()}
    assert found == {(x, y) for x in (5.0, 6.0, 7.0) for y in (0.0, 2.0)}


@pytest.mark.parametrize("keys", [
    {"kind": "sail", "spans": [4, 4], "rise": 0.5, "thickness": 0.2, "courses": 4, "voussoirs": 2},
    {"kind": "freeform", "height": "2 - y ** 2 / 4", "x": [-1, 1], "y": [-2, 2], "thickness": 0.2, "courses": 4,
     "voussoirs": 2},
])  # fmt: skip
def test_an_edge_that_a_vault_is_supported_at_twice_is_named_with_its_element_and_key(keys):
    told = "elements.e: supports: the edge 'south' is given twice; give each of south, north, west, east once"
    twice = {**keys, "springers": 0.4, "supports": ["south", "south"]}
    assert refused({"name": "vault", "elements": {"e": twice}}) == told


def test_supports_are_the_ground_or_groups():
    ring = {"kind": "arch", "span": 2, "thickness": 0.3, "depth": 1, "voussoirs": 9, "springers": 0.4}
    assembly = build(scene_from({"name": "ring", "elements": {"a": ring}, "supports": ["a.springer"]}))
    assert {assembly.groups[i] for i in np.flatnonzero(assembly.support)} == {"a.springer.left", "a.springer.right"}
    twice = ring | {"repeat": {"number": 2, "by": [0, 1, 0]}}
    assembly = build(scene_from({"name": "ring", "elements": {"a": twice}, "supports": ["a.*.springer.left"]}))
    assert assembly.support.sum() == 2
    assert refused({"name": "ring", "elements": {"a": ring}}).startswith('"a.springer.left" reaches down to z = -0.4')
    assert refused({"name": "ring", "elements": {"a": ring | {"at": [0, 0, 2]}}}).startswith("nothing stands on the")
    assert refused({"name": "ring", "elements": {"a": ring}, "supports": ["b"]}) == (
        'supports: no group "b"; groups are: a.arch, a.springer.left, a.springer.right, ground'
    )


def test_elements_that_overlap_are_named():
    message = refused(changed(post={"kind": "box", "size": [0.4, 0.4, 3], "at": [-1.25, 0, 0]}))
    assert message.startswith('elements "piers" and "post" overlap: blocks "piers.1.pier.')
    both = GATE["elements"]["piers"] | {"repeat": {"number": 2, "by": [0.1, 0, 0]}}
    assert refused(changed(piers=both)).startswith('element "piers" overlaps with itself: blocks "piers.1.pier.')


def test_the_volume_of_a_scene_is_that_of_its_free_blocks_whichever_elements_it_shares(monkeypatch):
    built, blocks_of = [], compose.blocks_of
    monkeypatch.setattr(compose, "blocks_of", lambda element: built.append(element) or blocks_of(element))
    volumes = compose.FreeVolumes()
    wide = (0.5, 0.6)
    for height in (1.0, 2.0):
        for width in wide:
            post = {"kind": "pier", "size": [width, 0.5], "height": 1.0, "courses": 2}
            row = {"kind": "pier", "size": [0.4, 0.3], "height": height, "courses": 3, "at": [3, 0, 0]}
            row["repeat"] = [{"number": 3, "by": [2, 0, 0]}]
            held = {"kind": "pier", "size": [0.2, 0.2], "height": 0.7, "courses": 1, "at": [0, 5, 0]}
            tables = {"post": post, "row": row, "held": held}
            scene = scene_from({"name": "s", "supports": ["ground", "held"], "elements": tables})
            assert volumes.of(scene) == pytest.approx(width * 0.5 + 3 * 0.4 * 0.3 * height, rel=1e-12)
            assembly = build(scene)
            assert volumes.of(scene) == pytest.approx(assembly.volume[assembly.free].sum(), rel=1e-12)
    # Two posts, two rows and the one that is held; and three of each of the four scenes that were built.
    assert len(built) == 2 + 2 + 1 + 4 * 3


def test_a_search_tells_of_designs_whose_elements_overlap():
    low = {"kind": "pier", "size": ["= w", 0.5], "height": 1.0, "courses": 1}
    other = {"kind": "pier", "size": [1.0, 0.5], "height": 1.0, "courses": 1, "at": [1.0, 0, 0]}
    width = {"value": 1.0, "min": 0.8, "max": 1.2, "step": 0.2}
    scene = scene_from({"name": "s", "parameters": {"w": width}, "elements": {"low": low, "other": other}})
    found = search(scene, over="grid", strategy="pruned", verify=None)
    assert found.best_parameters == {"parameters.w": 0.8}
    only = scene_from({"name": "s", "parameters": {"w": width | {"min": 1.2, "value": 1.2}},
                       "elements": {"low": low, "other": other}})  # fmt: skip
    found = search(only, over="grid", strategy="pruned", verify=None)
    assert found.best_parameters is None
    assert [row.static for row in found.history] == ["error"]
    assert 'elements "low" and "other" overlap' in found.history[0].note


def test_an_element_may_have_a_density_of_its_own():
    data = changed(ring=GATE["elements"]["ring"] | {"density": 1500}) | {"material": {"density": "= 1000 * span"}}
    assembly = build(scene_from(data))
    assert set(assembly.density[assembly.in_group("ring")]) == {1500.0}
    assert set(assembly.density[assembly.in_group("piers")]) == {2000.0}


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("= 2 * (t + 1) - 1 / 4", 2 * 1.5 - 0.25), ("= 7 // 2 + 7 % 4", 6.0), ("= 2 ** 3", 8.0), ("= -t", -0.5),
        ("= min(t, 0.2) + max(1, 2)", 2.2), ("= sqrt(2) * sin(pi / 4)", 1.0), ("= floor(1.7) + ceil(1.2)", 3.0),
        ("= cos(0) + tan(0) + round(1.6) + abs(-1)", 4.0), ("= twice", 1.0),
    ],
)  # fmt: skip
def test_arithmetic(text, value):
    data = changed(post={"kind": "box", "size": [1, 1, 1], "at": [9, text, 0]})
    data["parameters"] = {"t": 0.5, "span": 2, "half": 1, "twice": "= 2 * t"}
    assembly = build(scene_from(data))
    assert assembly.centroid[assembly.in_group("post"), 1] == pytest.approx([value])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("= wide", 'elements.ring.span: "= wide": no parameter "wide"; parameters are: t, span, half'),
        ("= exp(1)", 'no function "exp"; functions are: abs, ceil'),
        ("= 1 / 0", "elements.ring.span"), ("= 9 ** 9 ** 9", "elements.ring.span"),
        ("= (-1) ** 0.5", "elements.ring.span"), ("= 2 +", 'is no arithmetic such as "= 2 * t + 1"'),
        ("= __import__('os')", "no function"), ("= t.real", '"t.real" is not allowed'),
        ("= 'a' * 3", "is not allowed"), ("= sqrt()", "elements.ring.span"), ("= [1][0]", "is not allowed"),
        ("= 0 < t < 1", '"0 < t < 1" is not allowed'),
        ("= " + "(" * 300 + ")" * 300, "is no arithmetic"), ("= " + "-" * 2000 + "1", "is no arithmetic"),
        ("= t - 5", "elements.ring.span: it must be a number above 0"),
        ("wide", "elements.ring.span: it must be a number, not a text"),
    ],
)  # fmt: skip
def test_bad_arithmetic_names_key_and_word(text, words):
    message = refused(changed(ring=GATE["elements"]["ring"] | {"span": text}))
    assert words in message
    assert message.startswith("elements.ring.span: ")


def test_what_is_refused_names_its_path_and_what_is_allowed():
    ring = GATE["elements"]["ring"]
    assert refused(changed(ring=ring | {"kind": "ark"})).startswith('elements.ring.kind: no kind "ark"; kinds are: ')
    assert refused(changed(ring={"span": 2})).startswith("elements.ring.kind: the kind is missing; kinds are: ")
    assert refused(changed(ring=ring | {"spam": 2})).startswith("elements.ring.spam: unknown key; keys here are: ")
    assert "shape, span, rise" in refused(changed(ring=ring | {"spam": 2}))
    message = refused(changed(ring=ring | {"repeat": {"number": 2, "bye": [0, 0, 0]}}))
    assert message == "elements.ring.repeat.bye: unknown key; keys here are: number, by, turn, about"
    message = refused(changed(ring=ring | {"thickness": {"value": 1, "min": 0.5, "max": 2}}))
    assert message.startswith("elements.ring.thickness: ")
    assert "step" in message
    assert refused(changed(ring=ring | {"shape": "round"})).startswith("elements.ring: shape is 'round'; it must be")
    assert refused(GATE | {"roof": {}}).startswith("roof: unknown key; keys here are: name, elements, parameters")
    assert refused(GATE | {"elements": {}}).startswith("elements: there are none")
    assert refused(changed(**{"a.b": ring})).startswith('elements: "a.b" is no name')
    assert refused(GATE | {"material": {"weight": 1}}).startswith(
        "material.weight: unknown key; keys here are: density"
    )
    circle = GATE | {"parameters": {"a": "= b", "b": "= c + 1", "c": "= a", "t": 1, "half": 1, "span": "= a"}}
    assert refused(circle).startswith("parameters.a: it depends on itself: a -> b -> c -> a")
    assert "parameters.t" in refused(GATE | {"parameters": {"t": "wide", "span": 2, "half": 1}})
    assert "parameters.sin" in refused(GATE | {"parameters": GATE["parameters"] | {"sin": 1}})
    # The ends of a range must do as well as its value.
    wild = GATE | {"parameters": GATE["parameters"] | {"t": {"value": 0.5, "min": -0.5, "max": 0.5, "step": 0.5}}}
    assert refused(wild, errors=2).startswith("elements.")


def test_every_design_that_can_be_built_reads_back(tmp_path):
    """Also where an end of one range does not go with the value that another has now."""
    ranges = {
        "t": {"value": 0.8, "min": 0.2, "max": 0.8, "step": 0.1},
        "u": {"value": 0.2, "min": 0.2, "max": 0.6, "step": 0.1},
    }
    ledge = {"kind": "box", "size": [1.0, "= rest", 0.1]}
    data = {"name": "w", "parameters": ranges | {"rest": "= t - u + 0.1"}, "elements": {"ledge": ledge}}
    design = with_values(scene_from(data), {"parameters.t": 0.3})
    assert build(design).volume[1] == pytest.approx(1.0 * (0.3 - 0.2 + 0.1) * 0.1)
    path = tmp_path / "w.toml"
    path.write_text(scene_text(design), encoding="utf-8")
    assert load_scene(path) == design
    # With u a number, t = 0.2 alone decides: 0.2 - 0.6 + 0.1 is no size.
    data["parameters"] |= {"u": 0.6}
    assert refused(data).startswith("elements.ledge.size[1]: ")
    # An end that its own key cannot have is told whatever else moves.
    tall = {"value": 1.0, "min": -1.0, "max": 1.0, "step": 1.0}
    data["parameters"] |= ranges
    data["elements"] = {"ledge": ledge | {"size": [1.0, "= rest", tall]}}
    assert refused(data).startswith("elements.ledge.size[2]: ")


def test_a_count_may_be_computed_but_for_rounding():
    data = {"name": "t", "parameters": {"w": 0.3}, "elements": {"a": PIER | {"courses": "= w / 0.1"}}}
    assert 0.3 / 0.1 != 3
    assert build(scene_from(data)).n_blocks == 1 + 3
    data["parameters"]["w"] = 0.31
    assert "elements.a.courses" in refused(data)


PUSH = {"kind": "acceleration", "direction": [1, 0, 0]}
RUN = {"path": [[0, 0], [3, 0]], "thickness": 0.4, "height": 1.0}
ASIDE = RUN | {"path": [[0, 3], [3, 3]]}
DOME = {"kind": "freeform", "x": [-1, 1], "y": [-1, 1], "courses": 4, "voussoirs": 2, "thickness": 0.2}


@pytest.mark.parametrize(
    "tables",
    [
        {"loads": {"step": PUSH}, "cases": {"c": {"factors": {"step": 1}}}},
        {"loads": {"a": PUSH}, "cases": {name: {"factors": {"a": 1}} for name in ("value", "min", "max", "step")}},
        {"loads": {"present": PUSH}, "cases": {"c": {"factors": {"present": 1}}}},
        {"ties": {"max": {"between": ["a.pier.0.0", "a.pier.1.0"], "points": [[0, 0, 0.1], [0, 0, 0.9]]}}},
        {"elements": {"a": PIER, "w": {"kind": "walls", "at": [2, 2, 0], "runs": {"min": RUN, "max": ASIDE}}}},
        {"elements": {"a": PIER, "v": DOME | {"height": "2 - step * y ** 2", "constants": {"step": 0.5}}}},
    ],
)
def test_users_may_choose_the_names_of_keys_of_a_range(tables):
    data = {"name": "t", "elements": {"a": PIER}} | tables
    scene = scene_from(data)
    assert parameters(scene) == {}
    plan = resolve(scene)
    assert plan.cases == data.get("cases", {})
    assert build(scene).n_blocks >= 3


def test_a_range_short_of_a_key_is_told_by_its_key():
    for half in ({"value": 2}, {"value": 2, "min": 1, "max": 2}, {"min": 1, "max": 2}, {"max": 2, "step": 1}):
        message = refused({"name": "t", "elements": {"a": PIER | {"height": half}}})
        lacking = [key for key in ("value", "min", "max", "step") if key not in half]
        assert message.startswith(
            f"elements.a.height: {', '.join(lacking)} {'are' if len(lacking) > 1 else 'is'} missing"
        )


def test_only_the_steps_of_a_range_are_checked_with_its_ends():
    # From 1 m up to 2 m in steps of 3 m there are two heights; 2 - 3 = -1 m is none of them.
    scene = scene_from({"name": "t", "elements": {"a": PIER | {"height": {"value": 1, "min": 1, "max": 2, "step": 3}}}})
    assert parameters(scene)["elements.a.height"].steps() == [2, 1]


@pytest.mark.parametrize("sign", [1, -1])
def test_a_whole_number_of_hundreds_of_digits_is_told_by_its_key(sign, tmp_path):
    value = sign * 10**400
    assert refused({"name": "t", "elements": {"a": PIER | {"at": [0, value, 0]}}}).startswith("elements.a.at.1: ")
    assert refused({"name": "t", "parameters": {"n": value}, "elements": {"a": PIER}}).startswith("parameters.n: ")
    path = tmp_path / "loads.toml"
    path.write_text(f"[loads.a]\nkind = 'acceleration'\ndirection = [{value}, 0, 0]\n")
    with pytest.raises(InputError, match=r"line 3: loads\.a\.direction\.0: "):
        load_file(path)


def test_expressions_of_any_depth_are_computed_or_refused_by_their_key():
    terms = 60
    chain = {f"p{k}": f"= p{k + 1} " + "+ 1 " * terms for k in range(48)} | {"p48": 1.0}
    data = {"name": "t", "parameters": chain, "elements": {"a": PIER | {"height": "= p0"}}}
    assert resolve(scene_from(data)).elements["a"].height == 48 * terms + 1
    message = refused({"name": "t", "elements": {"a": PIER | {"height": "= " + "-" * 490 + "1"}}})
    assert message.startswith('elements.a.height: "= ---')


def test_names_that_an_expression_cannot_say_are_refused():
    for name in ("in", "None", "lambda"):
        message = refused({"name": "t", "parameters": {name: 1}, "elements": {"a": PIER}})
        assert message == f'parameters.{name}: "{name}" is no name of a parameter; expressions could not say it'
    vault = DOME | {"height": "2 - y ** 2 / pi", "constants": {"pi": 3}}
    assert refused({"name": "t", "elements": {"v": vault}}).startswith("elements.v: constants.pi: pi is a number by")


@pytest.mark.parametrize(
    ("name", "change", "key"),
    [("ground", {}, "elements.ground"), ("a", {"prefix": "ground.a"}, "elements.a.prefix")],
)
def test_no_element_takes_the_name_of_the_slab(name, change, key):
    message = refused({"name": "t", "elements": {name: PIER | change}})
    assert message == f'{key}: "ground" is the name of the slab; an element needs another'


TOML = """
description = "A gate."
[parameters]
t = 0.5
span = 2.0
[elements.piers]
kind = "pier"
size = ["= t", 0.8]
height = 1.5
courses = 3
at = ["= -(span + t) / 2", 0, 0]
repeat = { number = 2, by = ["= span + t", 0, 0] }
[elements.ring]
kind = "arch"
span = "= span"
thickness = "= t"
depth = 0.8
voussoirs = 9
at = [0, 0, 1.5]
"""


def test_the_same_scene_from_toml(tmp_path):
    path = tmp_path / "gate.toml"
    path.write_text(TOML)
    np.testing.assert_array_equal(build(load_scene(path)).vertices, build(scene_from(GATE)).vertices)
    assert load_scene(path).name == "gate"


POST = {"kind": "box", "size": [1.0, 1.0, 2.0]}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"elements": {"post": POST | {"present": False}}}, '"gate": no element is present; there is nothing to build'),
        ({"supports": []}, 'supports: there are none; write "ground" or groups that cannot move'),
        ({"elements": 3}, "elements: it must be a table, not a whole number"),
        ({"parameters": 3}, "parameters: it must be a table, not a whole number"),
        ({"parameters": {"t": {"value": 1, "mini": 0}}}, "parameters.t.mini: unknown key; keys here are: value, min"),
        (
            {"parameters": {"t": {"value": 1, "min": 0}}},
            "parameters.t: max, step are missing; keys here are: value, min, max, step",
        ),
        ({"parameters": {"t": [1]}}, "parameters.t: [1] is not a number, true, false"),
    ],
)
def test_a_gate_that_cannot_be_read_or_stand_says_why(change, says):
    assert refused({"name": "gate", "elements": {"post": POST}} | change).startswith(says)


def test_a_composition_has_elements():
    with pytest.raises(InputError, match="elements is missing; keys here are: name, elements"):
        scene_from({"name": "gate", "parameters": {"a": 1}})


@pytest.mark.parametrize("table", [3, "normal", None])
def test_what_is_uncertain_is_a_table(table):
    says = f"uncertain.friction: {table!r} is no table; write kind, and mean and deviation or least and most"
    with pytest.raises(InputError, match=says):
        uncertain_of({"friction": table})


POST = {"kind": "pier", "size": [0.6, 0.6], "height": 1.0, "courses": 2}
PROP = POST | {"at": [0.6, 0, 0]}


def posts(*, prop=None, **tables):
    """A post that stands by itself, and a prop beside it that may be absent."""
    return {"name": "posts", "elements": {"p": POST, "q": PROP | {"present": "search"} | (prop or {})}} | tables


def law(*between, **values):
    return {"joints": [{"between": list(between)} | (values or {"friction": 0.5})]}


@pytest.mark.parametrize(
    "tables",
    [law("q", "p"), law("*", "q.pier"), {"supports": ["ground", "q"]}, {"supports": ["ground", "q.*"]}],
    ids=["law", "law of a part", "support", "support by a pattern"],
)
@pytest.mark.parametrize("over", ["line", "grid"])
def test_the_search_leaves_out_an_element_that_a_law_or_a_support_names(tables, over):
    found = search(scene_from(posts(**tables)), over=over, verify=None)
    assert found.best_parameters == {"elements.q.present": 0.0}
    assert [(row.static, row.note) for row in found.history] == [("stable", "")]
    assert found.history[0].volume == pytest.approx(0.6 * 0.6 * 1.0)  # of the post alone


def test_a_law_about_an_absent_element_is_void_and_the_others_count():
    both = [{"between": ["q", "p"], "friction": 0.5}, {"between": ["p", "ground"], "friction": 0.6}]
    scene = posts(joints=both, supports=["ground", "q"])
    there = build(scene_from(scene))
    assert [rule.friction for rule in there.joints] == [0.5, 0.6]
    assert [there.names[i] for i in np.flatnonzero(there.support)] == ["ground", "q.pier.0.0", "q.pier.1.0"]
    gone = build(scene_from(posts(prop={"present": False}, joints=both, supports=["ground", "q"])))
    assert [rule.friction for rule in gone.joints] == [0.6]
    assert [gone.names[i] for i in np.flatnonzero(gone.support)] == ["ground"]


@pytest.mark.parametrize("present", [True, False])
@pytest.mark.parametrize(
    ("tables", "told"),
    [
        (law("qq", "p"), ['joint law: no group "qq"']),
        (law("q", "post"), ['joint law: no group "post"']),
        (law("p.peir", "*"), ['joint law: no group "p.peir"']),
        ({"supports": ["ground", "qq"]}, ['supports: no group "qq"']),
        (
            {"joints": [*law("q", "pp")["joints"], *law("rr", "*")["joints"]]},
            ['joint law: no group "pp"', 'joint law: no group "rr"'],
        ),
    ],
)
def test_a_misspelt_group_is_refused_whether_or_not_an_element_is_absent(present, tables, told):
    with pytest.raises(InputError) as refused:
        build(scene_from(posts(prop={"present": present}, **tables)))
    groups = "ground, p.pier, q.pier" if present else "ground, p.pier"
    assert list(refused.value.args) == [f"{text}; groups are: {groups}" for text in told]


@pytest.mark.parametrize("prop", [{"present": False}, {"present": False, "prefix": "a.q"}])
@pytest.mark.parametrize("copies", [1, 2])
@pytest.mark.parametrize(("part", "refused"), [("", False), (".pier", False), (".peir", True), (".pier.x", False)])
def test_a_misspelt_part_of_an_absent_element_is_refused(prop, copies, part, refused):
    name = prop.get("prefix", "q") + (f".{copies}" if copies > 1 else "") + part
    own = prop | {"repeat": {"number": copies, "by": [2, 0, 0]}}
    stage = {"stages": [{"name": "all", "place": ["p", name]}]}
    for tables, told in (
        (law(name, "p"), f'joint law: no group "{name}"; groups are: ground, p.pier'),
        ({"supports": ["ground", name]}, f'supports: no group "{name}"; groups are: ground, p.pier'),
        (stage, f'stages.0 ("all"): no group "{name}"; groups are: ground, p.pier'),
    ):
        scene = scene_from(posts(prop=own, **tables))
        if not refused:
            assert build(scene).n_blocks == 3
            continue
        with pytest.raises(InputError) as error:
            build(scene)
        assert str(error.value) == told


def test_a_misspelt_part_of_an_element_that_a_search_leaves_out_is_refused():
    scene = scene_from(posts(**law("q.peir", "p")))
    for present in (1, 0):
        with pytest.raises(InputError, match=r'joint law: no group "q\.peir"'):
            build(with_values(scene, {"elements.q.present": present}))


def test_parts_of_an_absent_element_that_cannot_be_built_or_that_a_range_moves_are_not_known():
    moves = {"present": False, "courses": {"value": 2, "min": 1, "max": 3, "step": 1}}
    wide = {"path": [[0, 3], [4, 3]], "thickness": 0.4, "height": 1.5, "openings": [{"width": 9.0, "height": 1.0}]}
    for absent in (PROP | moves, {"kind": "walls", "runs": {"a": wide}, "present": False}):
        scene = {"name": "posts", "elements": {"p": POST, "q": absent}} | law("q.part", "p")
        assert build(scene_from(scene)).joints == ()
    with pytest.raises(InputError, match=r"elements\.q: .*opening"):  # as it would be if it were present
        build(scene_from(scene | {"elements": {"p": POST, "q": absent | {"present": True}}}))


@pytest.mark.parametrize(
    ("present", "place", "empty"),
    [
        ("search", ["p", "q"], None),
        ("search", ["p", "q.pier", "p.peir"], None),  # there may be one with another value
        ("search at 0", ["p", "q", "q.pier", "p.peir"], ["q", "q.pier"]),
        (False, ["p", "q.pier"], ["q.pier"]),
    ],
)
def test_the_assembly_takes_the_groups_for_empty_that_are_absent_by_choice(present, place, empty):
    tables = {"stages": [{"name": "all", "place": place}]}
    scene = scene_from(posts(prop={"present": "search" if present == "search at 0" else present}, **tables))
    if present == "search at 0":
        scene = with_values(scene, {"elements.q.present": 0})
    assert build(scene).metadata.get("absent") == empty


def test_supports_that_are_all_absent_hold_nothing():
    with pytest.raises(InputError, match=r'^supports: there are none; write "ground" or groups that cannot move$'):
        build(scene_from(posts(prop={"present": False}, supports=["q"])))


@pytest.mark.parametrize(("name", "refused"), [("pier", False), ("pier.top", False), ("peir", True)])
def test_an_absent_element_without_a_prefix_is_known_by_the_groups_of_its_blocks(name, refused):
    block = {"kind": "box", "size": [0.6, 0.6, 1.0]}
    scene = {"name": "x", "elements": {"b": block, "q": PROP | {"prefix": "", "present": False}}} | law(name, "b")
    if refused:
        with pytest.raises(InputError, match='joint law: no group "peir"'):
            build(scene_from(scene))
    else:
        assert build(scene_from(scene)).joints == ()


@pytest.mark.parametrize(
    ("absent", "name"),
    [
        ({"runs.b": {"present": False}}, "w.wall.b"), ({"runs.b": {"present": False}}, "w.buttress.b.1"),
        ({"opening": {"present": False}}, "w.wall.a.lintel"), ({"opening": {"number": 0}}, "w.wall.a.lintel"),
        ({"opening": {"head": "flat", "present": False}}, "w.wall.a.arch"),
        ({"buttress": {"present": False}}, "w.buttress.a"), ({"buttress": {"at": []}}, "w.buttress"),
    ],
)  # fmt: skip
@pytest.mark.parametrize("copies", [1, 2])
def test_laws_about_absent_runs_openings_and_buttresses_are_void(absent, name, copies):
    runs = {
        "a": {"path": [[0, 0], [4, 0]], "thickness": 0.4, "height": 1.5},
        "b": {"path": [[0, 3], [4, 3]], "thickness": 0.4, "height": 1.5} | absent.get("runs.b", {}),
    }
    runs["a"]["openings"] = [{"width": 0.5, "height": 1.0} | absent.get("opening", {})]
    buttress = {"wall": "a", "width": 0.5, "projection": 0.5, "height": 1.0, "at": [1.0]} | absent.get("buttress", {})
    walls = {"kind": "walls", "runs": runs, "buttresses": [buttress], "repeat": {"number": copies, "by": [0, 9, 0]}}
    name = name if copies == 1 else name.replace("w.", "w.2.")
    assert build(scene_from({"name": "x", "elements": {"w": walls}} | law(name, "*"))).joints == ()
    wrong = name.replace("wall", "wal").replace("buttress", "butress")
    with pytest.raises(InputError, match=f'joint law: no group "{wrong}"'):
        build(scene_from({"name": "x", "elements": {"w": walls}} | law(wrong, "*")))


@pytest.mark.parametrize(
    ("name", "misspelt"),
    [
        ("vault", "vaults"), ("buttress", "butress"), ("buttress.south", "buttress.soth"),
        ("buttress.south.1", "buttress.north.1"), ("wall.south.lintel", "wall.south.lintels"),
    ],
)  # fmt: skip
def test_laws_about_what_is_absent_in_the_short_form_are_void(name, misspelt):
    data = CHAPEL | {"windows": {"south": CHAPEL["windows"]["south"] | {"present": "search"}}} | law(name, "*")
    scene = scene_from(data)
    assert len(build(scene).joints) == 1
    assert build(with_values(scene, dict.fromkeys(parameters(scene), 0))).joints == ()
    wrong = scene_from(data | law(misspelt, "*"))
    for values in ({}, dict.fromkeys(parameters(wrong), 0)):
        with pytest.raises(InputError, match=f'joint law: no group "{misspelt}"'):
            build(with_values(wrong, values))


def test_the_search_leaves_out_buttresses_of_the_short_form_that_a_law_names():
    hut = {"name": "hut", "length": 3.2, "span": 2.0, "brick": {"length": 0.8, "height": 0.4}}
    hut |= {"wall": {"thickness": 0.8, "height": 1.2}} | law("buttress", "wall")
    buttress = {"number": 1, "thickness": 0.4, "width": 0.4, "height": 1.2}
    found = search(scene_from(hut | {"buttresses": {"south": buttress | {"present": "search"}}}), verify=None)
    assert found.best_parameters == {"buttresses.south.present": 0.0}
    # Two walls of 3.2 m and two of 2 m, none of them with a buttress.
    assert found.history[-1].volume == pytest.approx((2 * 3.2 + 2 * 2.0) * 0.8 * 1.2)
    none = {"number": {"value": 1, "min": 0, "max": 1, "step": 1}}
    found = search(scene_from(hut | {"buttresses": {"south": buttress | none}}), verify=None)
    assert found.best_parameters == {"buttresses.south.number": 0.0}
    with pytest.raises(InputError, match='joint law: no group "buttress"'):
        build(scene_from(hut))  # there is no table of buttresses
