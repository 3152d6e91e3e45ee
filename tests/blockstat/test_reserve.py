"""What a stable verdict has in reserve: neutral motions, slivers, and contacts that are in no program."""

import re
from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from blockstat import (
    Assembly,
    Block,
    Imperfections,
    JointLaw,
    LoadOutcome,
    Outcome,
    Tie,
    acceleration,
    assess,
    find_interfaces,
    limit_load,
)
from blockstat.analysis import limit_load as limits
from blockstat.analysis.problem import pose
from blockstat.analysis.reserve import (
    SLIVER,
    Doubtful,
    doubtful_joints,
    joints_in_words,
    neutral_warning,
    without_slivers,
)
from blockstat.analysis.rims import falling_freely, overlap_warnings, rim_warnings
from evidence.scenes.small import assembly, bevelled, box, pinched, prism
from overhang import BACKWARDS, FORWARDS, PLACES, apex, beside, one_support, overhanging, rising

GROUND = box((-9, -9, -1), (9, 9, 0), name="ground")


def posed(asm, **options):
    given = {"friction": None, "gravity": None, "loads": None, "gap": 0.01, "interfaces": None}
    return pose(asm, **(given | options))


def seesaw(shift=0.0, n=1):
    """Plates each on a ridge below its middle, or so far beside it, on wedges that are supports."""
    blocks, supports = [], []
    for k in range(n):
        x = 10.0 * k
        ridge = [(x - 1, 0, 0), (x + 1, 0, 0), (x + 1, 2, 0), (x - 1, 2, 0), (x, 0, 1), (x, 2, 1)]
        faces = [[3, 2, 1, 0], [0, 1, 4], [3, 5, 2], [1, 2, 5, 4], [0, 4, 5, 3]]
        blocks += [Block(np.array(ridge, dtype=float), faces, f"ridge{k}")]
        supports.append(f"ridge{k}")
        blocks += [box((x - 2 + shift, 0, 1), (x + 2 + shift, 2, 1.2), name=f"plate{k}")]
    return assembly(blocks, supports=supports)


def test_a_plate_on_a_ridge_is_balanced_without_reserve():
    verdict = assess(seesaw())
    assert verdict.outcome is Outcome.STABLE
    assert [verdict.assembly.names[k] for k in verdict.neutral] == ["plate0"]
    assert verdict.summary()["neutral"] == ["plate0"]
    assert verdict.warnings[-1] == (
        'balanced: in equilibrium without reserve; nothing resists a small push that moves "plate0"'
    )
    assert assess(seesaw(0.01)).outcome is Outcome.UNSTABLE
    resting = assess(assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="b")]))
    assert resting.neutral.tolist() == []
    assert not any("balanced" in text for text in resting.warnings)


def test_neutral_blocks_are_named_up_to_three():
    problem = posed(seesaw(n=5))
    for count, words in ((1, '"plate0"'), (3, '"plate0", "plate1", "plate2"'), (5, None)):
        (text,) = neutral_warning(problem, np.arange(1, 2 * count, 2))
        assert text.endswith(words or '"plate0", "plate1", "plate2" and 2 more')
    assert neutral_warning(problem, np.empty(0, dtype=int)) == []


def on_a_knife(*ties, **options):
    """A slab 1 m wide whose middle rests on a ridge, 1 m above the foot of the ridge; ties at places across."""
    faces = [[3, 2, 1, 0], [0, 1, 4], [3, 5, 2], [1, 2, 5, 4], [0, 4, 5, 3]]
    corners = [(-1, 0, 0), (1, 0, 0), (1, 1, 0), (-1, 1, 0), (0, 0, 1), (0, 1, 1)]
    blocks = [Block(np.array(corners, dtype=float), faces, "ridge"), box((-0.5, 0, 1), (0.5, 1, 1.2), name="slab")]
    guys = [Tie(("ridge", "slab"), ((x, 0.5, 0), (x, 0.5, 1)), **options) for x in ties]
    return assembly(blocks, supports=["ridge"], ties=guys)


def told_balanced(asm):
    verdict = assess(asm)
    assert verdict.outcome is Outcome.STABLE
    assert any("balanced" in text for text in verdict.warnings) == bool(len(verdict.neutral))
    return [verdict.assembly.names[k] for k in verdict.neutral]


def test_ties_on_both_sides_of_an_edge_resist_a_push_and_one_does_not():
    asm = on_a_knife(-0.4, 0.4, greatest=1e4)
    assert told_balanced(asm) == []
    moment = np.zeros((2, 6))
    moment[1, 4] = 1.0
    limit = limit_load(asm, moment)
    assert limit.lower == pytest.approx(0.4 * 1e4, rel=1e-4)
    assert told_balanced(on_a_knife()) == ["slab"]
    # One tie must stay slack, as nothing balances its moment, and gives way to a turn that shortens it.
    assert told_balanced(on_a_knife(0.4, greatest=1e4)) == ["slab"]
    # In the plane of the edge ties have no arm.
    assert told_balanced(on_a_knife(0.0, greatest=1e4)) == ["slab"]
    # A given force on each side is a load, which resists nothing.
    assert told_balanced(on_a_knife(-0.4, 0.4, least=5.0, greatest=5.0)) == ["slab"]


