"""LMGC90 as the engine of dynamic verdicts: statics that have a closed form, and what it refuses.

Everything but the messages needs the package compas_lmgc90 and is skipped without it.
"""

import importlib.util
import json
import sys
from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

from blockstat import Assembly, Block, InputError, JointLaw, box, find_interfaces, write
from dynsim import Comparison, Comparisons, Removal, Settings, compare, simulate, verify
from dynsim.cli.commands import app
from dynsim.engine import lmgc90

installed = pytest.mark.skipif(
    importlib.util.find_spec("compas_lmgc90") is None, reason="compas_lmgc90 is not installed"
)
SHORT = Settings(end=1.0)


def slab(angle: float, friction: float = 0.5, **options) -> Assembly:
    """A slab on the ground under gravity that is turned by an angle about y."""
    blocks = [box((-3, -3, -1), (3, 3, 0), name="ground"), box((-0.5, -0.4, 0), (0.5, 0.4, 0.2), name="slab")]
    tilt = np.radians(angle)
    gravity = 9.81 * np.array([np.sin(tilt), 0.0, -np.cos(tilt)])
    return Assembly.from_blocks(blocks, supports=["ground"], friction=friction, gravity=gravity, **options)


def ell() -> Assembly:
    """A concave block, an L on its side of unit thickness, on the ground; turned so that no axis is special."""
    outline = np.array([[0, 0], [2, 0], [2, 1], [1, 1], [1, 3], [0, 3]], dtype=float)
    low, high = (np.column_stack([outline[:, 0], np.full(6, y), outline[:, 1]]) for y in (0.0, 1.0))
    sides = [[k, (k + 1) % 6, (k + 1) % 6 + 6, k + 6] for k in range(6)]
    faces = [[0, 1, 2, 3, 4, 5], [11, 10, 9, 8, 7, 6], *[side[::-1] for side in sides]]
    block = Block(np.concatenate([low, high]), faces, name="ell")
    ground = box((-4, -4, -1), (5, 5, 0), name="ground")
    return Assembly.from_blocks([ground, block], supports=["ground"], friction=0.5)


def test_a_missing_package_is_named_with_the_way_to_install_it(monkeypatch, tmp_path):
    monkeypatch.setitem(sys.modules, "compas_lmgc90", None)
    with pytest.raises(InputError, match=r'compas_lmgc90; install it with: pip install "blockstat\[lmgc90\]"'):
        verify(slab(0), engine="lmgc90")
    with pytest.raises(InputError, match="compas_lmgc90"):
        compare(slab(0), engines=("bullet", "lmgc90"), jobs=1)


def test_engines_that_do_not_exist_are_refused():
    with pytest.raises(InputError, match="no engine 'ode'; engines are: bullet, lmgc90"):
        verify(slab(0), engine="ode")
    with pytest.raises(InputError, match="no engine 'ode'"):
        simulate(slab(0), engine="ode")
    with pytest.raises(InputError, match="they must be bullet, or bullet,lmgc90"):
        compare(slab(0), engines=("lmgc90",), jobs=1)


def test_the_table_has_a_column_for_lmgc90_only_where_it_was_asked():
    row = Comparison(name="slab", static="stable", dynamic="stands")
    second = Comparison(name="ell", static="stable", dynamic="stands", lmgc90="falls")
    assert "LMGC90" not in Comparisons((row,))._repr_html_()
    html = Comparisons((row, second))._repr_html_()
    assert html.count("LMGC90") == 1
    assert row.engines_agree is None
    assert second.engines_agree is False


@installed
@pytest.mark.parametrize("friction", [0.2, 0.7])
def test_a_slab_slides_where_the_slope_is_steeper_than_friction(friction):
    limit = np.degrees(np.arctan(friction))
    assert verify(slab(limit - 0.1, friction), engine="lmgc90").outcome.word == "stands"
    assert verify(slab(limit + 0.3, friction), engine="lmgc90").outcome.word == "falls"


