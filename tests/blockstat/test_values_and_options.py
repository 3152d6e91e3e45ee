"""Rules that hold for every module of the judged rooms: values are frozen, and no argument is nameless."""

import importlib.util
import inspect
import sys
from dataclasses import is_dataclass
from pathlib import Path

import pytest

import blockstat
from evidence.mutation.mutations import SOURCE, files

#: What is filled while a program runs, and is handed to nobody.
FILLED = {"_Evidence", "_Member", "_Film"}


MODULES = [path.relative_to(SOURCE) for path in files()]


def loaded(path, monkeypatch):
    """The classes and functions that a module defines, from a copy of it that is loaded anew."""
    name = ".".join(["copy", *path.with_suffix("").parts])
    spec = importlib.util.spec_from_file_location(name, Path(blockstat.__file__).parents[1] / path)
    module = importlib.util.module_from_spec(spec)
    monkeypatch.setitem(sys.modules, name, module)
    spec.loader.exec_module(module)
    return [value for value in vars(module).values() if getattr(value, "__module__", None) == name]


@pytest.mark.parametrize("path", MODULES, ids=str)
def test_values_are_frozen_and_arguments_have_names(path, monkeypatch):
    for thing in loaded(path, monkeypatch):
        own = [thing] if inspect.isfunction(thing) else []
        if inspect.isclass(thing):
            if is_dataclass(thing):
                assert thing.__dataclass_params__.frozen is (thing.__name__ not in FILLED), thing
            own = [value for name, value in vars(thing).items() if inspect.isfunction(value) and name != "_replace"]
        for function in own:
            kinds = {parameter.kind for parameter in inspect.signature(function).parameters.values()}
            assert inspect.Parameter.POSITIONAL_ONLY not in kinds, function
