"""Code as HTML, its comments, names and texts in classes of their own."""

from html import escape
from typing import Final

from pygments import highlight
from pygments.formatters import HtmlFormatter
from pygments.lexers import get_lexer_by_name

LEXERS: Final = {"python": "python", "toml": "toml", "json": "json", "sh": "bash", "html": "html", "hal": "bash"}
"""Of a fence's language; any other is plain text, a dialogue with a shell but for its prompts."""
FORM: Final = HtmlFormatter(nowrap=True)


def highlighted(code: str, language: str) -> str:
    """The code, marked up. A line of a dialogue that begins with `$ ` is a command."""
    if language == "console":
        return "".join(_of_dialogue(line) for line in code.splitlines(keepends=True))
    lexer = LEXERS.get(language)
    return str(highlight(code, get_lexer_by_name(lexer), FORM)) if lexer else escape(code, quote=False)


def _of_dialogue(line: str) -> str:
    if line.startswith("$ "):
        return f'<span class="prompt">$ </span><b>{escape(line[2:].rstrip(), quote=False)}</b>\n'
    return escape(line, quote=False)
