"""The live page as a user meets it. WebGL in software takes its time: all but the first test are slow ones."""

import json

import pytest

from blockstat import build, load_scene, with_values, write
from browser import CHAPEL, live
from evidence.scenes.small import stack


@pytest.fixture
def hut(tmp_path):
    path = tmp_path / "hut.toml"
    path.write_text(CHAPEL)
    return path


def test_a_slider_changes_the_verdict_and_the_picture_shows_why(hut, capfd):
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.sees("milliseconds:")
        tab.number(0, 0.1)
        tab.sees("Unstable", exact=True)
        tab.sees("speed in the mechanism")
        tab.sees("First to move:")
        tab.number(0, 0.6)
        tab.sees("Stable", exact=True)
        tab.sees("friction or strength used in the force field found")
        # A checkbox adds the buttress: more blocks than before.
        before = page.known.verdict.assembly.n_blocks
        tab.page.get_by_role("checkbox").first.click()
        tab.page.wait_for_timeout(100)
        wait_until(tab, lambda: page.known.verdict.assembly.n_blocks > before)
        assert tab.page.get_by_text("blocks / joints").count() == 1


@pytest.mark.slow
def test_every_control_of_the_picture_answers(hut, capfd):
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.tab("View")
        for choice, words in (
            ("demand", "friction or strength used in the force field found"),
            ("tension", "residual tension at a block"),
            ("group", "wall.south"),
            ("displacement", "speed in the mechanism"),
        ):
            choose(tab, 0, choice)
            tab.sees(words)
        boxes = tab.page.get_by_role("checkbox").locator("visible=true")
        boxes.nth(0).click()
        tab.sees("longest arrow of forces")
        boxes.nth(1).click()
        tab.sees("longest arrow of thrust")
        # The mechanism of the limit load comes with the dearer numbers, and swings.
        wait_until(tab, lambda: page.known.weakest is not None)
        tab.sees(f"of the limit load along {page.known.weakest.push}")
        at_rest = page.view.canvas.vertices.copy()
        choose(tab, 1, "always")
        wait_until(tab, lambda: abs(page.view.canvas.vertices - at_rest).max() > 0.01)
        assert not page.view.canvas._arrows  # they belong to the blocks at rest
        choose(tab, 1, "never")
        wait_until(tab, lambda: set(page.view.canvas._arrows) == {"forces", "thrust"})
        assert (page.view.canvas.vertices == at_rest).all()
        choose(tab, 2, "+x")
        tab.sees("of the limit load along +x")


@pytest.mark.slow
def test_a_click_on_a_block_tells_its_forces(hut, capfd):
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.page.wait_for_timeout(3000)
        tab.page.mouse.click(500, 330)
        tab.sees("neighbour")
        name = page.view._chosen
        assert name in page.known.verdict.assembly.names
        tab.sees(name)


@pytest.mark.slow
def test_a_bad_file_is_answered_with_what_is_wrong_in_it(hut, tmp_path, capfd):
    files = {
        "typo.toml": (CHAPEL.replace("thickness", "thikness", 1), "thikness"),
        "broken.toml": ("name = [", "not valid TOML"),
        "broken.json": ('{"blocks": [', "broken.json"),
        "picture.png": ("no", "the page opens"),
        "loose.obj": ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "loose.obj"),
        "noise.glb": ("not a glb", "noise.glb"),
    }
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        drawn = page.known.verdict
        tab.tab("File")
        for name, (text, words) in files.items():
            (tmp_path / name).write_text(text)
            upload(tab, tmp_path / name)
            if name.endswith((".obj", ".glb")):
                answer_dialogue(tab, "block0")
            seen(tab.page.locator(".trouble").filter(has_text=words)).wait_for()
            # What was known of the design before stands no more where the verdict stands.
            tab.sees("Not opened", exact=True)
            assert tab.page.get_by_text("Stable", exact=True).count() == 0
            tab.sees("Still on show: hut (stable).")
        assert page.known.verdict.assembly.names == drawn.assembly.names
        write(stack(3), tmp_path / "stones.json")
        upload(tab, tmp_path / "stones.json")
        wait_until(tab, lambda: page.known and "stone0" in page.known.verdict.assembly.names)
        tab.page.locator(".trouble").first.wait_for(state="detached")


