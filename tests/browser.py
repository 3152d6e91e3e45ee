"""The live page in a real browser: Chromium, headless, with WebGL in software."""

from __future__ import annotations

import logging
import os
import shutil
from contextlib import contextmanager
from pathlib import Path

import pytest

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable")
FLAGS = ("--use-gl=angle", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--no-sandbox")
#: A step of a test may take this long before it has failed [ms]; a busy machine with WebGL in software is slow.
PATIENCE = 180_000

#: What axe-core checks: WCAG 2.2 at level AA.
RULES = ["wcag2a", "wcag2aa", "wcag21a", "wcag21aa", "wcag22aa"]

CHAPEL = """
name = "hut"
length = 3.0
span = 2.0
[brick]
length = 1.0
height = 0.5
[wall]
thickness = { value = 0.6, min = 0.1, max = 0.6, step = 0.05 }
height = 1.5
[vault]
thickness = { value = 0.3, min = 0.2, max = 0.3, step = 0.05 }
voussoirs = 7
[buttresses.south]
number = { value = 0, min = 0, max = 1, step = 1 }
thickness = 0.5
width = 0.5
height = 1.0
[windows.north]
number = { value = 0, min = 0, max = 2, step = 1 }
width = 1.2
height = 0.5
sill = 0.5
"""


def browser_path() -> str:
    """Where Chromium is; skips the test when there is none."""
    pytest.importorskip("viser", reason="viser is not installed (extra ui)")
    pytest.importorskip("playwright.sync_api", reason="playwright is not installed (extra test)")
    named = os.environ.get("CHROMIUM")
    found = named or next(filter(None, map(shutil.which, NAMES)), None)
    if found is None:
        pytest.skip("no Chromium on this machine (install it, or set CHROMIUM to its path)")
    return found


def axe_path():
    """Where axe-core is; skips the test where it is not installed (npm install axe-core, or its path in AXE)."""
    places = [os.environ.get("AXE", ""), "node_modules/axe-core/axe.min.js"]
    found = next((path for path in places if path and Path(path).is_file()), None)
    if found is None:
        pytest.skip("axe-core is not installed (npm install axe-core, or set AXE to the path of axe.min.js)")
    return found


class Log(logging.Handler):
    """Keeps what is logged as an error."""

    def __init__(self):
        super().__init__(logging.ERROR)
        self.lines = []

    def emit(self, record):
        self.lines.append(record.getMessage())


class Tab:
    """One page of the browser, with what a user does on it; it keeps every request and every console error."""

    def __init__(self, browser, address, size=(1000, 700)):
        self.page = browser.new_page(viewport={"width": size[0], "height": size[1]})
        self.page.set_default_timeout(PATIENCE)
        self.address, self.requests, self.errors = address, [], []
        self.page.on("request", lambda request: self.requests.append(request.url))
        self.page.on("websocket", lambda socket: self.requests.append(socket.url))
        self.page.on("pageerror", lambda error: self.errors.append(str(error)))
        self.page.on("console", lambda m: self.errors.append(m.text) if m.type == "error" else None)
        self.page.goto(address)

    def sees(self, text, *, exact=False):
        self.page.get_by_text(text, exact=exact).locator("visible=true").first.wait_for()

    def number(self, index, value):
        """Type a value into a slider's box, counted from the top of the tab on show."""
        box = self.page.locator("input[inputmode=decimal]").locator("visible=true").nth(index)
        box.fill(str(value))
        box.press("Enter")

    def tab(self, name):
        self.page.get_by_role("tab", name=name, exact=True).click()

    def press(self, name):
        self.page.get_by_role("button", name=name, exact=True).click()

    def barriers(self, axe):
        """What axe-core, a file, finds on the page: rules and the parts that break them."""
        if not self.page.evaluate("() => 'axe' in window"):
            self.page.add_script_tag(path=axe)
        found = self.page.evaluate("tags => axe.run({runOnly: tags})", RULES)["violations"]
        return [(rule["id"], [node["html"] for node in rule["nodes"]]) for rule in found]

    def close(self):
        self.page.close()

    @property
    def outside(self):
        """Requests that left this machine."""
        host = self.address.partition("//")[2].partition("/")[0]
        inside = (f"http://{host}", f"ws://{host}", f"blob:http://{host}", "data:")
        return [url for url in self.requests if not url.startswith(inside)]


@contextmanager
def live(path, capfd, *, panels=(), supports=""):
    """A page that is up, a function that opens tabs of it, and a check at the end that nothing went wrong."""
    executable = browser_path()
    from playwright.sync_api import sync_playwright

    from blockstat.app.design import open_model
    from blockstat.app.server import running

    log, tabs = Log(), []
    logging.getLogger().addHandler(log)
    try:
        with running(open_model(path, supports=supports), panels=panels) as (page, address), sync_playwright() as play:
            browser = play.chromium.launch(executable_path=executable, args=list(FLAGS))

            def open_tab(**options):
                tabs.append(Tab(browser, address, **options))
                return tabs[-1]

            yield page, open_tab
            browser.close()
    finally:
        logging.getLogger().removeHandler(log)
    assert not log.lines
    assert not [error for tab in tabs for error in tab.errors]
    assert not [url for tab in tabs for url in tab.outside]
    assert tabs
    assert any(url.startswith("ws://127.0.0.1") for url in tabs[0].requests)
    captured = capfd.readouterr()
    assert "Traceback" not in captured.out + captured.err
    assert "exception" not in (captured.out + captured.err).lower()
