"""The examples in docstrings run, and those of public names run by themselves."""

import doctest
import inspect
from importlib import import_module

import pytest

import blockstat
import blockstat.model
import dynsim
from test_architecture import MODULES

WITH_EXAMPLES = sorted(name for name, path in MODULES.items() if ">>> " in path.read_text())
PUBLIC = [
    example
    for package in (blockstat, blockstat.model, dynsim)
    for name in package.__all__
    if inspect.isroutine(made := getattr(package, name)) or inspect.isclass(made)
    for example in doctest.DocTestFinder().find(made, f"{package.__name__}.{name}", module=False, globs={})
    if example.examples
]


@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_the_examples_of_a_module_run(module, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # examples may write files
    result = doctest.testmod(import_module(module))
    assert result.attempted > 0
    assert result.failed == 0


def test_most_public_names_have_examples():
    assert len(PUBLIC) > 100


@pytest.mark.parametrize("example", PUBLIC, ids=lambda example: example.name)
def test_who_copies_the_example_of_a_public_name_has_all_that_it_needs(example, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    said = []
    failed, _ = doctest.DocTestRunner(verbose=False).run(example, out=said.append, clear_globs=False)
    assert not failed, "".join(said)