@pytest.mark.slow
def test_a_mesh_wants_supports_and_opens_with_them(hut, tmp_path, capfd):
    write(stack(2), tmp_path / "stones.glb")
    bare = tmp_path / "bare.obj"
    write(stack(2), bare)
    bare.write_text("\n".join(line for line in bare.read_text().splitlines() if not line.startswith("#")))
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.tab("File")
        upload(tab, bare)
        answer_dialogue(tab, "", units="mm")
        tab.sees("(blocks: ground, ")  # it asks again, says what there is, and keeps the units
        answer_dialogue(tab, "ground")
        wait_until(tab, lambda: page.known and page.known.verdict.assembly.n_blocks == 3)
        assert page.known.verdict.assembly.volume[1] == pytest.approx(1e-9 * stack(2).volume[1])
        upload(tab, bare)
        answer_dialogue(tab, "ground", gap="2 miles")
        tab.sees('gap is "2 miles"; it must be a share of the block size')
        upload(tab, bare)
        answer_dialogue(tab, "ground", gap="2 mm")
        wait_until(tab, lambda: page.known and page.known.verdict.interfaces.searched == "2 mm")
        upload(tab, tmp_path / "stones.glb")  # a file of our own says it all
        answer_dialogue(tab, "")
        wait_until(
            tab, lambda: page.known and page.known.verdict.assembly.volume[1] == pytest.approx(stack(2).volume[1])
        )


@pytest.mark.slow
def test_what_is_saved_is_what_is_shown(hut, tmp_path, capfd):
    from blockstat import read

    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.number(0, 0.45)
        wait_until(
            tab, lambda: page.known and page.known.verdict.assembly.metadata["parameters"]["wall.thickness"] == 0.45
        )
        shown = page.known.verdict.assembly
        tab.tab("File")
        saved = {}
        for label in ("Save scene (.toml)", "Save report (.html)", "Save blocks (.glb)", "Save picture (.png)"):
            with tab.page.expect_download() as download:
                tab.press(label)
            saved[label] = tmp_path / download.value.suggested_filename
            download.value.save_as(saved[label])
        again = build(load_scene(saved["Save scene (.toml)"]))
        assert (again.vertices == shown.vertices).all()
        assert read(saved["Save blocks (.glb)"], supports=["ground"]).names == shown.names
        assert saved["Save picture (.png)"].read_bytes().startswith(b"\x89PNG")
        report = saved["Save report (.html)"].read_text()
        assert "wall.thickness" in report
        assert "__VISER_EMBED_DATA__" in report
        # The report by itself: it draws, and asks for nothing.
        sheet = tab.page.context.browser.new_page()
        asked, errors = [], []
        sheet.on("request", lambda request: asked.append(request.url))
        sheet.on("console", lambda message: errors.append(message.text) if message.type == "error" else None)
        sheet.goto(saved["Save report (.html)"].as_uri())
        sheet.frame_locator("iframe").locator("canvas").first.wait_for(timeout=90_000)
        assert [url for url in asked if not url.startswith(("file:", "blob:", "data:", "about:"))] == []
        assert errors == []


@pytest.mark.slow
def test_a_failed_build_keeps_the_last_good_picture(hut, capfd):
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        kept = page.known
        tab.number(1, 2)  # two windows of 1.2 m do not fit a wall of 3 m
        seen(tab.page.locator(".trouble").filter(has_text="windows.north")).wait_for()
        assert page.known.verdict is kept.verdict
        assert page.view.canvas.assembly is kept.verdict.assembly
        tab.number(1, 1)
        wait_until(tab, lambda: page.known.verdict is not kept.verdict)
        tab.page.locator(".trouble").first.wait_for(state="detached")


