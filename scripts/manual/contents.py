"""Which pages the manual has, and in which order: the lists of docs/index.md."""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from scripts import reference

ROOT: Final = Path(__file__).parents[2]
INDEX: Final = ROOT / "docs" / "index.md"
GROUP: Final = re.compile(r"^## (.+)$")
ENTRY: Final = re.compile(r"^- \[(.+?)\]\(([^)]+\.md)\)(?:: (.+))?")


@dataclass(frozen=True)
class Page:
    """A Markdown file, the name by which lists call it, and what they say it is about."""

    source: Path
    title: str
    about: str = ""

    @property
    def address(self) -> str:
        """Its file in the site; all stand in one folder."""
        return f"{self.source.stem.lower()}.html"

    @property
    def language(self) -> str:
        """The language of its text: that of its folder."""
        return "de" if self.source.parent.name == "de" else "en"

    @property
    def text(self) -> str:
        """Its Markdown, made from the code or read."""
        return reference.text_of(self.source)


@dataclass(frozen=True)
class Group:
    """Pages for one kind of reader."""

    title: str
    pages: tuple[Page, ...]


def groups(index: str | None = None) -> tuple[Group, ...]:
    """Returns the headings of the index that have pages below them, with these."""
    found: list[tuple[str, list[Page]]] = []
    for line in (INDEX.read_text(encoding="utf-8") if index is None else index).splitlines():
        if heading := GROUP.match(line):
            found.append((heading[1], []))
        elif entry := ENTRY.match(line):
            found[-1][1].append(Page((INDEX.parent / entry[2]).resolve(), entry[1], entry[3] or ""))
    return tuple(Group(title, tuple(pages)) for title, pages in found if pages)


def pages() -> tuple[Page, ...]:
    """The index, and all pages that it lists."""
    return (Page(INDEX, "Manual"), *(page for group in groups() for page in group.pages))
