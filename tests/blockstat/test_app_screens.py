"""The live page on screens of several sizes, without a mouse, and for those who do not see it well."""

import numpy as np
import pytest

from browser import CHAPEL, axe_path, live

pytestmark = pytest.mark.slow
SIZES = [(1280, 800), (1920, 1080), (390, 844)]
#: Where the picture is on the page.
PICTURE = """
() => {
  const boxes = [...document.querySelectorAll("canvas")].map(canvas => canvas.getBoundingClientRect());
  const box = boxes.reduce((a, b) => a.width * a.height > b.width * b.height ? a : b);
  return [box.left, box.top, box.width, box.height];
}
"""


@pytest.fixture
def hut(tmp_path):
    path = tmp_path / "hut.toml"
    path.write_text(CHAPEL)
    return path


def projected(page):
    """Where the free blocks appear in the browser's picture, -1 to 1 across and up."""
    camera = next(iter(page.server.get_clients().values())).camera
    assembly = page.known.verdict.assembly
    free = assembly.vertices[~assembly.support[assembly.vertex_block]] - page.view.canvas._origin
    forward = camera.look_at - camera.position
    forward /= np.linalg.norm(forward)
    right = np.cross(forward, [0, 0, 1.0])
    right /= np.linalg.norm(right)
    away = free - camera.position
    depth = away @ forward * np.tan(camera.fov / 2)
    return np.column_stack([away @ right / camera.aspect, away @ np.cross(right, forward)]) / depth[:, None]


@pytest.mark.parametrize("size", SIZES)
def test_the_verdict_and_the_whole_building_are_in_view(hut, capfd, size):
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab(size=size)
        tab.sees("Stable", exact=True)
        tab.page.wait_for_timeout(2000)
        assert tab.page.title() == "hut"
        seen = projected(page)
        assert np.abs(seen).max() < 1
        assert np.abs(seen).max() > 0.7  # and not far away
        left, top, width, height = tab.page.evaluate(PICTURE)
        word = tab.page.get_by_text("Stable", exact=True).locator("visible=true").first.bounding_box()
        assert min(word["x"], word["y"]) >= 0
        assert word["x"] + word["width"] <= size[0]
        assert word["y"] + word["height"] <= size[1]
        beside = word["x"] + word["width"] <= left or word["x"] >= left + width
        below = word["y"] >= top + height
        assert beside or below  # neither hides the other
        assert tab.page.evaluate("document.documentElement.scrollWidth") <= size[0]
        # The verdict comes before all controls.
        slider = tab.page.get_by_role("slider").locator("visible=true").first.bounding_box()
        assert word["y"] < slider["y"]


def test_a_design_that_falls_is_shown_falling_until_that_is_switched_off(hut, capfd):
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        assert not page.player.playing
        tab.number(0, 0.1)
        tab.sees("Unstable", exact=True)
        assembly = page.known.verdict.assembly
        farthest = 0.0
        for _ in range(40):
            farthest = max(farthest, np.linalg.norm(page.view.canvas.vertices - assembly.vertices, axis=1).max())
            tab.page.wait_for_timeout(50)
        assert 0 < farthest < 0.1 * np.ptp(assembly.vertices, axis=0).max()
        tab.tab("View")
        tab.page.get_by_role("combobox").locator("visible=true").nth(1).click()
        tab.page.get_by_role("option", name="never", exact=True).click()
        for _ in range(100):
            if not page.player.playing:
                break
            tab.page.wait_for_timeout(50)
        assert (page.view.canvas.vertices == assembly.vertices).all()


def test_a_number_outside_its_range_is_told_with_what_is_used(hut, capfd):
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        shown = page.known.verdict
        tab.number(0, 5)
        tab.sees("wall.thickness: 5 m is outside 0.1 to 0.6 m; 0.6 m is used")
        assert page.known.verdict is shown  # limit loads of the same design may have come
        tab.number(0, 0.5)
        tab.page.get_by_text("is outside").first.wait_for(state="detached")


def test_a_decimal_comma_is_a_point_and_letters_are_not_taken(hut, capfd):
    with live(hut, capfd) as (page, open_tab):
        tab = open_tab()
        tab.sees("Stable", exact=True)
        box = tab.page.locator("input[inputmode=decimal]").locator("visible=true").first
        for text, used in (("0,4", 0.4), ("5e-1", 0.5), ("0,43", 0.45)):
            tab.number(0, text)
            for _ in range(100):
                if page.values["wall.thickness"] == used:
                    break
                tab.page.wait_for_timeout(50)
            assert page.values["wall.thickness"] == used
        box.click()
        box.press("Control+a")
        tab.page.keyboard.type("0,4", delay=30)
        tab.page.wait_for_timeout(1000)
        assert page.values["wall.thickness"] == 0.4
        box.press("Control+a")
        tab.page.keyboard.type("0.5e9", delay=30)
        assert "e is not taken" in box.evaluate("part => part.validationMessage")
        assert box.input_value() == "0.5"
        box.fill("")
        box.press("Tab")
        tab.page.wait_for_timeout(500)
        assert float(box.input_value()) == page.values["wall.thickness"] == 0.5


@pytest.mark.parametrize("size", [SIZES[0], SIZES[-1]])
def test_the_keyboard_reaches_every_control_and_moves_the_design(hut, capfd, size):
    with live(hut, capfd) as (_, open_tab):
        tab = open_tab(size=size)
        tab.sees("Stable", exact=True)
        names = set()
        for _ in range(60):
            tab.page.keyboard.press("Tab")
            names.add(tuple(tab.page.evaluate(FOCUSED)))
        wanted = {("slider", "thickness [m]"), ("textbox", "thickness [m]"), ("tab", "Design"), ("checkbox", "number")}
        assert wanted <= names
        # A tab is chosen with the arrows, a slider moved with them.
        tab.page.get_by_role("tab", name="Design", exact=True).focus()
        tab.page.keyboard.press("ArrowRight")
        tab.page.get_by_text("joint forces").locator("visible=true").first.wait_for()
        tab.page.keyboard.press("ArrowLeft")
        tab.page.get_by_role("slider").first.focus()
        tab.page.keyboard.press("Home")
        tab.sees("Unstable", exact=True)


#: Role and name of the part that has the focus, as a screen reader tells them.
FOCUSED = """
() => {
  const part = document.activeElement;
  if (!part || part === document.body) return ["", ""];
  const kind = part.type === "checkbox" ? "checkbox" : part.tagName === "INPUT" ? "textbox" : "";
  const label = part.id && document.querySelector(`label[for="${CSS.escape(part.id)}"]`);
  return [part.getAttribute("role") || kind || part.tagName.toLowerCase(),
          part.getAttribute("aria-label") || (label ? label.textContent : part.textContent)];
}
"""


@pytest.mark.parametrize("size", [SIZES[0], SIZES[-1]])
def test_axe_finds_nothing_that_keeps_anyone_out(hut, capfd, size):
    axe = axe_path()
    with live(hut, capfd) as (_, open_tab):
        tab = open_tab(size=size)
        tab.sees("Stable", exact=True)
        for name in ("Design", "View", "File"):
            tab.tab(name)
            tab.page.wait_for_timeout(500)
            assert tab.barriers(axe) == []