def test_a_weight_on_a_vertical_tie_swings_and_one_between_ties_does_not():
    ceiling, weight = box((-2, -2, 2), (3, 3, 3), name="ceiling"), box((0, 0, 0), (1, 1, 1), name="weight")

    def hung(*points):
        ties = [Tie(("ceiling", "weight"), (above, below)) for above, below in points]
        return assembly([ceiling, weight], supports=["ceiling"], ties=ties)

    assert told_balanced(hung(((0.5, 0.5, 2), (0.5, 0.5, 1)))) == ["weight"]
    upright = [((x, y, 2), (x, y, 1)) for x in (0, 1) for y in (0, 1)]
    assert told_balanced(hung(*upright)) == ["weight"]  # four hold it level, and it swings
    # Two more from each corner, which lean apart along x and along y.
    spread = [((x + dx, y + dy, 2), (x, y, 1)) for x in (0, 1) for y in (0, 1)
              for dx, dy in ((-1, 0), (1, 0), (0, -1), (0, 1))]  # fmt: skip
    assert told_balanced(hung(*upright, *spread)) == []


def test_blocks_on_patches_that_ties_also_hold_are_one_body_with_the_ground():
    tie = Tie(("ground", "b"), ((0.5, 0.5, -1), (0.5, 0.5, 1)))
    assert told_balanced(assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="b")], ties=[tie])) == []


@pytest.mark.parametrize(("bond", "moment"), [(0.0, 1.0), (1.0, 0.0)])
def test_a_bond_without_one_capacity_leaves_a_cube_on_the_ground_its_reserve(bond, moment):
    law = JointLaw(("*", "*"), bond=bond, bond_moment=moment)
    asm = assembly([GROUND, box((0, 0, 0), (1, 1, 1), name="b")], joints=[law])
    assert told_balanced(asm) == []
    assert limit_load(asm, (1, 0, 0)).lower > 0.4
    plate = seesaw()
    glued = told_balanced(plate.with_(joints=[law]))
    assert glued == ["plate0"]  # glue needs a surface


def resting(width):
    """A cube that rests on a plate, and on a strip of so much of the next one."""
    blocks = [box((0, 0, -1), (1 - width, 1, 0), name="left"), box((1 - width, 0, -1), (3, 1, 0), name="right")]
    return assembly([*blocks, box((0, 0, 0), (1, 1, 1), name="cube")], supports=["left", "right"])


@pytest.mark.parametrize("scale", [0.2, 1.0, 5.0])
def test_a_joint_is_a_sliver_below_a_thousandth_of_the_smaller_block(scale):
    for factor, found in ((0.9, 1), (1.5, 0)):
        asm = resting(factor * SLIVER)
        asm = asm.with_(vertices=scale * asm.vertices, density=asm.density / scale**3)
        joints = find_interfaces(asm)
        problem = posed(asm, interfaces=joints)
        rows = [k for k, pair in enumerate(joints.pair.tolist()) if pair == [1, 2]]
        assert len(rows) == 1
        forces = np.zeros((joints.n_points, 3))
        assert len(doubtful_joints(problem, forces).slivers) == 0
        forces[:, 0] = 0.1
        assert len(doubtful_joints(problem, forces).slivers) == found
        if found:
            assert doubtful_joints(problem, forces).slivers.tolist() == rows
            own = slice(joints.start[rows[0]], joints.start[rows[0] + 1])
            for load, loaded in ((0.9e-9, False), (1.1e-9, True)):
                forces[own] = 0.0
                forces[joints.start[rows[0]], 1] = load  # of the weight of 1
                assert (len(doubtful_joints(problem, forces).slivers) == 1) is loaded


def on_a_lip(height, *, mu=0.5):
    """A cube on the ground that a lip of so much in front of it holds."""
    lip, floor = box((-1, 0, -1), (0, 1, height), name="lip"), box((0, 0, -1), (2, 1, 0), name="floor")
    cube = box((0, 0, 0), (1, 1, 1), name="cube")
    return assembly([lip, floor, cube], supports=["lip", "floor"], friction=mu)


@pytest.mark.parametrize("solver", ["auto", "clarabel"])
def test_a_limit_that_rests_on_a_sliver_says_so_and_what_is_carried_without_it(solver):
    """Without the lip the cube slides at its friction; with it, it tips about the lip at half its width by height."""
    found = limit_load(on_a_lip(2e-6), (-1, 0, 0), solver=solver)
    assert found.lower == pytest.approx(1.0, rel=1e-4)
    (text,) = found.warnings
    assert re.fullmatch(
        r"the load is carried up to 1\.0000\d* only with joints narrower than 0\.001 of their smaller block: "
        r'"lip" to "cube"; without them it is 0\.5',
        text,
    )


@pytest.mark.parametrize("width", [2e-2, 9e-4, 1e-5])
def test_a_cube_on_two_rails_of_one_block_slides_before_it_tips_however_narrow_they_are(width):
    """Friction .7; it would tip at 1, half its width by half its height. Rails below a thousandth of it are slivers."""
    foot = [(-1, -1), (2, -1), (2, -0.5), (1, -0.5), (1, 0), (1 - width, 0), (1 - width, -0.5)]
    foot += [(width, -0.5), (width, 0), (0, 0), (0, -0.5), (-1, -0.5)]
    rails = assembly([prism(foot, 1, name="rails"), box((0, 0, 0), (1, 1, 1), name="cube")], friction=0.7)
    verdict = assess(rails)
    assert verdict.outcome is Outcome.STABLE
    told = ['"rails" to "cube"; without them it is not proven stable'] if width < SLIVER else []
    assert [text.split("block: ")[1] for text in verdict.warnings] == told
    assert limit_load(rails, (1, 0, 0)).lower == pytest.approx(0.7, rel=1e-4)


