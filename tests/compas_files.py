"""How a reading of a COMPAS file is held against what the COMPAS packages themselves read from it."""

import numpy as np

#: The files of tests/compas/make_files.py.
FILES = ("assembly", "bare_assembly", "model", "plain_model")


def assert_same(asm, expected, *, atol=1e-14):
    """Names, groups, supports, densities where one is given, faces exactly; vertices [m] to atol; volumes."""
    rows = expected["blocks"]
    assert asm.name == expected["name"]
    assert list(asm.names) == [row["name"] for row in rows]
    assert list(asm.groups) == [row["group"] for row in rows]
    assert asm.support.tolist() == [row["support"] for row in rows]
    for i, row in enumerate(rows):
        np.testing.assert_allclose(asm.block_vertices(i), row["vertices"], rtol=0, atol=atol)
        assert [face.tolist() for face in asm.faces_of(i)] == row["faces"]
        if row["density"] is not None:
            assert asm.density[i] == row["density"]
    np.testing.assert_allclose(asm.volume, [row["volume"] for row in rows], rtol=1e-12)
