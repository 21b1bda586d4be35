"""Small pieces of HTML. Text given by a user goes through `esc`, everywhere and once."""

import html
from collections.abc import Iterable, Sequence


def esc(text: object) -> str:
    """Text made harmless in content and in quoted attributes."""
    return html.escape(str(text))


def table(head: Sequence[str], rows: Iterable[Sequence[str]], words: Iterable[int] = (0,), name: str = "") -> str:
    """A table of cells that are HTML already; the columns in `words` are set left, all others right as numbers."""
    kinds = ["" if i in set(words) else ' class="n"' for i in range(len(head))]

    def row(cells: Sequence[str], tag: str) -> str:
        return "".join(f"<{tag}{kind}>{cell}</{tag}>" for kind, cell in zip(kinds, cells, strict=True))

    body = "".join(f"<tr>{row(cells, 'td')}</tr>" for cells in rows)
    identity = f' id="{name}"' if name else ""
    header = f"<thead><tr>{row(head, 'th')}</tr></thead>"
    return f'<div class="scroll"><table{identity}>{header}<tbody>{body}</tbody></table></div>'


def items(texts: Iterable[str]) -> str:
    """A list of items that are HTML already."""
    return f"<ul>{''.join(f'<li>{text}</li>' for text in texts)}</ul>"


def section(name: str, heading: str, *parts: str) -> str:
    """A section with its heading; `name` is its address within the page."""
    return f'<section id="{name}"><h2>{heading}</h2>{"".join(parts)}</section>'
