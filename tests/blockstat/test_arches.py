import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import InputError, assess, find_interfaces
from blockstat.model import arch, assemble, jack_arch, moved
from elements import joint_areas, sound

SPAN, DEPTH, SPRINGER = 2.0, 0.5, 0.3
#: Shape and rise over a span of 2 m, and the residual of the curve's equation at x, z: 0 on the intrados.
CURVES = {
    "semicircular": (None, lambda x, z: np.hypot(x, z) - 1),
    "segmental": (0.5, lambda x, z: np.hypot(x, z + 0.75) - 1.25),  # radius (1 + .5^2) / (2 x .5)
    "horseshoe": (1.25, lambda x, z: np.hypot(x, z - 0.225) - 1.025),  # radius (1 + 1.25^2) / (2 x 1.25)
    "pointed": (1.5, lambda x, z: np.hypot(np.abs(x) + 0.625, z) - 1.625),  # (1 + c)^2 = c^2 + 1.5^2
    "elliptic": (0.6, lambda x, z: x**2 + (z / 0.6) ** 2 - 1),
}


def joints_of(assembly):
    """Corners of the joints of an arch from left to right, shape (n + 1, 2, 2): intrados and extrados as x, z."""
    found = []
    for block in assembly.in_group("arch"):
        section = assembly.block_vertices(block)
        section = section[section[:, 1] < 0][:, [0, 2]]
        assert len(section) == 4
        found.append(section)
    shared = [[p for p in a if (p == b).all(axis=1).any()] for a, b in zip(found, found[1:], strict=False)]
    assert all(len(joint) == 2 for joint in shared), "neighbours do not share the corners of their joint"
    joints = np.array(shared)
    return np.take_along_axis(joints, np.hypot(*joints.T).T.argsort(axis=1)[..., None], axis=1)


def test_volume_of_a_semicircular_arch_by_hand():
    # n triangles of apex angle pi / n between two circles.
    n, inner, outer = 15, 1.0, 1.2
    asm = assemble(arch(span=SPAN, thickness=0.2, depth=DEPTH, voussoirs=n, springers=SPRINGER))
    ring = DEPTH * n / 2 * np.sin(np.pi / n) * (outer**2 - inner**2)
    assert asm.volume[asm.in_group("arch")].sum() == pytest.approx(ring, rel=1e-12)


@pytest.mark.parametrize("shape", CURVES)
@pytest.mark.parametrize("kind", ["radial", "vertical"])
def test_joints_follow_the_curve(shape, kind):
    if (shape, kind) == ("horseshoe", "vertical"):
        pytest.skip("a horseshoe has radial joints only")
    rise, residual = CURVES[shape]
    asm = assemble(
        arch(shape, span=SPAN, rise=rise, thickness=0.2, depth=DEPTH, voussoirs=12, joints=kind, springers=SPRINGER)
    )
    joints = joints_of(asm)
    inner, outer = joints.swapaxes(0, 1)
    assert np.abs(residual(*inner.T)).max() < 1e-9
    np.testing.assert_allclose(joints[::-1] * (-1, 1), joints, atol=1e-12)  # symmetric
    np.testing.assert_allclose(inner[5], (0, SPAN / 2 if rise is None else rise), atol=1e-9)  # the crown
    across = outer - inner
    if kind == "vertical":
        assert (across[:, 0] == 0).all()
        return
    # Normal to the curve (its gradient), as long as the arch is thick; a pointed crown has a vertical joint.
    live = np.arange(11) != 5 if shape == "pointed" else slice(None)
    h = 1e-6
    x, z = inner[live].T
    gradient = np.stack(
        [residual(x + h, z) - residual(x - h, z), residual(x, z + h) - residual(x, z - h)], axis=1
    ) / (2 * h)  # fmt: skip
    gradient /= np.linalg.norm(gradient, axis=1)[:, None]
    np.testing.assert_allclose(across[live], 0.2 * gradient, atol=1e-7)


