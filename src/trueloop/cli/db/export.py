"""`trueloop db export`: the whole store as a text file."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded
from trueloop.cli.terminal import busy

Output = Annotated[Path, typer.Option("--output", "-o", help="File to write: JSON, one value a line.")]


@guarded
def export(output: Output, db: Db = None) -> None:
    """Write the whole store into a text file, one value a line; imported into an empty store, it gives an equal one."""
    from trueloop.jobs.db.exported import export as write
    from trueloop.jobs.store.opened import opened

    store = opened(db, read_only=True)
    with busy(f"exporting {store.where}"):
        count = write(store, output)
    typer.echo(f"written: {output}, {count} values", err=True)
