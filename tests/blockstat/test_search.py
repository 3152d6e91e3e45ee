"""The search with the real static solver; the dynamic verifier's place is taken by statics where only the
bookkeeping is tested (the real one is in tests/dynsim)."""

import csv
import math
import re
from dataclasses import dataclass, replace
from enum import Enum
from functools import partial
from types import SimpleNamespace

import pytest

from blockstat import (
    InputError,
    JointLaw,
    Memory,
    Outcome,
    assess,
    build,
    grid,
    latin_hypercube,
    search,
    sweep,
    with_values,
    write,
)
from blockstat.design_search.search import PRUNED, FailureTarget, Margin
from blockstat.design_search.shared_joints import SharedJoints
from blockstat.design_search.space import Space, space_of
from blockstat.spec import Range, parameters, scene_from
from evidence.references.arches import POLY
from evidence.scenes.small import HUT, assembly, box


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
    return search(scene_from(HUT), verify=verifier, **options), verifier


def rows(result):
    """All that a history says, timings aside."""
    return [replace(c, static_seconds=0.0, dynamic_seconds=0.0) for c in result.history]


def arch_of(voussoirs, thickness):
    """An arch of centreline radius 1; its intrados follows its thickness."""
    return scene_from(
        {
            "name": "arch",
            "parameters": {"n": voussoirs, "t": thickness},
            "material": {"friction": 2.0},
            "elements": {
                "arch": {"kind": "arch", "span": "= 2 - t", "thickness": "= t", "depth": 1.0, "voussoirs": "= n"}
            },
        }
    )


def between(low, high, step):
    return {"value": high, "min": low, "max": high, "step": step}


RIBBED = {
    "name": "ribbed",
    "parameters": {"t": between(0.08, 0.2, 0.02), "pier": between(0.2, 0.7, 0.1), "strut": "search"},
    "elements": {
        "arch": {
            "kind": "arch", "span": 2.0, "thickness": "= t", "depth": 0.5, "voussoirs": 9, "at": [0, 0, 1.0],
        },
        "left": {"kind": "box", "size": ["= pier", 0.5, 1.0], "at": ["= -1 - pier / 2", 0, 0]},
        "right": {"kind": "box", "size": ["= pier", 0.5, 1.0], "at": ["= 1 + pier / 2", 0, 0]},
        "prop": {"kind": "box", "size": [0.4, 0.5, 1.0], "at": ["= -1.2 - pier", 0, 0], "present": "= strut"},
    },
}  # fmt: skip


def test_the_paper_starts_at_the_largest_and_simulates_every_candidate():
    result, verifier = run(strategy="paper")
    thicknesses = [c.parameters["wall.thickness"] for c in result.history]
    assert thicknesses[:4] == [0.8, 0.6, 0.4, 0.2]
    assert verifier.calls == len(result.history) == result.dynamic_runs == 5
    for candidate in result.history:
        asm = build(with_values(result.building, candidate.parameters))
        assert candidate.static == assess(asm).outcome.word
        assert candidate.volume == pytest.approx(asm.volume[asm.free].sum())
    standing = [c.parameters for c in result.history if c.stands]
    assert result.best_parameters in standing
    assert result.best_parameters["wall.thickness"] == min(p["wall.thickness"] for p in standing)


def test_a_presence_is_tried_without_and_then_with():
    result = search(scene_from(RIBBED), verify=None, strategy="paper", names=["parameters.strut"])
    assert [c.parameters["parameters.strut"] for c in result.history] == [0.0, 1.0]


def test_only_what_statics_allow_is_simulated():
    result, verifier = run()
    assert verifier.calls == result.dynamic_runs == sum(c.dynamic != PRUNED for c in result.history)
    for candidate in result.history:
        asm = build(with_values(result.building, candidate.parameters))
        assert (candidate.dynamic == PRUNED) == (assess(asm).outcome.word == "unstable")
    assert any(c.dynamic == PRUNED for c in result.history)
    assert result.finished


SPACES = {
    "hut": scene_from(HUT),
    "ribbed": scene_from(RIBBED),
    "arches": arch_of(between(4, 12, 1), between(0.09, 0.11, 0.01)),
    "fine arch": arch_of(9, between(0.08, 0.12, 0.002)),
    "fine hut": scene_from(HUT | {"wall": {"thickness": between(0.2, 0.6, 0.02), "height": 1.5}}),
}


