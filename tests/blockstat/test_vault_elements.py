"""Ribs, drums, fan and sail vaults, vaults from meshes: sound, whole, and of the size that theory says."""

import json
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from blockstat import InputError, InputWarning, assess, box, build, find_interfaces, read, repair, scene_from, write
from blockstat.model import (
    assemble,
    barrel_vault,
    dome,
    drum,
    fan_vault,
    mesh_vault,
    moved,
    rib,
    sail_vault,
    surface_points,
)
from elements import joint_areas, outline_volume, sound

SHAPES = {"semicircular": None, "segmental": 0.3, "pointed": 0.7, "elliptic": 0.4}  #: rise over span


@settings(max_examples=15, deadline=None)
@given(
    shape=st.sampled_from(sorted(SHAPES)), span=st.floats(1, 10), thick=st.floats(0.05, 0.12),
    depth=st.floats(0.2, 1.0), half=st.integers(3, 10),
)  # fmt: skip
def test_a_rib_carries_its_vault_course_by_course(shape, span, thick, depth, half):
    rise = SHAPES[shape] and SHAPES[shape] * span
    plan = {"shape": shape, "span": span, "rise": rise, "voussoirs": 2 * half}
    vault = barrel_vault(length=depth, brick=depth, thickness=thick * span, springers=0.3 * span, **plan)
    below = moved(rib(thickness=thick * span, depth=depth, springers=0.3 * span, **plan), turn=90, prefix="rib.")
    asm = assemble([*vault, *below], supports=["springer", "rib.springer"])
    faces = sound(asm, convex=True)
    assert len(asm.in_group("rib.rib")) == 2 * half
    # A stone of the vault and its stone of the rib meet in the whole facet of the intrados.
    corners = np.array([asm.block_vertices(b) for b in asm.in_group("rib.rib")])[..., [1, 2]]
    assert corners.shape[1] == 8
    areas = joint_areas(asm, faces)
    under = {key: area for key, area in areas.items() if key[0].startswith("vault") != key[1].startswith("vault")}
    under = {key: area for key, area in under.items() if "rib.rib" in "".join(key)}
    per_course = np.zeros(2 * half)
    for key, area in under.items():
        stone = next(name for name in key if name.startswith("rib.rib"))
        per_course[int(stone.split(".")[-1])] += area
    # All voussoirs are of one length along the intrados; on circles so are their chords.
    if shape != "elliptic":
        np.testing.assert_allclose(per_course, per_course[0], rtol=1e-6)
    assert (per_course > 0).all()


def test_a_rib_has_the_volume_of_its_ring():
    n, outer, inner, depth = 15, 2.0, 1.7, 0.4
    asm = assemble(rib(span=4.0, thickness=0.3, depth=depth, voussoirs=n, springers=0.3))
    ring = depth * n / 2 * np.sin(np.pi / n) * (outer**2 - inner**2)
    assert asm.volume[asm.in_group("rib")].sum() == pytest.approx(ring, rel=1e-12)


def test_a_rib_too_thick_for_its_curve_is_refused():
    for thickness in (1.0, 5.0):
        with pytest.raises(InputError, match="thickness is"):
            rib("elliptic", span=4.0, rise=0.9, thickness=thickness, depth=0.5, voussoirs=12)
    with pytest.raises(InputError, match="even number"):
        rib("pointed", span=4.0, rise=2.4, thickness=0.2, depth=0.5, voussoirs=11)


@settings(max_examples=10, deadline=None)
@given(
    span=st.floats(2, 12), thick=st.floats(0.03, 0.2), height=st.floats(0.2, 1.0), courses=st.integers(1, 6),
    voussoirs=st.integers(4, 20), bond=st.sampled_from(["running", "stack"]),
)  # fmt: skip
def test_any_drum_carries_its_dome(span, thick, height, courses, voussoirs, bond):
    t = thick * span
    plan = {"span": span, "voussoirs": voussoirs, "thickness": t}
    stones = drum(height=height * span, courses=courses, bond=bond, **plan)
    top = moved(dome(rings=4, **plan), (0, 0, height * span))
    asm = assemble([*stones, *top], supports="drum.0")
    faces = sound(asm)
    assert {f"drum.{k}" for k in range(courses)} <= set(asm.groups)
    # A polygon ring of 2 x voussoirs sides.
    ring = voussoirs * np.sin(np.pi / voussoirs) * ((span / 2 + t) ** 2 - (span / 2) ** 2)
    assert asm.volume[asm.in_group("drum")].sum() == pytest.approx(ring * height * span, rel=1e-9)
    springing = sum(
        a for key, a in joint_areas(asm, faces).items() if {n.split(".")[0] for n in key} == {"drum", "dome"}
    )
    assert springing == pytest.approx(ring, rel=1e-9)


