"""What every page is wrapped in: one HTML file with its style, its scripts and the Plotly library inside."""

import json
from importlib.util import find_spec
from pathlib import Path
from typing import Final

from trueloop.report.still import svg
from trueloop.report.style import Figure

HERE: Final = Path(__file__).parent
POLICY: Final = "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; img-src data: blob:"
"""Content security: the browser itself refuses whatever would come from elsewhere."""


def html_page(title: str, body: str, script: str = "") -> str:
    """The page; title and body are HTML. `script` names a file beside this one that the page needs besides."""
    scripts = "\n".join((HERE / name).read_text(encoding="utf-8") for name in ("page.js", script) if name)
    return (
        f'<!doctype html><html lang="en"><head><meta charset="utf-8"><title>{title}</title>'
        f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        f"<style>{(HERE / 'page.css').read_text(encoding='utf-8')}</style></head>"
        f"<body><main>{body}</main>"
        f"<script>{_plotly()}</script><script>{scripts}</script></body></html>\n"
    )


def figure_block(name: str, figure: Figure, caption: str, small: bool = False) -> str:
    """A figure with both its appearances; `caption` is HTML."""
    data = json.dumps(figure, separators=(",", ":"), ensure_ascii=False).replace("<", "\\u003c")
    return (
        f'<figure id="{name}"{" class=small" if small else ""}>{svg(figure, name)}<div class="plot"></div>'
        f'<script type="application/json">{data}</script><figcaption>{caption}</figcaption></figure>'
    )


def _plotly() -> str:
    """The library as it comes with the Python package, found without importing that: an import would take a second."""
    package = find_spec("plotly")
    if package is None or package.origin is None:
        raise ModuleNotFoundError("the Python package plotly is not installed, which brings plotly.min.js")
    return (Path(package.origin).parent / "package_data" / "plotly.min.js").read_text(encoding="utf-8")