@pytest.mark.parametrize("over", ["line", "grid"])
@pytest.mark.parametrize("reuse", [False, True], ids=["solved", "remembered"])
@pytest.mark.parametrize("name", SPACES)
def test_pruning_changes_nothing_but_the_work(name, reuse, over):
    memory = Memory() if reuse else None
    paper, pruned = Verifier(), Verifier()
    if over == "grid" and name in ("ribbed", "fine hut"):
        pytest.skip("too many designs for what they say")
    whole = search(SPACES[name], verify=paper, strategy="paper", over=over)
    quick = search(SPACES[name], verify=pruned, static=lambda asm: assess(asm, memory=memory), memory=memory, over=over)
    assert whole.best_parameters is not None
    assert quick.best_parameters == whole.best_parameters
    assert pruned.calls < paper.calls
    assert quick.dynamic_runs == pruned.calls
    assert quick.static_solves + quick.certificates_reused == len(quick.history)
    if reuse:
        assert quick.certificates_reused <= memory.statistics["forces"] + memory.statistics["mechanism"]
    if over == "grid":
        standing = [c.volume for c in whole.history if c.stands]
        best = next(c for c in whole.history if c.parameters == whole.best_parameters)
        assert best.volume == min(standing)


def test_arches_are_not_monotone_in_their_voussoirs_and_the_search_does_not_care():
    scene = arch_of(between(4, 10, 1), 0.1005)
    whole = search(scene, verify=None, strategy="paper")
    stands = {int(c.parameters["parameters.n"]): c.stands for c in whole.history}
    least = {n: float(POLY[n]) for n in (4, 5, 6, 8, 10)}
    assert {n: stands[n] for n in least} == {n: t < 0.1005 for n, t in least.items()}
    assert list(least.values()) != sorted(least.values())
    late = arch_of(between(6, 30, 1), 0.1005)
    assert search(late, verify=None).best_parameters == search(late, verify=None, strategy="paper").best_parameters


