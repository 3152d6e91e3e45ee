"""The page without a browser: what is asked, what is answered, what is drawn."""

import logging
import time
from dataclasses import replace
from math import isnan, nan
from unittest.mock import MagicMock, Mock

import numpy as np
import pytest

from blockstat import Assembly, Imperfections, InputError, JointLaw, assess, box, build, load_scene, show, write
from blockstat.analysis.certificate_cache import Memory
from blockstat.app.background import Crashed, Ended, Limits, Worker
from blockstat.app.controls import Controls, named
from blockstat.app.design import PUSHES, Failed, Judged, Pushed, Question, Scored, Slipped, Stopped, open_model
from blockstat.app.evaluation import evaluated, slower_results
from blockstat.app.files import left_out, report_file, scene_file
from blockstat.app.follow import Follower
from blockstat.app.words import Known, block_card, headline, numbers
from blockstat.errors import InputWarning
from blockstat.io.scene_text import scene_text
from blockstat.view.three_d.arrows import force_arrows, thrust_arrows
from blockstat.view.three_d.colouring import CHOICES, colouring, tension
from blockstat.view.three_d.geometry import block_at, surface
from blockstat.view.three_d.player import swing, trajectory
from browser import CHAPEL
from evidence.scenes.small import arch, stack
from page_tasks import Scripted


@pytest.fixture
def hut(tmp_path):
    path = tmp_path / "hut.toml"
    path.write_text(CHAPEL)
    return path


def test_the_surface_has_the_area_and_the_volume_of_the_blocks():
    for assembly in (stack(3), arch(11, 0.2)):
        shape = surface(assembly)
        a, b, c = (assembly.vertices[shape.triangles[:, k]] for k in range(3))
        # Gauss: the signed volume of the cones from the origin over outward triangles.
        cones = np.einsum("ij,ij->i", a, np.cross(b, c)) / 6
        volume = np.bincount(shape.triangle_block, cones, assembly.n_blocks)
        assert np.allclose(volume, assembly.volume)
        area = np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2
        assert np.isclose(area, assembly.planes.area.sum())


def test_a_box_has_twelve_edges():
    assembly = stack(2)
    assert (np.bincount(surface(assembly).edge_block) == 12).all()


def test_a_ray_meets_the_first_block_in_its_way():
    assembly = stack(3)
    shape = surface(assembly)
    middle = assembly.centroid[2]
    for away in np.array([[5.0, 0, 0], [0, -7.0, 0.1], [3.0, 4.0, 0]]):
        assert block_at(shape, assembly.vertices, middle + away, -away) == 2
    assert block_at(shape, assembly.vertices, middle + [0, 0, 50.0], np.array([0, 0, -1.0])) == 3
    assert block_at(shape, assembly.vertices, middle + [0, 0, 50.0], np.array([0, 0, 1.0])) is None


@pytest.mark.parametrize("thickness", [0.08, 0.25])
def test_every_colouring_has_a_colour_a_block_and_a_legend(thickness):
    verdict = assess(arch(11, thickness))
    for choice in CHOICES:
        found = colouring(choice, verdict)
        assert found.index.shape == (verdict.assembly.n_blocks,)
        assert 0 <= found.index.min() <= found.index.max() < len(found.palette)
        assert (found.index[verdict.assembly.support] == 0).all()
        assert "support" in found.legend
    with pytest.raises(InputError, match="colourings are: verdict"):
        colouring("mood", verdict)


def test_colours_keep_their_order_in_grey():
    # A reader who sees no hue must still see which block is the worse.
    for choice, thickness in (("demand", 0.25), ("displacement", 0.08), ("tension", 0.08)):
        palette = colouring(choice, assess(arch(11, thickness))).palette[1:] / 255
        grey = palette @ [0.2126, 0.7152, 0.0722]
        assert (np.diff(grey) > 0).all()


def test_missing_tension_is_that_of_the_verdict():
    verdict = assess(arch(11, 0.08))
    # Each point's adhesion is counted at both blocks that it joins.
    assert np.isclose(tension(verdict).sum(), 2 * verdict.adhesion.sum())