@settings(max_examples=10, deadline=None)
@given(
    x=st.floats(2, 8), ratio=st.floats(0.6, 1.6), rise=st.floats(0.4, 0.9), thick=st.floats(0.03, 0.06),
    rings=st.integers(3, 8), half=st.integers(1, 4),
)  # fmt: skip
def test_any_fan_vault_is_sound(x, ratio, rise, thick, rings, half):
    y, small = x * ratio, min(x, x * ratio)
    t, foot = thick * small, 0.1 * small
    blocks = fan_vault(
        spans=(x, y), rise=rise * small, thickness=t, foot=foot, rings=rings, voussoirs=2 * half, springers=0.2
    )
    asm = assemble(blocks)
    faces = sound(asm)
    assert set(asm.groups) == {
        f"{part}.{corner}" for part in ("vault", "springer") for corner in ("ne", "nw", "sw", "se")
    }
    quarter = asm.volume[asm.in_group("vault.ne")].sum()
    for corner in ("nw", "sw", "se"):
        assert asm.volume[asm.in_group(f"vault.{corner}")].sum() == pytest.approx(quarter, rel=1e-9)
    # Blocks fill what their outer surface encloses: no gaps, no overlaps.
    assert outline_volume(asm) == pytest.approx(asm.volume.sum(), rel=1e-9)
    # It covers its bay: from the edge planes to the middle lines, all of whose joints lie in upright planes.
    lower, upper = asm.bounds
    np.testing.assert_allclose((lower.min(axis=0)[:2], upper.max(axis=0)[:2]), ((-x / 2, -y / 2), (x / 2, y / 2)))
    across = np.array([len({asm.groups[a].split(".")[1], asm.groups[b].split(".")[1]}) > 1 for a, b in faces.pair])
    assert across.any()
    assert np.abs(faces.frame[across, 0, 2]).max() < 1e-9


def test_bed_of_a_fan_by_hand():
    # A quarter of a ring between two polygons, level at the springing.
    asm = assemble(fan_vault(spans=(4, 4), rise=2.2, thickness=0.25, foot=0.4, rings=6, voussoirs=4, springers=0.3))
    beds = sum(a for key, a in joint_areas(asm, sound(asm)).items() if key[0].startswith("springer"))
    quarter = 8 / 2 * np.sin(np.pi / 16) * (0.4**2 - 0.15**2)
    assert beds == pytest.approx(4 * quarter, rel=1e-9)
    assert assess(asm).outcome.word == "stable"


@settings(max_examples=8, deadline=None)
@given(
    x=st.floats(2, 8), ratio=st.floats(0.6, 1.6), rise=st.floats(0.3, 0.8), courses=st.integers(5, 11),
    voussoirs=st.integers(3, 6),
)  # fmt: skip
def test_any_sail_vault_is_sound_and_spherical(x, ratio, rise, courses, voussoirs):
    spans = (x, x * ratio)
    reach = np.hypot(*spans) / 2
    rise, t = rise * reach, 0.03 * x
    asm = assemble(sail_vault(spans=spans, rise=rise, thickness=t, courses=courses, voussoirs=voussoirs, springers=0.2))
    sound(asm)
    assert outline_volume(asm) == pytest.approx(asm.volume.sum(), rel=1e-9)
    radius = (reach**2 + rise**2) / (2 * rise)
    vault = np.concatenate([asm.block_vertices(b) for b in asm.in_group("vault")])
    distance = np.linalg.norm(vault - (0, 0, rise - radius), axis=1)
    # Normals are differences between points of a coarse grid: thickness along them is t, radii nearly so.
    np.testing.assert_allclose(np.abs(distance - radius), t / 2, rtol=0.1)


