"""What every page is wrapped in: one HTML file with its style and its scripts inside."""

from collections.abc import Mapping
from html import unescape
from pathlib import Path
from typing import Final

from trueloop.report.markup import text_of
from trueloop.report.still import svg
from trueloop.report.style import Figure
from trueloop.report.texts.texts import Texts

HERE: Final = Path(__file__).parent
POLICY: Final = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
"""Content security: the browser itself refuses whatever would come from elsewhere."""


def on_screen(say: Texts) -> str:
    """Explains what a screen can do besides."""
    words = say("Point at a mark for its values; drag over a figure for a closer look, double-click to return.")
    return f"<p class='note screen'>{words}</p>"


def html_page(title: str, body: str, script: str = "", language: str = "en", connects: bool = False) -> str:
    """Writes the page; title and body are HTML. `script` names a file beside this one that the page needs besides.

    `connects`: it asks the server that it came from for more, and nobody else.
    """
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