def test_a_limit_that_rests_on_no_sliver_has_no_word_of_it():
    assert limit_load(on_a_lip(2e-3), (-1, 0, 0)).warnings == ()  # no sliver
    assert limit_load(on_a_lip(2e-6), (1, 0, 0)).warnings == ()  # not pushed against it
    # The strip takes a load of its own; without it, the cube tips at a ten-thousandth less.
    assert limit_load(resting(1e-4), (1, 0, 0)).warnings == ()


def test_a_load_that_slivers_alone_carry_without_limit_says_so():
    """Pushed by a / sqrt(2) down and forward, the cube slides where a / sqrt(2) = mu (1 + a / sqrt(2)), which
    is never from mu = 1 on. Below that the lip alone lets it carry any load, as it does not tip.
    """
    asm = on_a_lip(2e-6, mu=1.5)
    found = limit_load(asm, (-1, 0, -1))
    assert found.outcome is LoadOutcome.UNBOUNDED
    assert found.warnings == ()  # friction carries it as well
    found = limit_load(asm.with_(friction=0.5), (-1, 0, -1))
    assert found.outcome is LoadOutcome.UNBOUNDED
    (text,) = found.warnings
    assert text.startswith("any multiple is carried only with joints narrower than 0.001 of their smaller block: ")
    assert text.endswith('"lip" to "cube"; without them it is 1.41421')


def test_an_edge_shorter_than_a_thousandth_of_the_smaller_block_is_a_sliver_and_a_corner_is_none():
    asm = resting(0.3)
    joints = find_interfaces(asm)
    least = SLIVER * asm.size[joints.pair[0]].min()
    for kind, length, found in ((1, 0.9, [0]), (1, 1.1, []), (2, 0.9, [])):
        point = joints.point.copy()
        point[:2] = [(0.1, 0.5, 0), (0.1 + length * least, 0.5, 0)]
        count = np.concatenate([[0, 2], 2 + np.cumsum(np.diff(joints.start)[1:])])
        point = np.concatenate([point[:2], point[joints.start[1] :]])
        bare = replace(joints, kind=np.array([kind, 0]), area=np.array([0.0, 0.3]), point=point, start=count)
        assert doubtful_joints(posed(asm, interfaces=bare), None).slivers.tolist() == found


@pytest.mark.parametrize("turn", [0.0, 0.3])
@pytest.mark.parametrize("split", [False, True])
@pytest.mark.parametrize(("inside", "sliver"), [(1e-5, True), (9e-4, True), (2e-3, False), (0.3, False)])
def test_an_edge_that_lies_on_a_face_by_less_than_a_sliver_is_one(inside, sliver, split, turn):
    """A keel on two tables, over the rim of one by so much; its centre is in the middle between its two edges."""
    wedge = [(-inside, 0), (0.5, 0.5), (1.3, 0), (1.6, 1.0), (-inside - 0.3, 1.0)]
    tables = [[(-1, -1), (0, -1), (0, 0), (-1, 0)], [(1, -1), (2, -1), (2, 0), (1, 0)]]
    blocks = [prism(outline, 1.0, name=name) for outline, name in zip([*tables, wedge], "lrk", strict=True)]
    if split:  # faces in triangles have edges that are no rims
        halves = [
            [half for f in block.faces for half in ([f[:3], [f[0], *f[2:]]] if len(f) == 4 else [f])]
            for block in blocks
        ]
        blocks = [replace(block, faces=own) for block, own in zip(blocks, halves, strict=True)]
    rotation = Rotation.from_rotvec([turn, -turn, 2 * turn]).as_matrix()
    blocks = [replace(block, vertices=np.asarray(block.vertices) @ rotation.T) for block in blocks]
    keel = Assembly.from_blocks(blocks, supports=["l", "r"], density=1.0, gravity=rotation @ (0, 0, -1.0))
    problem = posed(keel)
    assert problem.interfaces.contacts["edge"] == 2
    named = problem.interfaces.pair[doubtful_joints(problem, None).slivers].tolist()
    assert named == ([[0, 2]] if sliver else [])
    verdict = assess(keel)
    assert verdict.outcome is Outcome.STABLE
    assert any('"l" to "k"' in text for text in verdict.warnings) is sliver


def told_on_a_prop(prop, kind, sliver, *, carried=None, **options):
    """The slab stands on the prop, and it is told whether this is a sliver."""
    asm, along = overhanging(prop, **options)
    verdict = assess(asm)
    assert verdict.outcome is Outcome.STABLE
    assert verdict.interfaces.contacts[kind] == 1
    assert verdict.interfaces.n_interfaces == 2
    found = limit_load(asm, along)
    assert found.lower == pytest.approx(carried, rel=1e-4) if carried else found.lower > 0.1
    told = ['block: "slab" to "prop"; without them '] if options.get("order") != BACKWARDS else [
        'block: "prop" to "slab"; without them '
    ]  # fmt: skip
    for texts, words in (
        (verdict.warnings, "it is not proven stable"),
        (found.warnings, "the dead load is not proven to be carried"),
    ):
        narrow = [text for text in texts if "narrower than 0.001" in text]
        assert [text.endswith(told[0] + words) for text in narrow] == [True] * sliver
    assert without_slivers(posed(asm)).n_interfaces == (1 if sliver else 2)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("order", [FORWARDS, BACKWARDS])
