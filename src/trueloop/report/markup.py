"""Small pieces of HTML. Text given by a user goes through `esc`, everywhere and once."""

import html
import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from html import unescape
from pathlib import Path
from typing import Final, TypeVar

from trueloop.domain.option import Language, LengthUnit
from trueloop.formats.outputs import write_all
from trueloop.report.shape import Shape
from trueloop.report.still import svg
from trueloop.report.style import Figure
from trueloop.report.texts.texts import Texts

TAG: Final = re.compile(r"<[^>]*>|&shy;")


def esc(text: object) -> str:
    """Makes text harmless in content and in quoted attributes."""
    return html.escape(str(text))


def as_room_allows(blocks: Iterable[str], count: int, largest: int) -> tuple[str, int]:
    """Joins the first of `count` blocks, up to `largest` bytes but one at least; also how many are left out."""
    fitting: list[str] = []
    size = 0
    for block in blocks:
        size += len(block.encode())
        if fitting and size > largest:
            break
        fitting.append(block)
    return "".join(fitting), count - len(fitting)


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


HERE: Final = Path(__file__).parent
POLICY: Final = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
"""Content security: the browser itself refuses whatever would come from elsewhere."""


def on_screen(say: Texts) -> str:
    """Explains what a screen can do besides."""
    words = say("Point at a mark for its values; drag over a figure for a closer look, double-click to return.")
    return f"<p class='note screen'>{words}</p>"


def html_page(title: str, body: str, script: str = "", language: str = "en", connects: bool = False) -> str:
    """Writes the page; title and body are HTML; `script`: a file beside; `connects`: it asks its own server."""
    scripts = "\n".join((HERE / name).read_text(encoding="utf-8") for name in ("page.js", script) if name)
    policy = f"{POLICY}; connect-src 'self'" if connects else POLICY
    return (
        f'<!doctype html><html lang="{language}"><head><meta charset="utf-8"><title>{title}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{policy}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{(HERE / 'page.css').read_text(encoding='utf-8')}"
        f"@page {{ @bottom-left {{ content: {_css_text(unescape(title))}; }} }}</style></head>"
        f"<body><main>{body}</main>"
        f"<script>{scripts}</script></body></html>\n"
    )


def _css_text(text: str) -> str:
    """A text in a style sheet: what is neither letter nor digit by its number, so that nothing ends the text."""
    return '"' + "".join(one if one.isalnum() else f"\\{ord(one):x} " for one in text) + '"'


def figure_block(name: str, figure: Figure | Mapping[str, Figure], caption: str, small: bool = False) -> str:
    """Writes a figure as a picture whose marks show their values when pointed at; `caption` is HTML.

    Of figures by name, the page's style shows the one for the window's width: "wide" or "narrow".
    """
    kind, alternative = " class=small" if small else "", text_of(caption) or name
    if "data" in figure:
        pictures = svg(dict(figure), alternative)
    else:
        pictures = "".join(f'<div class="{shown}">{svg(one, alternative)}</div>' for shown, one in figure.items())
    return f'<figure id="{name}"{kind}>{pictures}<figcaption>{caption}</figcaption></figure>'


T = TypeVar("T", bound=Shape)


def write_page(
    shape: T,
    name: str,
    page: Callable[[T, Texts], str],
    folder: Path | None,
    language: Language,
    unit: LengthUnit,
    csv: str = "",
) -> list[str]:
    """Writes `name`.json, .html and .csv, if given, to a folder: all, or nothing without one. Raises OUT errors."""
    if folder is None:
        return []
    contents = [
        *([(f"{name}.csv", csv.encode())] if csv else []),
        (f"{name}.json", (shape.model_dump_json(indent=1) + "\n").encode()),
        (f"{name}.html", page(shape, Texts(language, unit)).encode()),
    ]
    return [str(file) for file in write_all(folder, contents)]