def test_thrust_arrows_carry_the_weight():
    verdict = assess(arch(15, 0.3))
    arrows = thrust_arrows(verdict)
    vectors = (arrows.head - arrows.tail) / np.linalg.norm(arrows.head - arrows.tail, axis=1).max() * arrows.longest
    assert np.isclose(vectors[:, 2].sum(), -verdict.assembly.free_weight, rtol=1e-6)
    pressed, torn = force_arrows(verdict)
    assert len(torn.tail) == 0
    assert len(pressed.tail) == verdict.interfaces.n_interfaces


def test_a_film_begins_and_ends_where_it_should():
    verdict = assess(arch(11, 0.08))
    film = swing(verdict, 0.3)
    assert np.allclose(film(0.0), verdict.assembly.vertices)
    assert np.isclose(np.linalg.norm(film(1.5) - film(0.0), axis=1).max(), 0.3, rtol=0.05)
    assembly = stack(2)
    times = np.array([0.0, 0.5, 1.0])
    gone = np.zeros((3, 3, 3))
    gone[1:, 2, 0] = 0.1, 0.4
    move = trajectory(assembly, times, gone, np.broadcast_to(np.eye(3), (3, 3, 3, 3)))
    for seconds, way in ((0.7, 0.1), (99.0, 0.4)):
        assert np.allclose((move(seconds) - assembly.vertices)[assembly.vertex_block == 2], [way, 0, 0])


def test_a_scene_written_and_read_is_the_same_scene(hut, root, tmp_path):
    # A scene that names a mesh file finds it next to itself only, so the canopy is left out.
    paths = [path for path in sorted((root / "examples").glob("*.toml")) if path.stem != "canopy"]
    assert len(paths) > 5
    for path in (hut, *paths):
        scene = load_scene(path)
        again = tmp_path / "again.toml"
        again.write_text(scene_text(scene), encoding="utf-8")
        assert load_scene(again) == scene


def test_a_model_moves_its_parameters_and_its_material(hut):
    model = open_model(hut)
    assert {"wall.thickness", "buttresses.south.number", "friction", "density"} <= set(model.ranges)
    assembly = model.built({**model.start, "wall.thickness": 0.4, "friction": 0.25, "density": 1800.0})
    assert assembly.friction == 0.25
    assert (assembly.density == 1800.0).all()
    assert assembly.metadata["parameters"]["wall.thickness"] == 0.4
    assert named("buttresses.south.number") == ("buttresses south", "number")
    assert named("friction") == ("material", "friction")


def test_a_saved_scene_has_the_material_of_the_page_and_says_what_it_cannot_have(hut, tmp_path):
    model, again = open_model(hut), tmp_path / "again.toml"
    values = {**model.start, "wall.thickness": 0.4, "friction": 0.2, "density": 1800.0, "rounded_edges": 5.0}
    again.write_bytes(scene_file(model, values)[1])
    assert again.read_text().startswith("# rounded_edges = 5 mm was set on the page")
    assert '--imperfection "edge=5 mm"' in left_out(model, values)
    assert left_out(model, {**values, "rounded_edges": 0.0}) == ""
    saved, shown = build(load_scene(again)), model.built(values)
    assert saved.friction == shown.friction == 0.2
    assert (saved.density == shown.density).all()
    assert (saved.density == 1800.0).all()
    assert model.moved(model.start) == model.scene


def test_a_saved_composition_says_which_elements_keep_their_density(tmp_path):
    path, again = tmp_path / "slab.toml", tmp_path / "again.toml"
    slab = 'kind = "box"\nsize = [1.0, 1.0, 0.3]\nat = [0, 0, 0]\ndensity = 2691.0'
    path.write_text(f'name = "slab"\n[parameters]\nmu = 0.6\n[material]\nfriction = "= mu"\n[elements.slab]\n{slab}')
    model = open_model(path)
    again.write_bytes(scene_file(model, {**model.start, "friction": 0.2, "density": 1800.0})[1])
    assert "These elements keep their own here: slab." in again.read_text()
    assert build(load_scene(again)).friction == 0.2


