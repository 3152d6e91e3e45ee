import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from shapely import Polygon

from blockstat import InputError, assess
from blockstat.model import assemble, dome
from elements import joint_areas, outline_volume, sound


def rings_by_hand(span, thickness, rings, oculus):
    """Radii and heights of the joints of a hemispherical dome, each shape (rings + 1, 2): intrados, extrados."""
    last = np.arccos(oculus / span) if oculus else np.pi / 2 * rings / (rings + 0.5)
    angle = last * np.arange(rings + 1) / rings
    radius = np.array([span / 2, span / 2 + thickness])
    return np.outer(np.cos(angle), radius), np.outer(np.sin(angle), radius)


@settings(max_examples=12, deadline=None)
@given(
    span=st.floats(1.0, 30.0), thick=st.floats(0.03, 0.3), rings=st.integers(1, 8), n=st.integers(3, 14),
    opening=st.sampled_from([0.0, 0.2, 0.5]), bond=st.sampled_from(["running", "stack"]),
)  # fmt: skip
def test_any_dome_is_sound(span, thick, rings, n, opening, bond):
    t, oculus = thick * span / 2, opening * span
    asm = assemble(
        dome(span=span, thickness=t, rings=rings, voussoirs=n, oculus=oculus, bond=bond, springers=0.1 * span)
    )
    assert set(asm.groups) == {"springer", *(f"dome.{i}" for i in range(rings)), *([] if oculus else ["dome.key"])}
    faces = sound(asm)

    r, z = rings_by_hand(span, t, rings, oculus)
    sections = [
        Polygon([(r[j, k], z[j, k]) for j, k in ((i, 0), (i, 1), (i + 1, 1), (i + 1, 0))]) for i in range(rings)
    ]  # fmt: skip
    facet = np.pi / n  # a wedge between meridian planes: its chords and apothems go with the radius
    ring = [2 * n * np.sin(facet) * s.area * s.centroid.x for s in sections]
    key = n * np.sin(facet) / 3 * np.ptp(z[-1]) * ((r[-1] ** 2).sum() + r[-1].prod())
    volume = sum(ring) + (0 if oculus else key)
    assert asm.volume[asm.in_group("dome")].sum() == pytest.approx(volume, rel=1e-9)
    assert outline_volume(asm) == pytest.approx(asm.volume.sum(), rel=1e-9)

    bed = 2 * n * np.sin(facet / 2) * r.sum(axis=1) * np.hypot(np.ptp(r, axis=1) * np.cos(facet / 2), np.ptp(z, axis=1))
    beds = bed.sum() - (bed[-1] if oculus else 0)
    assert faces.area.sum() == pytest.approx(beds + n * sum(s.area for s in sections), rel=1e-9)
    between = 2 * n if bond == "running" else n
    assert len(joint_areas(asm, faces)) == n + rings * n + (rings - 1) * between + (0 if oculus else n)


def test_voussoirs_of_a_bonded_dome_share_half_a_bed():
    asm = assemble(dome(span=5, thickness=0.4, rings=4, voussoirs=10, springers=0.3))
    areas = joint_areas(asm, sound(asm))
    assert areas["dome.1.3", "dome.2.3"] == pytest.approx(areas["dome.1.3", "dome.2.4"])
    assert ("dome.1.3", "dome.2.5") not in areas


@pytest.mark.parametrize(
    ("shape", "rise"), [("pointed", 3.5), ("segmental", 1.0), ("elliptic", 1.6), ("horseshoe", 3.0)]
)
def test_other_profiles(shape, rise):
    asm = assemble(dome(shape, span=5.0, rise=rise, thickness=0.4, rings=6, voussoirs=12, springers=0.3))
    sound(asm)
    assert outline_volume(asm) == pytest.approx(asm.volume.sum(), rel=1e-9)
    assert assess(asm).outcome.word == "stable"


def test_an_oculus_is_as_wide_as_asked():
    asm = assemble(dome("pointed", span=5, rise=3.5, thickness=0.4, rings=6, voussoirs=12, oculus=1.2, springers=0.3))
    free = asm.vertices[~asm.support[asm.vertex_block]]
    assert np.hypot(*free[:, :2].T).min() == pytest.approx(0.6)
    assert assess(asm).outcome.word == "stable"


@pytest.mark.parametrize(
    ("thickness", "bond", "outcome"),
    [(0.036, "stack", "unstable"), (0.040, "stack", "stable"), (0.036, "running", "stable")],
)
def test_verdict_on_both_sides_of_the_least_thickness(thickness, bond, outcome):
    """A hemisphere cut into lunes needs t / R = 0.0428 (Heyman 1967: 0.042) when the lunes are infinitely narrow.

    Of 32 lunes each is deeper by the sagitta of its arc in plan, 1 - cos(pi / 32) = 0.0048, which leaves 0.0380. Bond
    carries the hoop tension by friction on the beds, which lunes cannot: a thinner dome stands.
    """
    asm = assemble(dome(span=2 - thickness, thickness=thickness, rings=12, voussoirs=32, bond=bond, springers=0.3))
    assert assess(asm).outcome.word == outcome


def test_bond_does_not_hold_narrow_stones_of_little_friction():
    # Twice as narrow: half the overlap, half the hoop tension.
    options = {"span": 2 - 0.02, "thickness": 0.02, "rings": 12, "bond": "running", "springers": 0.3}
    wide, narrow = (assemble(dome(voussoirs=n, **options)) for n in (32, 64))
    assert assess(wide, friction=0.4).outcome.word == "stable"
    assert assess(narrow, friction=0.4).outcome.word == "unstable"


@pytest.mark.parametrize(
    ("options", "match"),
    [
        ({"rings": 0}, "rings is 0; it must be a whole number of at least 1"),
        ({"voussoirs": 2}, "voussoirs is 2"),
        ({"bond": "flemish"}, "bond is 'flemish'; it must be one of: running, stack"),
        ({"oculus": 6.0}, "oculus is 6.0; it must be a diameter from 0 to the span, 5 m"),
        ({"span": -5}, "span is -5"),
        ({"springers": -1}, "springers is -1"),
    ],
)
def test_bad_parameters_are_named(options, match):
    with pytest.raises(InputError, match=match):
        dome(**{"span": 5, "thickness": 0.4, "rings": 4, "voussoirs": 10} | options)
