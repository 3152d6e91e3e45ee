import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import InputError, assess
from blockstat.model import assemble, column, groin_vault, moved, pier
from elements import sound


@settings(max_examples=10, deadline=None)
@given(
    x=st.floats(0.2, 3.0), y=st.floats(0.2, 3.0), height=st.floats(0.5, 8.0), courses=st.integers(1, 10),
    bond=st.sampled_from(["single", "halves"]),
)  # fmt: skip
def test_any_pier_is_sound(x, y, height, courses, bond):
    asm = assemble(pier(size=(x, y), height=height, courses=courses, bond=bond, plinth=0.3), supports="plinth")
    assert set(asm.groups) == {"pier", "plinth"}
    faces = sound(asm, convex=True)
    assert asm.volume[asm.in_group("pier")].sum() == pytest.approx(x * y * height)
    beds, halves = courses * x * y, bond == "halves"
    upright = height / courses * (y * ((courses + 1) // 2) + x * (courses // 2)) if halves else 0.0
    assert faces.area.sum() == pytest.approx(beds + upright)
    # Between courses of halves every stone meets both of the next.
    assert faces.n_interfaces == (courses + 2 + 4 * (courses - 1) if halves else courses)


@settings(max_examples=10, deadline=None)
@given(
    foot=st.floats(0.3, 2.0), slim=st.floats(0.5, 1.0), height=st.floats(0.5, 10.0), drums=st.integers(1, 8),
    sides=st.integers(3, 24),
)  # fmt: skip
def test_any_column_is_sound(foot, slim, height, drums, sides):
    asm = assemble(
        column(diameter=foot, top=slim * foot, height=height, drums=drums, sides=sides, plinth=0.3), supports="plinth"
    )
    assert set(asm.groups) == {"column", "plinth"}
    faces = sound(asm, convex=True)
    polygon = sides / 2 * np.sin(2 * np.pi / sides) / 4  # of a circle of diameter 1
    volume = polygon * height / 3 * foot**2 * (1 + slim + slim**2)
    assert asm.volume[asm.in_group("column")].sum() == pytest.approx(volume)
    wide = foot * (1 + (slim - 1) * np.arange(drums) / drums)
    np.testing.assert_allclose(np.sort(faces.area), np.sort(polygon * wide**2))


def test_a_column_tips_where_its_base_says():
    # A prism of height h on a base of apothem a tips sideways at a / (h / 2): the side looks along x.
    asm = assemble(column(diameter=1.0, height=4.0, drums=4, sides=16, plinth=0.3), supports="plinth")
    limit = 0.5 * np.cos(np.pi / 16) / 2.0
    for share, outcome in ((0.99, "stable"), (1.01, "unstable")):
        assert assess(asm, gravity=(share * limit, 0, -1)).outcome.word == outcome


@pytest.mark.parametrize(("width", "outcome"), [(0.5, "unstable"), (1.6, "stable")])
def test_cross_vault_on_piers(width, outcome):
    # The thrust of the webs overturns slender piers; wide ones, growing outwards from the corner, carry it.
    vault = groin_vault(spans=(4.0, 4.0), thickness=0.4, voussoirs=15, brick=0.7)
    blocks, place, height = list(vault), 2.0 + width / 2, 3.0
    for name, x, y in (("ne", 1, 1), ("nw", -1, 1), ("sw", -1, -1), ("se", 1, -1)):
        stones = pier(size=(width, width), height=height, courses=5, plinth=0.3)
        blocks += moved(stones, (x * place, y * place, -height), prefix=f"{name}.")
    asm = assemble(blocks, supports=[f"{c}.plinth" for c in ("ne", "nw", "sw", "se")])
    sound(asm)
    assert assess(asm).outcome.word == outcome


@pytest.mark.parametrize(
    ("build", "options", "match"),
    [
        (pier, {"size": 1.0}, "size is 1.0"),
        (pier, {"size": (1.0, 0.0)}, r"size\[1\] is 0.0"),
        (pier, {"courses": 0}, "courses is 0"),
        (pier, {"bond": "english"}, "bond is 'english'"),
        (pier, {"plinth": -1}, "plinth is -1"),
        (column, {"sides": 2}, "sides is 2"),
        (column, {"drums": 0}, "drums is 0"),
        (column, {"top": 0.0}, "top is 0.0"),
    ],
)
def test_bad_parameters_are_named(build, options, match):
    good = {"size": (1.0, 1.0), "courses": 3} if build is pier else {"diameter": 1.0, "drums": 3}
    with pytest.raises(InputError, match=match):
        build(**{"height": 2.0} | good | options)
