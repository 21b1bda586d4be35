"""Makes the pages and JSON schemas of docs/ that follow from the code alone and that git does not hold.

`python -m scripts.reference` writes them into docs/, as `make docs` does; the site and the tests take them from here.
"""

from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Final

from scripts import error_page, file_keys_page, key_tables, performance_page, python_page

DOCS: Final = key_tables.DOCS


def _http_page() -> str:
    from scripts import http_page  # builds the whole service: only where the page is wanted

    return http_page.page()


GENERATED: Final[dict[str, Callable[[], str]]] = {
    "errors.md": error_page.page,
    "file-keys.md": file_keys_page.page,
    "python-reference.md": python_page.page,
    "performance.md": performance_page.page,
    "http-api.md": _http_page,
    **{name: partial(key_tables.schema, name) for name in key_tables.SCHEMAS},
}
"""By the name in docs/."""


def is_generated(file: Path) -> bool:
    """Returns whether a file of docs/ is made from the code."""
    return file.parent == DOCS and file.name in GENERATED


@cache
def text_of(file: Path) -> str:
    """Returns the text of a page or schema: made from the code where it is generated, else read."""
    return GENERATED[file.name]() if is_generated(file) else file.read_text(encoding="utf-8")


def write() -> None:
    """Writes every generated file into docs/."""
    for name, text in GENERATED.items():
        (DOCS / name).write_text(text(), encoding="utf-8")


if __name__ == "__main__":
    write()
