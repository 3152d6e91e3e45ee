import html
from dataclasses import replace

import numpy as np
import pytest
from matplotlib.figure import Figure
from shapely import Point, Polygon

from blockstat import (
    Assembly,
    InputError,
    Outcome,
    assess,
    capacity,
    limit_load,
    limit_load_by_direction,
    plot_capacity,
    plot_directions,
    reserve_map,
)
from blockstat.model import assemble, dome, pavilion_vault
from blockstat.view.painter import face_order, paint_order, view_of, visible, with_copies
from blockstat.view.plot import (
    mechanism_pose,
    plot,
    plot_forces,
    plot_mechanism,
    plot_stone_sensitivity,
    plot_verdict,
    resultants,
)
from blockstat.view.utilisation import plot_reserve_map, plot_utilisation
from evidence.scenes.small import arch, assembly, box, running_bond, stack


def test_nearer_blocks_are_painted_later():
    # Seen from the front right above: along each axis the block nearer to the eye hides the other.
    view = view_of(-45.0, 30.0)
    for step in np.eye(3):
        blocks = [box(2.0 * step * k, 2.0 * step * k + 1) for k in range(4)]
        asm = assembly(blocks)
        order = paint_order(asm, asm.vertices, asm.planes, view)
        nearer = (asm.centroid @ view[2])[order]
        assert (np.diff(nearer) > 0).all()


@pytest.mark.parametrize("azimuth", [-55, 20, 130, 250])
def test_no_brick_is_painted_over_one_that_hides_it(azimuth):
    asm = running_bond(6, 4)
    view = view_of(azimuth, 25.0)
    rank = np.empty(asm.n_blocks, dtype=int)
    rank[paint_order(asm, asm.vertices, asm.planes, view)] = np.arange(asm.n_blocks)
    # Walk from points inside each block towards the eye: every block met on the way must be painted later.
    lower, upper = asm.bounds
    rng = np.random.default_rng(0)
    for block in range(asm.n_blocks):
        for point in lower[block] + rng.random((20, 3)) * (upper[block] - lower[block]):
            path = point + np.linspace(0, 3, 400)[:, None] * view[2]
            inside = (path[:, None] > lower + 1e-9) & (path[:, None] < upper - 1e-9)
            for other in np.flatnonzero(inside.all(axis=2).any(axis=0)):
                assert other == block or rank[other] > rank[block]


@pytest.mark.parametrize("azimuth", [-55, 20, 130, 250])
def test_no_face_of_notched_blocks_is_painted_over_one_that_hides_it(azimuth):
    # L-shaped stones that grip one another: no order of whole blocks is right.
    asm = assemble(pavilion_vault(spans=(4.0, 3.0), thickness=0.4, voussoirs=9, brick=0.8, springers=0.3))
    view = view_of(azimuth, 25.0)
    front = np.flatnonzero(asm.planes.normal @ view[2] > 1e-9)
    order = list(face_order(asm, asm.planes, view, front))
    # What is seen at a point is the face painted last there: it must be the one a ray from the eye meets first.
    flat = asm.vertices @ view.T
    shapes = {f: Polygon(flat[asm.face_vertices[asm.face_start[f] : asm.face_start[f + 1]], :2]) for f in order}
    checked = 0
    for x, y in np.random.default_rng(0).uniform(-2, 2, (400, 2)):
        here = [f for f in order if shapes[f].contains(Point(x, y))]
        ray = x * view[0] + y * view[1]
        depth = [
            (asm.planes.centre[f] - ray) @ asm.planes.normal[f] / (view[2] @ asm.planes.normal[f]) for f in here
        ]  # fmt: skip
        assert not here or depth[-1] == pytest.approx(max(depth))
        checked += len(here) > 1
    assert checked > 50


def test_edges_within_a_curved_face_are_not_drawn():
    # Voussoirs of a dome have two facets on either side: no line where they meet, 360 / 2 x 24 degrees from each other.
    asm = assemble(dome(span=5.0, thickness=0.4, rings=3, voussoirs=24, oculus=2.0), supports=())
    polygons, fill, line = visible(asm, asm.vertices, view_of(-55, 90), np.ones((asm.n_blocks, 4)))
    assert len(polygons) == len(fill) == len(line)
    # From above one sees two facets of extrados and two of upper bed of each; three edges of each facet are sharp.
    facets = [(f == e).all() for p, f, e in zip(polygons, fill, line, strict=True) if len(p) > 2]
    assert facets == [True] * (3 * 24 * 4)
    assert sum(len(p) == 2 for p in polygons) == 3 * len(facets)


