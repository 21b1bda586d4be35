"""Where the links of a page lead: to pages of the site, to files that come with it, or outside."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Final
from urllib.parse import unquote

from markdown_it.token import Token

from scripts import reference
from scripts.manual.contents import ROOT, Page

OUTSIDE: Final = ("https://", "http://", "mailto:")


class DeadLinkError(ValueError):
    """A link to a file that is not there, or to one that no list of the index names."""


@dataclass(frozen=True)
class Files:
    """The pages of the site by their files, and the files that pages name, by their address in the site."""

    pages: dict[Path, Page]
    copied: dict[str, Path] = field(default_factory=dict)

    def address(self, source: Path, link: str) -> str:
        """What a link of that page is in the site. Raises DeadLinkError."""
        if link.startswith(OUTSIDE) or link.startswith("#"):
            return link
        path, hash_, anchor = unquote(link).partition("#")
        file = (source.parent / path).resolve()
        if page := self.pages.get(file):
            return page.address + hash_ + anchor
        if not (file.is_file() or reference.is_generated(file)) or file.suffix == ".md":
            raise DeadLinkError(f"{source.name}: no page of the manual and no file: {link}")
        name = f"files/{file.relative_to(ROOT).as_posix()}"
        self.copied[name] = file
        return name


def linked(tokens: Sequence[Token]) -> Iterator[tuple[Token, str, str]]:
    """Every link and picture of a page: its token, the attribute, what it says."""
    for token in tokens:
        for one in token.children or ():
            for name in ("href", "src"):
                if (value := one.attrGet(name)) is not None:
                    yield one, name, str(value)


def redirect(tokens: Sequence[Token], source: Path, files: Files) -> None:
    """Makes every link of the page one of the site."""
    for token, name, value in linked(tokens):
        token.attrSet(name, files.address(source, value))