@pytest.mark.parametrize(("friction", "density"), [(1000.0, 2691.0), (123.4, 11340.0), (0.7, 1e6)])
def test_blocks_of_any_friction_and_density_can_be_opened(tmp_path, friction, density):
    assembly = stack(2).with_(friction=friction, density=np.full(3, density))
    model = open_model(write(assembly, tmp_path / "stones.json"))
    assert (model.start["friction"], model.start["density"]) == (friction, density)
    usual = open_model(write(stack(2), tmp_path / "usual.json")).ranges
    assert (usual["friction"].step, usual["density"].step) == (0.01, 1.0)


def test_an_assembly_has_only_its_material_to_move(tmp_path):
    model = open_model(write(stack(2), tmp_path / "stones.json"))
    assert set(model.ranges) == {"friction", "density", "rounded_edges"}
    with pytest.raises(InputError, match="has no scene"):
        model.moved(model.start)


def test_a_question_that_cannot_be_built_is_answered_with_its_reason(hut):
    model = open_model(hut)
    answer = evaluated(Question(7, model, {**model.start, "windows.north.number": 2.0}), Memory())
    assert isinstance(answer, Failed)
    assert (answer.number, answer.is_internal) == (7, False)
    assert "windows.north" in answer.message
    good = evaluated(Question(8, model, model.start), Memory())
    assert isinstance(good, Judged)
    assert good.verdict.outcome is assess(model.built(model.start)).outcome


def test_the_slider_of_rounded_edges_asks_for_joints_without_them(tmp_path):
    """A block half as wide as high, tilted by .45: it falls once its joint has lost a tenth of its width in all."""
    tilted = stack(1, 1.0, 2.0).with_(gravity=np.array([0.45, 0.0, -1.0]))
    model = open_model(write(tilted, tmp_path / "block.json"))
    assert named("rounded_edges") == ("material", "rounded edges")
    memory = Memory()
    words = {}
    for lost in (0.0, 20.0):  # mm of a block of 1 m: it still stands
        found = evaluated(Question(1, model, {**model.start, "rounded_edges": lost}), memory)
        words[lost] = found.verdict.outcome.word
        assert ("joints lose 20 mm at each edge" in headline(Known(found.verdict))) == (lost > 0)
    assert set(words.values()) == {"stable"}
    small = tilted.with_(vertices=0.3 * tilted.vertices)
    model = open_model(write(small, tmp_path / "small.json"))
    outcomes = [
        evaluated(Question(1, model, {**model.start, "rounded_edges": lost}), memory).verdict.outcome.word
        for lost in (14.5, 15.5)  # (300 - 2 x 15) / 600 = .45
    ]
    assert outcomes == ["stable", "unstable"]


def test_the_words_say_what_the_verdict_says():
    verdict = assess(arch(11, 0.08))
    known = Known(verdict)
    first = verdict.assembly.names[verdict.moving[0]]
    assert "Unstable" in headline(known)
    assert first in headline(known)
    assert f"{verdict.score:.3g}" in numbers(known)
    card = block_card(verdict, 3)
    for k in np.flatnonzero((verdict.interfaces.pair == 3).any(axis=1)):
        assert all(verdict.assembly.names[i] in card for i in verdict.interfaces.pair[k])


def test_names_are_shown_as_they_are_written_and_never_run():
    assembly = stack(1)
    evil = "<img src=x onerror=alert(1)>"
    renamed = assembly.__class__(**{**vars_of(assembly), "names": ("ground", evil), "groups": ("", evil)})
    verdict = assess(renamed)
    for text in (block_card(verdict, 1), block_card(verdict, 0), colouring("group", verdict).legend):
        assert "<img" not in text
        assert "&lt;img" in text


def vars_of(assembly):
    return {name: getattr(assembly, name) for name in assembly.__dataclass_fields__}


def count_to(channel, number):
    for k in range(number):
        channel.send(k)


def break_down(channel):
    raise RuntimeError("the bridge is out")


def sleep_long(channel):
    channel.send("asleep")
    time.sleep(600)


def collected(work, *arguments, until=Ended):
    told = []
    worker = Worker(work, *arguments, report=lambda _, message: told.append(message))
    wait(lambda: told and isinstance(told[-1], until))
    return worker, told


