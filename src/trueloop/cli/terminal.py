"""How commands talk: results on stdout, progress on stderr while a person watches."""

import codecs
import json
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object instead, for machines.")]


@contextmanager
def busy(doing: str) -> Iterator[Callable[[str], None]]:
    """Shows a spinner on stderr, where that is a terminal, while the block runs; yields what sets its text."""
    if not sys.stderr.isatty():
        yield lambda text: None
        return
    from rich.console import Console

    with Console(stderr=True).status(doing) as status:
        yield status.update


def wide_console() -> "Console":
    """Stdout for people: as wide as the terminal; where there is none, wide enough for every table."""
    from rich.console import Console

    width = None if sys.stdout.isatty() else 160
    return Console(highlight=False, soft_wrap=True, width=width)


def put(text: str, output: Path | None, inputs: Iterable[Path]) -> None:
    """A text on stdout, or in a file, whose name is then printed on stderr. Raises OUT errors."""
    if output is None:
        typer.echo(text, nl=False)
        return
    from trueloop.formats.outputs import write_all

    (written,) = write_all(output.parent, [(output.name, text.encode())], inputs)
    typer.echo(f"written: {written}", err=True)


def print_lines(lines: Iterable[object]) -> None:
    """Prints lines for people on stdout, unchanged."""
    for line in lines:
        typer.echo(str(line))


def print_table(head: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """A table for people on stdout: the first column set left, all others right."""
    from rich.markup import escape
    from rich.table import Table

    table = Table(box=None, pad_edge=False)
    for k, name in enumerate(head):
        table.add_column(name, justify="right" if k else "left", no_wrap=True)
    for row in rows:
        table.add_row(*(escape(cell) for cell in row))
    wide_console().print(table)


def print_json(value: Mapping[str, object]) -> None:
    """One JSON object on stdout, escaped where that is not UTF-8. What JSON has no word for must be null already."""
    lossless = codecs.lookup(sys.stdout.encoding or "utf-8").name == "utf-8"
    typer.echo(json.dumps(value, indent=2, ensure_ascii=not lossless, allow_nan=False))