def quad_mesh(cells: int, rise: float = 1.2, size: float = 4.0):
    place = np.linspace(-size / 2, size / 2, cells + 1)
    x, y = np.meshgrid(place, place, indexing="ij")
    z = rise * (1 - (2 * x / size) ** 2)
    index = np.arange((cells + 1) ** 2).reshape(cells + 1, cells + 1)
    faces = np.stack([index[:-1, :-1], index[1:, :-1], index[1:, 1:], index[:-1, 1:]], axis=-1).reshape(-1, 4)
    return np.column_stack([x.ravel(), y.ravel(), z.ravel()]), faces.tolist()


@settings(max_examples=10, deadline=None)
@given(cells=st.integers(3, 8), twist=st.floats(-0.1, 0.1), thick=st.floats(0.02, 0.1), triangles=st.booleans())
def test_any_mesh_is_a_sound_vault(cells, twist, thick, triangles):
    vertices, faces = quad_mesh(cells)
    vertices[:, 2] += twist * vertices[:, 0] * vertices[:, 1] ** 2
    if triangles:
        faces = [part for a, b, c, d in faces for part in ([a, b, c], [a, c, d])]
    asm = assemble(mesh_vault(vertices, faces, thickness=4 * thick, supports="all", springers=0.3))
    sound(asm)
    assert len(asm.in_group("vault")) == len(faces)
    assert len(asm.in_group("springer")) == 4 * cells
    assert outline_volume(asm) == pytest.approx(asm.volume.sum(), rel=1e-9)


def test_a_flat_mesh_by_hand():
    vertices, faces = quad_mesh(4, rise=0.0)
    turned = [face[::-1] for face in faces]
    for quads in (faces, turned):
        asm = assemble(mesh_vault(vertices, quads, thickness=0.25, supports="all", springers=0.5))
        np.testing.assert_allclose(asm.volume[asm.in_group("vault")], 0.25)
    mixed = [*faces[:-1], faces[-1][::-1]]
    with pytest.raises(InputError, match="turned against its neighbour"):
        mesh_vault(vertices, mixed, thickness=0.25)


@pytest.mark.parametrize("suffix", [".obj", ".ply", ".stl"])
def test_a_mesh_file_in_a_scene(tmp_path, suffix):
    import trimesh

    vertices, faces = quad_mesh(6)
    path = tmp_path / f"surface{suffix}"
    if suffix == ".obj":
        lines = ["v " + " ".join(map(str, v)) for v in vertices]
        path.write_text("\n".join([*lines, *("f " + " ".join(str(k + 1) for k in f) for f in faces)]))
    else:
        trimesh.Trimesh(vertices, [p for a, b, c, d in faces for p in ([a, b, c], [a, c, d])]).export(path)
    shared = {"file": str(path), "thickness": 0.3, "springers": 0.3}
    as_faces = {"name": "roof", "elements": {"roof": {"kind": "mesh_vault", **shared}}, "supports": ["roof.springer"]}
    asm = build(scene_from(as_faces))
    sound(asm)
    assert len(asm.in_group("roof.vault")) == (36 if suffix == ".obj" else 72)
    assert len(asm.in_group("roof.springer")) == 12  # two edges at the lowest level
    courses = {"kind": "freeform", "courses": 7, "voussoirs": 4, "supports": ["west", "east"], **shared}
    asm = build(scene_from({"name": "roof", "elements": {"roof": courses}, "supports": ["roof.springer"]}))
    sound(asm)
    np.testing.assert_allclose(asm.bounds[1][asm.in_group("roof.vault"), 2].max(), 1.2 + 0.15, atol=0.02)


def test_points_of_a_mesh_lie_on_it():
    vertices, faces = quad_mesh(8)
    points = surface_points(vertices, faces, x=(-1.5, 1.5), y=(-1.9, 1.9), courses=5, voussoirs=3)
    place = np.linspace(-2, 2, 9)
    np.testing.assert_allclose(
        points[..., 2], np.interp(points[..., 0], place, 1.2 * (1 - (place / 2) ** 2)), atol=1e-9
    )
    with pytest.raises(InputError, match="height is nan at x = -3 m"):
        surface_points(vertices, faces, x=(-3, 3), y=None, courses=5, voussoirs=3)


