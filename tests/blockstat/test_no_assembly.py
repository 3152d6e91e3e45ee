"""What is no Assembly is refused, with what makes one."""

import inspect
from pathlib import Path

import pytest

import blockstat
import dynsim
from blockstat import InputError, scene_from

NEED_ONE = [
    (function, place, name)
    for package in (blockstat, dynsim)
    for function in (getattr(package, name) for name in package.__all__)
    if inspect.isfunction(function)
    for place, (name, found) in enumerate(inspect.signature(function).parameters.items())
    if found.annotation == "Assembly"
]
PIER = scene_from({"name": "pier", "elements": {"p": {"kind": "pier", "size": [1, 1], "height": 1, "courses": 2}}})


def test_most_functions_of_both_packages_need_an_assembly():
    assert len(NEED_ONE) > 60


@pytest.mark.parametrize(("function", "place", "name"), NEED_ONE, ids=lambda value: getattr(value, "__name__", ""))
def test_a_scene_is_refused_where_an_assembly_is_needed(function, place, name):
    words = f"{name} is a Composition; it must be an Assembly: .* blockstat.build of a scene"
    others = [other for other, found in inspect.signature(function).parameters.items() if found.default is found.empty]
    with pytest.raises(InputError, match=words):
        function(**({other: None for other in others if other != "options"} | {name: PIER}))
    with pytest.raises(InputError, match=words):
        function(*[None] * place, PIER, *[None] * (len(others) - place - 1))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ("tiny.toml", "assembly is a str, 'tiny.toml'; it must be an Assembly: blockstat.read makes one of a file"),
        (Path("tiny.toml"), "assembly is a PosixPath, 'tiny.toml'; it must be"),
        (None, "assembly is a NoneType; it must be"),
        ([1, 2], "assembly is a list; it must be"),
    ],
    ids=str,
)
def test_the_error_says_what_was_given_for_an_assembly(given, words):
    with pytest.raises(InputError, match=words):
        blockstat.assess(given)


@pytest.mark.parametrize("function", [dynsim.verify_many, dynsim.compare], ids=lambda function: function.__name__)
@pytest.mark.parametrize(
    ("given", "words"),
    [("a.toml", "assembly is a str"), (PIER, "assembly is a Comp"), ([PIER], "assembly 0 is a Comp")],
)
def test_each_of_several_assemblies_must_be_one(function, given, words):
    with pytest.raises(InputError, match=words):
        function(given)
