"""The examples in docstrings run."""

import doctest
from importlib import import_module

import pytest

from test_architecture import MODULES

WITH_EXAMPLES = sorted(name for name, path in MODULES.items() if ">>> " in path.read_text())


@pytest.mark.parametrize("module", WITH_EXAMPLES)
def test_the_examples_of_a_module_run(module, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)  # examples may write files
    result = doctest.testmod(import_module(module))
    assert result.attempted > 0
    assert result.failed == 0