@pytest.mark.parametrize("shape", CURVES)
def test_extrados_of_vertical_joints_is_that_of_radial_ones(shape):
    if shape == "horseshoe":
        pytest.skip("a horseshoe has radial joints only")
    options = {"span": SPAN, "rise": CURVES[shape][0], "thickness": 0.2, "depth": DEPTH, "springers": SPRINGER}
    # A polyline through many radial joints is the extrados; vertical joints end on it.
    fine = joints_of(assemble(arch(shape, voussoirs=2000, **options)))[:, 1]
    fine = fine[np.argsort(fine[:, 0])]
    x, z = joints_of(assemble(arch(shape, voussoirs=16, joints="vertical", **options)))[:, 1].T
    np.testing.assert_allclose(z, np.interp(x, *fine.T), atol=1e-4)


@settings(max_examples=15, deadline=None)
@given(
    shape=st.sampled_from([*CURVES, "flat"]), span=st.floats(0.5, 20), rise=st.floats(0.15, 0.95),
    thick=st.floats(0.05, 0.4), depth=st.floats(0.2, 2), half=st.integers(2, 12),
    kind=st.sampled_from(["radial", "vertical"]),
)  # fmt: skip
def test_any_arch_is_sound(shape, span, rise, thick, depth, half, kind):
    n, thickness = 2 * half, thick * span / 2
    if shape == "flat":
        blocks = jack_arch(span=span, thickness=thickness, depth=depth, voussoirs=n, springers=span / 5)
    else:
        above = shape in ("horseshoe", "pointed")
        given_rise = None if shape == "semicircular" else span * (0.5 + 0.5 * rise if above else 0.5 * rise)
        kind = "radial" if shape == "horseshoe" else kind
        blocks = arch(
            shape, span=span, rise=given_rise, thickness=thickness, depth=depth, voussoirs=n, joints=kind,
            springers=span / 5,
        )  # fmt: skip
    asm = assemble(blocks)
    assert sorted(set(asm.groups)) == ["arch", "springer.left", "springer.right"]
    faces = sound(asm, convex=True)
    joints = joints_of(asm)
    length = np.linalg.norm(joints[:, 1] - joints[:, 0], axis=1)
    areas = joint_areas(asm, faces)
    assert len(areas) == n + 1  # one between neighbours and two springings, no others
    inner = [areas[f"arch.{i}", f"arch.{i + 1}"] for i in range(n - 1)]
    np.testing.assert_allclose(inner, depth * length, rtol=1e-9)
    if shape != "flat":
        assert areas["springer.left", "arch.0"] == pytest.approx(thickness * depth)
        assert areas["springer.right", f"arch.{n - 1}"] == pytest.approx(thickness * depth)


def test_jack_arch_by_hand():
    # A trapezium of skewbacks at 20 degrees; joints meet in one point below.
    asm = assemble(jack_arch(span=2.0, thickness=0.4, depth=DEPTH, voussoirs=9, springers=SPRINGER))
    widening = 0.4 * np.tan(np.deg2rad(20.0))
    assert asm.volume[asm.in_group("arch")].sum() == pytest.approx(DEPTH * 0.4 * (2.0 + widening))
    slope = [(b - a)[0] / (b - a)[1] / a[0] for a, b in joints_of(asm)]
    np.testing.assert_allclose(slope, slope[0])


def test_number_of_voussoirs_from_their_size():
    blocks = arch(span=SPAN, thickness=0.2, depth=DEPTH, voussoir=0.35)
    assert len(blocks) == round(np.pi / 0.35)
    assert len(arch("pointed", span=SPAN, rise=1.5, thickness=0.2, depth=DEPTH, voussoir=0.5)) % 2 == 0


@pytest.mark.parametrize(("thickness", "outcome"), [(0.105, "unstable"), (0.110, "stable")])
def test_verdict_on_both_sides_of_the_least_thickness(thickness, outcome):
    # t / R = 0.1075 for the centreline radius (Ochsendorf 2006; Cocchetti et al. 2011).
    ring = arch(span=2 - thickness, thickness=thickness, depth=DEPTH, voussoirs=60, springers=SPRINGER)
    assert assess(assemble(ring), friction=0.8).outcome.word == outcome


