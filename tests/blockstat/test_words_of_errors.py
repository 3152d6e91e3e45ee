"""Errors of single values read as sentences."""

import numpy as np
import pytest

from blockstat import Assembly, Block, InputError, box, build, scene_from
from blockstat.model.arches.profile import profile


def wall(**opening):
    runs = {"front": {"path": [[0, 0], [4, 0]], "thickness": 0.4, "height": 2.0, "openings": [opening]}}
    return build(scene_from({"name": "x", "elements": {"w": {"kind": "walls", "brick": [0.4, 0.2], "runs": runs}}}))


def of_size(text):
    return scene_from({"name": "x", "elements": {"p": {"kind": "box", "size": [text, 1, 1]}}})


def ring():
    """A square frame whose upper face is one outline with a bridge to its hole."""
    square = np.array([(0, 0), (3, 0), (3, 3), (0, 3)])
    plan = np.vstack([square, (square + 1.5) / 2])
    vertices = np.vstack([np.column_stack([plan, np.full(8, z)]) for z in (0.0, 1.0)])
    return Assembly.from_blocks([Block(vertices, [[8, 9, 10, 11, 8, 12, 15, 14, 13, 12], [0, 1, 9, 8]], name="ring")])


@pytest.mark.parametrize(
    ("ask", "sentence"),
    [
        (lambda: of_size("= 9**9**9"), 'elements.p.size.0: "= 9**9**9" is too large a number'),
        (lambda: wall(width=900, height=1), "openings[0]: an opening of 900 m width does not fit 4 m of wall"),
        (lambda: wall(width=900, height=1, number=2), "2 openings of 900 m width do not fit 4 m of wall"),
        (lambda: profile("pointed", 0.8, 0.3), "over 0.8 m a pointed profile has one above 0.4 m"),
        (lambda: profile("segmental", 0.8, 0.5), "over 0.8 m a segmental profile has one between 0 and 0.4 m"),
        (lambda: profile("elliptic", 0.8, None), "an elliptic profile needs one"),
        (
            lambda: wall(width=1, height=1, head="elliptic", rise=0.5, skew=0.1),
            "skew says nothing about an elliptic h",
        ),
        (
            lambda: Assembly.from_blocks([box((0, 0, 0), (1e9, 1e9, 0.5), name="b")]),
            'block "b": its volume is 5e+17 m3 over 1.41e+09 m; it is flat',
        ),
        (
            ring,
            "12]; it needs three or more different corners; cut a face with a hole into faces without",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_the_sentence(ask, sentence):
    with pytest.raises(InputError) as refused:
        ask()
    assert sentence in str(refused.value)
