from collections import Counter

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import InputError, assess
from blockstat.model import assemble, barrel_vault, groin_vault, pavilion_vault
from elements import joint_areas, sound
from evidence.references.bays import Bay

CORNERS, SIDES = ("ne", "nw", "se", "sw"), ("north", "east", "south", "west")
BAYS = {
    "spans": st.tuples(st.floats(2.0, 8.0), st.floats(2.0, 8.0)), "thick": st.floats(0.06, 0.3),
    "n": st.integers(5, 19), "brick": st.floats(0.3, 2.0), "groins": st.sampled_from(["solid", "mitred"]),
}  # fmt: skip


def vault_of(build, spans, thick, n, brick, groins):
    """A vault of semicircular profile along x and its section by hand."""
    options = {"spans": spans, "thickness": thick * spans[0] / 2, "voussoirs": n, "brick": brick}
    asm = assemble(build(groins=groins, springers=0.3, **options))
    return asm, Bay(spans, options["thickness"], n)


def count_of(asm):
    """How many blocks each web has in each course."""
    return Counter(tuple(name.split(".")[1:3]) for name in asm.names if name.split(".")[1] in SIDES)


@settings(max_examples=12, deadline=None)
@given(**BAYS)
def test_any_groin_vault_is_sound(spans, thick, n, brick, groins):
    asm, bay = vault_of(groin_vault, spans, thick, n, brick, groins)
    webs = {f"vault.{side}" for side in SIDES} if set(count_of(asm)) else set()
    assert set(asm.groups) - webs == {
        *(f"vault.groin.{c}" for c in CORNERS), *(f"springer.{c}" for c in CORNERS), *(["vault.key"] if n % 2 else [])
    }  # fmt: skip
    faces = sound(asm)
    assert asm.volume[asm.in_group("vault")].sum() == pytest.approx(bay.groin_volume(), rel=1e-9)
    # A stone of a web beyond those at the groins or at the key has one head joint more.
    heads = 0.0
    for (side, course), number in count_of(asm).items():
        across = 0 if side in ("north", "south") else 1
        crown = int(course) == bay.courses
        number = number - 1 if crown else number
        heads += number * (bay.crown_area(across) if crown else bay.section(int(course)).area * bay.reach[across])
    total = bay.groin_beds() + heads + (bay.mitres() if groins == "mitred" else 0.0)
    assert faces.area.sum() == pytest.approx(total, rel=1e-9)


@settings(max_examples=12, deadline=None)
@given(**BAYS)
def test_any_pavilion_vault_is_sound(spans, thick, n, brick, groins):
    asm, bay = vault_of(pavilion_vault, spans, thick, n, brick, groins)
    assert {g for g in asm.groups if g.startswith("vault.groin")} == {f"vault.groin.{c}" for c in CORNERS}
    assert {g for g in asm.groups if g.startswith("springer")} == {f"springer.{side}" for side in SIDES}
    faces = sound(asm)
    assert asm.volume[asm.in_group("vault")].sum() == pytest.approx(bay.pavilion_volume(), rel=1e-9)
    # k stones between the two corners of a side have k + 1 head joints.
    heads, count = 0.0, count_of(asm)
    for course in range(bay.courses):
        for side in SIDES:
            across = 1 if side in ("north", "south") else 0
            heads += (count[side, str(course)] + 1) * bay.section(course).area * bay.reach[across]
    total = bay.pavilion_beds() + heads + (bay.mitres() if groins == "mitred" else 0.0)
    assert faces.area.sum() == pytest.approx(total, rel=1e-9)


def test_volume_of_a_groin_vault_is_that_under_two_barrels():
    # Many courses: at each place the thickness of the barrel whose intrados is higher.
    a, t = 2.0, 0.3
    asm = assemble(groin_vault(spans=(2 * a, 2 * a), thickness=t, voussoirs=301, brick=1.0, springers=0.3))
    u = (np.arange(2000) + 0.5) / 2000 * (a + t)
    x, y = np.meshgrid(u, u)
    low = np.minimum(x, y)  # the web whose profile is higher
    inner = np.sqrt(np.maximum(a**2 - low**2, 0))
    outer = np.sqrt((a + t) ** 2 - low**2)
    volume = 4 * (outer - inner).mean() * (a + t) ** 2
    assert asm.volume[asm.in_group("vault")].sum() == pytest.approx(volume, rel=1e-3)