@installed
def test_a_sliding_slab_accelerates_by_what_friction_leaves_of_its_weight():
    """On a slope a, x'' = g (sin a - mu cos a)."""
    run = simulate(slab(40.0), engine="lmgc90", settings=SHORT, stop=lambda t, moved, _: np.abs(moved).max() > 0.4)
    a = np.radians(40.0)
    expected = 9.81 * (np.sin(a) - 0.5 * np.cos(a)) / 2 * run.times**2
    assert run.displacement[:, 1, 0] == pytest.approx(expected, rel=0.02, abs=2e-3)
    kinetic = run.assembly.mass[1] / 2 * (9.81 * (np.sin(a) - 0.5 * np.cos(a)) * run.times) ** 2
    assert run.kinetic[-1] == pytest.approx(kinetic[-1], rel=0.02)


@installed
@pytest.mark.parametrize(("across", "word"), [(0.49, "stands"), (0.51, "falls")])
def test_a_pillar_tips_where_its_weight_leaves_its_foot(across, word):
    """A pillar of height 1 and width w tips at tan(a) = w; the slope is 0.5 times the width that is too small."""
    blocks = [box((-3, -3, -1), (3, 3, 0), name="ground"), box((0, 0, 0), (0.5, 0.4, 1.0), name="pillar")]
    gravity = [across, 0.0, -1.0]
    asm = Assembly.from_blocks(blocks, supports=["ground"], friction=2.0, gravity=gravity)
    assert verify(asm, engine="lmgc90").outcome.word == word


@installed
@pytest.mark.parametrize("turned", [0.0, 0.7])
def test_contact_forces_carry_a_concave_block_at_its_centroid(turned):
    """Force and moment of the ground balance the weight at the true centroid, that of the two parts of the L."""
    asm = ell()
    c, s = np.cos(turned), np.sin(turned)
    rotation = np.array([[c, -s, 0], [s, c, 0], [0, 0, 1]]) @ np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    asm = asm.with_(vertices=asm.vertices @ rotation.T, gravity=rotation @ asm.gravity)
    run = simulate(asm, engine="lmgc90", settings=SHORT, stop=lambda time, *_: time > 0.2)
    assert np.abs(run.displacement).max() < 1e-5
    assert run.contacts.on(1) == pytest.approx(-asm.mass[1] * asm.gravity, rel=1e-4, abs=1e-4 * asm.mass[1] * 9.81)
    centre = rotation @ np.array([(2 * 1.0 + 2 * 0.5) / 4, 0.5, (2 * 0.5 + 2 * 2.0) / 4])  # two areas of 2 each
    arm = run.contacts.point - centre
    sign = np.where(run.contacts.pairs[:, 1] == 1, 1.0, -1.0)[:, None]
    moment = np.cross(arm, sign * run.contacts.force).sum(axis=0)
    assert np.abs(moment).max() < 1e-3 * asm.mass[1] * 9.81


@installed
def test_blocks_jammed_between_fixed_ones_fall():
    """Model H: friction could hold the middle block by any thrust, but no load causes one."""
    blocks = [box((0, 0, 0), (1, 1, 1), name="left"), box((1, 0, 0), (2, 1, 1), name="middle"),
              box((2, 0, 0), (3, 1, 1), name="right")]  # fmt: skip
    asm = Assembly.from_blocks(blocks, supports=["left", "right"], friction=0.84)
    verdict = verify(asm, engine="lmgc90")
    assert verdict.outcome.word == "falls"
    assert verdict.first_block == "middle"
    assert verdict.run.engine == verdict.summary()["engine"] == "lmgc90"
    assert "LMGC90" in verdict.explain()


@installed
def test_units_change_nothing():
    small = slab(20).with_(vertices=slab(20).vertices / 50, gravity=3 * slab(20).gravity)
    one, other = (verify(asm, engine="lmgc90", settings=SHORT) for asm in (slab(20), small))
    assert other.run.times[-1] == pytest.approx(one.run.times[-1] / np.sqrt(150))
    assert other.outcome is one.outcome


@installed
def test_what_it_does_not_simulate_is_refused():
    with pytest.raises(InputError, match='loads, actions and bonds need the engine "bullet"'):
        verify(slab(0), engine="lmgc90", loads=[Removal("slab")])
    with pytest.raises(InputError, match='their own friction need the engine "bullet"'):
        verify(slab(0, joints=(JointLaw(("*", "*"), friction=0.1),)), engine="lmgc90")