def wait(true, seconds=60):
    for _ in range(100 * seconds):
        if true():
            return
        time.sleep(0.01)
    raise AssertionError("it did not come about in time")


def test_a_worker_tells_everything_and_then_that_it_ended():
    _, told = collected(count_to, 3)
    assert told[:3] == [0, 1, 2]
    assert type(told[3]) is Ended


def test_a_worker_that_breaks_says_why():
    _, told = collected(break_down)
    assert isinstance(told[-1], Crashed)
    assert "the bridge is out" in told[-1].message


def test_a_worker_that_is_stopped_is_gone_and_silent():
    worker, told = collected(sleep_long, until=str)
    worker.stop()
    wait(lambda: not worker._process.is_alive())
    time.sleep(0.1)
    assert told == ["asleep"]
    assert not worker.running


def answered(calls, follower):
    """Run what was posted; whether the newest question has its answer."""
    while calls.qsize():
        calls.get()()
    return not follower.pending


def test_the_newest_question_wins(hut):
    import queue

    calls, told = queue.Queue(), []
    follower = Follower(calls.put, told.append)
    model = open_model(hut)
    try:
        for value in np.linspace(0.6, 0.35, 20):
            last = follower.ask(model, {**model.start, "wall.thickness": float(value)})
        wait(lambda: answered(calls, follower))
    finally:
        follower.stop()
    answers = [message for message in told if isinstance(message, Judged)]
    assert answers[-1].number == last == 20
    assert len(answers) < 20
    assert [m.number for m in answers] == sorted(m.number for m in answers)


def test_an_evaluator_that_is_killed_is_replaced(hut):
    import queue

    calls, told = queue.Queue(), []
    follower = Follower(calls.put, told.append)
    model = open_model(hut)

    try:
        follower.ask(model, model.start)
        wait(lambda: answered(calls, follower))
        follower._evaluator._process.kill()
        wait(lambda: not follower._evaluator.running)
        follower.ask(model, {**model.start, "wall.thickness": 0.5})
        wait(lambda: answered(calls, follower))
    finally:
        follower.stop()
    assert [type(m) for m in told if isinstance(m, (Judged, Failed))][-1] is Judged


@pytest.mark.parametrize(
    ("first", "seconds", "words"),
    [(Scripted(30.0), 1.0, "stopped after 1 s"), (Scripted(1.0, "memory"), 60.0, "GB of memory")],
)
def test_a_question_that_waits_for_one_that_fails_is_asked(first, seconds, words):
    import queue

    calls, told = queue.Queue(), []
    follower = Follower(calls.put, told.append, limits=Limits(seconds))
    try:
        follower.ask(first, {})
        wait(lambda: (answered(calls, follower), follower._began == 1)[1])
        if seconds < 2:
            time.sleep(0.7 * seconds)
        follower.ask(Scripted(0.0), {})
        wait(lambda: (follower.tick(), answered(calls, follower))[1])
    finally:
        follower.stop()
    failed, judged = (message for message in told if isinstance(message, (Judged, Failed)))
    assert (failed.number, type(failed), judged.number, type(judged)) == (1, Failed, 2, Judged)
    assert words in failed.message


def test_an_evaluator_that_ends_before_it_begins_fails_the_newest_question_and_is_not_started_again():
    told = []
    follower = Follower(lambda call: call(), told.append)
    follower._new_evaluator = Mock()
    follower.ask(Scripted(0.0), {})
    follower.ask(Scripted(0.0), {})
    follower._reported(follower._evaluator, Crashed("no memory to start in"))
    assert [(message.number, type(message)) for message in told] == [(2, Failed)]
    assert (follower.pending, follower._new_evaluator.call_count) == (False, 1)


def test_the_scores_that_memory_leaves_open_come_later(hut):
    model, memory = open_model(hut), Memory()
    thin = {**model.start, "wall.thickness": 0.15}
    evaluated(Question(1, model, thin), memory)
    again = evaluated(Question(2, model, thin), memory)
    assert isnan(again.verdict.score)
    assert "…" in numbers(Known(again.verdict))
    assert "not known yet" in colouring("tension", again.verdict).legend