@pytest.mark.parametrize(("inside", "sliver"), [(5e-6, True), (9e-4, True), (1.2e-3, False), (0.3, False)])
def test_a_corner_on_a_face_no_further_from_its_rim_than_a_sliver_is_one(inside, sliver, order, place):
    """The slab of 1.2 m3 is the smaller block: a thousandth of its size is 1.06 mm. Pushed, it slides at .7 or tips."""
    told_on_a_prop(
        apex(1.5 - inside), "corner", sliver, carried=min(0.7, (0.6 - inside) / 0.5), order=order, place=place
    )
    told_on_a_prop(apex(1.4, y=inside), "corner", sliver, order=order, place=place)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("order", [FORWARDS, BACKWARDS])
@pytest.mark.parametrize(("inside", "sliver"), [(5e-6, True), (6e-4, True), (2e-3, False), (0.3, False)])
def test_edges_that_cross_no_further_from_an_end_than_a_sliver_are_one(inside, sliver, order, place):
    """Near the end of the ridge of the prop, and near the end of the edge of the slab, at right angles.

    On the ridge, which rises, the slab cannot slide: pushed it tips about the prop, .6 m by .5 m.
    """
    told_on_a_prop(rising(inside), "crossing", sliver, carried=1.2, order=order, place=place)
    told_on_a_prop(rising(0.3, y=inside), "crossing", sliver, order=order, place=place)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("order", [FORWARDS, BACKWARDS])
@pytest.mark.parametrize(
    ("angle", "at", "sliver"),
    [(1e-4, 0.5, True), (-1e-4, 0.5, True), (1.9e-3, 0.5, True), (1e-2, 0.5, False), (0.1, 0.3, False)],
)
def test_edges_that_cross_and_hardly_part_are_a_sliver(angle, at, sliver, order, place):
    """A slip by half a metre times the angle parts them; this is less than a thousandth of a metre or more."""
    told_on_a_prop(beside(angle, at), "crossing", sliver, carried=1.2 if at == 0.5 else None, order=order, place=place)


def test_a_blunt_corner_near_the_rim_is_a_sliver_as_a_sharp_one_is():
    """The facets about a corner that rises by a thousandth of their width lie in the plane of the face, too."""
    for inside, sliver in ((5e-4, True), (1e-2, False)):
        asm, _ = overhanging(apex(1.5 - inside, slope=2e-3, depth=2e-3 / 3))
        problem = posed(asm, gap=1e-6)
        assert problem.interfaces.contacts["corner"] == 1
        assert (len(doubtful_joints(problem, None).slivers) == 1) is sliver


def test_a_limit_that_a_corner_on_a_rim_carries_is_told_with_what_is_carried_without_it():
    """On a table that ends at 1 the slab tips about that end: an arm of .1 m at a height of .5 m."""
    for inside, told in ((1e-5, ["0.2"]), (1e-2, [])):
        asm, along = overhanging(apex(1.5 - inside), ends=1.0)
        found = limit_load(asm, along)
        assert found.lower == pytest.approx(0.7, rel=1e-4)
        assert [text.split("without them it is ")[1][:3] for text in found.warnings] == told


def test_beams_that_cross_edge_on_edge_in_the_middle_rest_on_no_sliver():
    """Square beams on their edges, at right angles: the upper one lies on two supports."""
    lower = [Block(_on_edge(x, np.pi / 2), BOX, name) for x, name in ((-1.0, "a"), (1.0, "b"))]
    upper = Block(_on_edge(0.0, 0.0) + (0, 0, np.sqrt(2)), BOX, "beam")
    verdict = assess(Assembly.from_blocks([*lower, upper], supports=["a", "b"], density=2000.0))
    assert verdict.outcome is Outcome.STABLE
    assert verdict.interfaces.contacts["crossing"] == 2
    assert not any("narrower" in text for text in verdict.warnings)


BOX = [list(face) for face in box((0, 0, 0), (1, 1, 1)).faces]


def _on_edge(x, turn):
    """A beam of 4 x 1 x 1 through (x, 0, 0), on an edge."""
    corners = np.asarray(box((-2, -0.5, -0.5), (2, 0.5, 0.5)).vertices)
    corners = corners @ Rotation.from_rotvec([np.pi / 4, 0, 0]).as_matrix().T
    return corners @ Rotation.from_rotvec([0, 0, turn]).as_matrix().T + (x, 0, 0)


@pytest.mark.parametrize(("inside", "sliver"), [(1e-5, True), (9e-4, True), (1.6e-3, False), (0.3, False)])
@pytest.mark.parametrize("edge", [False, True])
def test_a_corner_or_an_edge_beside_a_patch_of_its_pair_is_a_sliver_on_a_rim(edge, inside, sliver):
    """One support has a foot below the slab and a ridge at the far rim, or its tip: one joint of two parts."""
    asm = one_support(inside, edge=edge)
    verdict = assess(asm)
    assert verdict.outcome is Outcome.STABLE
    assert verdict.interfaces.n_interfaces == 1
    assert len(verdict.interfaces.point) == 4
    assert any("narrower" in text for text in verdict.warnings) is sliver


