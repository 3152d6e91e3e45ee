"""Units, defaults and doubts of files are those that docstrings state.

What is read when a module is imported counts from there, so the modules are imported in the tests.
"""

import json

import numpy as np
import pytest

from evidence.scenes.small import assembly, box

CORNERS = [[0, 0, 0], [2, 0, 0], [0, 3, 0], [0, 0, 4]]
FACES = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]


def test_coordinates_are_in_the_unit_that_is_named_and_doubted_where_no_building_has_them(tmp_path):
    from blockstat import InputError, read
    from blockstat.io import native, parts

    # The international inch and foot of 1959.
    path = tmp_path / "t.json"
    for unit, metres in {"m": 1, "dm": 0.1, "cm": 0.01, "mm": 0.001, "in": 0.0254, "ft": 0.3048}.items():
        path.write_text(json.dumps({"blocks": [{"vertices": CORNERS, "faces": FACES}], "supports": [0], "units": unit}))
        np.testing.assert_allclose(read(path, units=unit).vertices, np.array(CORNERS) * metres, rtol=1e-12)
    assert len(parts.UNITS) == 6
    # What a native file leaves out.
    bare = native.native_parts({"blocks": [{"vertices": CORNERS, "faces": FACES}]}, "stem", supports=[0]).assembled()
    assert (bare.density.tolist(), bare.friction, bare.gravity.tolist()) == ([2691.0], 0.7, [0.0, 0.0, -9.81])
    joint, tie = {"between": ["*", "*"]}, {"between": [0, 1], "points": [[0, 0, 0], [1, 1, 1]]}
    found = native.native_parts({"blocks": [], "joints": [joint], "ties": [tie]}, "stem")
    law, rod = found.options["joints"][0], found.options["ties"][0]
    assert (law.friction, law.tension, law.bond, law.cohesion, law.compression, law.cells) == (
        None, 0.0, 0.0, None, None, 0,
    )  # fmt: skip
    assert law.bond_moment is None
    assert (rod.least, rod.greatest, rod.strut) == (0.0, np.inf, False)
    assert (found.blocks, found.supports, found.options["metadata"]) == ([], [], {})
    # No stone is longer than 25 m or lighter than cork, and no building heavier than 6e10 N.
    long = assembly(
        [box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (25.1, 0.1, 0.1), density=200.0)], gravity=(0, 0, -9.81)
    )
    assert "25.1 m long" in parts.doubts(long)[0]
    short = assembly(
        [box((0, 0, -1), (1, 1, 0)), box((0, 0, 0), (24.9, 0.1, 0.1), density=200.0)], gravity=(0, 0, -9.81)
    )
    assert parts.doubts(short) == []
    for density, told in ((199.0, True), (20e3, False), (20001.0, True)):
        assert bool(parts.doubts(short.with_(density=np.array([1.0, density])))) is told
    for pull, told in ((5.99e10, False), (6.01e10, True)):
        heavy = parts.doubts(short.with_(gravity=(0, 0, -pull / (200 * 0.249))))
        assert any("the blocks weigh" in text for text in heavy) is told
    assert parts.Parts([], []).up == "z"
    assert parts.Parts([], []).options == {}
    for frozen, field in ((parts.Parts([], []), "up"), (rod, "least")):
        with pytest.raises(AttributeError):
            setattr(frozen, field, 2.0)
    with pytest.raises(InputError, match="units are"):
        read(path, units="yd")
