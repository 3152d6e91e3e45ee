"""Bullet and the search on the live page."""

import re
from types import SimpleNamespace
from unittest.mock import MagicMock, Mock

import numpy as np
import pytest

from blockstat import assess, write
from blockstat.analysis.certificate_cache import Memory
from blockstat.app.background import Crashed, Refused
from blockstat.app.design import Question, open_model
from blockstat.app.evaluation import evaluated
from blockstat.app.files import report_file
from blockstat.app.words import Known
from blockstat.design_search.search import Candidate
from blockstat.result import millimetres
from browser import CHAPEL, live
from dynsim import verify
from dynsim.panel import FallPanel, OptimisePanel, work
from dynsim.panel.fall import criteria, side_by_side
from dynsim.panel.optimise import KINDS, plotted
from dynsim.panel.work import Fallen, Film, Found, Step, let_fall, optimise
from evidence.scenes.small import stack

#: The hut with two thicknesses of its walls.
SMALL = CHAPEL.replace("min = 0.1", "min = 0.3").replace("step = 0.05 }\nheight", "step = 0.3 }\nheight")

#: The same in smaller stones: a run of Bullet that is long enough to be broken off.
LARGE = SMALL.replace("length = 1.0\nheight = 0.5", "length = 0.4\nheight = 0.25").replace(
    "voussoirs = 7", "voussoirs = 13"
)


class Told:
    """A channel that keeps what it is told."""

    def __init__(self):
        self.messages = []

    def send(self, message):
        self.messages.append(message)


def leaning():
    """Three cubes under a gravity that tips them: tan = .5 against a third."""
    return stack(3).with_(gravity=(0.5 * 9.81, 0.0, -9.81))


def test_what_falls_is_shown_falling_further_than_its_verdict_needs():
    told = Told()
    let_fall(told, assess(leaning()))
    fallen, film = told.messages
    assert isinstance(fallen, Fallen)
    assert fallen.verdict.outcome.word == "falls"
    assert isinstance(film, Film)
    gone = np.linalg.norm(film.displacement[-1] - film.displacement[0], axis=1).max()
    assert gone > 10 * fallen.verdict.brick_threshold
    text = side_by_side(Known(assess(leaning())), fallen)
    assert "unstable" in text
    assert "falls" in text
    for _, value, limit in criteria(fallen.verdict):
        assert millimetres(value) in text
        assert millimetres(limit) in text
    report = report_file(Known(assess(leaning()), simulated=fallen.verdict))[1].decode()
    assert fallen.verdict.outcome.value.partition(": ")[2][1:] in report
    assert "Not asked for" not in report


def test_what_turns_too_far_fails_a_criterion():
    # A cube that a couple spins about the vertical, without friction: no centroid moves.
    asm = stack(1, 0.3, 0.3, friction=0.0, gravity=(0, 0, -9.81))
    wrench = np.zeros((2, 6))
    wrench[1, 5] = 0.05 * 0.3 * 9.81 * asm.mass[1]
    verdict = verify(asm, loads=wrench)
    failed = [name for name, value, limit in criteria(verdict) if value >= limit]
    assert (verdict.outcome.word, failed) == ("falls", ["a block, by turning"])


def test_a_run_that_ends_before_its_film_leaves_the_verdict():
    panel = FallPanel()
    panel._worker = worker = Mock()
    panel._text = panel._stop = panel._go = panel._page = Mock()
    panel._known, panel._began, panel._fallen = Known(assess(stack(1))), 0.0, None
    verdict = SimpleNamespace(
        outcome=SimpleNamespace(word="falls", value="it falls"), first_block="", group="", warnings=(),
        group_drop=1.0, max_drop=1.0, max_displacement=1.0, roof_threshold=0.1, brick_threshold=0.1,
        max_turn=1.0, turn_threshold=0.1,
    )  # fmt: skip
    for end, words in (
        (panel.cancel, "Bullet was stopped."),
        (lambda: panel._told(worker, Crashed("out of memory")), "Bullet ended without a film: out of memory"),
    ):
        panel._worker = worker
        panel._told(worker, Fallen(verdict, ""))
        panel._page.simulated.assert_called_with(verdict)
        assert "the film is being made" in panel._text.content
        end()
        assert "it falls" in panel._text.content
        assert words in panel._text.content
        assert "being made" not in panel._text.content
        assert panel._worker is None


