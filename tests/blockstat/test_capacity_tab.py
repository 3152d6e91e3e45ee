"""The tab "Capacity" of the live page: what is sent to it, what its figure shows, and the tab in a browser."""

import re
from time import sleep
from xml.etree import ElementTree

import numpy as np
import pytest

from blockstat import Assembly, assess, box, capacity, write
from blockstat.app.background import Refused
from blockstat.app.capacity_tab.figure import HEIGHT, WIDTH, axes_of, figure
from blockstat.app.capacity_tab.following import follow_curve
from blockstat.app.capacity_tab.panel import CapacityPanel
from blockstat.app.capacity_tab.trace import CLICKED, MOST, MOST_NAMES, Event, Finished, Seen, Trace, controls, told
from blockstat.app.design import open_model
from blockstat.app.server import running
from blockstat.large_displacement.finite_steps.fall import FallenBlocks
from blockstat.large_displacement.linkage.path import PathEvent
from blockstat.view.settling import film_times
from blockstat.view.three_d.dress import AT_REST
from browser import CHAPEL, axe_path, live
from evidence.scenes.small import arch, stack

WIDTH_OF_BLOCK, HIGH = 0.5, 2.0


class Told:
    """A channel that keeps what it is told."""

    def __init__(self):
        self.messages = []

    def send(self, message):
        self.messages.append(message)


def block(**options):
    """A block that turns about its toe under a load along x."""
    blocks = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((0, 0, 0), (WIDTH_OF_BLOCK, 1, HIGH), name="block")]
    return Assembly.from_blocks(blocks, supports=["ground"], **options)


def followed(assembly, push="+x", control=None):
    """The trace of a curve as the page gathers it, and all that was told."""
    channel, trace = Told(), Trace(push)
    follow_curve(channel, assess(assembly), push, control)
    for message in channel.messages:
        trace.take(message)
    return trace, channel.messages


def bare(bracket):
    """A trace of displacements [m] and brackets, of one block that stays."""
    return Trace("+x", [Seen(*row, np.zeros((1, 3)), np.eye(3)[None]) for row in bracket])


def test_a_block_on_its_toe_is_told_in_millimetres_and_units_of_gravity():
    """Livesley 1978: the multiplier is the tangent of the angle that the centroid's arm still has to the vertical."""
    assembly = block()
    trace, messages = followed(assembly, control="block")
    assert isinstance(messages[-1], Finished)
    displacement, lower, upper = trace.plotted()
    assert displacement.shape == lower.shape == upper.shape == (len(trace.states),)
    assert (lower <= upper).all()
    arm = np.hypot(WIDTH_OF_BLOCK / 2, HIGH / 2)
    sine = (WIDTH_OF_BLOCK / 2 - 1e-3 * displacement) / arm
    assert lower == pytest.approx(sine / np.sqrt(1 - sine**2), abs=1e-5)
    assert upper == pytest.approx(lower, abs=1e-5)
    assert displacement[-1] == pytest.approx(250.0, rel=1e-6)
    assert "block" in messages[-1].control
    assert trace.states[-1].words == "displacement 250 mm, multiplier 0 g"


def test_the_blocks_are_shown_in_true_scale():
    assembly = block()
    trace, _ = followed(assembly, control="block")
    own = assembly.vertex_block == 1
    toe = own & (assembly.vertices[:, 0] == WIDTH_OF_BLOCK) & (assembly.vertices[:, 2] == 0)
    for number, state in enumerate(trace.states):
        there = trace.vertices(assembly, number)
        assert there[toe] == pytest.approx(assembly.vertices[toe], abs=1e-6)  # the toe stays
        assert (there[~own] == assembly.vertices[~own]).all()
        moved = (there[own] - assembly.vertices[own]).mean(axis=0)  # of a box: its centroid
        assert moved[0] == pytest.approx(state.displacement, abs=1e-6)
        across, at_rest = (v[own][:, None] - v[own][None] for v in (there, assembly.vertices))
        assert np.linalg.norm(across, axis=2) == pytest.approx(np.linalg.norm(at_rest, axis=2), abs=1e-6)
    assert trace.states[0].moved.dtype == np.float32


