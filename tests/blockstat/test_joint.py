import json
from dataclasses import replace

import numpy as np
import pytest

from blockstat import (
    InputError,
    JointLaw,
    LoadOutcome,
    Outcome,
    acceleration,
    assess,
    build,
    find_interfaces,
    limit_load,
    read,
    write,
)
from blockstat.contact.cells import refine
from blockstat.contact.point_law import laws_of
from blockstat.sensitivity.parameters import limit_load_gradient
from blockstat.spec import scene_from
from evidence.scenes.small import assembly, box, running_bond, stack

NEAR = 1e-6


def hanging(law):
    ceiling = box((0, 0, 1), (1, 1, 2), name="ceiling", group="rock")
    return assembly([ceiling, box((0, 0, 0), (1, 1, 1), name="block", group="bell")], joints=[law])


@pytest.mark.parametrize("kind", ["bond", "tension"])
def test_a_hanging_block_needs_its_weight_in_tension(kind):
    # Weight 1 under an area of 1.
    for capacity, outcome in ((1 + NEAR, Outcome.STABLE), (1 - NEAR, Outcome.UNSTABLE)):
        verdict = assess(hanging(JointLaw(("rock", "bell"), **{kind: capacity})))
        assert verdict.outcome is outcome
        if outcome is Outcome.STABLE:
            assert verdict.forces[:, 0].sum() == pytest.approx(-1.0)


@pytest.mark.parametrize("length", [1.0, 3.0])
def test_a_bonded_cantilever(length):
    # The block turns about the lower edge of its joint, against the two upper corners: W L / 2 = F / 2 x a.
    a, force = 0.5, 4.0
    wall = box((-1, 0, -1), (0, a, 1), name="wall", group="wall")
    beam = box((0, 0, -a / 2), (length, a, a / 2), name="beam", group="beam", density=1.0)
    asm = assembly([wall, beam], joints=[JointLaw(("wall", "beam"), bond=force)], gravity=(0, 0, -1e-3), friction=5.0)
    found = limit_load(asm, (0, 0, -1))
    weight = asm.mass[1] * 1e-3
    assert found.outcome is LoadOutcome.LIMIT
    assert (1 + found.lower) * weight == pytest.approx(force * a / length, rel=1e-6)


def test_friction_of_one_pair_of_groups():
    blocks = [
        box((-5, -5, -1), (5, 5, 0), name="ground", group="ground"),
        box((-1, -1, 0), (1, 1, 0.2), group="slab.lower"),
        box((-1, -1, 0.2), (1, 1, 0.4), group="slab.upper"),
    ]
    asm = assembly(blocks, friction=0.7)
    for law, limit in (
        (JointLaw(("slab", "ground"), friction=0.3), 0.3),
        (JointLaw(("slab.upper", "slab.lower"), friction=0.2), 0.2),
        (JointLaw(("*", "*"), friction=0.5), 0.5),
    ):
        assert limit_load(asm.with_(joints=[law]), (1, 1, 0)).lower == pytest.approx(limit, rel=1e-7)
    both = [JointLaw(("*", "*"), friction=0.2), JointLaw(("ground", "slab"), friction=0.4)]
    assert limit_load(asm.with_(joints=both), (0, 1, 0)).lower == pytest.approx(0.2, rel=1e-7)


def test_a_bond_only_adds_strength_and_a_law_of_nothing_changes_nothing():
    wall = running_bond(4, 3)
    dry = limit_load(wall, (0, 1, 0)).lower
    assert limit_load(wall.with_(joints=[JointLaw(("*", "*"))]), (0, 1, 0)).lower == pytest.approx(dry, rel=1e-9)
    held = [limit_load(wall.with_(joints=[JointLaw(("*", "*"), bond=b)]), (0, 1, 0)).lower for b in (1e-3, 1e-2)]
    assert dry < held[0] < held[1]


def test_forces_with_bonds_balance_by_hand():
    asm = stack(2, 0.5, 1.0).with_(joints=[JointLaw(("*", "*"), bond=5.0)])
    verdict = assess(asm, gravity=(0.4, 0, -1))
    assert verdict.outcome is Outcome.STABLE
    k = verdict.interfaces.point_interface
    push = np.einsum("nij,ni->nj", verdict.interfaces.frame[k], verdict.forces)
    base = (verdict.interfaces.pair[k] == [0, 1]).all(axis=1)
    np.testing.assert_allclose(push[base].sum(axis=0), -asm.mass[1:].sum() * np.array([0.4, 0, -1]), atol=1e-9)