def test_a_formula_and_what_is_wrong_with_it():
    roof = {"kind": "freeform", "x": [-2, 2], "y": [-2, 2], "courses": 7, "voussoirs": 4, "thickness": 0.3}
    roof |= {"springers": 0.3}

    def built(**change):
        scene = {"name": "roof", "elements": {"roof": roof | change}, "supports": ["roof.springer"]}
        return build(scene_from(scene))

    asm = built(height="top - y ** 2 / 4", constants={"top": 1.0})
    sound(asm)
    middle = asm.centroid[asm.in_group("roof.vault")]
    np.testing.assert_allclose(middle[:, 2], 1 - middle[:, 1] ** 2 / 4, atol=0.1)
    for change, words in (
        ({"height": "top"}, r'elements.roof: height: .*no parameter "top"; parameters are: x, y'),
        ({"height": "1 / 0"}, "elements.roof: height: "),
        ({"height": "sqrt(-1 - x ** 2)"}, "elements.roof: height: "),
        ({}, "give either height"),
        ({"height": "1", "x": None}, "x and y are missing"),
        ({"height": "1", "constants": {"x": 1}}, "constants.x: x is a coordinate"),
    ):
        with pytest.raises(InputError, match=words):
            built(**change)


def test_blocks_of_a_file_among_elements(tmp_path):
    stone = {"name": "stone", "elements": {"stone": {"kind": "box", "size": [1, 1, 0.5]}}}
    path = write(build(scene_from(stone)), tmp_path / "stone.obj")
    scene = {"kind": "mesh", "file": str(path), "at": [0, 0, 0.5]}
    asm = build(scene_from({"name": "two", "elements": {"old": scene}, "supports": ["old.ground"]}))
    assert set(asm.names) == {"old.stone", "old.ground"}
    with pytest.raises(InputError, match=r"elements\.old: .*none\.obj: no such file"):
        build(scene_from({"name": "two", "elements": {"old": scene | {"file": str(tmp_path / "none.obj")}}}))


def pile_of_file(path, element=(), *, names=("", "", ""), **said):
    """A scene of one JSON file of cubes on top of each other."""
    cubes = [box((0, 0, k), (1, 1, k + 1), name=name) for k, name in enumerate(names)]
    blocks = [{"name": b.name, "vertices": np.array(b.vertices).tolist(), "faces": b.faces} for b in cubes]
    path.write_text(json.dumps({"blocks": blocks, **said}, default=list))
    return build(scene_from({"name": "n", "elements": {"pile": {"kind": "mesh", "file": str(path), **dict(element)}}}))


def test_blocks_of_a_file_have_its_density(tmp_path):
    path = tmp_path / "pile.json"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert pile_of_file(path, density=1000).density[1:].tolist() == 3 * [1000.0]
    assert read(path, supports=[0]).density.tolist() == 3 * [1000.0]
    assert pile_of_file(path, {"density": 1500}).density[1:].tolist() == 3 * [1500.0]  # the file says none
    assert pile_of_file(path, {"density": 1500}, density=1000).density[1:].tolist() == 3 * [1500.0]


def test_what_a_scene_does_not_take_of_a_file_is_told(tmp_path):
    path = tmp_path / "pile.json"
    law = {"between": ["*", "*"], "tension": 1e5}
    tie = {"between": [0, 1], "points": [[0.5, 0.5, 0.5], [0.5, 0.5, 1.5]]}
    with pytest.warns(InputWarning, match=r"pile\.json: joints, ties, friction of the file are not taken"):
        asm = pile_of_file(path, joints=[law], ties=[tie], friction=0.3)
    assert (asm.joints, asm.ties, asm.friction) == ((), (), 0.7)


def test_blocks_of_a_file_without_names_have_their_numbers(tmp_path):
    path = tmp_path / "pile.json"
    assert pile_of_file(path).names[1:] == ("pile.block0", "pile.block1", "pile.block2")
    assert pile_of_file(path, names=("", "block0", "")).names[1:] == ("pile.block0_", "pile.block0", "pile.block2")
    assert pile_of_file(path, names=("",)).names[1:] == ("pile",)
    assert [b.name for b in moved([box((0, 0, 0), (1, 1, 1), name="")] * 2, (1, 0, 0))] == ["", ""]
    copies = pile_of_file(path, {"repeat": {"number": 2, "by": [3, 0, 0]}})
    assert copies.names[1:] == tuple(f"pile.{k}.block{i}" for k in (1, 2) for i in range(3))


