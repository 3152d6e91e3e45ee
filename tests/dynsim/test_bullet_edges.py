"""Blocks on edges and corners in Bullet, against limits that are exact."""

import numpy as np
import pytest

from blockstat import assess, find_interfaces, glued
from dynsim import AngularSprings, verify
from evidence.scenes.edges import crossed_keels, octahedron_in_corner, prism_in_groove, references, two_ridges

SCENES = [scene for scene in references() if not scene.along_groove]


@pytest.mark.parametrize("pushed", [pytest.param(scene, id=scene.name) for scene in SCENES])
def test_bullet_carries_the_exact_limit_to_three_per_cent(pushed):
    assert verify(pushed.at(0.97)).outcome.word == "stands"
    assert verify(pushed.at(1.03)).outcome.word == "falls"


@pytest.mark.parametrize("mu", [0.2, 0.5])
def test_along_a_groove_bullet_holds_too_much_and_no_more_than_its_friction_pyramid_allows(mu):
    # Each contact has friction mu along two directions at right angles, so sqrt(2) mu halfway between, and the prism
    # may wedge itself: mu' / (sin b sqrt(1 - mu'^2 / tan^2 b)) with mu' = sqrt(2) mu.
    pushed = prism_in_groove(mu, "along")
    most = np.sqrt(2) * mu / (np.sqrt(0.5) * np.sqrt(1 - 2 * mu**2))
    assert verify(pushed.at(0.97)).outcome.word == "stands"
    assert verify(pushed.at(1.03 * most / pushed.limit)).outcome.word == "falls"


@pytest.mark.parametrize(
    "scene",
    [two_ridges(0.0, 0.8, (1, 0)).scene, crossed_keels(0.0).scene, octahedron_in_corner(0.3).scene],
    ids=["edges on a face", "edges across edges", "corners on faces"],
)
def test_contacts_without_area_pass_through_bonds_springs_and_cracks(scene):
    found = find_interfaces(scene)
    assert found.n_interfaces >= 2
    assert not found.area.any()
    assert verify(scene, actions=[AngularSprings(50.0)]).outcome.word == "stands"
    weight = float(scene.mass[scene.free].sum() * np.linalg.norm(scene.gravity))
    for moment in (None, weight):  # glue needs a surface, in statics and in Bullet
        held = glued(scene, 2 * weight, moment=moment)
        assert (assess(held).outcome.word, verify(held).outcome.word) == ("stable", "stands")
        hung = held.with_(gravity=-scene.gravity)
        assert (assess(hung).outcome.word, verify(hung).outcome.word) == ("unstable", "falls")


def test_cracks_are_counted_at_edges():
    cracks = verify(two_ridges(0.0, 0.8, (1, 0)).at(1.1)).cracks
    assert (len(cracks.pair), cracks.n_cracks) == (2, 1)  # it turns about one of its two ridges
