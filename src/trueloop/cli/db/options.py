"""What the commands `trueloop db` have in common."""

from typing import Annotated

import typer

Db = Annotated[
    str | None,
    typer.Option("--db", metavar="FILE|URL", help="The store.  [default: trueloop.db in this folder]"),
]