def test_pictures_have_something_on_them(tmp_path):
    from matplotlib.image import imread

    stands, falls = arch(12, 0.2), arch(12, 0.08)
    for name, asm in (("stands", stands), ("falls", falls)):
        path = plot_verdict(assess(asm), tmp_path / f"{name}.png")
        pixels = imread(path)[..., :3]
        assert (pixels < 0.99).any(axis=2).mean() > 0.02
    plain = plot(stands, tmp_path / "plain.png")
    assert plain.stat().st_size > 5000


def test_pictures_go_into_axes(tmp_path):
    from matplotlib.figure import Figure

    axes = Figure(figsize=(12, 4)).subplots(1, 4)
    stands, limit = assess(arch(12, 0.2)), limit_load(arch(12, 0.2), (1, 0, 0))
    assert plot_verdict(stands, axes[0]) is axes[0]
    plot_mechanism(limit, axes[1])
    plot_forces(stands, axes[2])
    plot_utilisation(stands, axes[3])
    # Every panel has its blocks, in front of the eye; the thrust line is drawn over them.
    assert all(np.ptp(panel.dataLim.get_points(), axis=0).min() > 0.5 for panel in axes)
    assert [bool(panel.lines) for panel in axes] == [False, False, True, False]
    assert list(tmp_path.iterdir()) == []


def test_verdicts_and_limits_explain_themselves_in_a_notebook():
    for result in (assess(arch(12, 0.2)), assess(arch(12, 0.08)), limit_load(arch(12, 0.2), (1, 0, 0))):
        page = result._repr_html_()
        assert html.unescape(page) == f'<pre style="white-space: pre-wrap">{result.explain()}</pre>'
        assert "<=" not in page
        assert str(result) == result.explain()


def test_bad_picture_paths(tmp_path):
    with pytest.raises(InputError, match="no such directory"):
        plot(arch(4, 0.2), tmp_path / "gone" / "x.png")
    with pytest.raises(InputError, match=r"x\.xyz"):
        plot(arch(4, 0.2), tmp_path / "x.xyz")


def test_an_unknown_option_of_a_picture_is_refused_and_the_known_ones_are_named(tmp_path):
    stands, falls, limit = assess(arch(12, 0.2)), assess(arch(12, 0.08)), limit_load(arch(12, 0.2), (1, 0, 0))
    pictures = [
        (plot, (stands.assembly,)),
        (plot_verdict, (stands,)),
        (plot_verdict, (falls,)),
        (plot_mechanism, (limit,)),
        (plot_forces, (stands,)),
        (plot_utilisation, (stands,)),
        (plot_stone_sensitivity, (limit, (1, 0, 0))),
        (plot_reserve_map, (reserve_map(limit, (1, 0, 0)), "edge")),
    ]
    for draw, what in pictures:
        with pytest.raises(InputError, match=r'unknown option "azimut"; options are: values, .*azimuth, elevation'):
            draw(*what, tmp_path / "x.png", azimut=30.0)
    assert list(tmp_path.iterdir()) == []


def test_the_mechanism_is_drawn_at_the_amplitude_asked_for():
    verdict = assess(running_bond(4, 3), gravity=(0, 0.6, -1))
    shift, turn = mechanism_pose(verdict, amplitude=1e-3)
    asm = verdict.assembly
    block = np.repeat(np.arange(asm.n_blocks), np.diff(asm.vertex_start))
    arm = asm.vertices - asm.centroid[block]
    moved = shift[block] + np.einsum("nij,nj->ni", turn[block], arm) - arm
    assert np.linalg.norm(moved, axis=1).max() == pytest.approx(1e-3, rel=1e-3)


def test_the_thrust_line_stays_inside_the_arch_and_carries_its_weight():
    verdict = assess(arch(20, 0.15))
    asm = verdict.assembly
    point, force, tension = resultants(verdict)
    assert len(point) == verdict.interfaces.n_interfaces
    assert not tension.any()
    radius = np.linalg.norm(point[:, [0, 2]], axis=1)
    assert (np.abs(radius - 1.0) <= 0.075 + 1e-9).all()
    # Between two joints only the weight of one voussoir is added.
    order = np.argsort(point[:, 0])
    pair = verdict.interfaces.pair[order]
    assert len(pair) == 21
    springing = [k for k in range(21) if asm.support[verdict.interfaces.pair[k]].any()]
    signs = [1.0 if asm.support[verdict.interfaces.pair[k, 0]] else -1.0 for k in springing]
    lifted = sum(sign * force[k] for k, sign in zip(springing, signs, strict=True))
    np.testing.assert_allclose(lifted, [0, 0, asm.mass[asm.free].sum()], atol=1e-9)