def test_how_blocks_move_first_is_told_as_the_command_tells_it(hut):
    """Of the many mechanisms that prove a fall the page tells the one of least residual tension, once it is known."""
    model, memory = open_model(hut), Memory()
    thin = {**model.start, "wall.thickness": 0.15}
    first = [evaluated(Question(number, model, thin), memory).verdict for number in (1, 2)][-1]
    assert isnan(first.score)  # decided by the evidence of the question before
    assert first.mechanism.any()
    early = Known(first)
    assert not early.shows_motion
    assert "Unstable" in headline(early)
    assert "follows" in headline(early)
    assert not any(name in headline(early) for name in first.assembly.names)
    assert "in the mechanism" not in block_card(first, int(first.moving[0]), shows_motion=early.shows_motion)
    scored = Known(told_of(first)[0].verdict)
    told = assess(model.built(thin)).explain()
    assert scored.shows_motion
    words = headline(scored)
    assert told.partition("First to move: ")[2].partition(",")[0] in words
    for kind in ("Slides at", "Opens as a hinge at", "Parts at"):
        assert (kind in words) == (kind in told)
    stopped = headline(replace(early, stopped=True))
    assert "First to move" in stopped
    assert "was not found here" in stopped


def jammed():
    """A stone between two walls, with nothing below it and nothing that presses the walls together."""
    walls = [box((-1, 0, 0), (0, 1, 1), name="left"), box((1, 0, 0), (2, 1, 1), name="right")]
    return Assembly.from_blocks([*walls, box((0, 0, 0), (1, 1, 1), name="stone")], supports=["left", "right"])


def test_the_report_of_the_page_has_the_verdict_without_self_stress(tmp_path):
    """Friction holds the stone only if the walls press on it, and nothing makes them: it falls."""
    pytest.importorskip("viser")
    model = open_model(write(jammed(), tmp_path / "jammed.json"))
    known = Known(evaluated(Question(1, model, model.start), Memory()).verdict, values=model.start)
    assert known.verdict.outcome.word == "stable"
    assert "real joints may carry less" in headline(known)
    report = report_file(known)[1].decode()
    assert "Without dilatancy and self-stress (Coulomb friction): stable only by self-stress" in report
    assert "Not asked for" in report
    assert "…" not in report.partition("<h2>Pictures")[0].partition("<iframe")[0]
    assert "<dt>least friction with which it stands</dt><dd>not found yet when this was saved</dd>" in report
    again = report_file(replace(known, slipped=Slipped(1, 0.5, 0.0)))[1].decode()
    assert "<dt>least friction with which it stands</dt><dd>0.500</dd>" in again


def test_the_report_of_rounded_edges_is_of_the_joints_that_are_left(tmp_path):
    """A cube of 1 m that has lost 20 mm at each edge tips at .96 of its slope; it would slide at 2."""
    pytest.importorskip("viser")
    model = open_model(write(stack(1, 1.0, 1.0, friction=2.0), tmp_path / "cube.json"))
    values = {**model.start, "rounded_edges": 20.0}
    report = report_file(Known(evaluated(Question(1, model, values), Memory()).verdict, values=values))[1].decode()
    assert "Least limit load (associated friction): 0.96" in report
    assert "joints lose 20 mm at each edge" in report


def test_load_cases_that_do_not_act_are_named_on_the_page_in_its_report_and_in_the_terminal(tmp_path):
    pytest.importorskip("viser")
    from blockstat.app.server import serve

    path = tmp_path / "bridge.toml"
    path.write_text(BRIDGE)
    model = open_model(path)
    known = Known(evaluated(Question(1, model, model.start), Memory()).verdict)
    for text in (model.idle, headline(known), report_file(known)[1].decode()):
        assert "No load case acts on this page, only the weight: traffic, storm." in text
    with pytest.warns(InputWarning, match="traffic, storm"), pytest.raises(InputError, match="no such directory"):
        serve(path, folder=tmp_path / "absent")
    path.write_text(BRIDGE.partition("[cases")[0])
    assert open_model(path).idle == "No load acts on this page, only the weight: truck."
    path.write_text(BRIDGE.partition("[loads")[0])
    assert open_model(path).idle == ""