@pytest.mark.parametrize(("width", "degrees"), [(0.01, 4), (0.02, 2), (0.005, 8)])
@pytest.mark.parametrize("scale", [1.0, 30.0])
def test_what_a_limit_is_without_bevels_that_count_as_bearing_is_told(width, degrees, scale):
    """The slab tips about the rim of its flat foot: half its width over the height of the centroid, and falls on then.

    It has to turn by the slope of the bevel before that bears, and topples after less.
    """
    asm = bevelled(width, degrees, scale)
    exact = (0.025 - width) * scale / asm.centroid[1, 2]
    (told,) = [text for text in limit_load(asm, (1, 0, 0)).warnings if "only with joints" in text]
    assert 'only with joints that do not quite close: "ground" to "slab"; without them it is ' in told
    assert float(told.split()[-1]) == pytest.approx(exact, rel=1e-4)
    leans = asm.with_(gravity=(1.2 * exact * 9.81, 0.0, -9.81))
    verdict = assess(leans)
    assert verdict.outcome is Outcome.STABLE
    assert any("stable only with joints that do not quite close" in text for text in verdict.warnings)
    assert assess(leans, gap=1e-5).outcome is Outcome.UNSTABLE


def test_bevels_that_carry_nothing_that_matters_are_told_to_be_open_and_no_more():
    verdict = assess(bevelled(0.005, 8))
    assert [text.split(" joints")[0] for text in verdict.warnings] == ["2 of 3"]


@pytest.mark.parametrize("deep", [0.002, 0.009])
def test_of_a_joint_of_several_patches_those_that_close_stay(deep):
    """A boss of 0.4 m on a block of 1 m, in one piece with it: the block above, 2 m high, tips at 0.2 / 1."""
    steps = [
        (-0.5, 0),
        (0.5, 0),
        (0.5, 1 - deep),
        (0.2, 1 - deep),
        (0.2, 1),
        (-0.2, 1),
        (-0.2, 1 - deep),
        (-0.5, 1 - deep),
    ]
    upper = box((-0.5, 0, 1), (0.5, 1, 3), name="upper")
    asm = assembly([prism(steps, 1.0, name="lower"), upper], supports=["lower"])
    (told,) = [text for text in limit_load(asm, (1, 0, 0)).warnings if "only with joints" in text]
    assert float(told.split()[-1]) == pytest.approx(0.2, rel=1e-4)
    assert not any("only with" in text for text in assess(asm).warnings)


@pytest.mark.parametrize("n", [60, 128])
def test_the_limit_of_a_drum_without_the_facets_that_do_not_close_is_told(n):
    """A drum of radius 1 m with n facets rolls over the edge of the lowest one, at tan(pi / n)."""
    turns = (np.arange(n) + 0.5) * 2 * np.pi / n
    rim = np.column_stack([np.sin(turns), np.cos(np.pi / n) - np.cos(turns)])
    asm = assembly([GROUND, prism(rim, 1.0, name="drum")], supports=["ground"])
    (told,) = [text for text in limit_load(asm, (1, 0, 0)).warnings if "only with joints" in text]
    assert float(told.split()[-1]) == pytest.approx(np.tan(np.pi / n), rel=1e-4)


def test_slivers_are_named_up_to_three():
    blocks = [GROUND, *(box((2 * k, 0, 0), (2 * k + 1, 1, 1), name=f"b{k}") for k in range(5))]
    problem = posed(assembly(blocks, supports=["ground"]))
    texts = [joints_in_words(problem, Doubtful(np.arange(n), np.arange(0))) for n in (2, 3, 5)]
    assert texts[0] == 'joints narrower than 0.001 of their smaller block: "ground" to "b0", "ground" to "b1"'
    assert texts[1].endswith('"ground" to "b2"')
    assert texts[2].endswith('"ground" to "b2" and 2 more')


def test_interfaces_without_some_keep_all_that_belongs_to_the_others():
    blocks = [GROUND, *(box((2 * k, 0, 0), (2 * k + 1 + k, 1, 1), name=f"b{k}") for k in range(3))]
    joints = find_interfaces(assembly(blocks, supports=["ground"]))
    marked = replace(
        joints, share=np.arange(joints.n_points, dtype=float), gap=np.arange(joints.n_interfaces, dtype=float),
        outlines=tuple(f"o{k}" for k in range(joints.n_interfaces)), kind=np.arange(joints.n_interfaces) % 2,
        friction=0.1 * np.arange(joints.n_interfaces),
    )  # fmt: skip
    kept = [k for k in range(joints.n_interfaces) if k != 1]
    found = marked.subset(np.array(kept))
    assert found.pair.tolist() == joints.pair[kept].tolist()
    assert found.gap.tolist() == kept
    assert found.kind.tolist() == [k % 2 for k in kept]
    assert found.friction.tolist() == [0.1 * k for k in kept]
    assert found.outlines == tuple(f"o{k}" for k in kept)
    np.testing.assert_array_equal(found.area, joints.area[kept])
    np.testing.assert_array_equal(found.frame, joints.frame[kept])
    points = [p for k in kept for p in range(joints.start[k], joints.start[k + 1])]
    np.testing.assert_array_equal(found.point, joints.point[points])
    assert found.share.tolist() == points
    assert np.diff(found.start).tolist() == np.diff(joints.start)[kept].tolist()
    assert found.start[0] == 0
    bare = joints.subset(np.empty(0, dtype=int))
    assert (bare.n_interfaces, bare.n_points) == (0, 0)
    assert joints.subset(np.arange(joints.n_interfaces)).pair.tolist() == joints.pair.tolist()


