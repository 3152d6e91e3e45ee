"""The screenshots of docs/app.md: the live page in Chromium at 1280 x 800, as docs/app-*.png.

Needs the extras ui, dynamics and test, and Chromium (its path in CHROMIUM if it is not on the PATH).
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

from blockstat.app.design import open_model
from blockstat.app.server import running
from dynsim.panel import FallPanel, OptimisePanel

HERE = Path(__file__).parent
CHAPEL = HERE.parent / "examples" / "chapel.toml"
FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
PATIENCE = 300_000  #: [ms] for a run of Bullet or a search on a slow machine


def main() -> None:
    from playwright.sync_api import sync_playwright

    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium") or sys.exit("Chromium is not installed")
    with running(open_model(CHAPEL), panels=[FallPanel(), OptimisePanel()]) as (page, address), sync_playwright() as p:
        browser = p.chromium.launch(executable_path=chromium, args=FLAGS)
        tab = browser.new_page(viewport={"width": 1280, "height": 800})
        tab.set_default_timeout(PATIENCE)
        tab.goto(address)
        tab.get_by_text("Stable", exact=True).wait_for()
        _dismiss(tab)
        _settled(tab, page)
        tab.mouse.click(620, 640)
        tab.get_by_text("neighbour").wait_for()
        _shoot(tab, "stable")
        _number(tab, 0, 0.3)
        tab.get_by_text("Unstable", exact=True).wait_for()
        _settled(tab, page)
        _open(tab, "View")
        _number(tab, 0, 0.1)
        _shoot(tab, "mechanism")
        _number(tab, 0, 0)
        _open(tab, "Design")
        _number(tab, 0, 0.6)
        tab.get_by_text("Stable", exact=True).wait_for()
        _settled(tab, page)
        _open(tab, "View")
        tab.get_by_role("checkbox").locator("visible=true").nth(0).click()
        _shoot(tab, "forces")
        tab.get_by_role("checkbox").locator("visible=true").nth(0).click()
        _open(tab, "Design")
        _number(tab, 0, 0.3)
        tab.get_by_text("Unstable", exact=True).wait_for()
        _settled(tab, page)
        _open(tab, "Fall")
        tab.get_by_role("button", name="Let it fall").click()
        tab.get_by_text("displacement [mm]").wait_for()
        tab.wait_for_timeout(8000)
        _shoot(tab, "fall")
        _open(tab, "Optimise")
        tab.get_by_role("button", name="Optimise", exact=True).click()
        tab.get_by_text("It is on show.").wait_for()
        _settled(tab, page)
        _shoot(tab, "optimise")
        browser.close()


def _dismiss(tab) -> None:
    """Close the browser's remark that it draws in software."""
    note = tab.locator(".mantine-Notification-closeButton")
    if note.count():
        note.first.click()


def _settled(tab, page) -> None:
    """Wait until the dearer numbers are there and the picture is drawn."""
    tab.wait_for_timeout(500)
    while page.follower.pending or page.known is None or page.known.slipped is None:
        tab.wait_for_timeout(200)
    tab.wait_for_timeout(2500)


def _number(tab, index: int, value: float) -> None:
    box = tab.get_by_role("textbox").locator("visible=true").nth(index)
    box.fill(str(value))
    box.press("Enter")


def _open(tab, name: str) -> None:
    tab.get_by_role("tab", name=name, exact=True).click()


def _shoot(tab, name: str) -> None:
    tab.mouse.move(620, 20)
    tab.wait_for_timeout(2500)
    tab.screenshot(path=HERE / f"app-{name}.png")
    print(HERE / f"app-{name}.png", flush=True)


if __name__ == "__main__":
    main()