@pytest.mark.slow
def test_twenty_fast_moves_end_with_the_verdict_on_the_last(hut, capfd):
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        slider = tab.page.get_by_role("slider").first
        slider.focus()
        for step in range(20):
            slider.press("ArrowLeft" if step % 10 < 9 else "Home")
        tab.number(0, 0.35)
        wait_until(tab, lambda: not page.follower.pending and page.values["wall.thickness"] == 0.35)
        tab.page.wait_for_timeout(200)
        assert page.known.verdict.assembly.metadata["parameters"]["wall.thickness"] == 0.35
        tab.sees("limit load, +y")


@pytest.mark.slow
def test_two_pages_show_the_same(hut, capfd):
    with live(hut, capfd) as (_, open_tab):
        one, two = open_tab(), open_tab()
        for tab in (one, two):
            tab.sees("Stable", exact=True)
        one.number(0, 0.1)
        two.sees("Unstable", exact=True)
        two.number(0, 0.6)
        one.sees("Stable", exact=True)
        one.close()
        two.number(0, 0.1)
        two.sees("Unstable", exact=True)


@pytest.mark.slow
def test_a_model_without_a_free_block_is_shown_and_said_to_be_so(hut, tmp_path, capfd):
    scene = with_values(load_scene(hut), {"wall.thickness": 0.5})
    empty = tmp_path / "empty.json"
    write(build(scene), empty)
    data = json.loads(empty.read_text())
    empty.write_text(json.dumps(data | {"supports": [block["name"] for block in data["blocks"]]}))
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        tab.tab("File")
        upload(tab, empty)
        tab.sees("all blocks are supports")
        tab.tab("View")
        tab.page.get_by_role("checkbox").locator("visible=true").first.click()
        wait_until(tab, lambda: page.known and page.known.slipped is not None)
        upload_back = hut
        tab.tab("File")
        upload(tab, upload_back)
        wait_until(tab, lambda: page.known and len(page.known.verdict.assembly.free) > 0)


def choose(tab, index, option):
    """An option of a dropdown, counted from the top of the tab on show."""
    tab.page.get_by_role("combobox").locator("visible=true").nth(index).click()
    tab.page.get_by_role("option", name=option, exact=True).click()


def upload(tab, path):
    with tab.page.expect_file_chooser() as chooser:
        tab.press("Open …")
    chooser.value.set_files(str(path))


def seen(part):
    """Those of some parts of the page that are on show."""
    return part.locator("visible=true").first


def answer_dialogue(tab, supports, units=None, gap=""):
    """Fill in the dialogue that opens a mesh, and confirm it."""
    dialogue = tab.page.get_by_role("dialog")
    dialogue.wait_for()
    dialogue.get_by_role("textbox").first.fill(supports)
    dialogue.get_by_role("textbox").last.fill(gap)
    if units is not None:
        dialogue.get_by_role("combobox").first.click()
        tab.page.get_by_role("option", name=units, exact=True).click()
    tab.page.wait_for_timeout(500)
    dialogue.get_by_role("button", name="Open", exact=True).click()
    dialogue.wait_for(state="detached")


def wait_until(tab, true, seconds=60):
    for _ in range(10 * seconds):
        if true():
            return
        tab.page.wait_for_timeout(100)
    raise AssertionError("it did not come about in time")


EMPTY = """
name = "maybe"
[elements.slab]
kind = "box"
size = [1.0, 1.0, 0.3]
at = [0, 0, 0]
present = "search"
"""


@pytest.mark.slow
def test_a_scene_that_becomes_empty_says_so_and_comes_back(tmp_path, capfd):
    path = tmp_path / "maybe.toml"
    path.write_text(EMPTY)
    with live(path, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        kept = page.known.verdict
        present = tab.page.get_by_role("checkbox").locator("visible=true").first
        present.click()
        seen(tab.page.locator(".trouble").filter(has_text="no element is present")).wait_for()
        assert page.known.verdict is kept
        present.click()
        tab.page.locator(".trouble").first.wait_for(state="detached")
        wait_until(tab, lambda: page.known.verdict is not kept)
