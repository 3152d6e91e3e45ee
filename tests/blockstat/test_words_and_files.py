"""What is refused, said and written below the commands: files, imports, pages and pictures."""

import json
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from test_capacity import track

from blockstat import (
    InputError,
    Plan,
    Step,
    assess,
    assess_plan,
    capacity,
    limit_load_by_direction,
    plot_directions,
    utilisation,
    write_plan_film,
)
from blockstat.analysis.limit_load import LoadOutcome
from blockstat.design_search.candidate import Candidate, SearchResult
from blockstat.spec import scene_from
from blockstat.studies.directions import DirectionOutcome
from blockstat.system import process, reading
from blockstat.system.on_demand import on_demand
from blockstat.system.writing import written_whole
from blockstat.view import assessment, report, settling
from blockstat.view.building.removal import weight_lost
from evidence.scenes.small import assembly, box, stack

BREEZE = SimpleNamespace(name="breeze", words="1 x push")


@pytest.mark.parametrize(
    ("case", "acting"),
    [(None, "the weight of the blocks"), (BREEZE, "all loads of the case &quot;breeze&quot;: 1 x push")],
)
def test_a_report_says_under_which_loads_its_verdicts_are(case, acting):
    text = assessment._cases(SimpleNamespace(case=case, cases=(), loaded=False))
    assert f"Verdicts and pictures here are those under {acting}. " in text


def found(*history, **options):
    scene = scene_from({"name": "post", "elements": {"post": {"kind": "box", "size": [0.5, 0.5, 1.0]}}})
    return SearchResult(scene, None, None, history, **options)


def design(dynamic="stands", **options):
    return Candidate({"t": 0.5}, "stable", 0.0, dynamic, 1.0, 2, 0.1, 0.1, **options)


def test_the_page_of_a_search_says_what_there_is_to_say(tmp_path):
    def said(result):
        return report.write_report(result, tmp_path, []).read_text()

    whole, ended = said(found(design())), said(found(design(), finished=False))
    front = said(found(design(), front=(design(reserve=0.2),)))
    assert "Run the same command again to go on." in ended
    assert "Volume against reserve" in front
    for words in ("Interrupted", "Volume against reserve"):
        assert words not in whole
    assert "<b>Interrupted before any design stood.</b>" in ended
    assert "<b>Designs stand, and none was found with the reserve or the safety asked for.</b>" in whole
    assert "<b>No design of the space stood.</b>" in said(found(design("falls")))
    unjudged = said(found(design("falls"), design("error"), unexamined=3))
    assert "<b>No design stood of the 2 examined (1 not judged); the space has 5.</b>" in unjudged
    assert "o design stood" not in ended


def best():
    scene = scene_from({"name": "post", "elements": {"post": {"kind": "box", "size": [0.5, 0.5, 1.0]}}})
    return SearchResult(scene, scene, {}, (design(),))


def test_the_best_design_is_written_with_its_limits_and_a_view_to_turn(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "available", lambda: True)
    monkeypatch.setattr(report, "interactive_html", lambda _: "<p>turn me</p>")
    figures = report.write_designs(best(), tmp_path)
    assert [figure.path.name for figure in figures] == ["building.png", "demand.png", "directions.png", "view.html"]
    assert (tmp_path / "view.html").read_text() == "<p>turn me</p>"
    # A post tips at its width over its height.
    assert "the least is 0.5 times gravity" in figures[2].caption