def test_what_a_scene_names_itself_has_no_unit(tmp_path):
    path = tmp_path / "bridge.toml"
    path.write_text(BRIDGE)
    gui = MagicMock()
    Controls(gui, open_model(path).ranges, print)
    labels = [call.args[0] for call in gui.add_slider.call_args_list]
    assert labels == ["stones", "friction", "density [kg/m³]", "rounded edges [mm]"]


BRIDGE = """
name = "bridge"
[parameters]
stones = { value = 9, min = 7, max = 11, step = 2 }
[elements.ring]
kind = "arch"
span = 4.0
thickness = 0.5
depth = 2.0
voussoirs = "= stones"
[loads.truck]
kind = "dispersed"
point = [1.0, 0, 3.0]
force = 20e3
spread = 0.5
footprint = [0.3, 1.8]
[cases.traffic]
factors = { truck = 8.0 }
[cases.storm]
factors = { truck = 1.0 }
"""


class Sent(list):
    """A channel that keeps what is sent."""

    send = list.append


def told_of(verdict):
    sent = Sent()
    slower_results(sent, 1, verdict)
    return sent


def test_slower_results_are_of_the_gap_that_the_page_was_given():
    """A slab that is 9 mm in the ground slides at its friction, and needs none as it lies."""
    blocks = [box((-5, -5, -1), (5, 5, 0), name="ground"), box((0, 0, -0.009), (1, 1, 0.491), name="slab")]
    slab = Assembly.from_blocks(blocks, supports=["ground"], friction=0.6)
    told = told_of(assess(slab, gap="10 mm"))
    ends = [end for found in told if isinstance(found, Pushed) for end in (found.limit.lower, found.limit.upper)]
    assert ends == pytest.approx([0.6] * 8, rel=1e-6)
    assert (told[-1].least, told[-1].reason) == (pytest.approx(0.0, abs=1e-9), "")


def test_a_score_that_comes_later_is_of_the_same_worst_case():
    """A column whose joints have lost 0.2 m on both sides, .1 m of .5 m left, does not stand under .3 of its weight."""
    leans = stack(1, 0.5, 2.0, gravity=(3.0, 0.0, -9.81))
    verdict = assess(leans, imperfections=Imperfections(edge=0.2))
    assert verdict.worst
    scored = told_of(replace(verdict, score=nan))[0]
    assert isinstance(scored, Scored)
    assert (scored.verdict.worst, scored.verdict.score) == (verdict.worst, pytest.approx(verdict.score, rel=1e-6))


def test_friction_that_is_not_asked_for_is_not_said_to_be_too_little():
    own = stack(1, 2.0, 0.5, joints=[JointLaw(("*", "*"), friction=0.5)])
    verdict = assess(own)
    slipped = told_of(verdict)[-1]
    assert isnan(slipped.least)
    assert "all joints keep a friction of their own" in slipped.reason
    assert "not known" in numbers(Known(verdict, slipped=slipped))
    assert "none is enough" not in numbers(Known(verdict, slipped=slipped))
    assert "none is enough" in numbers(Known(verdict, slipped=Slipped(1, nan, 0.0)))


def test_a_limit_load_that_could_not_be_found_is_no_limit_of_nothing():
    verdict = assess(stack(1))
    pushed = {push: Pushed(1, push, None, "a reason") for push in PUSHES}
    assert numbers(Known(verdict, pushed=pushed)).count("not known") == 5  # four pushes and the reserve in tilt


def test_slower_results_that_are_stopped_are_told(hut):
    import queue

    calls, told = queue.Queue(), []
    follower = Follower(calls.put, told.append)
    model = open_model(hut)
    try:
        follower.ask(model, model.start)
        wait(lambda: answered(calls, follower))
        follower._limits = Limits(seconds=1e-3)
        wait(lambda: follower.tick() or not answered(calls, follower) or follower._slower is not None)
        wait(lambda: (answered(calls, follower), isinstance(told[-1], Stopped))[1])
    finally:
        follower.stop()
    assert told[-1].number == 1
    assert "limit loads and least friction: stopped after 0.001 s" in told[-1].message
    judged = next(message for message in told if isinstance(message, Judged))
    shown = numbers(Known(judged.verdict, stopped=True))
    assert "…" not in shown
    assert shown.count("stopped") == 6  # four limit loads, the reserve in tilt and the least friction


