"""How commands talk: results on stdout, progress on stderr while a person watches."""

import json
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import Annotated

import typer

AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object instead, for machines.")]


@contextmanager
def busy(doing: str) -> Iterator[None]:
    """A spinner on stderr while the block runs; nothing where stderr is no terminal."""
    from rich.console import Console

    with Console(stderr=True).status(doing):
        yield


def print_json(value: Mapping[str, object]) -> None:
    """One JSON object on stdout; numbers that JSON does not know (nan, inf) are refused by `allow_nan`."""
    typer.echo(json.dumps(value, indent=2, ensure_ascii=False, allow_nan=False))
