"""Small pieces of HTML. Text given by a user goes through `esc`, everywhere and once."""

import html
import re
from collections.abc import Iterable, Sequence
from typing import Final

TAG: Final = re.compile(r"<[^>]*>|&shy;")


def esc(text: object) -> str:
    """Makes text harmless in content and in quoted attributes."""
    return html.escape(str(text))


TOGETHER: Final = 24
"""Rows of a table that is not broken across pages."""


def table(
    head: Sequence[str],
    rows: Iterable[Sequence[str]],
    words: Iterable[int] = (0,),
    name: str = "",
    stacks: bool = False,
) -> str:
    """Writes a table of cells that are HTML already; columns in `words` are set left, all others right as numbers.

    Where the window is narrow, each row of a table that `stacks` becomes a list of headings and values.
    """
    left, content = set(words), list(rows)
    kinds = ["" if i in left else " class=n" for i in range(len(head))]
    labels = [f' data-label="{text_of(one.replace("<br>", " "))}"' if stacks else "" for one in head]
    header = "".join(f"<th scope=col{kind}>{cell}</th>" for kind, cell in zip(kinds, head, strict=True))

    def row(cells: Sequence[str]) -> str:
        columns = zip(kinds, labels, cells, strict=True)
        return f"<tr>{''.join(f'<td{kind}{label}>{cell}</td>' for kind, label, cell in columns)}</tr>"

    identity = f' id="{name}"' if name else ""
    outer = "scroll" + " short" * (len(content) <= TOGETHER) + " stack" * stacks
    body = "".join(map(row, content))
    return f'<div class="{outer}"><table{identity}><thead><tr>{header}</tr></thead><tbody>{body}</tbody></table></div>'


def fields(rows: Iterable[tuple[str, str]]) -> str:
    """Names with their values, which are HTML already; a dash where a value is not stated."""
    pairs = "".join(f"<div><dt>{name}</dt><dd>{value or '–'}</dd></div>" for name, value in rows)
    return f'<dl class="fields">{pairs}</dl>'


def text_of(content: str) -> str:
    """Returns the text of HTML, without its tags."""
    return TAG.sub("", content)


def items(texts: Iterable[str]) -> str:
    """Writes a list of items that are HTML already."""
    return f"<ul>{''.join(f'<li>{text}</li>' for text in texts)}</ul>"


def section(name: str, heading: str, *parts: str) -> str:
    """Writes a section with its heading; `name` is its address within the page."""
    return f'<section id="{name}"><h2>{heading}</h2>{"".join(parts)}</section>'