def test_what_is_told_on_the_way_is_the_curve():
    assembly = arch(11, 0.2)
    told_, points = [], []
    curve = capacity(assembly, (1, 0, 0), each=told_.append, progress=lambda *at: points.append(at))
    assert [item for item in told_ if item in curve.points] == list(curve.points)
    assert [item for item in told_ if isinstance(item, PathEvent)] == list(curve.events)
    assert len(curve.events) > 0  # this arch changes its hinges
    assert [at for at, _ in points] == curve.displacement.tolist()
    # A jump is told between the two states that stand at it.
    jump = told_.index(curve.events[0])
    assert told_[jump - 1].displacement == told_[jump + 1].displacement == curve.events[0].parameter


def test_states_that_were_told_outlive_a_process_that_is_killed():
    class Killed(Exception):
        pass

    channel = Told()

    def broken(message):
        channel.messages.append(message)
        if len(channel.messages) == 5:
            raise Killed

    whole = followed(arch(11, 0.2))[0].states
    channel.send = broken
    with pytest.raises(Killed):
        follow_curve(channel, assess(arch(11, 0.2)), "+x", None)
    kept = [m for m in channel.messages if isinstance(m, Seen)]
    assert len(kept) >= 3
    assert [s.displacement for s in kept] == [s.displacement for s in whole[: len(kept)]]


@pytest.mark.parametrize(
    ("assembly", "control", "words"),
    [
        (block(), "ground", "does not move in the mechanism; choose a block that does"),
        (block(), "gruond", 'no control "gruond"; controls are: ground, block, mean'),
        (block().with_(gravity=(4.0, 0.0, -9.81)), None, "no limit load to start from"),
        (block().with_(support=np.array([True, True])), None, "there is nothing to load"),
    ],
)
def test_what_cannot_be_followed_is_told_in_the_words_of_the_library(assembly, control, words):
    trace, messages = followed_or_refused(assembly, control)
    assert [type(message) for message in messages] == [Refused]
    assert words in messages[0].message
    assert trace.states == []


def followed_or_refused(assembly, control):
    channel = Told()
    follow_curve(channel, assess(assembly), "+x", control)
    return Trace("+x"), channel.messages


def test_a_load_that_any_multiple_of_is_carried_is_refused():
    walls = [box((-2, -2, -1), (3, 3, 0), name="ground"), box((1, 0, 0), (2, 1, 1), name="stop")]
    blocks = [*walls, box((0, 0, 0), (1, 1, 1), name="stone")]
    held = Assembly.from_blocks(blocks, supports=["ground", "stop"], friction=0.7)
    _, messages = followed_or_refused(held, None)
    assert "carries any multiple of the load" in messages[0].message


def drawing(trace, at=0, **options):
    """The figure as a tree, and its parts by kind."""
    text = figure(trace, at, **options)
    tree = ElementTree.fromstring(text)
    return tree[0], lambda kind: list(tree.iter(kind))


def places(part):
    return np.array([pair.split(",") for pair in part.get("points").split()], dtype=float)