def sunk():
    """One block deep in another, and a third by itself."""
    blocks = [
        GROUND, box((0, 0, 0), (2, 2, 2), name="low"), box((0.5, 0.5, 1), (1.5, 1.5, 3), name="in"),
        box((5, 0, 0), (6, 1, 1), name="other"),
    ]  # fmt: skip
    return assembly(blocks, supports=["ground"])


def test_a_mechanism_of_blocks_that_overlap_proves_nothing():
    asm = sunk()
    problem = posed(asm, interfaces=find_interfaces(asm))
    motion = np.zeros((4, 6))
    assert overlap_warnings(problem, motion) == []
    motion[3, 2] = 1.0
    assert overlap_warnings(problem, motion) == []
    for block in (1, 2):
        moved = motion.copy()
        moved[block, 5] = 1e-12
        (text,) = overlap_warnings(problem, moved)
        assert text.startswith('"low" and "in" overlap too far to have a joint (1 such pairs move)')
    several = replace(problem, overlapping=np.array([[0, 3], [1, 3], [2, 3]]))
    (text,) = overlap_warnings(several, motion)
    assert text.startswith('"ground" and "other" overlap too far to have a joint (3 such pairs move)')
    known = replace(problem, overlapping=np.array([[0, 3]]))
    assert overlap_warnings(known, motion)[0].startswith('"ground" and "other" overlap')
    assert overlap_warnings(replace(problem, overlapping=np.empty((0, 2), dtype=int)), moved) == []


def corner_to_corner(gap=0.0):
    """Two cubes that share an edge along y; the upper one lies on a plate that is a support."""
    blocks = [
        GROUND, box((0, 0, 0), (1, 1, 1), name="low"), box((1 + gap, 0, 1), (2 + gap, 1, 2), name="high"),
        box((1.4, -2, 0.5), (3, 3, 1), name="shelf"),
    ]  # fmt: skip
    return assembly(blocks, supports=["ground", "shelf"])


def test_edges_along_each_other_resist_what_drives_them_together_alone():
    problem = posed(corner_to_corner())
    pair = sorted(problem.interfaces.rims.tolist())
    assert [1, 2] in pair
    motion = np.zeros((4, 6))
    for velocity, told in (
        ((0, 0, 0), False), ((1, 0, 1), False), ((1, 0, -0.5), False), ((-0.5, 0, 1), False), ((-1, 0, -1), True),
        ((-1e-7, 0, -1e-7), False), ((-1, 0, 0), True), ((0, 0, -1), True), ((0, 1, 0), False),
    ):  # fmt: skip
        motion[2, :3] = velocity
        found = rim_warnings(problem, motion)
        assert bool(found) is told, velocity
    (text,) = found or rim_warnings(problem, np.array([[0] * 6, [1, 0, 1, 0, 0, 0], [0] * 6, [0] * 6], dtype=float))
    assert text.startswith('"low" and "high" touch only edge along edge')
    assert "(1 such pairs would be driven into each other)" in text
    alone = posed(assembly([GROUND, box((0, 0, 0), (1, 1, 1))]))
    assert rim_warnings(alone, np.ones((2, 6))) == []


def pushed_past_and_into_edges():
    """Two cubes on the ground: pushed along (2, -1), one passes an upright edge, the other is driven into one."""
    blocks = [
        box((-5, -5, -1), (9, 15, 0), name="ground"), box((0, 0, 0), (1, 1, 1), name="stopped"),
        box((1, -1, 0), (2, 0, 1), name="stop"), box((0, 6, 0), (1, 7, 1), name="passing"),
        box((1, 7, 0), (2, 8, 1), name="passed"),
    ]  # fmt: skip
    return assembly(blocks, supports=["ground", "stop", "passed"], friction=0.6)


def test_what_falls_past_an_edge_falls_though_another_edge_holds_its_neighbour():
    asm = pushed_past_and_into_edges()
    along = np.array([2.0, -1.0, 0.0]) / np.sqrt(5)
    limit = limit_load(asm, along)
    assert limit.outcome is LoadOutcome.LIMIT
    assert limit.upper == pytest.approx(0.6, rel=1e-4)
    assert limit.lower == pytest.approx(0.6, rel=1e-4)
    moving = np.abs(limit.mechanism).max(axis=1) > 1e-3
    assert [name for name, moves in zip(asm.names, moving, strict=True) if moves] == ["passing"]
    verdict = assess(asm, loads=0.63 * acceleration(asm, along))
    assert verdict.outcome is Outcome.UNSTABLE
    assert rim_warnings(posed(asm), verdict.mechanism) == []


def test_what_only_edges_hold_is_undecided():
    blocks = [box((-5, -5, -1), (9, 15, 0), name="ground"), box((0, 0, 0), (1, 1, 1)), box((1, -1, 0), (2, 0, 1))]
    asm = assembly(blocks, supports=[0, 2], friction=0.6)
    along = np.array([2.0, -1.0, 0.0]) / np.sqrt(5)
    limit = limit_load(asm, along)
    assert limit.outcome is LoadOutcome.UNDECIDED
    assert limit.lower == pytest.approx(0.6, rel=1e-4)
    assert limit.upper > 0.7


def between_wedges(friction):
    return assembly(pinched(), supports=["left", "right"], friction=friction)


