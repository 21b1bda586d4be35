"""`trueloop db init`: a new store."""

from typing import Annotated

import typer

from trueloop.cli.failure import guarded

Place = Annotated[
    str | None, typer.Argument(metavar="[FILE|URL]", help="The store to make.  [default: trueloop.db in this folder]")
]


@guarded
def init(place: Place = None) -> None:
    """Make an empty store: a SQLite file, or tables in a PostgreSQL database by its URL."""
    from trueloop.jobs.store.opened import made
    from trueloop.jobs.store.where import BESIDE
    from trueloop.storage.shown import shown

    made(place or BESIDE)
    typer.echo(f"made: {shown(place or BESIDE)}", err=True)
