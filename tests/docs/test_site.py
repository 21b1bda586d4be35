"""The manual as a site: every page is listed once, every link leads to something, nothing comes from outside."""

import re
from html.parser import HTMLParser
from pathlib import Path

import pytest

from scripts.manual.contents import ROOT, Page, groups, pages
from scripts.manual.links import DeadLinkError, Files
from scripts.manual.markdown import headings, html_of, tokens_of
from scripts.manual.pictures import MOST_BYTES, OF_THE_SERVICE, PICTURES
from scripts.reference import DOCS, GENERATED

PAGES = pages()


class Parsed(HTMLParser):
    """The anchors, links and loaded files of a page, read apart from what made it."""

    def __init__(self, text: str) -> None:
        super().__init__()
        self.anchors: list[str] = []
        self.links: list[str] = []
        self.loaded: list[str] = []
        self.feed(text)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        values = {name: value or "" for name, value in attrs}
        self.anchors += [values["id"]] if "id" in values else []
        self.links += [values["href"]] if tag == "a" else []
        self.loaded += [values[name] for name in ("src", "href") if name in values and tag != "a"]
        assert "style" not in values and not any(name.startswith("on") for name in values), "the policy forbids these"


@pytest.fixture(scope="module")
def parsed(manual: Path) -> dict[str, Parsed]:
    return {file.name: Parsed(file.read_text(encoding="utf-8")) for file in manual.glob("*.html")}


def test_the_index_lists_every_page_once() -> None:
    listed = [page.source for page in PAGES]
    assert sorted(listed) == sorted(set(listed))
    made = {DOCS / name for name in GENERATED if name.endswith(".md")}
    assert {page for page in listed if DOCS in page.parents} == set(DOCS.rglob("*.md")) | made


def test_every_link_leads_to_a_page_an_anchor_or_a_file_of_the_site(parsed: dict[str, Parsed], manual: Path) -> None:
    count = 0
    for name, page in parsed.items():
        for link in page.links + page.loaded:
            if link.startswith(("https://", "http://")):
                continue
            file, _, anchor = link.partition("#")
            assert (manual / (file or name)).is_file(), (name, link)
            assert not anchor or anchor in parsed[file or name].anchors, (name, link)
            count += 1
    assert count > 3000


def test_nothing_is_loaded_from_outside(parsed: dict[str, Parsed]) -> None:
    assert [link for page in parsed.values() for link in page.loaded if "//" in link] == []


def test_no_anchor_is_there_twice(parsed: dict[str, Parsed]) -> None:
    for name, page in parsed.items():
        assert len(page.anchors) == len(set(page.anchors)), name


def test_a_link_to_what_is_not_there_or_not_listed_is_refused(tmp_path: Path) -> None:
    (tmp_path / "stray.md").write_text("# Stray")
    for link in ("missing.md", "stray.md", "missing.nc"):
        with pytest.raises(DeadLinkError, match=re.escape(link)):
            Files({}).address(tmp_path / "page.md", link)


def test_the_lists_are_read_as_they_are_written() -> None:
    (found,) = groups("# Title\n\n## Ways\n\nNone.\n\n## Turned parts\n\n- [The job file](job-file.md): every key\n")
    assert found.title == "Turned parts"
    assert found.pages == (Page(ROOT / "docs" / "job-file.md", "The job file", "every key"),)


def test_anchors_are_those_of_github() -> None:
    """`trueloop db init [FILE|URL]` is reached on GitHub as trueloop-db-init-fileurl; the second of a name gets -1."""
    found = headings(tokens_of("# `trueloop db init [FILE|URL]`\n\n## What _it_ is\n\n## What it is\n"))
    assert [one.anchor for one in found] == ["trueloop-db-init-fileurl", "what-it-is", "what-it-is-1"]


def test_what_is_code_stays_code() -> None:
    html = html_of(tokens_of("```console\n$ trueloop nc check <file> | sort\na < b\n```\n\n`x<y>`\n"))
    assert "&lt;file&gt; | sort</b>" in html and "a &lt; b" in html and "<code>x&lt;y&gt;</code>" in html


def test_every_picture_is_shown_and_light_enough() -> None:
    shown = {(page.source.parent / link).resolve() for page in PAGES for link in pictures_of(page)}
    there = set((ROOT / "docs" / "images").iterdir())
    assert shown <= there and there - shown == {ROOT / "docs" / "images" / "modbas2-report.png"}, "of the README alone"
    assert [one.name for one in there if one.stat().st_size > MOST_BYTES] == []
    made = {f"{name}.png" for name in (*PICTURES, *OF_THE_SERVICE)}
    others = {"modbas2-report.png", "factory-decision.png"}  # of scripts/readme_picture.py and make demo-factory
    assert {one.name for one in there if one.suffix == ".png"} - made == others, "a script makes it"


def pictures_of(page: Page) -> list[str]:
    return re.findall(r"!\[[^\]]{20,}\]\(([^)]+)\)", page.text)