def test_a_block_that_others_lean_on_is_not_proven_to_fall():
    # Each heavy block of weight W presses with W tan(45 deg - atan mu) = W / 3, of which friction carries a half.
    falling = falling_freely(posed(between_wedges(0.5)))
    assert falling.tolist() == [4]  # if the others rested without it, which they do not
    verdict = assess(between_wedges(0.5), flow="coulomb")
    assert verdict.outcome is Outcome.STABLE
    assert not len(verdict.falling)
    # Upright walls come no closer under their weight, and the light one falls.
    walls = [
        box((x, 0, 0), (x + 0.5, 1, 2), name=name, density=2500.0) for x, name in ((-0.75, "left"), (0.25, "right"))
    ]
    light = box((-0.25, 0, 1.2), (0.25, 1, 1.6), name="light", density=250.0)
    alone = assess(
        assembly([box((-5, -5, -1), (5, 5, 0), name="ground"), *walls, light], supports=["ground"]), flow="coulomb"
    )
    assert alone.outcome is Outcome.STABLE_ONLY_BY_SELF_STRESS
    assert alone.falling.tolist() == [3]


def test_a_block_between_two_walls_falls_freely_unless_something_is_in_its_way():
    walls = [box((-1, 0, 0), (0, 1, 4), name="left"), box((1, 0, 0), (2, 1, 4), name="right")]
    block = box((0, 0, 2), (1, 1, 3), name="block")
    asm = assembly([*walls, block], supports=["left", "right"], friction=0.5)
    problem = posed(asm)
    assert falling_freely(problem).tolist() == [2]
    verdict = assess(asm, flow="coulomb")
    assert verdict.outcome is Outcome.STABLE_ONLY_BY_SELF_STRESS
    assert verdict.falling.tolist() == [2]
    assert verdict.coulomb.share == pytest.approx(1.0)
    assert verdict.coulomb.opposed
    assert verdict.coulomb.solves == 0
    assert len(verdict.held) == 2
    tied = asm.with_(ties=[Tie(("left", "block"), ((-1, 0, 4), (0.5, 0, 3)), 0.0, 9.0)])
    assert falling_freely(posed(tied)).tolist() == []
    pair = assembly([*walls, block, box((0, 0, 3), (1, 1, 3.5), name="upper")], supports=["left", "right"])
    assert falling_freely(posed(pair)).tolist() == [2, 3]
    stopped = [
        *walls,
        block,
        box((0, 0, 3), (1, 1, 3.5), name="upper"),
        box((0, 0, 0.985), (1, 1, 1.985), name="floor"),
    ]
    assert falling_freely(posed(assembly(stopped, supports=["left", "right", "floor"]))).tolist() == []
    floor = assembly([*walls, block, box((0, 0, 1), (1, 1, 2), name="floor")], supports=["left", "right", "floor"])
    assert falling_freely(posed(floor)).tolist() == []
    near = assembly(
        [*walls, block, box((0, 0, 0.985), (1, 1, 1.985), name="floor")], supports=["left", "right", "floor"]
    )
    assert falling_freely(posed(near)).tolist() == []
    deep = assembly([*walls, block, box((0.2, 0.2, 1), (0.8, 0.8, 2.5), name="in")], supports=["left", "right", "in"])
    assert falling_freely(posed(deep, interfaces=find_interfaces(deep))).tolist() == []


def test_what_is_interrupted_stays_stopped_at_edges_without_a_normal(monkeypatch):
    """No second program is begun; the bound by a mechanism that the edges may resist is dropped."""
    blocks = [box((-5, -5, -1), (9, 15, 0), name="ground"), box((0, 0, 0), (1, 1, 1)), box((1, -1, 0), (2, 0, 1))]
    asm = assembly(blocks, supports=[0, 2], friction=0.6)
    along, honest = np.array([2.0, -1.0, 0.0]) / np.sqrt(5), limits._bracket
    monkeypatch.setattr(limits, "_bracket", lambda *given, **how: (LoadOutcome.STOPPED, *honest(*given, **how)[1:]))
    monkeypatch.setattr(limits, "judged_with_rims", lambda *_: pytest.fail("a second limit load was begun"))
    found = limit_load(asm, along)
    assert (found.outcome, found.upper) == (LoadOutcome.STOPPED, np.inf)
    assert found.lower == pytest.approx(0.6, rel=1e-4)
    assert "touch only edge along edge" in found.warnings[-1]


def test_an_interrupt_without_dilatancy_keeps_what_holds_at_edges_without_a_normal():
    def stop(trial, low, high):
        if (low, trial) == (0.0, 0):
            raise KeyboardInterrupt

    asm, along = pushed_past_and_into_edges(), np.array([2.0, -1.0, 0.0]) / np.sqrt(5)
    found = limit_load(asm, along, flow="coulomb", progress=stop)
    assert found.outcome is LoadOutcome.STOPPED
    assert (found.lower, found.upper) == pytest.approx((0.6, 0.6), rel=1e-4)
    assert len(found.coulomb_kinds) == 1
    assert "Without dilatancy and self-stress: 0 to 0.6" in found.explain()


def test_undecided_names_contacts_without_a_normal_as_its_reason():
    # A beam that fits between two supports edge along edge: as a mortise it may jam, and no joint carries it.
    blocks = [box((0, 0, 0), (1, 1, 1), name="l"), box((1, 0, 1), (3, 1, 2), name="b"), box((3, 0, 0), (4, 1, 1))]
    verdict = assess(assembly(blocks, supports=[0, 2]))
    assert verdict.outcome is Outcome.UNDECIDED
    said = verdict.explain()
    assert said.startswith("Undecided: the blocks touch where forces have no definite direction")
    assert verdict.summary()["sentence"] == verdict.headline
    assert "No joint holds: b." in said
    assert not any(wrong in said for wrong in ("too close to the limit", "inf of the weight", "Nothing holds"))