def test_the_band_lies_between_the_bounds_and_the_axes_have_units():
    trace = bare([(0.0, 0.30, 0.32), (0.05, 0.2, 0.25), (0.1, 0.0, 0.1)])
    tree, parts = drawing(trace, 1)
    (band,) = parts("polygon")
    edge = places(band)
    assert len(edge) == 2 * len(trace.states)
    lower, upper = edge[:3], edge[:2:-1]
    assert (lower[:, 0] == upper[:, 0]).all()
    assert (lower[:, 1] > upper[:, 1]).all()  # the figure's y points down
    axes = axes_of(trace)
    assert lower[:, 0] == pytest.approx(axes.x(np.array([0, 50, 100])), abs=0.06)
    assert upper[:, 1] == pytest.approx(axes.y(np.array([0.32, 0.25, 0.1])), abs=0.06)
    words = [part.text for part in parts("text")]
    assert "displacement [mm]" in words
    assert "multiplier [g]" in words
    assert {"0", "50", "100"} & set(words)
    (mark,) = parts("circle")
    assert float(mark.get("cx")) == pytest.approx(axes.x(50.0), abs=0.06)
    assert "multiplier 0.3 g at rest" in tree.get("aria-label")
    everything = np.concatenate([places(part) for part in (*parts("polygon"), *parts("polyline"))])
    assert (everything >= 0).all()
    assert (everything <= [WIDTH, HEIGHT]).all()


def test_a_path_that_goes_back_is_drawn_in_its_order():
    trace = bare([(0.0, 0.3, 0.3), (0.10, 0.2, 0.2), (0.06, 0.1, 0.1)])
    _, parts = drawing(trace)
    across = places(parts("polyline")[0])[:, 0]
    assert across[1] > across[2] > across[0]


def test_a_curve_of_another_design_is_grey_and_unmarked():
    trace = bare([(0.0, 0.3, 0.3), (0.1, 0.2, 0.2)])
    new, old = drawing(trace), drawing(trace, old=True)
    assert not old[1]("circle")
    assert "another design" in old[0].get("aria-label")
    colours = [{part.get("stroke") for part in parts("polyline")} for _, parts in (new, old)]
    assert colours[0] != colours[1]
    red, green, blue = (int(next(iter(colours[1]))[k : k + 2], 16) for k in (1, 3, 5))
    assert max(red, green, blue) - min(red, green, blue) < 32


def test_a_curve_that_ends_at_once_has_a_figure_too():
    _, parts = drawing(bare([(0.0, 0.3, 0.3)]))
    assert len(parts("circle")) == 1
    assert figure(Trace("+x"), 0) == ""


def test_jumps_and_blocks_that_left_are_marked():
    names = ("ground", "<b>", *(f"stone{k}" for k in range(6)))
    trace = bare([(0.0, 0.3, 0.3), (0.1, 0.2, 0.2)])
    trace.take(told(PathEvent("jump", 0.05, 0.25, 0.2, (0,), ()), names))
    trace.take(told(FallenBlocks(0.09, np.arange(1, 8)), names))
    assert [(event.kind, event.displacement) for event in trace.events] == [("jump", 0.05), ("left", 0.09)]
    assert "from 0.25 g to 0.2 g" in trace.notes()
    assert "&lt;b&gt;, stone0, stone1, stone2 and 3 more" in trace.notes()
    _, parts = drawing(trace)
    assert {"jump", "left"} <= {part.text for part in parts("text")}
    dashed = [part for part in parts("line") if part.get("stroke-dasharray")]
    assert [float(part.get("x1")) for part in dashed] == pytest.approx(
        axes_of(trace).x(np.array([50.0, 90.0])), abs=0.06
    )
    # At the end the changes are those of the curve; blocks that left stay marked.
    end = Event("jump", 0.02, "from 0.28 g to 0.2 g")
    trace.take(Finished("Zero.", "corner", (end,), ("stones: fallen out",)))
    assert [event.displacement for event in trace.events] == [0.02, 0.09]
    assert "Note: stones: fallen out." in trace.notes()


def test_a_long_list_of_blocks_is_left_out():
    few, many = stack(3), stack(MOST_NAMES + 1)
    assert controls(few)[:2] == (MOST, CLICKED)
    assert set(few.names) - {"ground"} <= set(controls(few))
    assert not set(many.names) & set(controls(many))