@pytest.mark.parametrize("shape", [*CURVES, "flat"])
def test_a_thick_arch_stands(shape):
    if shape == "flat":
        blocks = jack_arch(span=SPAN, thickness=0.4, depth=DEPTH, voussoirs=9, springers=SPRINGER)
    else:
        blocks = arch(
            shape, span=SPAN, rise=CURVES[shape][0], thickness=0.3, depth=DEPTH, voussoirs=16, springers=SPRINGER
        )
    assert assess(assemble(blocks)).outcome.word == "stable"


def test_vertical_joints_of_a_round_arch_need_more_than_common_friction():
    # A vertical joint carries the weight above it by friction alone: near the springing that is more than 0.7 H.
    blocks = arch(span=SPAN, thickness=0.3, depth=DEPTH, voussoirs=16, joints="vertical", springers=SPRINGER)
    assert assess(assemble(blocks)).outcome.word == "unstable"
    assert assess(assemble(blocks), friction=np.inf).outcome.word == "stable"


@pytest.mark.parametrize("turn", [0, 90, 37.5])
def test_moved_blocks_keep_their_joints(turn):
    blocks = arch(span=SPAN, thickness=0.2, depth=DEPTH, voussoirs=7, springers=SPRINGER)
    asm = assemble(moved(blocks, (3, -2, 1.5), turn=turn, prefix="west."), supports="west.springer")
    assert set(asm.groups) == {"west.arch", "west.springer.left", "west.springer.right"}
    assert find_interfaces(asm).n_interfaces == 8
    crown = asm.centroid[asm.names.index("west.arch.3")]
    np.testing.assert_allclose(crown[:2], (3, -2), atol=1e-12)
    assert crown[2] > 2.5
    left = asm.centroid[asm.names.index("west.springer.left")][:2] - (3, -2)
    np.testing.assert_allclose(np.rad2deg(np.arctan2(*-left[::-1])), turn, atol=1e-12)


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"shape": "gothic"}, "shape is 'gothic'; it must be one of: semicircular"),
        ({"span": 0.0}, "span is 0.0; it must be a length above 0"),
        ({"thickness": -1}, "thickness is -1"),
        ({"depth": np.nan}, "depth is nan"),
        ({"rise": 0.3}, r"rise is 0.3; that of a semicircular profile is span / 2 = 1 m"),
        ({"shape": "segmental"}, "rise is missing"),
        ({"shape": "segmental", "rise": 1.2}, "rise is 1.2; over 2 m a segmental profile has one between 0 and 1 m"),
        ({"shape": "pointed", "rise": 1.5, "voussoirs": 7}, "voussoirs is 7; .* an even number"),
        ({"joints": "skew"}, "joints is 'skew'; it must be one of: radial, vertical"),
        ({"shape": "horseshoe", "rise": 1.5, "joints": "vertical"}, "a horseshoe profile has radial joints only"),
        ({"voussoir": 0.2}, "give either voussoirs"),
        ({"voussoirs": 1}, "voussoirs is 1; it must be a whole number of at least 2"),
        ({"springers": -0.2}, "springers is -0.2"),
    ],
)
def test_bad_parameters_are_named(options, match):
    with pytest.raises(InputError, match=match):
        arch(**{"span": SPAN, "thickness": 0.2, "depth": DEPTH, "voussoirs": 8} | options)


def test_supports_must_be_a_group():
    with pytest.raises(InputError, match='supports: no group "springer"; groups are: arch'):
        assemble(arch(span=SPAN, thickness=0.2, depth=DEPTH, voussoirs=8))


@pytest.mark.parametrize("skew", [-1.0, 80.0, np.nan])
def test_the_skew_of_a_flat_arch_is_an_angle_below_80_degrees(skew):
    options = {"span": 2.0, "thickness": 0.4, "depth": 0.5, "voussoirs": 5}
    with pytest.raises(InputError, match=f"skew is {skew}; it must be an angle from 0 to below 80 degrees"):
        jack_arch(skew=skew, **options)
    assert jack_arch(skew=79.0, **options)