def test_pictures_of_forces(tmp_path):
    for name, asm in (("stands", arch(12, 0.2)), ("falls", arch(12, 0.08))):
        path = plot_forces(assess(asm), tmp_path / f"{name}.png")
        assert path.read_bytes()[:4] == b"\x89PNG"


def test_copies_of_blocks_are_the_same_solids():
    asm = running_bond(3, 3)
    chosen = np.array([2, 5, 6])
    double = with_copies(asm, chosen)
    np.testing.assert_allclose(double.volume, np.concatenate([asm.volume, asm.volume[chosen]]))
    np.testing.assert_allclose(double.centroid[-3:], asm.centroid[chosen])
    assert (np.diff(double.face_block) >= 0).all()


def test_ghosts_are_painted_before_what_moves_and_after_what_they_hide():
    # In a row towards the eye: a fixed cube, a moving one, its ghost, another fixed one.
    view = view_of(-90.0, 0.0)
    asm = assembly([box((0, -k, 0), (1, 1 - k, 1)) for k in (0, 2, 4, 6)])
    assert list(paint_order(asm, asm.vertices, asm.planes, view)) == [0, 1, 2, 3]
    assert list(paint_order(asm, asm.vertices, asm.planes, view, np.array([0, 1, -1, 0]))) == [0, 2, 1, 3]


def pixels_of(path):
    from matplotlib.image import imread

    return imread(path)[..., :3]


def test_the_ghost_shows_where_the_blocks_were(tmp_path):
    # A tall block tips to the right by its own length: at rest it was left of every place it now covers.
    limit = limit_load(assembly([box((-3, -3, -1), (3, 3, 0)), box((0, 0, 0), (1, 1, 4))]), (1, 0, 0))
    assert limit.upper == pytest.approx(0.25, rel=1e-6)
    look = {"azimuth": -90.0, "elevation": 0.0, "amplitude": 2.0}
    with_ghost = pixels_of(plot_mechanism(limit, tmp_path / "ghost.png", **look))
    alone = pixels_of(plot_mechanism(limit, tmp_path / "alone.png", ghosts=None, **look))
    blank = (alone > 0.99).all(axis=2)
    grey = blank & (with_ghost < 0.99).any(axis=2)
    # Against the white paper the ghost fills its share of the picture, and it is pale and grey.
    assert grey.mean() > 0.02
    assert np.ptp(with_ghost[grey], axis=1).max() < 0.03
    assert np.median(with_ghost[grey]) > 0.7
    # It is behind: what moved is painted over it as if it were not there.
    coloured = np.ptp(alone, axis=2) > 0.3
    np.testing.assert_allclose(with_ghost[coloured], alone[coloured], atol=0.1)


def test_what_does_not_move_has_no_picture_of_a_mechanism(tmp_path):
    with pytest.raises(InputError, match="no mechanism to show, the verdict is stable"):
        plot_mechanism(assess(arch(12, 0.2)), tmp_path / "x.png")
    with pytest.raises(InputError, match="the limit load is unbounded"):
        plot_mechanism(limit_load(arch(12, 0.2), (0, 0, -1)), tmp_path / "x.png")
    with pytest.raises(InputError, match="amplitude is -1"):
        plot_mechanism(assess(arch(12, 0.08)), tmp_path / "x.png", amplitude=-1.0)


def test_the_picture_of_help_is_blue_where_a_stone_helps(tmp_path):
    # A tower tips about its foot at width over height: mass helps below the centroid and hinders above it.
    tower = assembly([box((-3, -3, -1), (3, 3, 0)), *(box((0, 0, k), (1, 1, k + 1)) for k in range(4))], friction=2.0)
    limit = limit_load(tower, (1, 0, 0))
    assert limit.lower == pytest.approx(0.25, rel=1e-5)
    pixels = pixels_of(plot_stone_sensitivity(limit, (1, 0, 0), tmp_path / "help.png", azimuth=-90.0, elevation=0.0))
    pixels = pixels[:, : int(0.8 * pixels.shape[1])]  # without the colour bar
    blue = np.argwhere(pixels[..., 2] - pixels[..., 0] > 0.2)[:, 0]
    red = np.argwhere(pixels[..., 0] - pixels[..., 2] > 0.2)[:, 0]
    assert len(blue) > 1000
    assert len(red) > 1000
    assert red.max() <= blue.min()