def test_show_is_one_page_that_needs_nothing_else():
    pytest.importorskip("viser")
    assembly = arch(11, 0.08)
    html = show(assembly, assess(assembly))._repr_html_()
    assert "srcdoc=" in html
    assert "__VISER_EMBED_DATA__" in html
    assert "Unstable" in html
    with pytest.raises(InputError, match="not of this assembly"):
        show(stack(2), assess(assembly))


def test_without_viser_the_message_says_what_to_install(monkeypatch):
    import sys

    monkeypatch.setitem(sys.modules, "viser", None)
    with pytest.raises(InputError, match=r"pip install 'blockstat\[ui\]'"):
        show(stack(1))


def test_the_page_opens_no_other_kind_of_file(tmp_path):
    (tmp_path / "a.png").write_text("")
    with pytest.raises(InputError, match=r"the page opens \.toml"):
        open_model(tmp_path / "a.png")
    with pytest.raises(InputError, match="no such file"):
        open_model(tmp_path / "absent.toml")


@pytest.mark.parametrize(
    ("chosen", "words"),
    [
        ({"supports": "wall.north"}, "supports cannot be chosen"),
        ({"units": "mm"}, "units cannot be chosen"),
        ({"up": "y"}, "another axis cannot be chosen"),
    ],
)
def test_what_a_scene_does_not_take_is_refused_on_the_page_as_it_is_elsewhere(hut, chosen, words):
    with pytest.raises(InputError, match=words):
        open_model(hut, **chosen)
    assert open_model(hut, supports=" ", units="m", up="z").scene is not None


def test_a_page_keeps_no_worker_that_has_ended_or_was_stopped(hut):
    pytest.importorskip("viser")
    from blockstat.app.server import running

    with running(open_model(hut)) as (page, _):
        told = []
        page.post(lambda: page.start(count_to, 3, report=told.append))
        wait(lambda: told and isinstance(told[-1], Ended))
        assert page._workers == []
        for _ in range(3):
            page.post(lambda: page.start(sleep_long, report=told.append).stop())
        page.post(lambda: told.append("started"))
        wait(lambda: told[-1] == "started")
        assert len(page._workers) == 1


def test_a_page_without_a_browser_follows_its_values(hut, capfd):
    pytest.importorskip("viser")
    from blockstat.app.server import running

    logging.getLogger("blockstat.app").setLevel(logging.ERROR)
    with running(open_model(hut)) as (page, address):
        assert address.startswith("http://127.0.0.1:")
        wait(lambda: page.known is not None)
        page.post(lambda: page.set_values({"wall.thickness": 0.1}))
        wait(lambda: page.known.verdict.outcome.word == "unstable")
        wait(lambda: page.known.slipped is not None)
        found = assess(build_of(page))
        assert page.known.verdict.score == found.score
        assert np.array_equal(page.known.verdict.moving, found.moving)
        assert f"First to move: {found.assembly.names[found.moving[0]]}" in page.layout.headline.content
        # A number between two steps of .05 from .1 is put to the nearer one, with a sentence.
        page.controls._handles["wall.thickness"].value = 0.43
        wait(lambda: "0.43 m is between steps of 0.05 m from 0.1 m; 0.45 m is used" in page.layout.note.content)
        wait(lambda: page.controls.value("wall.thickness") == page.values["wall.thickness"] == 0.45)
        page.controls._handles["wall.thickness"].value = 0.5
        wait(lambda: page.values["wall.thickness"] == 0.5 and page.layout.note.content == "")
    assert "Traceback" not in capfd.readouterr().err