def test_the_words_of_bullet_are_shown_as_they_are_written_and_never_run():
    evil = "<img src=x onerror=alert(1)>"
    verdict = SimpleNamespace(
        outcome=SimpleNamespace(word="falls", value="it falls"), first_block=evil, group=evil, warnings=(evil,),
        group_drop=1.0, max_drop=1.0, max_displacement=1.0, roof_threshold=0.1, brick_threshold=0.1,
        max_turn=1.0, turn_threshold=0.1,
    )  # fmt: skip
    text = side_by_side(Known(assess(stack(1))), Fallen(verdict, evil))
    assert "<img" not in text
    assert text.count("&lt;img") == 4
    panel = FallPanel()
    panel._worker = panel._text = panel._stop = panel._go = Mock()
    panel._told(panel._worker, Refused(evil))
    assert "&lt;img" in panel._text.content


def test_what_stands_is_filmed_standing():
    told = Told()
    let_fall(told, assess(stack(2)))
    assert told.messages[0].verdict.outcome.word == "stands"
    assert np.abs(told.messages[1].displacement).max() < 1e-3


def test_what_bullet_cannot_do_is_said():
    told = Told()
    assembly = stack(2)
    let_fall(told, assess(assembly.with_(support=np.ones(3, dtype=bool))))
    assert isinstance(told.messages[0], Refused)
    assert "nothing to simulate" in told.messages[0].message


def test_a_search_asks_statics_for_the_resolution_and_says_why_bullet_differs(tmp_path, monkeypatch):
    path, asked, told = tmp_path / "hut.toml", [], Told()
    path.write_text(SMALL)
    fallen = verify(leaning())

    def falls(assembly, *, gap, interfaces=None, statics=False):
        asked.append((interfaces is not None, statics))
        return fallen

    monkeypatch.setattr(work, "verify", falls)
    monkeypatch.setattr(work, "likely_reason", lambda static, dynamic: f"{static.outcome.word}, {dynamic.outcome.word}")
    model = open_model(path)
    optimise(told, model, model.start, ["wall.thickness"])
    notes = [message.candidate.note for message in told.messages if isinstance(message, Step)]
    assert asked
    assert set(asked) == {(True, True)}
    assert notes.count("stable, falls") == len(asked)


def test_a_search_tells_each_design_and_then_the_best(tmp_path):
    path = tmp_path / "hut.toml"
    path.write_text(SMALL)
    model, told = open_model(path), Told()
    optimise(told, model, model.start, ["wall.thickness"])
    steps = [message for message in told.messages if isinstance(message, Step)]
    assert {step.candidate.parameters["wall.thickness"] for step in steps} == {0.3, 0.6}
    assert isinstance(told.messages[-1], Found)
    standing = [step.candidate for step in steps if step.candidate.stands]
    least = min(standing, key=lambda candidate: candidate.volume, default=None)
    assert told.messages[-1].best == (least.parameters if least is not None else None)
    number, *kinds = plotted([step.candidate for step in steps])
    assert list(number) == [0, 1, 2, 3]
    assert (np.column_stack(kinds) > 0).sum(axis=1).tolist() == [0, 1, 1, 0]
    assert max(kind[1] for kind in kinds) == steps[0].candidate.volume


def test_a_search_judges_with_the_rounded_edges_of_the_page(tmp_path, monkeypatch):
    """A wall as thin as twice what its joints lose at each edge has no joints left."""
    path, told = tmp_path / "wall.toml", Told()
    path.write_text(
        'name = "edges"\nlength = 3.0\nspan = 2.0\n'
        "[wall]\nthickness = {value = 0.3, min = 0.04, max = 0.3, step = 0.02}\n"
    )
    stands = SimpleNamespace(outcome=SimpleNamespace(word="stands"), process_seconds=0.0, warnings=())
    monkeypatch.setattr(work, "verify", lambda *_, **__: stands)
    monkeypatch.setattr(work, "likely_reason", lambda *_: "")
    model = open_model(path)
    values = {**model.start, "rounded_edges": 20.0}
    optimise(told, model, values, ["wall.thickness"])
    best = told.messages[-1].best
    assert evaluated(Question(1, model, {**values, **best}), Memory()).verdict.outcome.word == "stable"


def test_the_best_design_is_shown_as_it_was_searched_and_so_is_each_row():
    shown, clicks = [], []
    page = MagicMock(values={"wall.thickness": 0.8, "friction": 0.7}, set_values=shown.append, post=lambda call: call())
    page.server.gui.add_button.return_value = Mock(on_click=clicks.append)
    panel = OptimisePanel()
    panel.attach(page)
    panel._choices = {"wall.thickness": Mock(value=True)}
    panel._draw = Mock()
    panel.start()
    page.values = {"wall.thickness": 0.8, "friction": 0.2}
    clicks.clear()
    row = Candidate({"wall.thickness": 0.6}, "stable", 0.0, "stands", 1.0, 9, 0.0, 0.0)
    panel._told(panel._worker, Step(1, 2, row))
    panel._told(panel._worker, Found({"wall.thickness": 0.5}))
    clicks[0](None)
    assert shown == [{"wall.thickness": 0.5, "friction": 0.7}, {"wall.thickness": 0.6, "friction": 0.7}]


