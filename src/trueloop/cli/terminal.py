"""How commands talk: results on stdout, progress on stderr while a person watches."""

import json
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Annotated

import typer

if TYPE_CHECKING:
    from rich.console import Console

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object instead, for machines.")]


@contextmanager
def busy(doing: str) -> Iterator[Callable[[str], None]]:
    """A spinner on stderr while the block runs; nothing where stderr is no terminal. Gives what changes its words."""
    from rich.console import Console

    with Console(stderr=True).status(doing) as status:
        yield status.update


def wide_console() -> "Console":
    """Stdout for people: as wide as the terminal; where there is none, wide enough for every table."""
    from rich.console import Console

    width = None if sys.stdout.isatty() else 160
    return Console(highlight=False, soft_wrap=True, width=width)


def print_json(value: Mapping[str, object]) -> None:
    """One JSON object on stdout. What JSON has no word for (nan, inf) must be null already."""
    typer.echo(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))