def test_a_film_shows_jumps_and_ends_in_time():
    times = film_times(np.array([0.0, 0.1, 0.1, 0.2]))
    assert (np.diff(times) > 0).all()
    assert times[-1] == pytest.approx(5.0)
    assert film_times(np.zeros(2))[-1] == pytest.approx(5.0)  # a jump at rest alone


def test_a_curve_whose_process_is_killed_stays_as_far_as_it_is_known(tmp_path):
    """As the limits of time and memory kill it."""
    pytest.importorskip("viser", reason="viser is not installed (extra ui)")
    path, panel = tmp_path / "hut.toml", CapacityPanel()
    path.write_text(CHAPEL)
    with running(open_model(path), panels=[panel]) as (page, _):
        in_time(lambda: page.known is not None)
        page.post(lambda: setattr(panel._push, "value", "+y"))
        page.post(panel.start)
        in_time(lambda: panel._trace is not None and len(panel._trace.states) >= 3)
        panel._worker._process.kill()
        in_time(lambda: panel._worker is None)
        assert "ended from outside" in panel._text.content
        assert len(panel._trace.states) >= 3
        assert not panel._go.disabled
        page.post(lambda: setattr(panel._slider, "value", len(panel._trace.states) - 1))
        in_time(lambda: shift(page) > 0)
        page.post(panel.rest)
        in_time(lambda: shift(page) == 0)


@pytest.fixture
def ring(tmp_path):
    return write(arch(11, 0.2), tmp_path / "ring.json")


def follow(tab, push="+x"):
    tab.tab("Capacity")
    choose(tab, 0, push)
    tab.press("Follow")


def choose(tab, index, option):
    tab.page.get_by_role("combobox").locator("visible=true").nth(index).click()
    tab.page.get_by_role("option", name=option, exact=True).click()


def in_time(true, wait=lambda: sleep(0.1), seconds=120):
    for _ in range(10 * seconds):
        if true():
            return
        wait()
    raise AssertionError("it did not come about in time")


def wait_until(tab, true):
    """As `in_time`, while the browser goes on."""
    in_time(true, lambda: tab.page.wait_for_timeout(100))


def shift(page):
    """How far the vertices on show are from where they are built [m]."""
    return np.linalg.norm(page.view.canvas.vertices - page.known.verdict.assembly.vertices, axis=1).max()


@pytest.mark.slow
def test_the_slider_shows_the_blocks_along_the_curve_and_leaving_puts_them_back(ring, capfd):
    panel = CapacityPanel()
    with live(ring, capfd, panels=[panel]) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        follow(tab)
        tab.sees("Zero: the multiplier reaches zero")
        tab.page.get_by_role("img", name=re.compile("Capacity curve towards \\+x")).wait_for()
        states = panel._trace.states
        eye = next(iter(page.server.get_clients().values())).camera.position.copy()
        slider = tab.page.get_by_role("slider", name="state").locator("visible=true")
        slider.focus()
        for _ in range(4):
            slider.press("ArrowRight")
        tab.sees(states[4].words)
        expected = panel._trace.vertices(page.known.verdict.assembly, 4)
        wait_until(tab, lambda: np.array_equal(page.view.canvas.vertices, expected))
        tab.sees("displacement [mm]")
        camera = next(iter(page.server.get_clients().values())).camera
        assert camera.position == pytest.approx(eye, abs=1e-6)  # the arrows moved the slider alone
        tab.press("Play")
        wait_until(tab, lambda: panel._at == len(states) - 1 and not page.player.playing)
        tab.page.get_by_role("button", name="Play", exact=True).wait_for()
        assert shift(page) > states[-1].displacement / 2
        tab.press("Play")
        tab.press("Pause")
        wait_until(tab, lambda: not page.player.playing)
        slider.press("End")
        wait_until(tab, lambda: panel._at == len(states) - 1)
        tab.tab("View")
        wait_until(tab, lambda: shift(page) == 0)
        assert page.view.moved is None
        tab.page.get_by_role("button", name=AT_REST).wait_for(state="detached")
        tab.tab("Capacity")
        tab.sees(states[0].words)


