"""The search with the real static solver; the dynamic verifier's place is taken by statics where only the
bookkeeping is tested (the real one is in tests/dynsim)."""

import csv
from dataclasses import dataclass
from enum import Enum

import pytest

from blockstat import InputError, assess, build, search, with_values
from blockstat.search import PRUNED
from blockstat.spec import scene_from
from problems import HUT


class Word(Enum):
    STANDS = 0
    FALLS = 1

    @property
    def word(self):
        return self.name.lower()


@dataclass
class Judgement:
    outcome: Word


class Verifier:
    """Stands where statics leave room: at a tilt of two degrees."""

    def __init__(self):
        self.calls = 0

    def __call__(self, assembly):
        self.calls += 1
        verdict = assess(assembly, gravity=(0, 0.35, -9.8))
        return Judgement(Word.STANDS if verdict.outcome.word == "stable" else Word.FALLS)


def run(**options):
    verifier = options.pop("verify", Verifier())
    return search(scene_from(HUT), static=assess, verify=verifier, **options), verifier


def words(result):
    return [(tuple(c.parameters.values()), c.static, c.dynamic, c.volume) for c in result.history]


def test_values_go_down_and_only_what_statics_allow_is_verified():
    result, verifier = run()
    thicknesses = [c.parameters["wall.thickness"] for c in result.history]
    assert thicknesses[:4] == [0.8, 0.6, 0.4, 0.2]
    assert verifier.calls == sum(c.dynamic != PRUNED for c in result.history)
    for candidate in result.history:
        asm = build(with_values(result.building, candidate.parameters))
        assert (candidate.dynamic == PRUNED) == (assess(asm).outcome.word == "unstable")
        assert candidate.volume == pytest.approx(asm.volume[asm.free].sum())
    assert any(c.dynamic == PRUNED for c in result.history)


def test_the_best_is_the_smallest_that_stands():
    result, _ = run()
    standing = [c for c in result.history if c.stands]
    assert result.best_parameters in [c.parameters for c in standing]
    assert min(c.parameters["wall.thickness"] for c in standing) == result.best_parameters["wall.thickness"]
    assert result.finished


def test_nothing_stands():
    result, _ = run(verify=lambda assembly: Judgement(Word.FALLS))
    assert result.best is None
    assert result.best_parameters is None


def test_only_the_named_parameters_move():
    result, _ = run(names=["vault.thickness"])
    assert {tuple(c.parameters) for c in result.history} == {("vault.thickness",)}
    with pytest.raises(
        InputError, match=r'no parameter "roof" to search; ranges are: wall\.thickness, vault\.thickness'
    ):
        run(names=["roof"])
    fixed = dict(HUT, wall={"thickness": 0.5}, vault={"thickness": 0.3})
    with pytest.raises(InputError, match='"hut" has no parameter to search'):
        search(scene_from(fixed), static=assess, verify=Verifier())


@pytest.mark.parametrize("stop_after", [1, 2, 3, 4])
def test_an_interrupted_search_goes_on_where_it_stopped(tmp_path, stop_after):
    whole, verifier = run()
    path = tmp_path / "history.csv"

    def interrupt(done, expected, last):
        if done == stop_after:
            raise KeyboardInterrupt

    first, before = run(history=path, progress=interrupt)
    assert not first.finished
    assert len(first.history) == stop_after
    second, after = run(history=path)
    assert words(second) == words(whole)
    assert before.calls + after.calls == verifier.calls
    assert len(list(csv.DictReader(path.open()))) == len(whole.history)


def test_a_row_cut_short_by_a_kill_is_computed_again(tmp_path):
    path = tmp_path / "history.csv"
    whole, _ = run(history=path)
    text = path.read_text()
    path.write_text(text[: len(text) - 25])
    again, _ = run(history=path)
    assert words(again) == words(whole)
    assert [row["static"] for row in csv.DictReader(path.open())] == [c.static for c in whole.history]


def test_the_history_of_another_scene_is_refused(tmp_path):
    path = tmp_path / "history.csv"
    run(history=path)
    other = scene_from(HUT | {"length": 2.5})
    with pytest.raises(InputError, match="this history is of another search"):
        search(other, static=assess, verify=Verifier(), history=path)


def test_a_design_that_cannot_be_built_is_a_row_with_its_reason():
    scene = HUT | {
        "windows": {
            "south": {
                "width": {"value": 0.5, "min": 0.5, "max": 2.5, "step": 1.0},
                "height": 0.5,
                "sill": 0.5,
            }
        }
    }
    result = search(scene_from(scene), static=assess, verify=Verifier(), names=["windows.south.width"])
    first = result.history[0]
    assert (first.static, first.dynamic) == ("error", "")
    assert first.note.startswith("windows.south: 1 openings of 2.5 m")
    assert result.best_parameters == {"windows.south.width": 0.5}