@pytest.mark.parametrize("noise", [1e-5, 1e-3])
def test_a_rough_curved_vault_is_repaired_without_being_flattened(noise):
    # Joints of twisted quadrilaterals are pairs of triangles: corners are brought together, no plane is forced on them.
    vertices, faces = quad_mesh(5)
    vertices[:, 2] += 0.08 * vertices[:, 0] * vertices[:, 1] ** 2
    exact = assemble(mesh_vault(vertices, faces, thickness=0.3, supports="all", springers=0.3))
    rng = np.random.default_rng(3)
    step = noise * exact.size[exact.vertex_block][:, None] * rng.uniform(-1, 1, exact.vertices.shape)
    repaired, report = repair(exact.with_(vertices=exact.vertices + step))
    before, after = find_interfaces(exact), find_interfaces(repaired)
    assert after.gap.max() < 1e-9 * exact.size.max()
    assert set(map(tuple, after.pair.tolist())) == set(map(tuple, before.pair.tolist()))
    # The springers have quadrilaterals that are not quite flat; these are made so.
    assert np.abs(repaired.vertices - exact.vertices).max() <= (noise + 2e-3) * exact.size.max()
    assert len(report.changed) == exact.n_blocks


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"voussoirs": 5}, "voussoirs is 5; it must be even, for a joint in the diagonal"),
        ({"foot": 0.2}, r"foot is 0\.2; it must be from the thickness, 0\.25 m, to less than half the smaller span"),
        ({"foot": 2.0}, r"foot is 2\.0; it must be from the thickness"),
        ({"rings": 1}, "rings is 1; it must be a whole number of at least 2"),
        ({"spans": 4.0}, r"spans is 4\.0; it must be the two spans along x and y"),
        ({"spans": (4.0, 4.0, 4.0)}, "it must be the two spans along x and y"),
        ({"spans": (4.0, 0.0)}, r"spans\[1\] is 0\.0"),
    ],
)
def test_bad_fan_vaults_are_named(change, words):
    fan = {"spans": (4.0, 6.0), "rise": 2.2, "thickness": 0.25, "foot": 0.4, "rings": 3, "voussoirs": 4}
    assert fan_vault(**fan)
    with pytest.raises(InputError, match=words):
        fan_vault(**fan | change)


def test_a_sail_is_less_than_half_a_sphere():
    # Over 3 m by 4 m half the diagonal is 2.5 m.
    sail = {"spans": (3.0, 4.0), "thickness": 0.2, "courses": 4, "voussoirs": 4}
    assert sail_vault(rise=2.49, **sail)
    for rise in (2.5, 3.0):
        with pytest.raises(
            InputError, match=f"rise is {rise}; over this bay it must be less than half the diagonal, 2.5 m"
        ):
            sail_vault(rise=rise, **sail)
    with pytest.raises(InputError, match=r"spans is \(3\.0,\); it must be the two spans"):
        sail_vault(rise=1.0, **sail | {"spans": (3.0,)})


TETRAHEDRON = [(0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)]


@pytest.mark.parametrize(
    ("vertices", "faces", "words"),
    [
        (TETRAHEDRON, [(0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2)], "the mesh has no boundary; there is nowhere for"),
        ([(0, 0, 0), (1, 0, 1), (0, 1, 1)], [(0, 1, 2)], "no edge of the mesh's boundary is at its lowest level"),
        ([(0, 0, 0), (1, 0, 0), (2, 0, 0)], [(0, 1, 2)], "corner 0 of the mesh has no normal; it is folded"),
    ],
    ids=["closed", "on a corner", "without area"],
)
def test_meshes_without_a_place_for_springers_or_a_normal_are_refused(vertices, faces, words):
    with pytest.raises(InputError, match=words):
        mesh_vault(vertices, faces, thickness=0.05, springers=0.2)


def test_a_mesh_on_one_corner_has_springers_at_all_its_edges_where_they_are_asked_for():
    asm = assemble(
        mesh_vault([(0, 0, 0), (1, 0, 1), (0, 1, 1)], [(0, 1, 2)], thickness=0.05, springers=0.2, supports="all")
    )
    assert asm.n_blocks == 1 + 3
