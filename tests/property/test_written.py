"""What is written comes back: every field of random assemblies, laws, ties and plans, in every unit."""

from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import Assembly, JointLaw, Tie, read, write
from blockstat.io.parts import UNITS
from blockstat.sequence.plan import Plan, Step, read_plan, write_plan
from evidence.scenes.small import assembly, box

FEW = settings(max_examples=25, deadline=None)
WORD = st.text(
    st.characters(codec="utf-8", exclude_categories=["C", "Z"], exclude_characters=".*"), min_size=1, max_size=6
)
GROUP = st.lists(WORD, min_size=1, max_size=3).map(".".join)
AMOUNT = st.floats(1e-3, 1e9)
MAYBE = st.none() | AMOUNT


@st.composite
def laws(draw, groups):
    names = st.sampled_from(["*", *groups])
    return JointLaw(
        (draw(names), draw(names)),
        friction=draw(st.none() | st.floats(1e-3, 1e6)), tension=draw(AMOUNT), bond=draw(AMOUNT), cohesion=draw(MAYBE),
        bond_moment=draw(MAYBE), compression=draw(MAYBE), cells=draw(st.integers(0, 64)),
    )  # fmt: skip


@st.composite
def assemblies(draw):
    """A tower of bricks, no two of one size, in which every field has a value of its own."""
    names = draw(st.lists(WORD, min_size=2, max_size=5, unique=True))
    groups = draw(st.lists(GROUP, min_size=len(names), max_size=len(names)))
    blocks = [
        box((0.1 * k, 0, k), (1 + draw(st.floats(0, 1)), 1, k + 1), name=name, group=group, density=draw(AMOUNT))
        for k, (name, group) in enumerate(zip(names, groups, strict=True))
    ]
    tied = draw(st.permutations(names))[:2]
    low = draw(st.floats(0, 10))
    # The two ends lie in the middle of their blocks' lower faces.
    ends = tuple((0.5, 0.5, float(names.index(name))) for name in tied)
    tie = Tie(tuple(tied), ends, low, low + draw(AMOUNT), draw(st.booleans()), draw(WORD))
    return assembly(
        blocks,
        supports=[k for k in range(len(names)) if k == 0 or draw(st.booleans())],
        name=draw(WORD), friction=draw(st.floats(0, 10)), gravity=[draw(st.floats(-9, 9)), 0.0, -draw(st.floats(1, 9))],
        joints=draw(st.lists(laws(sorted(set(groups))), max_size=3)), ties=[tie],
        metadata={draw(WORD) + "-": draw(WORD)},
    )  # fmt: skip


def alike(one, other):
    """Whether two values are the same to the last digit."""
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    return one == other


@FEW
@given(assemblies())
def test_every_field_of_an_assembly_comes_back_from_json(tmp_path_factory, asm):
    back = read(write(asm, tmp_path_factory.mktemp("json") / "scene.json"))
    different = [f.name for f in fields(Assembly) if not alike(getattr(asm, f.name), getattr(back, f.name))]
    assert different == []


@FEW
@given(assemblies())
@pytest.mark.parametrize("suffix", [".obj", ".glb"])
def test_meshes_keep_all_but_laws_and_ties(tmp_path_factory, suffix, asm):
    back = read(write(asm, tmp_path_factory.mktemp("mesh") / f"scene{suffix}"))
    for name in ("names", "groups", "support", "density", "friction", "gravity"):
        assert alike(getattr(asm, name), getattr(back, name)), name
    np.testing.assert_allclose(back.volume, asm.volume, rtol=1e-5)
    np.testing.assert_allclose(back.centroid, asm.centroid, rtol=1e-5, atol=1e-6)


@pytest.mark.parametrize("unit", UNITS)
@settings(max_examples=5, deadline=None)
@given(assemblies())
def test_lengths_alone_have_units(tmp_path_factory, unit, asm):
    # Metres in a unit by their definitions: of the inch and the foot that of 1959.
    metres = {"m": 1, "dm": 1 / 10, "cm": 1 / 100, "mm": 1 / 1000, "in": 254 / 10_000, "ft": 12 * 254 / 10_000}[unit]
    path = write(asm.with_(vertices=asm.vertices / metres), tmp_path_factory.mktemp("units") / "scene.obj")
    back = read(path, units=unit)
    np.testing.assert_allclose(back.vertices, asm.vertices, rtol=1e-12, atol=1e-15)
    np.testing.assert_array_equal(back.density, asm.density)
    np.testing.assert_array_equal(back.gravity, asm.gravity)


@FEW
@given(st.data())
def test_every_field_of_a_plan_comes_back(tmp_path_factory, data):
    names = data.draw(st.lists(WORD, min_size=3, max_size=6, unique=True))
    asm = assembly([box((0, 0, k), (1, 1, k + 1), name=name) for k, name in enumerate(names)])
    free = list(names[1:])
    first = data.draw(st.integers(1, len(free)))
    installed, left_out = free[:first], tuple(free[first:])
    steps = tuple(Step((name,), (name,) if data.draw(st.booleans()) else ()) for name in installed)
    boundary = (names[0],) if data.draw(st.booleans()) else ()
    plan = Plan(steps, boundary, left_out, data.draw(WORD), data.draw(WORD), {"author-": data.draw(WORD)})
    path = tmp_path_factory.mktemp("plan") / "plan.json"
    write_plan(plan, path)
    assert read_plan(path, asm) == plan