def test_a_report_is_of_one_design_with_its_own_values(hut, tmp_path):
    pytest.importorskip("viser")
    from blockstat.app.server import running

    stones = open_model(write(stack(2), tmp_path / "stones.json"))
    broken = tmp_path / "broken.toml"
    broken.write_text(CHAPEL.replace("value = 0, min = 0, max = 2", "value = 2, min = 0, max = 2"))
    with running(open_model(hut)) as (page, _):
        wait(lambda: page.known is not None)
        page.post(lambda: page.set_values({"windows.north.number": 2.0}))
        wait(lambda: "windows.north" in page.layout.trouble.content)
        assert "<dt>windows.north.number</dt><dd>0</dd>" in report_file(page.known)[1].decode()
        page.post(lambda: page.open(open_model(broken)))
        wait(lambda: "No verdict" in page.layout.headline.content)
        page.layout._save(None, lambda: report_file(page.layout._shown()))
        wait(lambda: "there is no verdict to save yet" in page.layout.trouble.content)
        assert not page.view.canvas._meshes
        page.post(lambda: page.open(stones))
        wait(lambda: page.known is not None)
        name, content = report_file(page.known)
        assert name == f"{stones.name}.html"
        assert "rounded_edges" in content.decode()


def test_an_answer_about_a_model_that_is_no_longer_open_is_ignored(hut, tmp_path):
    pytest.importorskip("viser")
    from blockstat.app.server import running

    stones = open_model(write(stack(2), tmp_path / "stones.json"))
    with running(open_model(hut)) as (page, _):
        wait(lambda: page.known is not None)
        late, seen = Judged(1, page.known.verdict, {}), []

        def reopen():
            page.open(stones)
            page._told(late)
            seen.append(page.known)

        page.post(reopen)
        wait(lambda: page.known is not None and seen)
        assert seen == [None]
        wait(lambda: page.known.verdict.assembly.n_blocks == 3)


def build_of(page):
    return build(page.model.moved(page.values))


@pytest.mark.parametrize("program", ["blockstat", "dynsim"])
def test_the_command_prints_its_address_serves_and_ends_when_interrupted(program, hut):
    pytest.importorskip("viser")
    import signal
    import subprocess
    import sys
    import urllib.request

    code = f"from {program}.cli.commands import main\nif __name__ == '__main__': main()"
    command = [sys.executable, "-c", code, "app", str(hut), "--port", "8471"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        line = process.stdout.readline()
        try:
            assert line.startswith("hut: http://127.0.0.1:")
            with urllib.request.urlopen(line.split()[1], timeout=60) as answer:
                assert answer.status == 200
            process.send_signal(signal.SIGINT)
            out, err = process.communicate(timeout=60)
        finally:
            process.kill()
    assert process.returncode == 0
    assert "Traceback" not in out + err


def test_a_bad_file_on_the_command_line_is_one_line(tmp_path):
    import subprocess
    import sys

    command = [
        sys.executable,
        "-c",
        "from blockstat.cli.commands import main; main()",
        "app",
        str(tmp_path / "no.toml"),
    ]
    answer = subprocess.run(command, capture_output=True, text=True)
    assert answer.returncode == 2
    assert "no such file" in answer.stderr
    assert len(answer.stderr.strip().splitlines()) == 1


def test_a_material_that_is_not_moved_stays_as_the_file_has_it(hut):
    model = open_model(hut)
    assembly = build(load_scene(hut))
    assert model.with_material(assembly, model.start) is assembly
    assert model.with_material(assembly, {**model.start, "friction": 0.3}).friction == 0.3


def test_the_report_of_a_search_holds_a_view_that_turns(hut, tmp_path):
    pytest.importorskip("viser")
    from types import SimpleNamespace

    from blockstat.design_search.search import search
    from blockstat.view.report import write_designs, write_report

    stands = SimpleNamespace(outcome=SimpleNamespace(word="stands"))
    result = search(load_scene(hut), static=assess, verify=lambda _: stands, names=["vault.thickness"])
    figures = write_designs(result, tmp_path)
    assert tmp_path / "view.html" in [figure.path for figure in figures]
    report = write_report(result, tmp_path, figures).read_text()
    assert report.count("<iframe srcdoc=") == 1
    assert "__VISER_EMBED_DATA__" in report
