"""A word that is not among those allowed is refused by an error that names the element and lists them all."""

import importlib
import importlib.util
import inspect
import json
from pathlib import Path

import pytest

import blockstat as bs
from blockstat import InputError, build, scene_from
from blockstat.model.kinds import KINDS
from evidence.scenes.small import stack

BAD = "xyzzy"
FLOWS = ("associated", "coulomb")
SOLVERS = ("auto", "interior-point", "clarabel", "cvxpy")
UP = ("x", "y", "z", "-x", "-y", "-z")
UNITS = ("m", "dm", "cm", "mm", "in", "ft")
ARCHES = ("semicircular", "segmental", "horseshoe", "pointed", "elliptic")
ENGINES = ("bullet", "lmgc90")
STRATEGIES = ("paper", "pruned", "gradient", "pareto", "robust")
PULSES = ("rectangle", "half-sine", "sine", "triangle")
WITH_BULLET = importlib.util.find_spec("pybullet") is not None


def scene(**changes):
    pier = {"kind": "pier", "size": [0.5, 0.5], "height": 1.0, "courses": 2}
    return scene_from({"name": "gate", "elements": {"post": pier}} | changes)


def element(**keys):
    return lambda: build(scene_from({"name": "gate", "elements": {"part": keys}, "supports": ["part"]}))


def hut(**changes):
    return lambda: scene_from({"name": "hut", "length": 3.0, "span": 2.0} | changes)


def wall(**keys):
    runs = {"front": {"path": [[0, 0], [4, 0]], "thickness": 0.4, "height": 2.0} | keys}
    return element(kind="walls", brick=[0.4, 0.2], runs=runs)


def opening(**keys):
    return wall(openings=[{"width": 0.8, "height": 1.0, "sill": 0.4} | keys])


def command(program, *words):
    """A command line, with FILE for three blocks on a ground and SCENE for a scene."""

    def run():
        if program == "dynsim" and not WITH_BULLET:
            pytest.skip("pybullet is not installed")
        bs.write(stack(3), "FILE.json")
        Path("SCENE.toml").write_text(SEARCHED)
        Path("RECORD.csv").write_text("0,1\n1,2\n")
        app = importlib.import_module(f"{program}.cli.commands").app
        app([{"FILE": "FILE.json", "SCENE": "SCENE.toml"}.get(word, word) for word in words], standalone_mode=False)

    return run


SEARCHED = """
length = 3.0
span = 2.0
wall = { thickness = { value = 0.6, min = 0.2, max = 0.8, step = 0.2 } }
"""


def plan(step):
    def run():
        Path("plan.json").write_text(json.dumps({"steps": [step]}))
        bs.read_plan("plan.json", stack(3))

    return run


ARCH = {"kind": "arch", "span": 2.0, "thickness": 0.3, "depth": 1.0, "voussoirs": 9}

