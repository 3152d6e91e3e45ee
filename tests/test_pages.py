"""The pages as a stranger reads them: links lead somewhere, pictures are described, and no page is endless."""

import re

import pytest

from extras import links

PAGES = links.pages()
LONGEST = 400  #: lines
WRITTEN = sorted(path for path in links.DOCS.rglob("*.md") if "notebooks" not in path.parts)
#: A picture as a paragraph of its own, and the paragraph after it.
PICTURE = re.compile(r"^!\[([^]]*)\]\(([^)]+)\)$(?:\n\n(.*?)(?=\n\n|\Z))?", re.MULTILINE | re.DOTALL)
#: A picture in the cell of a table, and the next cell.
CELL = re.compile(r"<img ([^>]*)> *\| *([^|\n]*)\|")
ALT = re.compile(r'\balt="([^"]*)"')


def name(path):
    return str(path.relative_to(links.ROOT))


@pytest.mark.parametrize("page", [*PAGES, *links.notebooks()], ids=name)
def test_links_inside_the_project_lead_to_a_file_and_a_heading(page):
    assert list(links.broken(page)) == []


@pytest.mark.parametrize("page", WRITTEN, ids=name)
def test_a_page_is_not_endless(page):
    assert len(page.read_text().splitlines()) <= LONGEST


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_every_picture_has_a_caption_and_words_for_who_does_not_see_it(page):
    """A caption is a paragraph in italics below the picture; in a table it is the cell beside it."""
    text = page.read_text()
    for alt, target, below in PICTURE.findall(text):
        assert len(alt.split()) >= 3, f"{target}: the words for who does not see it"
        assert re.fullmatch(r"\*[^*].*[^*]\*", below.strip(), re.DOTALL), f"{target}: no caption below it"
    for inside, beside in CELL.findall(text):
        assert len(ALT.search(inside)[1].split()) >= 2, inside
        assert beside.strip(), inside
    shown = len(PICTURE.findall(text)) + len(CELL.findall(text))
    assert shown == len([link for link in links.links(page) if link.picture]) + len(
        re.findall(r"<img ", links.prose(text))
    )


@pytest.mark.parametrize(
    ("heading", "anchor"),
    [
        ("Which faces form a joint", "which-faces-form-a-joint"),
        ("`ties.NAME`", "tiesname"),
        ('kind = "walls"', "kind--walls"),
        ("De Saxcé 1998", "de-saxcé-1998"),
        ("Several states, and which one is followed", "several-states-and-which-one-is-followed"),
        ("[Bullet](https://pybullet.org) and e\\*", "bullet-and-e"),
    ],
)
def test_a_heading_has_the_anchor_that_git_hosts_and_myst_make(heading, anchor):
    assert links.slug(heading) == anchor


def test_a_broken_link_is_told(tmp_path):
    other = tmp_path / "other.md"
    other.write_text("# Here\n\n## Twice\n\n## Twice\n\n#### Deep\n\n```text\n# No heading\n```\n")
    page = tmp_path / "page.md"
    targets = ("other.md", "other.md#here", "other.md#twice-1", "#page", "https://example.org")
    wrong = ("missing.md", "other.md#no-heading", "other.md#deep", "#nowhere")
    page.write_text("# Page\n\n" + " ".join(f"[a `b` c]({target})" for target in (*targets, *wrong)))
    assert [said.split(":")[0] for said in links.broken(page)] == list(wrong)


def test_links_in_code_are_not_links(tmp_path):
    page = tmp_path / "page.md"
    page.write_text("# Page\n\n`[a](b.md)` and\n\n    [a](c.md)\n\n```text\n[a](d.md)\n```\n\n[a](e.md)\n")
    assert [link.target for link in links.links(page)] == ["e.md"]


def test_external_links_are_listed_with_their_pages():
    found = links.external()
    assert "README.md" in found["https://pybullet.org"]
    assert not [address for address in found if not re.match(r"https?://[\w.-]+\.[a-z]+(/|$|\?)", address)]