@pytest.mark.slow
def test_another_design_greys_the_curve(ring, capfd):
    panel = CapacityPanel()
    with live(ring, capfd, panels=[panel]) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        follow(tab)
        tab.sees("Zero: the multiplier reaches zero")
        tab.page.get_by_role("slider", name="state").locator("visible=true").press("End")
        wait_until(tab, lambda: shift(page) > 0)
        before = page.known
        page.post(lambda: page.set_values({"friction": 0.5}))
        wait_until(tab, lambda: page.known is not before)
        tab.sees("The scene has changed")
        tab.page.get_by_role("img", name=re.compile("of another design")).wait_for()
        wait_until(tab, lambda: shift(page) == 0)
        assert tab.page.get_by_role("slider", name="state").locator("visible=true").count() == 0
        follow(tab, "-x")
        tab.page.get_by_role("img", name=re.compile("Capacity curve towards -x")).wait_for()


@pytest.mark.slow
def test_what_was_followed_until_it_is_stopped_stays(tmp_path, capfd):
    path = tmp_path / "hut.toml"
    path.write_text(CHAPEL)
    panel = CapacityPanel()
    with live(path, capfd, panels=[panel]) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        follow(tab, "+y")
        wait_until(tab, lambda: panel._trace is not None and len(panel._trace.states) >= 4)
        worker = panel._worker
        tab.press("Stop following")
        tab.sees("Stopped.")
        assert not worker.running
        assert len(panel._trace.states) >= 4
        tab.page.get_by_role("slider", name="state").locator("visible=true").press("End")
        wait_until(tab, lambda: shift(page) > 0)


@pytest.mark.slow
def test_what_cannot_be_followed_is_said_on_the_page(tmp_path, capfd):
    path = write(block(), tmp_path / "block.json")
    with live(path, capfd, panels=[CapacityPanel()]) as (_, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.tab("Capacity")
        choose(tab, 1, CLICKED)
        tab.press("Follow")
        tab.sees("No block is chosen")
        name = tab.page.get_by_role("textbox", name="name").locator("visible=true").first
        name.fill("ground")
        name.press("Enter")
        tab.page.wait_for_timeout(500)
        tab.press("Follow")
        tab.sees("does not move in the mechanism; choose a block that does")


@pytest.mark.slow
@pytest.mark.parametrize("size", [(1280, 800), (390, 844)])
def test_the_tab_keeps_nobody_out(ring, capfd, size):
    axe = axe_path()
    with live(ring, capfd, panels=[CapacityPanel()]) as (page, open_tab):
        tab = open_tab(size=size)
        tab.sees("Stable", exact=True)
        tab.tab("Capacity")
        tab.page.wait_for_timeout(500)
        assert tab.barriers(axe) == []
        tab.page.get_by_role("button", name="Follow", exact=True).focus()
        tab.page.keyboard.press("Enter")
        tab.sees("Zero: the multiplier reaches zero")
        reached = set()
        for _ in range(40):
            tab.page.keyboard.press("Tab")
            reached.add(
                tab.page.evaluate(
                    "document.activeElement.getAttribute('aria-label') || document.activeElement.textContent"
                )
            )
        assert {"state", "Play"} <= reached
        tab.page.get_by_role("slider", name="state").locator("visible=true").press("End")
        wait_until(tab, lambda: shift(page) > 0)
        assert tab.barriers(axe) == []
        assert tab.page.evaluate("document.documentElement.scrollWidth") <= size[0]
        picture = tab.page.get_by_role("img", name=re.compile("Capacity curve")).bounding_box()
        assert picture["x"] >= 0
        assert picture["x"] + picture["width"] <= size[0]
        tab.tab("Design")
        wait_until(tab, lambda: shift(page) == 0)
