"""A search that offers only designs on the steps of their ranges, against all designs on these steps.

A ring on two piers: a thicker ring pushes the piers apart, so that the reserve falls where a parameter grows, and the
next larger steps of the best design off the steps need not have the reserve.
"""

from itertools import product

import pytest

from blockstat import Margin, SearchOutcome, build, limit_load, scene_from, search, space_of, with_values

LOAD = (1, 0, 0)


def arcade(pier, ring, height, pier_step=0.1, ring_step=0.1):
    def between(low, high, step):
        return low if low == high else {"value": high, "min": low, "max": high, "step": step}

    return scene_from(
        {
            "name": "arcade",
            "parameters": {
                "pier": between(*pier, pier_step),
                "ring": between(*ring, ring_step),
                "h": between(*height, 0.5),
            },
            "elements": {
                "piers": {
                    "kind": "pier", "size": ["= pier", 0.6], "height": "= h", "courses": 2,
                    "at": ["= -(2 + pier) / 2", 0, 0], "repeat": {"number": 2, "by": ["= 2 + pier", 0, 0]},
                },
                "ring": {
                    "kind": "arch", "span": 2.0, "thickness": "= ring", "depth": 0.6, "voussoirs": 7,
                    "at": [0, 0, "= h"],
                },
            },
        }
    )  # fmt: skip


def lightest_of_all(scene, least):
    """Volume and values of the lightest design on the steps that has the reserve."""
    space = space_of(scene)
    found = []
    for values in product(*(found.steps() for found in space.ranges.values())):
        own = dict(zip(space.names, values, strict=True))
        assembly = build(with_values(scene, own))
        if limit_load(assembly, LOAD).lower >= least:
            found.append((float(assembly.volume[assembly.free].sum()), own))
    return min(found, key=lambda pair: pair[0]) if found else None


@pytest.mark.parametrize(
    ("pier", "ring", "height", "least"),
    [
        (
            (0.4, 0.6),
            (0.1, 0.4),
            (1.5, 1.5),
            0.08,
        ),  # off the steps it ends at the least pier, which takes no thicker ring
        ((0.4, 0.6), (0.1, 0.5), (2.5, 2.5), 0.02),
        ((0.4, 0.6), (0.1, 0.5), (2.5, 2.5), 0.12),
        ((0.4, 0.5), (0.1, 0.4), (1.5, 2.5), 0.12),
        ((0.4, 0.5), (0.2, 0.4), (1.5, 1.5), 0.5),  # none has so much
    ],
)
def test_the_lightest_design_on_the_steps_is_that_of_all(pier, ring, height, least):
    scene = arcade(pier, ring, height)
    expected = lightest_of_all(scene, least)
    found = search(scene, verify=None, strategy="gradient", margin=Margin(LOAD, least), snap=True)
    assert found.best_parameters == (expected and expected[1])
    assert found.outcome is (SearchOutcome.NO_RESERVE if expected is None else SearchOutcome.FOUND)


def test_among_many_designs_the_lightest_near_the_optimum_is_found():
    """More designs than are looked at one by one: 9 piers and 11 rings."""
    scene = arcade((0.4, 0.8), (0.1, 0.6), (2.0, 2.0), pier_step=0.05, ring_step=0.05)
    _, values = lightest_of_all(scene, 0.08)
    found = search(scene, verify=None, strategy="gradient", margin=Margin(LOAD, 0.08), snap=True)
    assert found.best_parameters == values
    assert len(found.history) < 60


def test_designs_around_another_come_from_the_nearest_on():
    space = space_of(arcade((0.4, 0.6), (0.1, 0.4), (1.5, 2.5)))
    centre = {"parameters.pier": 0.43, "parameters.ring": 0.19, "parameters.h": 2.1}
    designs = list(space.around(centre, list(space.names)))
    away = [sum(abs(own[name] - centre[name]) / space.ranges[name].step for name in own) for own in designs]
    assert len({tuple(own.values()) for own in designs}) == space.size == 3 * 4 * 3
    assert away == pytest.approx(sorted(away))
    assert designs[0] == {"parameters.pier": 0.4, "parameters.ring": 0.2, "parameters.h": 2.0}
    alone = list(space.around(centre, ["parameters.ring"]))
    assert [own["parameters.ring"] for own in alone] == [0.2, 0.1, 0.3, 0.4]
    assert {own["parameters.pier"] for own in alone} == {0.43}


def test_a_design_that_stands_without_the_reserve_is_not_called_fallen():
    """A pier 1 m wide and 2 m high tips at half its weight, so that it stands and cannot have .6."""
    pier = {"kind": "pier", "size": ["= w", 0.6], "height": 2.0, "courses": 2}
    width = {"value": 1.0, "min": 0.2, "max": 1.0, "step": 0.2}
    scene = scene_from({"name": "pier", "parameters": {"w": width}, "elements": {"pier": pier}})
    for snap in (False, True):
        found = search(scene, verify=None, strategy="gradient", margin=Margin(LOAD, 0.6), snap=snap)
        assert found.best_parameters is None
        assert found.outcome is SearchOutcome.NO_RESERVE
        assert "stood" not in found.explain()
        assert found.none_stood.startswith("designs stand, and none was found with the reserve")
    enough = search(scene, verify=None, strategy="gradient", margin=Margin(LOAD, 0.25), snap=True)
    assert enough.best_parameters == {"parameters.w": 0.6}  # tips at .3, the next smaller one at .2
