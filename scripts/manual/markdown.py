"""A page of Markdown as tokens and as HTML, with the anchors that GitHub gives the same headings."""

import re
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Final

from markdown_it import MarkdownIt
from markdown_it.token import Token

from scripts.manual.highlighted import highlighted

TABLE_OPEN: Final = '<div class="scroll" role="region" tabindex="0" aria-label="Table {}"><table>\n'
DRAWING_OPEN: Final = '<div class="scroll drawing" role="region" tabindex="0" aria-label="Drawing {}">'
READER: Final = MarkdownIt("commonmark", {"html": True}).enable("table")


@dataclass(frozen=True)
class Heading:
    """A heading: 1 is the page's title."""

    level: int
    text: str
    anchor: str


def tokens_of(text: str) -> list[Token]:
    """The page's blocks. Every heading has its anchor as `id`, every row of a table that names something too."""
    tokens = READER.parse(text)
    taken: Counter[str] = Counter()
    for at, token in enumerate(tokens):
        if token.type == "heading_open":
            slug = slug_of(plain(tokens[at + 1]))
            token.attrSet("id", f"{slug}-{taken[slug]}" if taken[slug] else slug)
            taken[slug] += 1
    for at, token in enumerate(tokens):
        if token.type == "tr_open" and tokens[at + 1].type == "td_open" and (name := named(tokens[at + 2])):
            if not taken[f"row-{name}"]:
                token.attrSet("id", f"row-{name}")
            taken[f"row-{name}"] += 1
    return tokens


def headings(tokens: Sequence[Token]) -> list[Heading]:
    """All headings, in order."""
    return [
        Heading(int(token.tag[1]), plain(tokens[at + 1]), str(token.attrGet("id")))
        for at, token in enumerate(tokens)
        if token.type == "heading_open"
    ]


def slug_of(text: str) -> str:
    """The anchor of a heading as GitHub makes it: small letters, blanks as hyphens, no punctuation."""
    return re.sub(r"[^\w\- ]", "", text.lower()).replace(" ", "-")


def plain(inline: Token) -> str:
    """The text of a line without its marks."""
    kinds = {"text", "code_inline", "softbreak", "hardbreak", "image"}
    return "".join(" " if "break" in one.type else one.content for one in inline.children or () if one.type in kinds)


def named(cell: Token) -> str:
    """What the first cell of a row names, where it is code or bold: a key, a code, an option, a term."""
    first = next((one for one in cell.children or () if one.content or one.type == "strong_open"), None)
    if first is None or first.type not in ("code_inline", "strong_open"):
        return ""
    return slug_of(plain(cell))[:60]


def html_of(tokens: Sequence[Token]) -> str:
    """The page's content. What is wider than a window scrolls by itself, by keyboard too."""
    parts: list[str] = []
    run: list[Token] = []
    table, fence, drawing = 0, 0, 0

    def flush() -> None:
        parts.append(READER.renderer.render(run, READER.options, {}))
        run.clear()

    for at, token in enumerate(tokens):
        if token.type in ("fence", "code_block"):
            flush()
            fence += 1
            parts.append(_fence(token, fence))
        elif token.type == "paragraph_open" and tokens[at + 1].content.endswith(".svg)"):
            flush()
            drawing += 1
            parts.append(DRAWING_OPEN.format(drawing))
        elif token.type == "paragraph_close" and tokens[at - 1].content.endswith(".svg)"):
            flush()
            parts.append("</div>\n")
        elif token.type == "table_open":
            flush()
            table += 1
            parts.append(TABLE_OPEN.format(table))
        elif token.type == "table_close":
            flush()
            parts.append("</table></div>\n")
        else:
            if token.type == "th_open":
                _head(tokens[at : at + 3])
            if token.type in ("th_open", "td_open"):
                _without_style(token)
            run.append(token)
    flush()
    return "".join(parts)


def _head(cell: Sequence[Token]) -> None:
    """A head without a text is no head of anything."""
    if not plain(cell[1]):
        cell[0].tag = cell[2].tag = "td"


def _without_style(cell: Token) -> None:
    """The policy of the pages forbids styles in elements: how a cell is aligned is its class."""
    if style := cell.attrs.pop("style", None):
        cell.attrSet("class", str(style).rpartition(":")[2])


def _fence(token: Token, number: int) -> str:
    language, _, rest = token.info.partition(" ")
    name = Path(rest).name if "." in rest else ""
    caption = f"<figcaption>{escape(name)}</figcaption>" if name else ""
    label = escape(f"{name or language or 'text'} {number}")
    code = highlighted(token.content, language)
    body = f'<pre tabindex="0" role="region" aria-label="{label}"><code>{code}</code></pre>'
    return f'<figure class="code {escape(language)}">{caption}{body}</figure>\n'
