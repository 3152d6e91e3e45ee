"""Open every page of build/docs in Chromium as on a desk and on a telephone, and list what does not fit.

    make docs && python extras/page_widths.py [PAGE ...]

All pages, or those named (howto/bridge). A page fits if nothing but a table or code that scrolls by itself reaches
beyond 1280 and 390 pixels; all its pictures have to load, too. Ends with status 1 if a page does not fit. Needs the
extra test, and Chromium (its path in CHROMIUM if it is not on the PATH).
"""

from __future__ import annotations

import os
import shutil
import sys
from pathlib import Path

PAGES = Path(__file__).parents[1] / "build" / "docs"
SIZES = ((1280, 800), (390, 844))
#: The width of the page beyond the window, the innermost elements that cause it, and the pictures that did not load.
MEASURE = """() => {
  const wide = document.documentElement.clientWidth;
  const over = document.documentElement.scrollWidth - wide;
  const scrolls = e => { for (; e; e = e.parentElement)
    if (['auto', 'scroll', 'hidden'].includes(getComputedStyle(e).overflowX) && e !== document.body
        && e !== document.documentElement) return true; return false; };
  const far = over <= 0 ? [] : [...document.querySelectorAll('body *')].filter(
    e => e.getBoundingClientRect().right > wide + 1 && !scrolls(e) && !e.children.length);
  const broken = [...document.images].filter(i => i.complete && !i.naturalWidth).map(i => i.getAttribute('src'));
  return {over, far: far.slice(0, 3).map(e => e.tagName + ' ' + e.textContent.trim().slice(0, 40)), broken};
}"""


def main() -> None:
    from playwright.sync_api import sync_playwright

    chromium = os.environ.get("CHROMIUM") or shutil.which("chromium") or sys.exit("Chromium is not installed")
    named = [PAGES / f"{name}.html" for name in sys.argv[1:]]
    pages = named or sorted(path for path in PAGES.rglob("*.html") if not path.relative_to(PAGES).parts[0][0] == "_")
    if not pages or not all(path.is_file() for path in pages):
        sys.exit(f"no pages in {PAGES}; run make docs")
    wrong = 0
    with sync_playwright() as p:
        browser = p.chromium.launch(executable_path=chromium, args=["--no-sandbox"])
        for width, height in SIZES:
            tab = browser.new_page(viewport={"width": width, "height": height})
            for path in pages:
                tab.goto(path.as_uri())
                found = tab.evaluate(MEASURE)
                if found["over"] > 0 or found["broken"]:
                    wrong += 1
                    what = [f"{found['over']} px too wide", *found["far"]] if found["over"] > 0 else []
                    what += [f"picture {name} does not load" for name in found["broken"]]
                    print(f"{path.relative_to(PAGES)} at {width} px: {'; '.join(what)}")
            tab.close()
        browser.close()
    print(f"{len(pages)} pages at {' and '.join(str(width) for width, _ in SIZES)} px: {wrong or 'none'} do not fit")
    sys.exit(1 if wrong else 0)


if __name__ == "__main__":
    main()