def test_a_long_line_is_bisected_and_every_smaller_value_is_still_excluded():
    result = search(SPACES["fine arch"], verify=None)
    values = sorted(parameters(SPACES["fine arch"])["parameters.t"].steps())
    asked = [c.parameters["parameters.t"] for c in result.history]
    assert asked[0] == values[len(values) // 2]
    judged = {c.parameters["parameters.t"]: c for c in result.history}
    smaller = [t for t in values if t < result.best_parameters["parameters.t"]]
    assert smaller
    assert all(judged[t].excluded for t in smaller)


def test_nothing_stands():
    for strategy in ("paper", "pruned"):
        result, _ = run(verify=lambda assembly: Judgement(Word.FALLS), strategy=strategy)
        assert result.best is None
        assert result.best_parameters is None
        assert result.disagreements == tuple(c for c in result.history if c.static == "stable")


def test_only_the_named_parameters_move():
    result, _ = run(names=["vault.thickness"])
    assert {tuple(c.parameters) for c in result.history} == {("vault.thickness",)}
    with pytest.raises(InputError, match=r'no parameter "roof"; parameters are: wall\.thickness, vault\.thickness'):
        run(names=["roof"])
    with pytest.raises(InputError, match="may be named once"):
        run(names=["wall.thickness", "wall.thickness"])
    fixed = dict(HUT, wall={"thickness": 0.5}, vault={"thickness": 0.3})
    with pytest.raises(InputError, match='"hut" has no parameter to search'):
        search(scene_from(fixed), verify=Verifier())


@pytest.mark.parametrize(
    ("options", "message"),
    [
        ({"strategy": "magic"}, "strategy is 'magic'; it must be one of: paper, pruned, gradient, pareto"),
        ({"over": "sphere"}, "over is 'sphere'; it must be one of: line, grid"),
        ({"margin": Margin()}, "margin is for strategies"),
        ({"snap": True}, 'snap is for strategies "gradient" and, without a target, "robust"; strategy is "pruned"'),
        ({"snap": True, "strategy": "pareto"}, 'snap is for strategies .* strategy is "pareto"'),
        ({"snap": True, "strategy": "robust", "target": FailureTarget(0.1)}, "snap is for .* without a target"),
        ({"over": "grid", "strategy": "gradient"}, 'over "grid" is for strategies "paper" and "pruned"; .*"gradient"'),
    ],
)
def test_a_bad_option_is_named(options, message):
    with pytest.raises(InputError, match=message):
        run(**options)


@pytest.mark.parametrize("strategy", ["paper", "pruned"])
@pytest.mark.parametrize("stop_after", [1, 2, 3])
def test_an_interrupted_search_goes_on_where_it_stopped(tmp_path, strategy, stop_after):
    whole, verifier = run(strategy=strategy)
    path = tmp_path / "history.csv"

    def interrupt(done, expected, last):
        if done == stop_after:
            raise KeyboardInterrupt

    first, before = run(history=path, progress=interrupt, strategy=strategy)
    assert not first.finished
    assert len(first.history) == stop_after
    second, after = run(history=path, strategy=strategy)
    assert rows(second) == rows(whole)
    assert before.calls + after.calls == verifier.calls
    assert len(list(csv.DictReader(path.open()))) == len(whole.history)


def remembered(path=None, **options):
    """A search whose statics use what earlier designs showed."""
    memory = Memory()
    return search(
        SPACES["fine hut"], verify=options.pop("verify", Verifier()), memory=memory,
        static=lambda asm: assess(asm, memory=memory), history=path, **options,
    )  # fmt: skip


def test_after_an_interruption_verdicts_rest_on_the_same_evidence(tmp_path):
    whole = remembered(tmp_path / "whole.csv")
    assert {c.evidence for c in whole.history} == {"solved", "forces"}
    for stop_after in range(1, len(whole.history), 3):
        path = tmp_path / f"{stop_after}.csv"

        def interrupt(done, expected, last, stop_after=stop_after):
            if done == stop_after:
                raise KeyboardInterrupt

        remembered(path, progress=interrupt)
        assert rows(remembered(path)) == rows(whole)
        assert lines(path) == lines(tmp_path / "whole.csv")


@pytest.mark.parametrize("ahead", [1, 2, 5])
def test_looking_ahead_changes_nothing_in_the_history(tmp_path, ahead):
    whole = remembered(tmp_path / "whole.csv")
    begun, unforeseen, verifier = [], [], Verifier()

    def verify(assembly):
        if not any(assembly is known for known in begun):
            unforeseen.append(assembly)
        return verifier(assembly)

    quick = remembered(tmp_path / "quick.csv", verify=verify, begin=begun.append, speculative=ahead)
    assert rows(quick) == rows(whole)
    assert lines(tmp_path / "quick.csv") == lines(tmp_path / "whole.csv")
    assert not unforeseen
    assert quick.dynamic_runs <= len(begun) < quick.dynamic_runs + ahead
    for stop_after in range(1, len(whole.history), 4):
        path = tmp_path / f"{stop_after}.csv"

        def interrupt(done, expected, last, stop_after=stop_after):
            if done == stop_after:
                raise KeyboardInterrupt

        remembered(path, progress=interrupt, begin=begun.append, speculative=ahead)
        assert rows(remembered(path, begin=begun.append, speculative=ahead)) == rows(whole)
        assert lines(path) == lines(tmp_path / "whole.csv")


def test_designs_that_were_foreseen_behind_the_answer_leave_no_evidence(tmp_path):
    # The top moves along the base, then the base gets narrower; behind the answer of the first line is a fall.
    scene = scene_from(
        {
            "name": "two", "parameters": {"o": between(0.3, 1.05, 0.75), "w": between(0.2, 2.0, 0.3)},
            "elements": {
                "base": {"kind": "box", "size": ["= w", 1.0, 0.5]},
                "top": {"kind": "box", "size": [1.0, 1.0, 1.0], "at": ["= o", 0, 0.5]},
            },
        }
    )  # fmt: skip

    def run_with(**options):
        memory = Memory()
        judge = partial(assess, memory=memory, score=False)
        verify = lambda assembly: Judgement(Word.STANDS)  # noqa: E731
        return search(scene, static=judge, memory=memory, verify=verify, **options), memory.statistics

    alone, counted = run_with()
    ahead, counted_ahead = run_with(begin=lambda assembly: None, speculative=2)
    assert rows(ahead) == rows(alone)
    assert counted_ahead == counted


def lines(path):
    return [{k: v for k, v in row.items() if "seconds" not in k} for row in csv.DictReader(path.open())]


def test_a_history_that_cannot_be_written_is_refused(tmp_path):
    with pytest.raises(InputError, match="no such directory"):
        run(history=tmp_path / "none" / "history.csv")
    with pytest.raises(InputError, match="is a directory; a file is needed"):
        run(history=tmp_path)


@pytest.mark.parametrize("points", [0, -1, 2.5])
def test_a_front_has_a_whole_number_of_points(points):
    with pytest.raises(InputError, match=f"points is {points}; it must be a whole number of at least 1"):
        run(verify=None, strategy="pareto", points=points)


def test_a_search_can_be_called_off():
    asked = []

    def called_off():
        asked.append(1)
        return len(asked) > 3

    result, _ = run(cancel=called_off)
    assert not result.finished
    assert len(result.history) < 4


@pytest.mark.parametrize("cut", [1, 25, 60, 150])
def test_a_row_cut_short_by_a_kill_is_computed_again(tmp_path, cut):
    path = tmp_path / "history.csv"
    whole, _ = run(history=path)
    text = path.read_text()
    path.write_text(text[: len(text) - cut])
    again, _ = run(history=path)
    assert rows(again) == rows(whole)
    assert [row["static"] for row in csv.DictReader(path.open())] == [c.static for c in whole.history]


def test_a_kill_in_the_middle_of_the_header_does_no_harm(tmp_path):
    path = tmp_path / "history.csv"
    path.write_text("wall.thickn")
    result, _ = run(history=path)
    assert len(list(csv.DictReader(path.open()))) == len(result.history)


def test_the_history_of_another_scene_is_refused(tmp_path):
    path = tmp_path / "history.csv"
    run(history=path)
    other = scene_from(HUT | {"length": 2.5})
    with pytest.raises(InputError, match="this history is of another search"):
        search(other, verify=Verifier(), history=path)


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
    result = search(scene_from(scene), verify=Verifier(), names=["windows.south.width"], strategy="paper")
    first = result.history[0]
    assert (first.static, first.dynamic) == ("error", "")
    assert first.note.startswith("windows.south: an opening of 2.5 m width does not fit 2 m")
    assert result.best_parameters == {"windows.south.width": 0.5}


def test_a_design_that_the_verifier_refuses_is_a_row_with_its_reason():
    def refuse(assembly):
        raise InputError("too thin to simulate")

    result, _ = run(verify=refuse)
    assert result.best is None
    assert {(c.dynamic, c.note) for c in result.history} == {("pruned", ""), ("error", "too thin to simulate")}


def test_a_design_that_the_verifier_could_not_judge_is_asked_again(tmp_path):
    def broken(assembly):
        raise InputError("Bullet needs pybullet")

    path = tmp_path / "history.csv"
    failed, _ = run(verify=broken, history=path)
    number = sum(c.dynamic == "error" for c in failed.history)
    assert f"{number} of {len(failed.history)} designs could not be judged: Bullet needs" in failed.explain()
    assert failed.disagreements == ()
    resumed, _ = run(history=path)
    assert rows(resumed) == rows(run()[0])
    paper, _ = run(verify=broken, strategy="paper")
    assert paper.outcome.word == "failed"


def test_what_statics_alone_judged_is_simulated_by_a_search_with_a_verifier(tmp_path):
    path = tmp_path / "history.csv"
    alone, _ = run(verify=None, history=path)
    assert alone.best is not None
    fallen, _ = run(verify=lambda assembly: Judgement(Word.FALLS), history=path)
    assert fallen.best is None
    assert fallen.dynamic_runs > 0


def test_the_history_of_other_files_is_refused(tmp_path):
    path, mesh = tmp_path / "history.csv", tmp_path / "stone.json"
    pier = {"kind": "pier", "size": [between(0.4, 0.6, 0.2), 0.5], "height": 1.0, "courses": 1, "at": [5, 0, 0]}
    elements = {"stone": {"kind": "mesh", "file": str(mesh)}, "pier": pier}
    scene = scene_from({"name": "stones", "elements": elements})
    for top in (1.0, 2.0):
        write(assembly([box((0, 0, 0), (1, 1, top))], supports=[0]), mesh)
        if top == 2.0:
            with pytest.raises(InputError, match="this history is of another search"):
                search(scene, verify=None, history=path)
        else:
            assert search(scene, verify=None, history=path).best is not None


def test_a_best_design_at_an_end_of_a_range_is_told():
    """A pier that stands at any width: the lightest has the least one, the first of a range or the last."""
    ends = "At an end of its range: elements.pier.size.0; a wider range may hold a lighter design."
    for width, told in (([0.4, 0.6], True), ("= 1 - a", True), ([0.6, 0.6], False)):
        free = {"a": between(0.4, 0.6, 0.2)} if isinstance(width, str) else {}
        own = width if isinstance(width, str) else between(*width, 0.2)
        pier = {"kind": "pier", "size": [own, 0.5], "height": 1.0, "courses": 1, "at": [0, 0, 0]}
        scene = scene_from({"name": "stones", "parameters": free, "elements": {"pier": pier}})
        name = "parameters.a" if free else "elements.pier.size.0"
        found = search(scene, verify=None, over="grid")
        assert found.best_parameters == {name: 0.6 if free or not told else 0.4}
        assert (ends.replace("elements.pier.size.0", name) in found.explain().splitlines()) == told


def test_a_search_tells_its_best_design_and_what_it_cost():
    result, _ = run(strategy="paper")
    first, second = result.explain().splitlines()[:2]
    best = ", ".join(f"{name} {value:g}" for name, value in result.best_parameters.items())
    assert first == "Found: the search has a design that stands."
    assert second == f"Best: {best}."
    assert "could not be judged" not in result.explain()
    assert "disagree" not in result.explain()
    fallen, _ = run(strategy="paper", verify=lambda assembly: Judgement(Word.FALLS))
    number = sum(c.static == "stable" for c in fallen.history)
    assert number > 0
    assert fallen.explain().splitlines()[-1] == f"Statics and dynamics disagree on {number}."
    assert "Best" not in fallen.explain()
    assured = SimpleNamespace(
        first=SimpleNamespace(probability=0.0123456), draws=SimpleNamespace(probability=0.02, interval=(0.01, 0.034567))
    )
    told = replace(result, assured=assured).explain().splitlines()
    assert "vault.thickness" in told[2]
    assert told[3] == "Probability of failure 0.0123 to first order; by draws 0.02 (0.01 to 0.0346)."


def test_a_search_of_which_no_design_can_be_built_has_failed():
    wide = {"width": 9.0, "height": 0.5, "sill": 0.5}
    result = search(scene_from(HUT | {"windows": {"south": wide}}), verify=Verifier(), names=["vault.thickness"])
    assert result.outcome.word == "failed"
    assert result.best is None
    told = result.explain().splitlines()
    assert told[0] == "Failed: no design could be judged."
    assert told[-1].startswith("2 of 2 designs could not be judged: windows.south: ")
    assert not any(line.startswith("Best") for line in told)
    part = replace(result, history=(*result.history, replace(result.history[0], static="unstable")))
    assert part.outcome.word == "none_stands"
    assert "2 of 3 designs could not be judged" in part.explain()


def test_joints_go_from_statics_to_the_verifier_unless_they_are_divided_into_cells():
    def blocks(**options):
        return assembly([box((0, 0, -1), (1, 1, 0), group="a"), box((0, 0, 0), (1, 1, 1), group="b")], **options)

    shared = SharedJoints()
    static, dynamic = shared.kept(assess), shared.handed(lambda asm, interfaces=None: interfaces)
    whole, divided = blocks(), blocks(joints=[JointLaw(("a", "b"), compression=100.0)])
    assert dynamic(whole) is None
    verdict = static(whole)
    assert dynamic(whole) is verdict.interfaces is not None
    assert static(divided).interfaces.share is not None
    assert dynamic(divided) is None
    assert shared.handed(len) is len  # a verifier that has no option for them is called as it is


@pytest.mark.parametrize("origin", [0.0, 1.1])
@pytest.mark.parametrize("least", [8, 9, 11])
def test_of_equally_light_designs_of_a_grid_the_first_is_the_answer_wherever_they_stand(least, origin):
    # Two piers p and q wide, in tenths of a metre: their volume grows with p + q alone.
    bars = {name: between(0.3, 0.6, 0.1) for name in "pq"}
    piers = {
        name: {"kind": "pier", "size": [f"= {name}", 0.6], "height": 2.1, "courses": 5, "at": [origin + 3 * k, 0, 0]}
        for k, name in enumerate("pq")
    }
    scene = scene_from({"name": "piers", "parameters": bars, "elements": piers})

    def verify(assembly):
        tenths = assembly.volume[assembly.free].sum() / (0.6 * 2.1 * 0.1)
        return Judgement(Word.STANDS if tenths > least - 0.5 else Word.FALLS)

    first = next(values for values in space_of(scene).grid() if round(10 * sum(values.values())) == least)
    for strategy in ("paper", "pruned"):
        assert search(scene, verify=verify, strategy=strategy, over="grid").best_parameters == first

    def interrupt(done, expected, last):
        if done == expected:
            raise KeyboardInterrupt

    interrupted = search(scene, verify=verify, strategy="paper", over="grid", progress=interrupt)
    assert not interrupted.finished
    assert interrupted.best_parameters == first


@pytest.mark.parametrize("strategy", ["paper", "pruned"])
def test_a_space_whose_largest_design_cannot_be_is_searched(strategy):
    """Of the width 1 - a - b, three of nine designs leave none; of those that leave 0.2 the first is best."""
    bars = {name: between(0.2, 0.6, 0.2) | {"value": 0.2} for name in "ab"}
    block = {"kind": "box", "size": ["= 1 - a - b", 1.0, 1.0]}
    scene = scene_from({"name": "left", "parameters": bars, "elements": {"p": block}})
    found = search(scene, verify=None, strategy=strategy, over="grid")
    assert found.best_parameters == {"parameters.a": 0.6, "parameters.b": 0.2}
    assert found.building == scene
    if strategy == "paper":
        assert [c.static for c in found.history].count("error") == 3
    # Along lines b is tried at the least a that stands beside the largest b, and both end at their least.
    line = search(scene, verify=None, strategy=strategy)
    assert line.best_parameters == {"parameters.a": 0.2, "parameters.b": 0.2}


@pytest.mark.parametrize("outcome", Outcome)
def test_only_what_statics_call_stable_can_disagree_with_a_fall(outcome):
    def static(assembly):
        return SimpleNamespace(outcome=outcome, score=0.0, solver="x", interfaces=None)

    result, _ = run(static=static, verify=lambda assembly: Judgement(Word.FALLS), strategy="paper")
    assert result.dynamic_runs == len(result.history) > 0
    disagreeing = len(result.history) if outcome is Outcome.STABLE else 0
    assert len(result.disagreements) == result.summary()["disagreements"] == disagreeing
    assert ("disagree" in result.explain()) == bool(disagreeing)


LEANING = {
    "name": "wall",
    "parameters": {"b": between(0.1, 0.6, 0.05)},
    "elements": {"wall": {"kind": "box", "size": ["= b", 3.0, 2.0]}},
}


def test_a_history_under_another_tilt_is_not_taken_up(tmp_path):
    """A wall that is 2 m high stands where gravity leans by no more than its width over its height."""
    scene, path = scene_from(LEANING), tmp_path / "history.csv"

    def leaning(share):
        return lambda asm: asm.with_(gravity=(9.81 * share, 0, -9.81))

    assert search(scene, verify=None, history=path, under=leaning(0.14)).best_parameters[
        "parameters.b"
    ] == pytest.approx(0.3)
    assert search(scene, verify=None, history=path, under=leaning(0.14)).best_parameters[
        "parameters.b"
    ] == pytest.approx(0.3)
    with pytest.raises(InputError, match="history"):
        search(scene, verify=None, history=path, under=leaning(0.24))
    alone = search(scene, verify=None, history=tmp_path / "other.csv", under=leaning(0.24))
    assert alone.best_parameters["parameters.b"] == pytest.approx(0.5)


def heavier(block, assembly):
    """Nine times the density of one block."""
    density = assembly.density.copy()
    density[assembly.names.index(block)] *= 9
    return assembly.with_(density=density)


def test_a_history_under_other_masses_of_the_same_sum_is_not_taken_up(tmp_path):
    """Two equal stones on a board that hangs over: with the far one heavier it tips.

    In weights of a stone, the board is 5, and one stone 9. The support ends at 0.25 m, and at x = 0 the board is at
    0.4 m, the stones at 0 and 0.8 m. The middle of all is then at (5 x 0.4 + 0.8) / 15 = 0.19 m with the near one
    heavier, and at (5 x 0.4 + 9 x 0.8) / 15 = 0.61 m with the far one; drawn in by 0.4 m, that is at 0.21 m.
    """
    stone, path = [0.2, 0.5, 0.5], tmp_path / "history.csv"
    elements = {
        "low": {"kind": "box", "size": [0.5, 0.5, 0.5]},
        "board": {"kind": "box", "size": [1, 0.5, 0.5], "at": ["= 0.4 - x", 0, 0.5]},
        "near": {"kind": "box", "size": stone, "at": ["= -x", 0, 1.0]},
        "far": {"kind": "box", "size": stone, "at": ["= 0.8 - x", 0, 1.0]},
    }
    scene = scene_from({"name": "board", "parameters": {"x": between(0.0, 0.4, 0.4)}, "elements": elements})
    masses = [heavier(block, build(scene)).mass.sum() for block in ("near", "far")]
    assert masses[0] == pytest.approx(masses[1], rel=1e-12)
    first = search(scene, verify=None, under=partial(heavier, "near"), history=path)
    assert first.best_parameters == {"parameters.x": 0.0}
    assert search(scene, verify=None, under=partial(heavier, "near"), history=path).history == first.history
    alone = search(scene, verify=None, under=partial(heavier, "far"))
    assert alone.best_parameters == {"parameters.x": 0.4}
    with pytest.raises(InputError, match="this history is of another search"):
        search(scene, verify=None, under=partial(heavier, "far"), history=path)
    with pytest.raises(InputError, match="this history is of another search"):
        search(scene, verify=None, under=lambda asm: asm.with_(friction=0.7 + 1e-9), history=path)


def test_a_history_whose_largest_design_cannot_be_is_not_taken_up_under_another_gravity(tmp_path):
    """A wall 2 m high stands where gravity leans by no more than its width over its height; a pillar ends its place."""
    pillar = {"kind": "box", "size": [0.5, 3.0, 2.0], "at": [0.8, 0, 0]}
    scene = scene_from(LEANING | {"elements": {**LEANING["elements"], "pillar": pillar}} | {
        "parameters": {"b": between(0.2, 1.4, 0.2)}
    })  # fmt: skip
    path = tmp_path / "history.csv"

    def leaning(share):
        return lambda asm: asm.with_(gravity=(9.81 * share, 0, -9.81))

    first = search(scene, verify=None, history=path, under=leaning(0.14), over="grid")
    assert first.best_parameters["parameters.b"] == pytest.approx(0.4)
    with pytest.raises(InputError, match="overlap"):
        build(space_of(scene).at(space_of(scene).start))
    with pytest.raises(InputError, match="history"):
        search(scene, verify=None, history=path, under=leaning(0.22), over="grid")


#: A beam 2.4 m wide, with its middle at x + y, on a block from -0.25 to 0.25: of nine designs one stands.
BEAM = {
    "name": "beam",
    "parameters": {"x": between(0.0, 0.8, 0.4), "y": between(0.0, 0.8, 0.4)},
    "elements": {
        "low": {"kind": "box", "size": [0.5, 0.5, 0.5]},
        "beam": {"kind": "box", "size": [2.4, 0.5, 0.3], "at": ["= x + y", 0, 0.5]},
    },
}


@pytest.mark.parametrize("strategy", ["paper", "pruned"])
def test_where_none_stood_it_is_told_how_many_of_how_many_were_examined(strategy):
    """Along lines x and y are moved one after the other from 0.8: five designs, all of which fall."""
    scene = scene_from(BEAM)
    line = search(scene, verify=None, strategy=strategy)
    assert (line.outcome.word, len(line.history), line.unexamined) == ("none_stands", 5, 4)
    assert line.none_stood == "no design stood of the 5 examined; the space has 9"
    assert line.explain().splitlines()[:2] == [
        "None stands: of the designs that were examined none was found to stand.",
        "No design stood of the 5 examined; the space has 9.",
    ]
    assert line.summary()["unexamined"] == 4
    every = search(scene, verify=lambda assembly: Judgement(Word.FALLS), strategy=strategy, over="grid")
    assert (every.unexamined, every.none_stood) == (0, "no design of the space stood")
    assert search(scene, verify=None, strategy=strategy, over="grid").best_parameters == {
        "parameters.x": 0.0, "parameters.y": 0.0,
    }  # fmt: skip


def test_a_search_between_the_steps_has_not_examined_all():
    """It falls at the largest number, 1, and has no slope that leads to where it stands."""
    away = {"low": BEAM["elements"]["low"], "beam": BEAM["elements"]["beam"] | {"at": ["= 9 * d", 0, 0.5]}}
    scene = scene_from({"name": "beam", "parameters": {"d": between(0.5, 1.0, 0.05)}, "elements": away})
    found = search(scene, verify=None, strategy="gradient")
    assert found.outcome.word == "none_stands"
    assert found.none_stood == f"no design stood of the {len(found.history)} examined; the ranges hold more"
    assert found.summary()["unexamined"] is None


def test_what_is_undecided_not_judged_or_not_built_is_no_fall():
    def open_(assembly):
        return SimpleNamespace(outcome=Outcome.UNDECIDED, score=0.0, solver="x", interfaces=None)

    def broken(assembly):
        raise InputError("the engine is out of order")

    left = search(scene_from(LEANING), verify=None, static=open_, over="grid")
    number = len(left.history)
    assert (left.outcome.word, left.undecided, number) == ("none_stands", number, 11)
    assert left.none_stood == "no design stood of the 11 examined (11 undecided)"
    # A wall b wide and 2 m high stands where gravity leans by b / 2: at 0.22 from 0.45 on, so 7 fall, and 4 are open.
    leaning = {"under": lambda asm: asm.with_(gravity=(9.81 * 0.22, 0, -9.81)), "over": "grid"}
    unjudged = search(scene_from(LEANING), verify=broken, **leaning)
    assert unjudged.outcome.word == "none_stands"
    assert unjudged.none_stood == "no design stood of the 11 examined (4 not judged)"
    assert search(scene_from(LEANING), verify=lambda asm: Judgement(Word.FALLS), static=open_).undecided == 0
    # Of the width 1 - a - b of test_a_space_whose_largest_design_cannot_be_is_searched, three of nine leave none.
    bars = {name: between(0.2, 0.6, 0.2) | {"value": 0.2} for name in "ab"}
    block = {"kind": "box", "size": ["= 1 - a - b", 1.0, 1.0]}
    fallen = search(
        scene_from({"name": "left", "parameters": bars, "elements": {"p": block}}),
        verify=lambda assembly: Judgement(Word.FALLS), over="grid",
    )  # fmt: skip
    assert fallen.none_stood == "no design stood of the 9 examined (3 cannot be built)"


def test_one_design_is_told_in_the_singular():
    found = search(scene_from(LEANING | {"parameters": {"b": between(0.6, 0.6, 0.05)}}), verify=None)
    assert "1 design: 1 static solve, " in found.explain()


def test_what_is_no_scene_is_refused_with_what_makes_one(tmp_path):
    built = build(scene_from(LEANING))
    for given, words in (
        (built, "of type Assembly, which has no ranges; it must be a Scene, as blockstat.load_scene makes one of a"),
        ("wall.toml", "'wall.toml'; it must be a Scene, as blockstat.load_scene makes one of a file"),
        (tmp_path, f"'{tmp_path}'; it must be a Scene"),
        (3, "of type int; it must be a Scene"),
    ):
        for ask in (
            lambda given=given: search(given, verify=None),
            lambda given=given: space_of(given),
            lambda given=given: grid(given),
            lambda given=given: latin_hypercube(given, 2),
            lambda given=given: sweep(given, [{}], tmp_path / "rows.jsonl"),
        ):
            with pytest.raises(InputError, match=re.escape(f"scene is {words}")):
                ask()
    assert not (tmp_path / "rows.jsonl").exists()


@pytest.mark.parametrize(
    ("option", "words"),
    [
        ({"margin": 0.1}, "margin is 0.1; it must be a blockstat.Margin, such as Margin((0, 1, 0), 0.1)"),
        ({"margin": ((0, 1, 0), 0.1)}, "margin is ((0, 1, 0), 0.1); it must be a blockstat.Margin, such as"),
        ({"target": 0.01}, "target is 0.01; it must be a blockstat.FailureTarget"),
        ({"imperfections": 0.01}, "imperfections is 0.01; it must be a blockstat.Imperfections"),
    ],
)
def test_an_option_of_another_kind_is_told_by_its_own(option, words):
    with pytest.raises(InputError, match=re.escape(words)):
        search(scene_from(LEANING), verify=None, strategy="gradient", **option)


@pytest.mark.parametrize("ask", [space_of, grid, lambda scene, names: latin_hypercube(scene, 2, names=names)])
def test_names_are_read_alike_wherever_parameters_are_named(ask):
    scene = scene_from(BEAM)

    def named(found):
        return found.names if isinstance(found, Space) else list(found[0])

    assert named(ask(scene, "parameters.y")) == named(ask(scene, ["parameters.y"])) == ["parameters.y"]
    assert named(ask(scene, ("parameters.y", "parameters.x"))) == ["parameters.y", "parameters.x"]
    for names, words in (
        (["parameters.x", "parameters.x"], "are parameters.x, parameters.x; each may be named once"),
        ([], "names is []; it must name at least one parameter of: parameters.x, parameters.y"),
        (3, "names is 3; it must name at least one"),
        ("z", 'no parameter "z"; parameters are: parameters.x, parameters.y'),
    ):
        with pytest.raises(InputError, match=re.escape(words)):
            ask(scene, names)


def test_the_least_of_a_range_to_nothing_has_no_sign():
    """0.3 - 3 x 0.1 is a little below zero in binary numbers."""
    for value in [*Range(0.3, 0.0, 0.3, 0.1).steps(), *Range(0.3, -0.0, 0.3, 0.2).steps()]:
        assert math.copysign(1.0, value) == 1.0


@pytest.mark.parametrize(
    ("verify", "words"), [(assess, "a static verdict"), (lambda asm: True, "a bool"), (lambda asm: None, "a NoneType")]
)
def test_what_is_no_dynamic_verdict_is_refused(verify, words):
    with pytest.raises(InputError, match=f"verify gave {words}; it must give a verdict that stands or falls"):
        search(scene_from(LEANING), verify=verify)
