"""An error names the file that its cause came from."""

import pytest

from blockstat import Assembly, InputError, Random, box, reliability, write

BARE = Assembly.from_blocks([box((0, 0, 0), (1, 1, 1)), box((0, 0, 1), (1, 1, 2))])
SCENE = """name = "gate"
[elements.ring]
kind = "arch"
span = 2.0
thickness = 0.3
depth = 0.5
voussoirs = 5
"""
NORMAL = 'kind = "normal"\nmean = 0.6\n'


@pytest.mark.parametrize(
    "question",
    [["check"], ["limit", "--load", "1,0,0"], ["reliability", "--uncertain", "friction=normal,0.6,0.1"], ["friction"]],
    ids=lambda question: question[0],
)
def test_a_file_without_supports_is_named(tmp_path, run_command, question):
    from blockstat.cli.commands import app

    path = write(BARE, tmp_path / "bare.json")
    status, _, said = run_command(app, "blockstat", question[0], path, *question[1:])
    assert (status, " ".join(said.split())) == (
        2,
        f'blockstat: {path}: "assembly" has no supports; list the blocks that cannot move under "supports"',
    )


def test_what_needs_no_supports_reads_a_file_without(tmp_path, run_command):
    from blockstat.cli.commands import app

    path = write(BARE, tmp_path / "bare.json")
    assert run_command(app, "blockstat", "convert", path, "-o", tmp_path / "bare.obj")[0] == 0
    assert run_command(app, "blockstat", "plot", path, "--plain", "-o", tmp_path / "bare.svg")[0] == 0


def test_random_variables_of_what_has_no_supports():
    with pytest.raises(InputError, match='"assembly" has no supports'):
        reliability(BARE, {"friction": Random("normal", 0.6, 0.1)}, draws=5)


@pytest.mark.parametrize(
    ("table", "question", "sentence"),
    [
        ('[[stages]]\nname = "x"\ncentring = ["ring"]', "sequence --stages", ': stages.0 ("x"): block "ring.arch.0"'),
        (
            f"[uncertain.friction]\n{NORMAL}deviation = 1e300",
            "reliability",
            ", line 8: uncertain.friction: normal: ",
        ),
        (
            f'[uncertain.corner]\n{NORMAL}deviation = 0.1\neach = "block"',
            "reliability",
            ', line 8: uncertain.corner: each is "block"',
        ),
        (f"[uncertain.loads.ring]\n{NORMAL}deviation = 0.1", "reliability", ", line 8: uncertain.loads.ring: there "),
    ],
)
def test_a_scene_with_bad_stages_or_random_variables_is_named(tmp_path, run_command, table, question, sentence):
    from blockstat.cli.commands import app

    path = tmp_path / "gate.toml"
    path.write_text(SCENE + table)
    command, *more = question.split()
    status, _, said = run_command(app, "blockstat", command, path, *more)
    assert status == 2
    assert f"blockstat: {path}{sentence}" in " ".join(said.split())


def test_a_scene_is_not_blamed_for_another_file(tmp_path, run_command):
    from blockstat.cli.commands import app

    path, draws = tmp_path / "gate.toml", tmp_path / "draws.jsonl"
    path.write_text(SCENE + f"[uncertain.friction]\n{NORMAL}deviation = 0.1")
    draws.write_text('{"draws": "blockstat reliability", "of": "another"}\n')
    status, _, said = run_command(app, "blockstat", "reliability", path, "--draws", 5, "-o", draws)
    assert status == 2
    assert said.startswith(f"blockstat: {draws}")
