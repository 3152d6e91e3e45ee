"""The screenshots of docs/app.md: the live page in Chromium at 1280 x 800, as docs/app-*.png.

    python -m evidence.pages.screenshots [NAME ...]

All of them, or those named. Needs the extras ui, dynamics and test, and Chromium (its path in CHROMIUM if it is not on
the PATH).
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path
from tempfile import TemporaryDirectory

from blockstat import write
from blockstat.app.capacity_tab.panel import CapacityPanel
from blockstat.app.design import open_model
from blockstat.app.server import running
from dynsim.panel import FallPanel, OptimisePanel
from evidence.paths import DOCS, EXAMPLES
from evidence.scenes.small import arch

FLAGS = ["--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox"]
PATIENCE = 1_200_000  #: [ms] for a run of Bullet or a search on a slow machine


def main() -> None:
    from playwright.sync_api import sync_playwright

    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium") or sys.exit("Chromium is not installed")
    names = sys.argv[1:] or list(SHOTS)
    with (
        running(open_model(EXAMPLES / "chapel.toml"), panels=[CapacityPanel(), FallPanel(), OptimisePanel()]) as (
            page,
            address,
        ),
        sync_playwright() as p,
    ):
        browser = p.chromium.launch(executable_path=chromium, args=FLAGS)
        for name in names:
            page.post(lambda: page.set_values(page.model.start))
            tab = browser.new_page(viewport={"width": 1280, "height": 800})
            tab.set_default_timeout(PATIENCE)
            tab.goto(address)
            tab.get_by_text("score").wait_for()
            _settled(tab, page)
            _dismiss(tab)
            SHOTS[name](tab, page)
            tab.mouse.move(620, 20)
            tab.wait_for_timeout(2500)
            tab.screenshot(path=DOCS / f"app-{name}.png")
            print(DOCS / f"app-{name}.png", flush=True)
            tab.close()
        browser.close()


def stable(tab, page) -> None:
    """A design that stands, one block chosen."""
    tab.mouse.click(620, 640)
    tab.get_by_text("neighbour").wait_for()


def mechanism(tab, page) -> None:
    """A design that falls, moved along its mechanism."""
    _thickness(tab, page, 0.3)
    _open(tab, "View")
    _number(tab, 0, 0.1)


def forces(tab, page) -> None:
    """The joint forces of a design that stands."""
    page.post(lambda: _still(page))
    _thickness(tab, page, 0.6)
    _open(tab, "View")
    tab.get_by_role("checkbox").locator("visible=true").nth(0).click()


def fall(tab, page) -> None:
    """A design that falls, in Bullet."""
    page.post(lambda: _still(page))
    _thickness(tab, page, 0.3)
    _open(tab, "Fall")
    tab.get_by_role("button", name="Let it fall").click()
    tab.get_by_text("displacement [mm]").wait_for()
    tab.wait_for_timeout(8000)


def optimise(tab, page) -> None:
    """A search through the thicknesses of the walls."""
    page.post(lambda: _still(page))
    _open(tab, "Optimise")
    tab.get_by_role("checkbox").locator("visible=true").nth(1).click()
    tab.get_by_role("button", name="Optimise", exact=True).click()
    tab.get_by_text("It is on show.").wait_for()
    _settled(tab, page)


def capacity(tab, page) -> None:
    """An arch along its capacity curve, after its hinges have changed. It stays open, so this picture is the last."""
    page.post(lambda: _still(page))
    with TemporaryDirectory() as folder:
        model = open_model(write(arch(15, 0.25), Path(folder) / "arch.json"))
    page.post(lambda: page.open(model))
    tab.get_by_role("heading", name=model.name).first.wait_for()
    _settled(tab, page)
    _open(tab, "Capacity")
    tab.get_by_role("button", name="Follow", exact=True).click()
    tab.get_by_text("states in").wait_for()
    _number(tab, 0, 24)


SHOTS = {
    "stable": stable, "mechanism": mechanism, "forces": forces, "fall": fall, "optimise": optimise,
    "capacity": capacity,
}  # fmt: skip


def _still(page) -> None:
    """Controls of the picture as they are at first."""
    page.layout.amplitude.value = 0.0
    page.layout.forces.value = False
    page.view.click((0.0, 0.0, 1e6), (0.0, 0.0, 1.0))


def _thickness(tab, page, value: float) -> None:
    _open(tab, "Design")
    _number(tab, 0, value)
    _settled(tab, page)


def _dismiss(tab) -> None:
    """Close the browser's remark that it draws in software."""
    note = tab.locator(".mantine-Notification-closeButton")
    if note.count():
        note.first.click()


def _settled(tab, page) -> None:
    """Wait until the dearer numbers are there and the picture is drawn."""
    tab.wait_for_timeout(1000)
    while page.follower.pending or page.known is None or page.known.slipped is None:
        tab.wait_for_timeout(200)
    tab.wait_for_timeout(2500)


def _number(tab, index: int, value: float) -> None:
    box = tab.locator("input[inputmode=decimal]").locator("visible=true").nth(index)
    box.fill(str(value))
    box.press("Enter")


def _open(tab, name: str) -> None:
    tab.get_by_role("tab", name=name, exact=True).click()


if __name__ == "__main__":
    main()
