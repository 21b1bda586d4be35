"""What every page is wrapped in: one HTML file with its style and its scripts inside."""

from pathlib import Path
from typing import Final

from trueloop.report.still import svg
from trueloop.report.style import Figure

HERE: Final = Path(__file__).parent
POLICY: Final = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
"""Content security: the browser itself refuses whatever would come from elsewhere."""

ON_SCREEN: Final = (
    "<p class='note screen'>Point at a mark for its values; drag over a figure for a closer look, double-click to "
    "return.</p>"
)


def html_page(title: str, body: str, script: str = "") -> str:
    """The page; title and body are HTML. `script` names a file beside this one that the page needs besides."""
    scripts = "\n".join((HERE / name).read_text(encoding="utf-8") for name in ("page.js", script) if name)
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{(HERE / 'page.css').read_text(encoding='utf-8')}</style></head>"
        f"<body><main>{body}</main>"
        f"<script>{scripts}</script></body></html>\n"
    )


def figure_block(name: str, figure: Figure, caption: str, small: bool = False) -> str:
    """A figure as a picture whose marks say their values; `caption` is HTML."""
    kind = " class=small" if small else ""
    return f'<figure id="{name}"{kind}>{svg(figure, name)}<figcaption>{caption}</figcaption></figure>'