def test_laws_in_files(tmp_path):
    law = JointLaw(("rock", "bell"), friction=0.5, bond=2.0, cohesion=3.0, bond_moment=1.0, compression=1e4, cells=4)
    asm = hanging(law)
    path = write(asm, tmp_path / "bell.json")
    assert read(path).joints == asm.joints
    data = json.loads(path.read_text())
    data["joints"][0]["between"] = ["rock", "belt"]
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match='joint law: no group "belt"; groups are: bell, rock'):
        read(path)
    data["joints"][0] = {"between": ["rock", "bell"], "glue": 3}
    path.write_text(json.dumps(data))
    with pytest.raises(InputError, match="glue"):
        read(path)
    scene = {"name": "s", "length": 2.0, "span": 1.5, "joints": [{"between": ["wall", "ground"], "friction": 0.4}]}
    assert build(scene_from(scene)).joints == (JointLaw(("wall", "ground"), friction=0.4),)
    with pytest.raises(InputError, match=r"joints\[0\]\.frictoin: unknown key"):
        scene_from({**scene, "joints": [{"between": ["wall", "ground"], "frictoin": 0.4}]})


@pytest.mark.parametrize(
    "bad",
    [
        {"friction": -0.1},
        {"tension": -1.0},
        {"bond": float("inf")},
        {"bond": float("nan")},
        {"cohesion": -1.0},
        {"bond_moment": float("nan")},
        {"compression": 0.0},
        {"cells": -1},
        {"cells": 65},
        {"cells": 2.5},
    ],
)
def test_bad_laws(bad):
    with pytest.raises(InputError, match="joint law between a and b"):
        JointLaw(("a", "b"), **bad)


def test_cohesion_needs_friction():
    asm = hanging(JointLaw(("rock", "bell"), friction=0.0, cohesion=2.0))
    with pytest.raises(InputError, match="joint law between rock and bell: cohesion needs a friction of at least"):
        assess(asm)


def test_cells_cover_their_joint():
    # Area, centroid and second moments of any convex patch, from the cells that divide it.
    asm = stack(1, 1.5, 0.5)
    corners = find_interfaces(asm)
    for cells in (1, 3, 10):
        fine = refine(corners, np.array([cells]))
        assert len(fine.point) == cells**2
        assert fine.point_share.sum() == pytest.approx(1.0)
        np.testing.assert_allclose(fine.point_share @ fine.point, corners.point.mean(axis=0), atol=1e-12)
    spread = fine.point - corners.point.mean(axis=0)
    second = fine.point_share @ spread[:, :2] ** 2
    np.testing.assert_allclose(second, np.array([1.5, 1.0]) ** 2 / 12, rtol=0.03)
    hexagon = np.column_stack(
        [np.cos(np.arange(6) * np.pi / 3 + 0.2), np.sin(np.arange(6) * np.pi / 3 + 0.2), np.zeros(6)]
    )
    part = refine(replace(corners, point=hexagon, start=np.array([0, 6])), np.array([5]))
    np.testing.assert_allclose(part.point_share @ part.point, 0, atol=1e-12)


def test_derivatives_refuse_strengths():
    def make(values):
        return stack(1, values["b"], 1.0).with_(joints=[JointLaw(("*", "*"), cohesion=1.0)])

    with pytest.raises(
        InputError, match=r"joint law between \* and \*: derivatives know friction, tension and bond, not cohesion"
    ):
        limit_load_gradient(make, {"b": 0.5}, lambda a: acceleration(a, (1, 0, 0)))


def test_a_law_of_a_group_is_not_one_of_groups_whose_names_begin_alike():
    blocks = [box((-9, -9, -1), (9, 9, 0), group="ground")]
    blocks += [box((k, 0, 0), (k + 0.5, 1, 1), group=name) for k, name in enumerate(("wall", "wall2", "wall.north"))]
    asm = assembly(blocks, joints=[JointLaw(("ground", "wall"), tension=1.0)])
    ((_, rows),) = laws_of(asm, find_interfaces(asm))
    assert rows.tolist() == [True, False, True]


def test_a_later_law_without_a_friction_has_that_of_the_assembly(tmp_path):
    """A slab that slides: at .9 by the law of all joints, at .5 where the law of its group counts, as in its file."""
    blocks = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((0, 0, 0), (1, 1, 0.2), name="slab", group="wall.a")]
    every, own = JointLaw(("*", "*"), friction=0.9), JointLaw(("wall", "*"), compression=5e6)
    for laws, friction in (([every], 0.9), ([every, own], 0.5), ([own, every], 0.9)):
        asm = assembly(blocks, friction=0.5, joints=laws)
        for found in (asm, read(write(asm, tmp_path / "slab.json"))):
            assert limit_load(found, (1, 0, 0)).lower == pytest.approx(friction, rel=2e-4)
