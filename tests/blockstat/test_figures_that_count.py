"""Units, tolerances and defaults that docstrings state are those that files, loads and tilts go by.

Modules that the package imports when they are first needed are imported in the tests: a figure that is read then
counts from there.
"""

import math

import numpy as np
import pytest

from evidence.scenes.small import assembly, box, prism

CORNERS = [[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 4]]


def test_files_are_read_in_the_axes_that_they_are_written_in_and_close_corners_are_one(tmp_path):
    from blockstat import InputWarning, read, write
    from blockstat.io import folder, mesh, names, obj, surface
    from blockstat.io.compas.write import CompasJoint

    # x, y, z of a scene is x, z, -y of a GLB: a rotation.
    np.testing.assert_array_equal(mesh.Y_UP, [[1, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
    asm = assembly([box((0, 0, 0), (1, 2, 3), name="a"), box((0, 0, 3), (1, 2, 4), name="b")])
    back = read(write(asm, tmp_path / "t.glb"))
    np.testing.assert_allclose(back.bounds, asm.bounds, atol=1e-6)
    # Corners nearer than a millionth of a solid, or of a surface, are one.
    for shift, count in ((0.3e-6, 4), (30e-6, 5)):
        lines = [f"v {x} {y} {z}" for x, y, z in [*CORNERS, (4 * shift, 0, 0)]]
        (tmp_path / "s.obj").write_text("\n".join([*lines, "f 1 2 3", "f 5 3 4"]))
        assert len(surface.read_surface(tmp_path / "s.obj")[0]) == count
    import trimesh

    for shift, corners in ((0.1e-6, 4), (40e-6, 6)):
        split = np.array([*CORNERS, *CORNERS[:2]], dtype=float)
        split[4:] += [0, 0, 4 * shift]
        faces = [[0, 2, 1], [4, 5, 3], [0, 3, 2], [1, 2, 3]]
        trimesh.Trimesh(split, faces, process=False).export(tmp_path / "s.ply", encoding="ascii")
        assert len(folder.read_whole(tmp_path / "s.ply")[0]) == corners
    # Names that file systems refuse, empty parts of groups, and groups that exporters write for none.
    odd = assembly([box((0, 0, 0), (1, 1, 1), name="con:", group="a..b")])
    (written,) = write(odd, tmp_path / "odd").rglob("*.ply")
    assert written.relative_to(tmp_path / "odd").as_posix() == "a/%/b/con%3A.ply"
    for group in obj.NO_GROUP:
        (tmp_path / "g.obj").write_text(
            "\n".join([f"v {x} {y} {z}" for x, y, z in CORNERS] + ["o a", f"g {group}", "f 1 2 3"])
        )
        assert obj.read_obj(tmp_path / "g.obj")[0][0].extras["group"] == ""
    assert obj.NO_GROUP == ("", "default", "off")
    # Joints of COMPAS cannot be changed once they are made; parts neither.
    made = CompasJoint((0, 1), [[0.0, 0, 0]], [[0.0, 0, 1]], 1.0, [])
    for frozen, field in ((made, "area"),):
        with pytest.raises(AttributeError):
            setattr(frozen, field, 2.0)
    # A warning names the line that reads.
    with pytest.warns(InputWarning) as caught:
        twice(names.distinct_names)
    assert caught[0].filename == __file__
    assert caught[0].lineno == twice.__code__.co_firstlineno + 5


def twice(function):
    def inner():
        return function(["a", "a"], [])

    # The reader calls what numbers the names; who calls the reader is told.
    return inner()


def test_loads_on_faces_go_by_the_tolerances_that_are_stated():
    from blockstat import InputError, dispersed_load, fluid_pressure, line_load, patch_load, surface_load
    from blockstat.loading import cases, faces, ground, on_faces
    from blockstat.loads import acceleration, point_load

    asm = assembly([box((0, 0, 0), (2, 3, 1), name="one")], supports=[])
    size = asm.size[0]
    corners = np.array([(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1.0)])
    # On a plane to a millionth of the size, all of it to ten millionths.
    assert patch_load(asm, corners + [0, 0, 0.98e-6 * size], (0, 0, -1)).any()
    assert patch_load(asm, corners - [0.98e-5, 0, 0], (0, 0, -1)).any()
    for shift in ([0, 0, 1.02e-6 * size], [-1.02e-5, 0, 0]):
        with pytest.raises(InputError):
            patch_load(asm, corners + shift, (0, 0, -1))
    # A line a ten thousand millionth outside runs along the edge.
    assert line_load(asm, (-0.9e-10 * size, 0, 1), (-0.9e-10 * size, 3, 1), (0, 0, -1))[0, 2] == pytest.approx(-3.0)
    assert (faces.TOWARDS, on_faces.EDGE) == (1e-2, 1e-10)
    # Faces that lean by less than 1e-2 are parallel.
    for lean, loaded in ((0.9e-2, False), (1.1e-2, True)):
        assert bool(fluid_pressure(asm, 9.0, 1.0, (lean, 0, 1))[0, 0]) is loaded
    # Within 45 degrees, and a joint within 15 degrees of its face.
    for degrees, loaded in ((44.99, True), (45.01, False)):
        angle = np.deg2rad(degrees)
        rise = 2 * np.tan(angle)
        roof = assembly([prism([(0, 0), (3, 0), (1, rise), (0, rise)], 1.0)], supports=[])
        area = 1.0 + loaded * 2 / np.cos(angle)
        assert surface_load(roof, (0, 0, -1.0), (0, 0, 1))[0, 2] == pytest.approx(-area, rel=1e-9)
    assert faces.ALONG == pytest.approx(math.cos(math.radians(15)))
    # Defaults: a fluid, no surcharge, a point on the fill.
    water = fluid_pressure(asm, 1.0, 2.0, (-1, 0, 0))[0]
    assert water[0] == pytest.approx(2.0 / 2 * 3)
    assert dispersed_load(asm, (1, 1, 2), 5.0, spread=0.1)[0, 2] == pytest.approx(-5.0)
    given = ground.dispersed_load(asm, (0.05, 1, 2), 5.0, spread=0.1)[0]
    assert given[4] == pytest.approx(5.0 * (0.075 - 1.0))  # a rectangle of .2 m, three quarters of it on the block
    # Load cases: words and factors that may be left out, and what makes each kind.
    case = cases.LoadCase("n", np.zeros((1, 6)), np.ones((1, 6)))
    assert (case.description, case.combination, case.words) == ("", "", "")
    assert set(cases.KINDS) == {
        "point", "line", "patch", "surface", "body", "acceleration", "pressure", "fill", "dispersed",
    }  # fmt: skip
    assert cases.KINDS["acceleration"] is acceleration
    push = {"kind": "point", "block": "one", "point": [0, 1, 1], "force": [1, 2, 3]}
    made = cases.load_case(asm, "n", {"push": push}, {"n": {"factors": {"push": 2.0}}})
    np.testing.assert_allclose(made.permanent, 2 * point_load(asm, "one", (0, 1, 1), (1, 2, 3)), rtol=1e-14)
    with pytest.raises(AttributeError):
        case.name = "m"
    with pytest.raises(AttributeError):
        faces.Face(0, np.eye(3), np.zeros(3), None).block = 1
    assert case != cases.LoadCase("n", np.zeros((1, 6)), np.ones((1, 6)))  # arrays are not compared


def test_tilts_are_searched_in_the_steps_and_widths_that_are_stated():
    from blockstat import Bracket, friction_limit, tilt_limit
    from blockstat.analysis.tilt_friction import friction, tilt

    block = assembly([box((-9, -9, -1), (9, 9, 0)), box((0, 0, 0), (1, 0.5, 2))], friction=0.3)
    for axis, tangent in (("x", 0.25), ("y", 0.3)):
        found = tilt_limit(block, axis)
        assert (found.stands, found.falls) == pytest.approx((math.degrees(math.atan(tangent)),) * 2, abs=1e-4)
    assert tilt_limit(block, "z").stands == 180.0
    still = np.zeros((2, 6))
    scanned = tilt_limit(block, "y", loads=still)
    assert scanned.stands == pytest.approx(math.degrees(math.atan(0.3)), abs=1e-4)
    assert 0 < scanned.falls - scanned.stands <= 1e-6
    assert tilt.COULOMB_WIDTH == 1e-2
    slope = block.with_(gravity=(0.1, 0, -1))
    found = friction_limit(slope)
    assert found.falls == pytest.approx(0.1, abs=1e-6)
    assert 0 < found.stands - found.falls <= 1e-6
    assert friction_limit(block.with_(gravity=(1, 0, -1))).falls == 10.0
    assert friction.COULOMB_FRICTION == 1e-4
    plain = Bracket(1.0, 2.0)
    assert (plain.parameter, plain.unit, plain.kinds, plain.worst) == ("parameter", "", (), "")
    with pytest.raises(AttributeError):
        plain.stands = 2.0