@installed
def test_a_corner_of_too_many_triangles_is_refused():
    """A pyramid over a polygon of 40 corners: LMGC90 would end the process."""
    angle = 2 * np.pi * np.arange(40) / 40
    foot = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(40)])
    sides = [[k, (k + 1) % 40, 40] for k in range(40)]
    pyramid = Block(np.vstack([foot, [0, 0, 1]]), [list(range(39, -1, -1)), *sides], name="pyramid")
    ground = box((-4, -4, -1), (5, 5, 0), name="ground")
    with pytest.raises(InputError, match=r'block "pyramid" has a corner where 4\d triangles .* 30 at most'):
        verify(Assembly.from_blocks([ground, pyramid], supports=["ground"], friction=0.5), engine="lmgc90")


def test_scenes_that_it_does_not_take_are_named_before_it_starts(monkeypatch):
    laws = {"joints": (JointLaw(("*", "*"), bond=9.0),)}
    for scene, actions, message in (
        (slab(0), [Removal("slab")], 'loads, actions and bonds need the engine "bullet"'),
        (slab(0, **laws), [], 'loads, actions and bonds need the engine "bullet"'),
        (slab(0, joints=(JointLaw(("*", "*"), friction=0.1),)), [], 'their own friction need the engine "bullet"'),
    ):
        with pytest.raises(InputError, match=message):
            lmgc90._check_scene(scene, actions)
    lmgc90._check_scene(slab(0), [])
    joints = find_interfaces(slab(0))
    lmgc90._check_scene(slab(0), [], replace(joints, friction=np.array([0.5])))  # that of the assembly
    with pytest.raises(InputError, match='their own friction need the engine "bullet"'):
        lmgc90._check_scene(slab(0), [], replace(joints, friction=np.array([0.1])))
    monkeypatch.setattr(lmgc90, "MOST_BLOCKS", 1)
    with pytest.raises(InputError, match="has 2 blocks; LMGC90 takes 1 at most"):
        lmgc90._check_scene(slab(0), [])


def test_a_corner_counts_the_triangles_of_its_hull():
    # At the corners of a cube four or five of twelve triangles meet, on the average 4.5.
    cube = np.array(list(np.ndindex(2, 2, 2)), dtype=float)
    lmgc90._check_corners(slab(0), [[cube], [cube]])
    angle = 2 * np.pi * np.arange(40) / 40
    cone = np.vstack([np.column_stack([np.cos(angle), np.sin(angle), np.zeros(40)]), [0, 0, 1]])
    with pytest.raises(InputError, match=r'block "slab" has a corner where 4\d triangles of its hull meet'):
        lmgc90._check_corners(slab(0), [[cube], [cube, cone]])


@pytest.mark.parametrize("other", [(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0.6, 0, 0.8), (-0.6, 0, -0.8)])
def test_a_direction_is_turned_into_another_the_short_way(other):
    one, other = np.array([1.0, 0, 0]), np.array(other, dtype=float)
    found = lmgc90.rotation_between(one, other)
    np.testing.assert_allclose(found @ one, other, atol=1e-12)
    np.testing.assert_allclose(found @ found.T, np.eye(3), atol=1e-12)
    assert np.linalg.det(found) == pytest.approx(1.0)
    assert np.trace(found) == pytest.approx(1 + 2 * one @ other)  # no further than it must


@installed
def test_the_command_line_takes_the_engine(tmp_path):
    path = tmp_path / "slab.json"
    write(slab(30), path)
    answer = CliRunner().invoke(app, ["verify", str(path), "--engine", "lmgc90", "--json"])
    assert answer.exit_code == 0
    assert json.loads(answer.stdout)["engine"] == "lmgc90"
    answer = CliRunner().invoke(app, ["compare", str(path), "--engines", "bullet,lmgc90", "--json", "--jobs", "1"])
    row = json.loads(answer.stdout)["rows"][0]
    assert (row["dynamic"], row["lmgc90"]) == ("falls", "falls")
