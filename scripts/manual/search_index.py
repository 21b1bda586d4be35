"""What the search looks through: every section of every page, and every row of a table that names something."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from markdown_it.token import Token

from scripts.manual.markdown import plain


@dataclass
class Entry:
    """A place of the manual with its words."""

    page: str
    heading: str
    address: str
    text: list[str]
    names: Sequence[str] = ()

    def as_list(self) -> list[str]:
        """Returns page, heading, address and text, and of a page the words that people search for it by."""
        row = [self.page, self.heading, self.address, " ".join(" ".join(self.text).split())]
        return [*row, "|".join(self.names)] if self.names else row


def entries(title: str, address: str, tokens: Sequence[Token]) -> Iterator[Entry]:
    """The places of one page. A row of a table is a place of its own where its first cell names something."""
    section = Entry(title, title, address, [])
    row: Entry | None = None
    for at, token in enumerate(tokens):
        if token.type == "heading_open":
            yield section
            name = plain(tokens[at + 1])
            section = Entry(title, name, f"{address}#{token.attrGet('id')}", [])
        elif token.type == "tr_open" and token.attrGet("id"):
            row = Entry(title, plain(tokens[at + 2]), f"{address}#{token.attrGet('id')}", [section.heading])
        elif token.type == "tr_close" and row:
            yield row
            row = None
        elif token.type == "inline" and tokens[at - 1].type != "heading_open":
            (row or section).text.append(plain(token))
        elif token.type in ("fence", "code_block"):
            section.text.append(token.content)
    yield section
