"""List the external links of the pages, or ask whether they answer.

    python extras/links.py            every external link, with the pages that have it
    python extras/links.py --check    ask each of them, and end with status 1 if one does not answer

`tests/test_pages.py` reads pages with the functions of this script, and checks the links inside the project. External
links depend on other machines, so no test asks them. The standard library is enough.
"""

import argparse
import json
import re
import sys
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from typing import NamedTuple
from urllib.error import HTTPError
from urllib.parse import unquote
from urllib.request import Request, urlopen

ROOT = Path(__file__).resolve().parents[1]
DOCS = ROOT / "docs"
FENCE = re.compile(r"^( *)(`{3,}|~{3,}).*?^\1\2`*$", re.MULTILINE | re.DOTALL)
INDENTED = re.compile(r"(?:(?<=\n\n)|\A)(?:    .*\n|\n)+")
CODE = re.compile(r"(`+)(?!`).+?(?<!`)\1(?!`)", re.DOTALL)
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\[\]]*\])*)\]\(\s*([^()\s]+(?:\([^()\s]*\)[^()\s]*)*)(?:\s+\"[^\"]*\")?\s*\)")
ADDRESS = re.compile(r"https?://[^\s)>\]\"'`|]+")
HEADING = re.compile(r"^(#{1,6}) +(.+?) *#*$", re.MULTILINE)
TARGET = re.compile(r"^\(([\w-]+)\)=$|<a (?:id|name)=\"([^\"]+)\"", re.MULTILINE)
#: What `docs/conf.py` asks MyST to make anchors of; a Git host makes them of all levels.
ANCHOR_LEVELS = 3
AGENT = {"User-Agent": "Mozilla/5.0 (links of blockstat's documentation)"}


class Link(NamedTuple):
    """A link of a page."""

    page: Path
    text: str
    target: str  #: as it is written
    picture: bool

    @property
    def external(self) -> bool:
        """Whether it leaves the project."""
        return bool(re.match(r"[a-z]+:", self.target))


def pages() -> list[Path]:
    """All pages of the project that readers see."""
    docs = (path for path in DOCS.rglob("*.md") if not {"_static", "results"} & set(path.relative_to(DOCS).parts))
    return [ROOT / "README.md", ROOT / "CONTRIBUTING.md", ROOT / "CHANGELOG.md", *sorted(docs)]


def notebooks() -> list[Path]:
    """All notebooks."""
    return sorted((ROOT / "notebooks").glob("*.ipynb"))


def text_of(page: Path) -> str:
    """The text of a page; of a notebook that of its Markdown cells."""
    if page.suffix != ".ipynb":
        return page.read_text()
    cells = json.loads(page.read_text())["cells"]
    return "\n\n".join("".join(cell["source"]) for cell in cells if cell["cell_type"] == "markdown")


def prose(text: str) -> str:
    """A page without its blocks of code, and with the words of code spans crossed out."""
    text = INDENTED.sub("\n", FENCE.sub("", text))
    return CODE.sub(lambda found: re.sub(r"[^`\n]", "x", found[0]), text)


def links(page: Path) -> list[Link]:
    """Links and pictures of a page, in their order."""
    return [Link(page, found[2], found[3], bool(found[1])) for found in LINK.finditer(prose(text_of(page)))]


def anchors(page: Path) -> set[str]:
    """Places of a page that a link may name, as MyST and Git hosts make them of its headings."""
    text = FENCE.sub("", page.read_text())
    names: set[str] = set()
    for level, heading in HEADING.findall(text):
        name = slug(heading)
        unique, number = name, 0
        while unique in names:
            number += 1
            unique = f"{name}-{number}"
        if len(level) <= ANCHOR_LEVELS:
            names.add(unique)
    return names | {a or b for a, b in TARGET.findall(text)}


def slug(heading: str) -> str:
    """The anchor of a heading."""
    words = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", heading).replace("\\", "")
    return re.sub(r"[^\w\- ]", "", words.strip().lower().replace("`", "")).replace(" ", "-")


def broken(page: Path) -> Iterator[str]:
    """What is wrong with the links of a page inside the project, a line each."""
    for link in links(page):
        if link.external:
            continue
        name, _, anchor = unquote(link.target).partition("#")
        path = (page.parent / name).resolve() if name else page
        if not path.exists():
            yield f"{link.target}: there is no such file"
        elif anchor and (path.suffix != ".md" or anchor not in anchors(path)):
            yield f"{link.target}: there is no such heading"


def external() -> dict[str, list[str]]:
    """Pages by external address."""
    found: dict[str, list[str]] = {}
    for page in (*pages(), *notebooks()):
        for address in sorted(set(ADDRESS.findall(prose(text_of(page))))):
            found.setdefault(address.rstrip(".,;"), []).append(str(page.relative_to(ROOT)))
    return dict(sorted(found.items()))


def answer(address: str) -> str:
    """What is wrong with an external address, or nothing."""
    for method in ("HEAD", "GET"):
        try:
            with urlopen(Request(address.partition("#")[0], headers=AGENT, method=method), timeout=30):
                return ""
        except HTTPError as error:
            wrong = f"status {error.code}"
        except OSError as error:
            wrong = str(error)
    return wrong


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--check", action="store_true", help="ask each address")
    options = parser.parse_args()
    found = external()
    if not options.check:
        for address, where in found.items():
            print(address, *where)
        return
    with ThreadPoolExecutor(8) as pool:
        wrong = {address: said for address, said in zip(found, pool.map(answer, found), strict=True) if said}
    for address, said in wrong.items():
        print(f"{address}: {said} ({', '.join(found[address])})")
    print(f"{len(found) - len(wrong)} of {len(found)} external links answer")
    sys.exit(bool(wrong))


if __name__ == "__main__":
    main()
