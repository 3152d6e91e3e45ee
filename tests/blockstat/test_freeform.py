import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import InputError, assess
from blockstat.model import assemble, freeform, height_field
from elements import joint_areas, outline_volume, sound


def bowl(a, b, c):
    """A surface with curvatures a and b along the axes and a twist c."""
    return lambda x, y: 3.0 - (a * x**2 + b * y**2) / 2 + c * x * y


@settings(max_examples=12, deadline=None)
@given(
    a=st.floats(-0.5, 0.5), b=st.floats(-0.5, 0.5), c=st.floats(-0.3, 0.3), t=st.floats(0.05, 0.3),
    courses=st.integers(2, 8), n=st.integers(2, 6), bond=st.sampled_from(["running", "stack"]),
    edges=st.sets(st.sampled_from(["south", "north", "west", "east"]), min_size=1),
)  # fmt: skip
def test_any_surface_is_sound(a, b, c, t, courses, n, bond, edges):
    points = height_field(bowl(a, b, c), x=(-2.0, 2.0), y=(-1.5, 1.5), courses=courses, voussoirs=n)
    asm = assemble(freeform(points, thickness=t, supports=sorted(edges), springers=0.2, bond=bond))
    assert set(asm.groups) == {*(f"vault.{i}" for i in range(courses)), *(f"springer.{edge}" for edge in edges)}
    faces = sound(asm)
    # Every joint has the same faces on both sides: taking them away leaves the closed surface of the whole.
    assert outline_volume(asm) == pytest.approx(asm.volume.sum(), rel=1e-9)

    # Pairs by the bond: heads within courses, one bed to each half stone above, springers under each stone of an edge.
    stones = [n + (i % 2 if bond == "running" else 0) for i in range(courses)]
    beds = 2 * n if bond == "running" else n
    springers = sum({"south": stones[0], "north": stones[-1]}.get(edge, courses) for edge in edges)
    # Where a surface is warped, diagonal neighbours may overlap by a micrometre.
    areas = {pair: area for pair, area in joint_areas(asm, faces).items() if area > 1e-6}
    assert len(areas) == sum(k - 1 for k in stones) + (courses - 1) * beds + springers
    # A bed is as long as its row of points, and as wide as the vault is thick but for the turn of the normals.
    rows = np.linalg.norm(np.diff(points, axis=1), axis=2).sum(axis=1)
    found = sum(
        area for (p, q), area in areas.items() if p[:5] == q[:5] == "vault" and p.split(".")[1] != q.split(".")[1]
    )
    assert found == pytest.approx(t * rows[1:-1].sum(), rel=0.1)


def test_volume_against_the_integral_over_the_surface():
    # Steiner: thickness t about a middle surface of Gauss curvature K holds t + K t^3 / 12 per area.
    a, b, c, t = 0.4, 0.3, 0.1, 0.3
    points = height_field(bowl(a, b, c), x=(-2.0, 2.0), y=(-1.5, 1.5), courses=40, voussoirs=40)
    asm = assemble(freeform(points, thickness=t, springers=0.2))
    x, y = np.meshgrid((np.arange(400) + 0.5) / 100 - 2, (np.arange(300) + 0.5) / 100 - 1.5)
    slope = 1 + (c * y - a * x) ** 2 + (c * x - b * y) ** 2
    volume = (np.sqrt(slope) * (t + (a * b - c**2) / slope**2 * t**3 / 12)).mean() * 12.0
    assert asm.volume[asm.in_group("vault")].sum() == pytest.approx(volume, rel=1e-3)


def test_a_slab_by_hand():
    points = height_field(lambda x, y: 0.5 * x, x=(0.0, 2.0), y=(0.0, 1.0), courses=2, voussoirs=2)
    asm = assemble(freeform(points, thickness=lambda x, y: 0.1 + 0.2 * y, springers=0.2))
    slope = np.sqrt(1.25)
    assert asm.volume[asm.in_group("vault")].sum() == pytest.approx(2.0 * slope * 0.2)
    areas = joint_areas(asm, sound(asm))
    assert areas["vault.0.0", "vault.1.0"] == pytest.approx(0.5 * slope * 0.2)  # half a stone
    assert areas["vault.0.0", "vault.0.1"] == pytest.approx(0.5 * 0.15)


def test_a_mesh_that_is_no_height_field():
    # A barrel of more than half a circle, by its angle; its joints are plane.
    angle, x = np.meshgrid(np.deg2rad(np.linspace(-100, 100, 16)), np.linspace(0, 3, 9), indexing="ij")
    points = np.stack([x, 2 * np.sin(angle), 2 * np.cos(angle)], axis=2)
    asm = assemble(freeform(points, thickness=0.4, springers=0.3))
    faces = sound(asm)
    assert assess(asm).outcome.word == "stable"
    beds = [area for (a, b), area in joint_areas(asm, faces).items() if a.split(".")[:2] != b.split(".")[:2]]
    assert sum(beds) == pytest.approx(16 * 0.4 * 3.0)


@pytest.mark.parametrize(("thickness", "outcome"), [(0.35, "stable"), (0.05, "unstable")])
def test_a_waving_barrel_stands_when_thick(thickness, outcome):
    points = height_field(
        lambda x, y: (1.6 + 0.2 * np.sin(1.5 * x)) * (1 - (y / 2) ** 4), x=(-3, 3), y=(-2, 2), courses=13, voussoirs=6
    )
    asm = assemble(freeform(points, thickness=thickness, springers=0.4))
    sound(asm)
    assert assess(asm).outcome.word == outcome


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"thickness": 0.0}, "thickness must be above 0"),
        ({"thickness": [[0.1, 0.2]]}, r"thickness has shape \(1, 2\)"),
        ({"thickness": 20.0}, "thickness: joints cross near"),
        (
            {"supports": ["south", "north", "south"]},
            "supports: the edge 'south' is given twice; give each of south, north, west, east once",
        ),
        ({"supports": ["up"]}, "supports: no edge 'up'; edges are: south, north, west, east"),
        ({"bond": "english"}, "bond is 'english'"),
        ({"springers": -1.0}, "springers is -1.0"),
        ({"points": np.zeros((3, 4, 3))}, r"points have shape \(3, 4, 3\)"),
        ({"points": np.full((3, 3, 3), np.nan)}, "points must be finite"),
        ({"points": np.zeros((3, 3, 3))}, "points coincide"),
    ],
)
def test_bad_parameters_are_named(options, match):
    points = height_field(bowl(0.5, 0.5, 0.0), x=(-2.0, 2.0), y=(-1.5, 1.5), courses=4, voussoirs=3)
    with pytest.raises(InputError, match=match):
        freeform(**{"points": points, "thickness": 0.2} | options)


def test_bad_height_fields_are_named():
    with pytest.raises(InputError, match=r"x is \(2, -2\)"):
        height_field(bowl(0, 0, 0), x=(2, -2), y=(0, 1), courses=2, voussoirs=2)
    with pytest.raises(InputError, match="height is nan at x = -2 m, y = 0 m"), np.errstate(invalid="ignore"):
        height_field(lambda x, y: np.sqrt(1 - x**2), x=(-2, 2), y=(0, 1), courses=2, voussoirs=2)
    with pytest.raises(InputError, match="courses is 1"):
        height_field(bowl(0, 0, 0), x=(0, 2), y=(0, 1), courses=1, voussoirs=2)