def test_solid_groins_are_one_stone_of_both_webs():
    options = {"spans": (4.0, 4.0), "thickness": 0.4, "voussoirs": 15, "brick": 0.7, "springers": 0.3}
    solid, mitred = (assemble(groin_vault(groins=g, **options)) for g in ("solid", "mitred"))
    assert mitred.n_blocks - solid.n_blocks == 4 * 7  # four groins of seven courses
    np.testing.assert_allclose(mitred.volume.sum(), solid.volume.sum())
    areas = joint_areas(mitred, sound(mitred, convex=False))
    joint = areas["vault.groin.ne.3.y", "vault.groin.ne.3.x"]
    assert joint == pytest.approx(Bay((4.0, 4.0), 0.4, 15).section(3).area * np.hypot(2, 2))


@pytest.mark.parametrize("build", [groin_vault, pavilion_vault])
def test_head_joints_of_a_web_do_not_run_through_two_courses(build):
    asm = assemble(build(spans=(4.0, 4.0), thickness=0.4, voussoirs=15, brick=0.4, springers=0.3))
    axis = 1 if build is groin_vault else 0
    lower, upper = (edge[:, axis] for edge in asm.bounds)
    ends: dict[int, set[float]] = {}
    for i in asm.in_group("vault.north"):
        course = int(asm.names[i].split(".")[2])
        ends.setdefault(course, set()).update(np.round([lower[i], upper[i]], 6).tolist())
    outside = round(float(upper.max()), 6)
    shared = [ends[c] & ends[c + 1] - {outside} for c in ends if c + 1 in ends]
    assert len(shared) > 2
    assert not any(shared)


@pytest.mark.parametrize("shape", ["pointed", "segmental", "elliptic"])
@pytest.mark.parametrize("build", [groin_vault, pavilion_vault])
def test_other_profiles_stand_on_fixed_springers(build, shape):
    rise = {"pointed": 2.6, "segmental": 1.2, "elliptic": 1.5}[shape]
    asm = assemble(build(shape, rise=rise, spans=(4.0, 3.5), thickness=0.4, voussoirs=12, brick=0.7, springers=0.4))
    sound(asm)
    assert assess(asm).outcome.word == "stable"


def test_a_thin_groin_vault_falls_and_a_thick_one_stands():
    # A web is an arch at its free edge, and falls when much thinner than t / R = 0.1075.
    for thickness, outcome in ((0.4, "stable"), (0.04, "unstable")):
        asm = assemble(groin_vault(spans=(4.0, 4.0), thickness=thickness, voussoirs=25, brick=0.3, springers=0.3))
        assert assess(asm).outcome.word == outcome


@settings(max_examples=8, deadline=None)
@given(
    span=st.floats(1.0, 8.0), length=st.floats(1.0, 10.0), thick=st.floats(0.05, 0.3), n=st.integers(3, 20),
    brick=st.floats(0.3, 2.0),
)  # fmt: skip
def test_any_barrel_is_sound(span, length, thick, n, brick):
    t = thick * span / 2
    asm = assemble(barrel_vault(span=span, length=length, thickness=t, voussoirs=n, brick=brick, springers=0.2 * span))
    assert set(asm.groups) == {"vault", "springer.south", "springer.north"}
    faces = sound(asm, convex=True)
    section = n / 2 * np.sin(np.pi / n) * ((span / 2 + t) ** 2 - (span / 2) ** 2)
    assert asm.volume[asm.in_group("vault")].sum() == pytest.approx(section * length)
    stones = len(asm.in_group("vault"))
    assert faces.area.sum() == pytest.approx((n + 1) * t * length + (stones - n) * section / n)


def test_a_barrel_of_another_profile():
    asm = assemble(
        barrel_vault("pointed", span=3, rise=2, length=4, thickness=0.3, brick=0.7, voussoir=0.4, springers=0.3)
    )
    sound(asm, convex=True)
    assert assess(asm).outcome.word == "stable"


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"spans": 4.0}, "spans is 4.0; it must be the two clear spans"),
        ({"spans": (4.0, -1.0)}, r"spans\[1\] is -1.0"),
        ({"shape": "horseshoe", "rise": 3.0}, "shape is 'horseshoe'; a bay"),
        ({"groins": "ribbed"}, "groins is 'ribbed'; it must be one of: solid, mitred"),
        ({"voussoirs": 2}, "voussoirs is 2; it must be a whole number of at least 3"),
        ({"voussoirs": 7.5}, "voussoirs is 7.5"),
        ({"brick": 0}, "brick is 0"),
        ({"springers": -1}, "springers is -1"),
    ],
)
@pytest.mark.parametrize("build", [groin_vault, pavilion_vault])
def test_bad_parameters_are_named(build, options, match):
    with pytest.raises(InputError, match=match):
        build(**{"spans": (4.0, 4.0), "thickness": 0.4, "voussoirs": 9, "brick": 0.7} | options)