def test_the_map_of_the_reserve_is_red_at_the_joint_that_matters(tmp_path):
    # A tower of three blocks tips about its foot: the other beds do not count, and friction nowhere.
    tower = assembly([box((-3, -3, -1), (3, 3, 0)), *(box((0, 0, k), (1, 1, k + 1)) for k in range(3))], friction=2.0)
    found = reserve_map(limit_load(tower, (1, 0, 0), optimum=True), (1, 0, 0))
    options = {"azimuth": -90.0, "elevation": 20.0}
    pixels = pixels_of(plot_reserve_map(found, "edge", tmp_path / "edge.png", **options))
    pixels = pixels[:, : int(0.8 * pixels.shape[1])]  # without the colour bar
    red = np.argwhere((pixels[..., 0] > 0.4) & (pixels[..., 1] < 0.3))[:, 0]
    assert len(red) > 100
    assert red.min() > 0.5 * pixels.shape[0]
    assert found.most("edge") == [('"block0" and "block1"', pytest.approx(-2 / 3, rel=1e-5))]
    assert found.most("corner", 1)[0][1] > 0
    for what in ("friction", "corner"):
        assert plot_reserve_map(found, what, tmp_path / f"{what}.png").is_file()
    axes = Figure().add_subplot()
    assert found.most("friction") == []
    plot_reserve_map(found, "friction", axes)
    assert "hangs on no friction" in axes.get_title()
    with pytest.raises(InputError, match="must be one of: edge, friction, corner"):
        plot_reserve_map(found, "edges", tmp_path / "x.png")
    bare = reserve_map(limit_load(tower, (1, 0, 0), optimum=True), (1, 0, 0), corners=False)
    with pytest.raises(InputError, match="without corners"):
        plot_reserve_map(bare, "corner", tmp_path / "x.png")


def test_a_plot_of_a_stable_verdict_takes_the_options_of_plot(tmp_path):
    verdict = assess(stack(2))
    assert verdict.outcome is Outcome.STABLE
    assert plot_verdict(verdict, tmp_path / "stable.png", title="two blocks", top=2.0).is_file()


def test_forces_of_blocks_without_a_joint_are_an_empty_picture(tmp_path):
    ground = box((0, 0, 0), (1, 1, 1), name="ground")
    alone = Assembly.from_blocks([ground], supports=["ground"])
    assert plot_forces(assess(alone), tmp_path / "forces.png").is_file()


def test_a_picture_of_what_does_not_move_is_titled_by_its_verdict():
    """A block between two walls: friction holds it on paper, and nothing presses it against them."""
    from matplotlib.figure import Figure

    blocks = [box((-1, 0, 0), (0, 1, 1)), box((0, 0, 0), (1, 1, 1)), box((1, 0, 0), (2, 1, 1))]
    jammed = Assembly.from_blocks(blocks, supports=[0, 2], friction=0.7, name="jammed")
    for flow, title in (("associated", "jammed: stable"), ("coulomb", "jammed: stable only by self stress")):
        axes = Figure().add_subplot()
        plot_verdict(assess(jammed, flow=flow), axes)
        assert axes.get_title() == title


@pytest.mark.parametrize("name", ["pier $5 and $6", "vault $^$", "A$\\frac$"])
def test_a_dollar_in_a_name_begins_no_formula(name, tmp_path):
    """A formula that cannot be read ends the drawing, and one that can loses the dollars."""
    post = stack(1, 1.0, 2.0, name=name)
    plot(post, tmp_path / "blocks.svg", title=name, values=np.ones(2), label=name)
    plot_directions(limit_load_by_direction(post, 4), tmp_path / "directions.svg")
    curve = capacity(post, (1, 0, 0), steps=3)
    plot_capacity(replace(curve, control=name), tmp_path / "curve.svg")
    assert all((tmp_path / f"{name}.svg").stat().st_size for name in ("blocks", "directions", "curve"))
    axes = plot(post, Figure().add_subplot(), title=name, values=np.ones(2), label=name)
    assert not axes.title.get_parse_math()
    assert not axes.figure.axes[1].yaxis.label.get_parse_math()