#: By name: what is called with the wrong word, what the message must name, and all the words that it must list.
CASES = {
    # Scene files.
    "kind of an element": (element(kind=BAD), "elements.part.kind", tuple(KINDS)),
    "kind that is a list": (element(kind=[BAD]), "elements.part.kind", tuple(KINDS)),
    "shape of an arch": (element(**ARCH, shape=BAD), "elements.part: shape", ARCHES),
    "joints of an arch": (element(**ARCH, joints=BAD), "elements.part: joints", ("radial", "vertical")),
    "bond of a pier": (
        element(kind="pier", size=[1, 1], height=1, courses=2, bond=BAD), "elements.part.bond", ("single", "halves"),
    ),
    "bond of a wall": (
        wall(bond=BAD), "elements.part.runs.front.bond", ("running", "stack", "english", "flemish")
    ),
    "side of a wall": (wall(align=BAD), "elements.part.runs.front.align", ("centre", "left", "right")),
    "head of an opening": (
        opening(head=BAD), 'wall "front": openings[0]: head',
        ("lintel", "flat", "semicircular", "segmental", "pointed", "elliptic"),
    ),
    "wall of a door": (hut(doors={BAD: {"width": 1, "height": 2}}), f"doors.{BAD}", ("south", "north", "west", "east")),
    "kind of a load": (lambda: scene(loads={"wind": {"kind": BAD}}), "loads.wind.kind", ("point", "surface", "fill")),
    "load of a case": (lambda: scene(cases={"a": {"live": {BAD: 1}}}), f"cases.a.live.{BAD}", ()),
    "kind of a random variable": (
        lambda: scene(uncertain={"friction": {"kind": BAD}}), "uncertain.friction.kind",
        ("normal", "lognormal", "uniform"),
    ),
    "each of a random variable": (
        lambda: scene(uncertain={"friction": {"kind": "uniform", "least": 0, "most": 1, "each": BAD}}),
        "uncertain.friction.each", ("all", "group", "course", "block", "joint"),
    ),
    "group of the supports": (lambda: build(scene(supports=[BAD])), "supports", ("post.pier",)),
    "group of a joint": (lambda: build(scene(joints=[{"between": [BAD, "*"]}])), "joint law", ("post.pier", "ground")),
    # Files.
    "suffix": (lambda: bs.read(f"a.{BAD}"), f"a.{BAD}", (".json", ".toml", ".obj", ".glb", ".stl", ".ply")),
    "suffix to write": (
        lambda: bs.write(stack(3), f"a.{BAD}"), f"a.{BAD}", (".json", ".obj", ".glb", ".stl", ".ply")
    ),
    "example": (
        command("blockstat", "example", BAD), f'no example "{BAD}"', ("chapel", "tower"),
    ),
    "key of a plan's step": (plan({BAD: ["stone0"]}), "step 0", ("install", "hold", "in", "out", "robots")),
    "block of a plan's step": (plan({"install": [BAD]}), "step 0", ("stone0", "stone2")),
    "parameter of a sweep": (lambda: list(bs.grid(scene(), [BAD])), f'no parameter "{BAD}"', ()),
    # Options of commands.
    "--units": (command("blockstat", "check", "FILE", "--units", BAD), "units", UNITS),
    "--up": (command("blockstat", "check", "FILE", "--up", BAD), "up is", UP),
    "--flow": (command("blockstat", "check", "FILE", "--flow", BAD), "flow", FLOWS),
    "--solver": (command("blockstat", "check", "FILE", "--solver", BAD), "solver", SOLVERS),
    "--case": (command("blockstat", "check", "FILE", "--case", BAD), f'no case "{BAD}"', ()),
    "--tilt": (command("blockstat", "check", "FILE", "--tilt", f"{BAD},1"), "--tilt", ("x", "y", "z")),
    "tilt": (command("blockstat", "tilt", "FILE", "--axis", BAD), "axis is", ("x", "y", "z")),
    "--control": (
        command("blockstat", "capacity", "FILE", "--load", "1,0,0", "--control", BAD), f'no control "{BAD}"',
        ("stone0", "mean"),
    ),
    "--reserve": (
        command("blockstat", "plot", "FILE", "-o", "a.png", "--load", "1,0,0", "--reserve", BAD), "--reserve",
        ("edge", "friction", "corner"),
    ),
    "--uncertain": (
        command("blockstat", "reliability", "FILE", "--uncertain", f"friction={BAD},0.5,0.1"), "kind",
        ("normal", "lognormal", "uniform"),
    ),
    "key of --uncertain": (
        command("blockstat", "reliability", "FILE", "--uncertain", f"{BAD}=normal,0.5,0.1"), f'uncertain "{BAD}"',
        ("friction", "edge", "corner", "push", "density.GROUP", "loads.GROUP"),
    ),
    "key of --imperfection": (
        command("blockstat", "check", "FILE", "--imperfection", f"{BAD}=1"), "--imperfection",
        ("edge", "friction", "density", "loads"),
    ),
    "--engine": (command("dynsim", "verify", "FILE", "--engine", BAD), "engine", ENGINES),
    "--engines": (command("dynsim", "compare", "FILE", "--engines", BAD), "engine", ENGINES),
    "--preset": (command("dynsim", "verify", "FILE", "--preset", BAD), "preset", ("fast", "default", "careful")),
    "--group": (command("dynsim", "verify", "FILE", "--group", BAD), f'no group "{BAD}"', ()),
    "--tilt-to": (command("dynsim", "verify", "FILE", "--tilt-to", f"{BAD},1"), "--tilt-to", ("x", "y", "z")),
    "--pulse": (command("dynsim", "shake", "FILE", "--pulse", f"1,0,0,1,{BAD}"), "pulse", PULSES),
    "--measure": (
        command("dynsim", "ida", "FILE", "--record", "RECORD.csv", "--measure", BAD), "measure", ("pga", "pgv"),
    ),
    "--strategy": (command("dynsim", "optimise", "SCENE", "-o", "out", "--strategy", BAD), "strategy", STRATEGIES),
    "--over": (command("dynsim", "optimise", "SCENE", "-o", "out", "--over", BAD), "over", ("line", "grid")),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_a_wrong_word_is_refused_with_all_that_are_allowed(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    call, element, words = CASES[name]
    refused(call, element, words)


def refused(call, element, words):
    with pytest.raises(InputError) as error:
        call()
    message = str(error.value)
    assert "\n" not in message
    assert element in message
    assert BAD in message
    given = message.replace(BAD, "")
    assert [word for word in words if word not in given] == []


#: Options of the Python interface whose value is one of some words, and the words.
WORDS = {
    "flow": FLOWS,
    "solver": SOLVERS,
    "engine": ENGINES,
    "least": ("total", "peak"),
    "strategy": STRATEGIES,
    "over": ("line", "grid"),
    "units": UNITS,
    "up": UP,
    "format": ("compas-assembly", "compas-model"),
    "choice": ("verdict", "demand", "tension", "group", "displacement"),
    "soil": ("A", "B", "C", "D", "E"),
    "kind": ("normal", "lognormal", "uniform"),
    "each": ("all", "group", "course", "block", "joint"),
    "what": ("edge", "friction", "corner"),
    "measure": ("pga", "pgv"),
    "shape": (),  #: of a pulse, or of a verification
}


def options():
    """Functions and classes that are given such words, and the option."""
    for module in (bs, importlib.import_module("dynsim")) if WITH_BULLET else (bs,):
        for name in module.__all__:
            thing = getattr(module, name)
            if name in RESULTS or not callable(thing) or (isinstance(thing, type) and issubclass(thing, Exception)):
                continue
            for option, own in inspect.signature(thing).parameters.items():
                if option in WORDS and "str" in str(own.annotation):
                    yield module.__name__, name, option


#: Results, which nobody makes; they hold the word that was given.
RESULTS = (
    "Assessment",
    "Bracket",
    "Falsework",
    "IncrementalAnalysis",
    "NonlinearCheck",
    "PathEvent",
    "Reliability",
    "RemovalVerdict",
    "Run",
    "Verdict",
)


def given(name):
    """What a function needs beside the option."""
    tie = bs.Tie(("ground", "stone2"), ((-1.0, 0, 0), (0, 0, 3)))
    blocks = stack(3).with_(ties=[tie]) if name == "tie_range" else stack(3)
    post = {"kind": "pier", "size": [0.5, 0.5], "height": 1.0, "courses": 2}
    return {
        "assembly": blocks,
        "axis": (1, 0, 0),
        "axles": [(0.0, 1.0)],
        "building": scene_from({"name": "gate", "elements": {"post": post}}),
        "curve": None,
        "direction": (1, 0, 0),
        "directory": "out",
        "duration": 1.0,
        "first": 0.0,
        "found": None,
        "held_at_most": 1,
        "kind": "normal",
        "load": (1, 0, 0),
        "moves": [],
        "one": (1, 0, 0),
        "options": None,
        "path": "FILE.json" if name == "read" else "a.json",
        "peak": (1, 0, 0),
        "place": "a.png",
        "plan": bs.Plan(()),
        "records": [],
        "props": bs.hoists if name == "least_centring" else [],
        "second": 1.0,
        "source": "FILE.json",
        "state": ["stone0"],
        "states": [["stone0"]],
        "supports": [0],
        "two": (0, 1, 0),
        "verdict": bs.assess(blocks),
        "verify": None,
    }


@pytest.mark.parametrize(("module", "name", "option"), list(options()))
def test_a_wrong_option_is_refused_with_all_that_are_allowed(module, name, option, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    if name in ("interactive_html", "show"):
        pytest.importorskip("viser")
    bs.write(stack(3), "FILE.json")
    function = getattr(importlib.import_module(module), name)
    needed = given(name)
    values = {
        own.name: needed[own.name]
        for own in inspect.signature(function).parameters.values()
        if own.default is own.empty and own.name != option and own.kind is not own.VAR_KEYWORD
    }
    words = {"Pulse": PULSES, "nonlinear_check": ("curve", "line")}.get(name, WORDS[option])
    if (name, option) == ("write", "format"):
        words = ("native", *words)
    refused(lambda: function(**values, **{option: BAD}), "", words)


BUTTRESS = {"wall": "front", "width": 0.4, "projection": 0.5, "height": 1.0}


@pytest.mark.parametrize(
    ("part", "sentence"),
    [
        (opening(widht=1.0), r"openings\[0\].widht: unknown key; keys here are: present, width, height, "),
        (wall(buttresses=[]), "runs.front.buttresses: unknown key; keys here are: name, present, path"),
        ("buttresses[0].projecton", r"buttresses\[0\].projecton: unknown key; keys here are: present, wall, width, "),
        ("buttresses[0].side", r"buttresses\[0\].side: .*'xyzzy'; it must be one of: left, right"),
        (
            element(kind="arc_wall", radius=3, thickness=0.4, height=2, openings=[{"widht": 1}]),
            r"openings\[0\].widht: unknown key; keys here are: ",
        ),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_a_misspelt_word_in_a_list_of_tables_is_told_with_the_words_there_are(part, sentence):
    if isinstance(part, str):
        runs = {"front": {"path": [[0, 0], [4, 0]], "thickness": 0.4, "height": 2.0}}
        row = BUTTRESS | {part.partition(".")[2]: BAD}
        part = element(kind="walls", brick=[0.4, 0.2], runs=runs, buttresses=[row])
    with pytest.raises(InputError, match=r"elements.part.*" + sentence):
        part()


PIER = {"kind": "pier", "size": [0.5, 0.5], "height": 1.0, "courses": 2}


@pytest.mark.parametrize(
    ("part", "key"),
    [
        (element(**PIER, present="serch"), "elements.part.present"),
        (element(**PIER, present=2), "elements.part.present"),
        (wall(present="serch"), "elements.part.runs.front.present"),
        (opening(present="serch"), r"elements.part.runs.front.openings\[0\].present"),
        (hut(vault={"present": "serch"}), "vault.present"),
        (hut(doors={"south": {"width": 1, "height": 1, "present": "serch"}}), "doors.south.present"),
    ],
    ids=lambda value: value if isinstance(value, str) else "",
)
def test_what_may_be_there_is_there_or_not_or_searched(part, key):
    with pytest.raises(InputError, match=f'^{key}: it must be true, false or "search"$'):
        part()
