"""docs/command_line.md and docs/command_line are what the commands say, and pages call the commands as they are."""

import re
import shlex

import pytest

from evidence.pages import command_line
from extras import links

#: A command as pages show it: indented, perhaps on several lines, with a remark behind it.
SHOWN = re.compile(r"^    ((?:blockstat|dynsim) (?:.*\\\n)*.*)$", re.MULTILINE)
BY_HAND = [page for page in links.pages() if "command_line" not in str(page)]
TASKS = [page for page in BY_HAND if page.parent.name == "howto" or page.stem in ("README", "quick_start")]
FILE = r"[\w./-]+\.(?:json|jsonl|toml|obj|glb|csv)"
#: Where a page writes a file: by an option, in a string of Python, or at the top of a file that it shows.
WRITTEN = re.compile(rf'(?:-o|--journal|--film) ({FILE})|"({FILE})"|^# ({FILE})$', re.MULTILINE)
#: Files that the reader has: of an own model, records of shakes, and what another page writes.
GIVEN = {"falls": r"gate\.glb", "facade": r"motion\.csv", "ida": r"wave.*\.csv", "code_check": r"facade\.toml"}


def test_the_reference_is_up_to_date(root):
    pages = command_line.pages()
    shown = {name: (root / "docs" / name).read_text().partition("\n<!-- made -->")[0].rstrip() for name in pages}
    assert shown == {name: text.rstrip() for name, text in pages.items()}, "run make evidence ONLY=command-line"
    written = {f"command_line/{path.name}" for path in (root / "docs" / "command_line").iterdir()}
    assert written == {name for name in pages if "/" in name}


@pytest.mark.parametrize("program", command_line.PROGRAMS)
def test_every_command_that_help_lists_is_on_one_page(program):
    shown = [name for _, own, names in command_line.PAGES.values() if own == program for name in names]
    assert sorted(shown) == sorted(command_line.commands(program))


def test_every_option_has_its_row_with_default_and_meaning():
    command = command_line.PROGRAMS["dynsim"].commands["limit"]
    rows = {row[0]: row[1:] for row in command_line.rows(command, "dynsim limit")}
    assert len(rows) == len([own for own in command.params if "--help" not in own.opts])
    assert rows["`FILE`"][0] == "needed"
    assert rows["`--load X,Y,Z`"][0] == "none"
    assert rows["`--check / --no-check`"] == ["`check`", "Two more runs beside the bracket."]
    assert all(said for _, said in rows.values())


@pytest.mark.parametrize("page", BY_HAND, ids=lambda page: page.stem)
def test_the_commands_on_a_page_have_the_options_that_it_shows(page):
    for shown in SHOWN.findall(page.read_text()):
        program, name, *words = shlex.split(shown.replace("\\\n", " "), comments=True)
        known = command_line.PROGRAMS[program].commands
        assert name in known, shown
        options = {option for own in known[name].params for option in (*own.opts, *own.secondary_opts)}
        used = {word.partition("=")[0] for word in words if re.match(r"--?[a-z]", word)}
        assert used <= options, f"{shown}: there is no {', '.join(used - options)}"


@pytest.mark.parametrize("page", TASKS, ids=lambda page: page.stem)
def test_the_files_that_commands_of_a_task_read_are_written_before(page, root):
    text = page.read_text()
    for shown in SHOWN.finditer(text):
        command = shown[1].partition(" #")[0]
        written = {name for match in WRITTEN.findall(text[: shown.start()]) for name in match}
        results = {name for match in WRITTEN.findall(command) for name in match}
        for name in set(re.findall(FILE, command)) - results:
            given = re.fullmatch(GIVEN.get(page.stem, "none"), name)
            assert name in written or (root / name).exists() or given, f"{shown[1]}: {name} is written nowhere before"