@pytest.fixture
def hut(tmp_path):
    path = tmp_path / "hut.toml"
    path.write_text(SMALL)
    return path


@pytest.fixture
def large(tmp_path):
    path = tmp_path / "large.toml"
    path.write_text(LARGE)
    return path


def worker_of(panel, tab):
    """The worker of a panel that has said that it works; the process starts a moment after the words."""
    for _ in range(200):
        if panel._worker is not None:
            return panel._worker
        tab.page.wait_for_timeout(20)
    raise AssertionError("no worker was started")


def panels():
    return [FallPanel(), OptimisePanel()]


@pytest.mark.slow
def test_let_it_fall_plays_the_trajectory_and_sets_both_verdicts_side_by_side(tmp_path, capfd):
    path = write(leaning(), tmp_path / "leaning.json")
    with live(path, capfd, panels=panels()) as (page, open_tab):
        tab = open_tab()
        tab.sees("Unstable", exact=True)
        tab.tab("Fall")
        tab.press("Let it fall")
        tab.sees("Eq. 1")
        tab.sees("falls", exact=True)
        tab.sees("displacement [mm]")
        moved = page.view.moved
        assert moved.max() > 0.1
        tab.press("Play again")
        tab.page.wait_for_timeout(1000)
        assert page.player.playing
        # Another design forgets the run.
        tab.tab("Design")
        tab.number(0, 0.6)
        tab.tab("Fall")
        tab.sees("has not been asked")


@pytest.mark.slow
def test_a_tab_closed_in_the_middle_of_a_run_leaves_the_run_alone(large, capfd):
    with live(large, capfd, panels=panels()) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.tab("Fall")
        tab.press("Let it fall")
        tab.sees("simulating")
        assert worker_of(page._panels[0], tab).running
        tab.close()
        other = open_tab()
        other.tab("Fall")
        other.sees("Eq. 1")
        other.sees("Stable", exact=True)


@pytest.mark.slow
def test_bullet_can_be_stopped(large, capfd):
    with live(large, capfd, panels=panels()) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.tab("Fall")
        tab.press("Let it fall")
        tab.sees("simulating")
        worker = worker_of(page._panels[0], tab)
        tab.press("Stop Bullet")
        tab.sees("Bullet was stopped")
        assert not worker.running
        tab.tab("Design")
        tab.number(0, 0.3)
        tab.sees("limit load, +y")


@pytest.mark.slow
def test_optimise_fills_its_history_and_a_row_shows_its_design(hut, capfd):
    with live(hut, capfd, panels=panels()) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.tab("Optimise")
        tab.page.get_by_role("checkbox").locator("visible=true").nth(0).wait_for()
        for box in range(1, tab.page.get_by_role("checkbox").locator("visible=true").count()):
            tab.page.get_by_role("checkbox").locator("visible=true").nth(box).click()
        tab.press("Optimise")
        tab.sees("2 designs.")
        assert dots(tab) >= 2 * 20  # pixels: two dots
        for value in (0.6, 0.3, 0.6):
            tab.page.get_by_role("button", name=re.compile(rf"\d: {value} ")).click()
            for _ in range(600):
                if page.values["wall.thickness"] == value and not page.follower.pending:
                    break
                tab.page.wait_for_timeout(100)
            assert page.known.verdict.assembly.metadata["parameters"]["wall.thickness"] == value


def dots(tab):
    """Pixels of the plot in the colours of its dots."""
    colours = [list(colour) for colour in KINDS.values()]
    return tab.page.locator(".uplot canvas").evaluate(
        """(canvas, colours) => {
            const data = canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
            let count = 0;
            for (let i = 0; i < data.length; i += 4)
                if (data[i + 3] == 255 && colours.some(c => c.every((v, k) => v == data[i + k]))) count++;
            return count;
        }""",
        colours,
    )


@pytest.mark.slow
def test_a_cancelled_search_stops_and_keeps_its_rows(large, capfd):
    with live(large, capfd, panels=panels()) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.tab("Optimise")
        tab.press("Optimise")
        tab.sees("of about")
        worker = worker_of(page._panels[1], tab)
        tab.press("Cancel")
        tab.sees("Cancelled after")
        assert not worker.running
        tab.page.get_by_role("button", name=re.compile(r"1: 0\.\d ")).wait_for()
        tab.page.get_by_role("button", name="Optimise").wait_for()