def test_a_joint_narrower_than_its_gap_asks_for_no_larger_tolerance():
    # Faces that face each other over 0.2 mm, 0.5 mm apart: the tolerance is 10 mm, and none takes them.
    blocks = [box((0, 0, 0), (1, 1, 1), name="floor"), box((0.9998, 0, 1.0005), (2, 1, 2), name="cube")]
    asm = assembly(blocks, supports=["floor"])
    (missed,) = find_interfaces(asm).dropped
    assert (missed.reason, missed.value, missed.limit) == ("narrow", pytest.approx(5e-4), pytest.approx(2e-4))
    (told,) = [text for text in assess(asm).warnings if "narrower" in text]
    assert '"floor" to "cube", 0.2 mm wide and 0.5 mm open: no tolerance takes them' in told
    assert find_interfaces(asm, gap=0.1).n_interfaces == 0


def fan(rise=0.0, at=(0.9, 0.5)):
    """The overhanging slab with its lower face in triangles about a vertex; the corner at 1.5, 1 may be higher."""
    lower = [(0.3, 0, 0), (1.5, 0, 0), (1.5, 1, rise), (0.3, 1, 0)]
    upper = [(x, y, 1.0) for x, y, _ in lower]
    middle = (*at, 0.0 if not rise else rise * (at[0] - 0.3) / 1.2 * at[1])
    sides = [[k, (k + 1) % 4, 4 + (k + 1) % 4, 4 + k] for k in range(4)]
    return Block(
        [*lower, *upper, middle], [[4, 5, 6, 7], *sides, *([(k + 1) % 4, k, 8] for k in range(4))], name="slab"
    )


def with_slab(asm, slab, place=PLACES[0]):
    """The overhanging scene with another slab in place of the box."""
    turn, scale, away = place
    rotation = Rotation.from_rotvec([0, 0, turn]).as_matrix()
    blocks = [Block(asm.block_vertices(k), asm.faces_of(k), name) for k, name in enumerate(asm.names)]
    blocks[asm.names.index("slab")] = replace(slab, vertices=scale * np.asarray(slab.vertices) @ rotation.T + away)
    return Assembly.from_blocks(blocks, supports=["table", "prop"], density=2000.0, friction=0.7)


@pytest.mark.parametrize("place", PLACES)
@pytest.mark.parametrize("order", [FORWARDS, BACKWARDS])
@pytest.mark.parametrize("away", [0.0, 0.1])
def test_a_corner_near_the_rim_of_a_meshed_face_is_a_sliver_in_any_order(order, place, away):
    """Half a millimetre inside the rim the prop is at a vertex of the mesh, or a tenth of a metre from one."""
    tip = 1.5 - 5e-4
    asm = with_slab(overhanging(apex(tip), place=place, order=order)[0], fan(at=(tip - away, 0.5)), place)
    found = assess(asm, score=False)
    assert found.outcome is Outcome.STABLE
    assert any("narrower than 0.001" in text for text in found.warnings)
    lost = assess(asm, score=False, imperfections=Imperfections(edge=3e-3 * place[1]))
    assert lost.outcome is Outcome.UNSTABLE


@pytest.mark.parametrize("rise", [0.0, 2e-3])
@pytest.mark.parametrize("off", [4e-4, 2e-3])
def test_an_edge_of_the_mesh_in_the_middle_of_a_rough_face_is_no_rim(rise, off):
    """The prop is beside the vertex of the fan, .3 m from the rim, and the facets turn by some tenths of a degree."""
    tip = 1.2
    prop = apex(tip + off)
    slab = fan(rise, at=(tip, 0.5))
    # The facet from the vertex to the rim at 1.5 is the plane through three of its corners.
    a, b, c = (np.array(slab.vertices[k], dtype=float) for k in (1, 2, 8))
    normal = np.cross(b - a, c - a)
    height = a[2] - normal[:2] @ ((tip + off, 0.5) - a[:2]) / normal[2]
    prop = replace(prop, vertices=np.asarray(prop.vertices) + (0, 0, height))
    asm = with_slab(overhanging(prop)[0], slab)
    for lost in (None, Imperfections(edge="3 mm")):
        found = assess(asm, score=False, imperfections=lost)
        assert found.outcome is Outcome.STABLE
        assert not any("narrower than 0.001" in text for text in found.warnings)


def test_a_foot_in_a_notch_is_at_no_rim():
    """A strut 2 mm from the inner corner of an L leans on a wall: at a re-entrant edge there is stone on both sides."""
    bed = prism([(-1, -1), (1, -1), (1, 0), (0, 0), (0, 2), (-1, 2)], 1.0, name="bed")
    foot, top = (2e-3, 0.0), (1.0 - 0.2, 1.5)
    wall = box((0.8, 0, 1), (1.5, 1, 2), name="wall")
    strut = prism([foot, (0.25, 0.2), top, (0.45, 1.5)], 1.0, name="strut")
    asm = Assembly.from_blocks([bed, wall, strut], supports=["bed", "wall"], friction=5.0)
    problem = posed(asm, gap=1e-6)
    assert problem.interfaces.contacts["edge"] == 2
    rims = [k for k in doubtful_joints(problem, None).slivers.tolist() if 0 in problem.interfaces.pair[k]]
    assert not rims
