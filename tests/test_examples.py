"""The scripts of examples/ run, and print the verdicts that their texts promise."""

import importlib.util

import pytest


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("dome", ["stable", "stable", "unstable", "stable"]),
        ("cross_vault", ["unstable", "unstable", "stable", "stable"]),
        ("freeform", ["unstable", "stable", "stable"]),
    ],
)
def test_example(root, capsys, name, words):
    spec = importlib.util.spec_from_file_location(f"example_{name}", root / "examples" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    module.main()
    assert [line.split()[-1] for line in capsys.readouterr().out.splitlines()] == words