def test_a_best_design_without_a_limit_or_a_viewer_has_neither_picture(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "available", lambda: False)
    unbounded = SimpleNamespace(outcome=DirectionOutcome.UNBOUNDED)
    monkeypatch.setattr(report, "limit_load_by_direction", lambda *_, **__: unbounded)
    figures = report.write_designs(best(), tmp_path)
    assert [figure.path.name for figure in figures] == ["building.png", "demand.png"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["best.glb", "best.json", "building.png", "demand.png"]


def test_the_thinnest_pruned_design_is_drawn_with_its_values(tmp_path, monkeypatch):
    monkeypatch.setattr(report, "available", lambda: False)
    scene = scene_from(
        {
            "name": "post",
            "elements": {
                "post": {"kind": "box", "size": [{"value": 0.5, "min": 0.1, "max": 0.5, "step": 0.1}, 0.5, 1.0]}
            },
        }
    )
    [name] = [key for key in report.parameters(scene)]
    pruned = [Candidate({name: t}, "unstable", 1.0, "pruned", t / 2, 2, 0.0, 0.0) for t in (0.4, 0.2)]
    figures = report.write_designs(SearchResult(scene, None, None, tuple(pruned)), tmp_path)
    assert [figure.path.name for figure in figures] == ["building.png", "mechanism.png"]
    assert figures[0].caption == "The design the search started from."
    assert "0.2" in figures[1].caption
    assert "0.4" not in figures[1].caption


@pytest.mark.parametrize("pruned", [0.3, 0.2, None])
def test_where_the_largest_design_cannot_be_built_one_that_can_is_drawn(tmp_path, pruned):
    """Two posts 0.4 m apart overlap where they are 0.5 m wide."""
    wide = {"t": {"value": 0.5, "min": 0.2, "max": 0.5, "step": 0.1}}
    posts = {name: {"kind": "box", "size": ["= t", 0.5, 1.0], "at": [x, 0, 0]} for name, x in (("a", 0), ("b", 0.4))}
    scene = scene_from({"name": "post", "parameters": wide, "elements": posts})
    rows = [Candidate({"parameters.t": 0.5}, "error", None, "", None, None, 0.0, 0.0, "they overlap")]
    if pruned is not None:
        rows.append(Candidate({"parameters.t": pruned}, "unstable", 1.0, "pruned", 0.05, 2, 0.0, 0.0))
    figures = report.write_designs(SearchResult(scene, None, None, tuple(rows)), tmp_path)
    names = [] if pruned is None else ["building.png", "mechanism.png"]
    assert [figure.path.name for figure in figures] == names
    if figures:
        assert figures[0].caption == f"The first design that could be built (parameters.t {pruned:g})."


def test_directions_are_drawn_in_axes_that_are_given():
    axes = Figure().add_subplot(projection="polar")
    made = limit_load_by_direction(stack(1, 1.0, 2.0), 4)
    assert plot_directions(made, axes) is axes
    reached = max(np.max(line.get_ydata()) for line in axes.lines)
    assert reached >= 0.5 * (1 - 1e-6)


def test_directions_that_are_undecided_are_hollow():
    made = limit_load_by_direction(stack(1, 1.0, 2.0), 4, refine=False)
    limits = list(made.limits)
    limits[1] = replace(limits[1], outcome=LoadOutcome.UNDECIDED, lower=0.3)
    axes = Figure().add_subplot(projection="polar")
    plot_directions(replace(made, limits=tuple(limits)), axes)
    points = {
        (float(angle), float(size)): to_hex(line.get_markerfacecolor())
        for line in axes.lines
        if line.get_marker() == "o" and line.get_color() == "#0072B2"
        for angle, size in zip(line.get_xdata(), line.get_ydata(), strict=True)
    }
    hollow = [place for place, colour in points.items() if colour == "#ffffff"]
    assert hollow == [(pytest.approx(np.pi / 2), 0.3)]
    assert len(points) == 4
    assert [text.get_text() for text in axes.get_legend().get_texts()][-1] == "undecided"
    assert "directions: undecided, at most 0.5 towards" in axes.get_title()


@pytest.mark.parametrize("seconds", [0.0, -1.0, float("nan"), float("inf")])
def test_a_film_of_a_plan_has_a_length(tmp_path, seconds):
    tower = stack(1)
    judged = assess_plan(tower, Plan((Step(("stone0",)),)))
    with pytest.raises(InputError, match=r"seconds is .*; it must be a positive number"):
        write_plan_film(tower, judged, tmp_path / "plan.glb", seconds=seconds)
    assert not list(tmp_path.iterdir())


def test_a_block_whose_removal_is_undecided_has_no_colour():
    tower = stack(2)
    lost = weight_lost(tower, {"stone0": SimpleNamespace(falls=None), "stone1": SimpleNamespace(falls=())})
    assert np.isnan(lost[1])
    assert lost[2] == 0.0


def test_blocks_without_a_joint_use_none():
    apart = assembly([box((0, 0, 0), (1, 1, 1)), box((0, 0, 5), (1, 1, 6))])
    assert utilisation(assess(apart)).shape == (0,)


def test_a_file_that_is_too_large_is_refused_before_it_is_read(tmp_path, monkeypatch):
    path = tmp_path / "large.json"
    path.write_text("four")
    monkeypatch.setattr(reading, "MOST_BYTES", 4)
    assert reading.text_of(path) == "four"
    monkeypatch.setattr(reading, "MOST_BYTES", 3)
    with pytest.raises(InputError, match=r"large\.json: has 4e-09 GB; at most 3e-09 GB are read"):
        reading.text_of(path)


def test_what_writes_nothing_keeps_the_file_that_was_there(tmp_path):
    path = tmp_path / "note.txt"
    with written_whole(path):
        pass
    assert not list(tmp_path.iterdir())
    path.write_text("old")
    with written_whole(path):
        pass
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


def test_a_module_that_misses_another_says_so_and_not_that_it_is_missing(tmp_path, monkeypatch):
    package = tmp_path / "stones_of_a_test"
    package.mkdir()
    (package / "__init__.py").write_text("")
    (package / "broken.py").write_text("import no_such_library_at_all\n")
    monkeypatch.syspath_prepend(tmp_path)
    get = on_demand("stones_of_a_test", {}, {})
    with pytest.raises(ModuleNotFoundError, match="no_such_library_at_all"):
        get("broken")
    with pytest.raises(AttributeError, match="module 'stones_of_a_test' has no attribute 'gone'"):
        get("gone")


def test_a_hook_for_lost_errors_that_is_there_already_is_left(monkeypatch):
    own = print
    monkeypatch.setattr(process, "_handle", lambda _: None)
    monkeypatch.setattr(sys, "unraisablehook", own)
    process.Interruptions().heed()
    assert sys.unraisablehook is own
    monkeypatch.setattr(sys, "unraisablehook", sys.__unraisablehook__)
    process.Interruptions().heed()
    assert sys.unraisablehook is process._lost


def test_a_path_of_one_state_is_a_film_that_stands_still(tmp_path):
    """The block of 1 x 2 m has turned about its toe, x = 1, until its centroid is above it: by atan .5."""
    curve = capacity(stack(1, 1.0, 2.0), (1, 0, 0), steps=5)
    path = settling.write_path(replace(curve, points=curve.points[-1:]), tmp_path / "still.glb")
    half = 0.5 * np.arctan(0.5)
    turned = [0, np.sin(half), 0, np.cos(half)]
    for what, value in (("translation", [1.0, 0.5, 1.25**0.5]), ("rotation", turned)):
        values, times = track(path, "stone0", what)
        assert values[0] == pytest.approx(value, abs=1e-4)
        np.testing.assert_array_equal(values[0], values[1])
        assert times[0] == 0 < times[1]


def test_a_path_that_is_a_state_at_rest_shows_the_blocks_in_their_places(tmp_path):
    curve = capacity(stack(1, 1.0, 2.0), (1, 0, 0), steps=5)
    data = settling.write_path(replace(curve, points=curve.points[:1]), tmp_path / "rest.glb").read_bytes()
    content = json.loads(data[20 : 20 + int.from_bytes(data[12:16], "little")])
    (stone,) = (node for node in content["nodes"] if node["name"] == "stone0")
    assert stone["translation"] == pytest.approx([0.5, 0.5, 1.0], abs=1e-9)
    assert "rotation" not in stone
