"""`trueloop db backup`, `restore` and `migrate`: copies of a store, and its form of today."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded
from trueloop.cli.terminal import busy

Copy = Annotated[Path, typer.Argument(metavar="FILE", help="The file to write, which must be new.")]
Backup = Annotated[Path, typer.Argument(metavar="FILE", help="A backup, or what `export` wrote.")]
New = Annotated[str, typer.Option("--db", metavar="FILE|URL", help="The store to make, which must be new.")]


@guarded
def backup(file: Copy, db: Db = None) -> None:
    """Copy the store into a SQLite file, as it is at one moment, while others go on working with it."""
    from trueloop.jobs.db.copied import back_up
    from trueloop.jobs.store.opened import opened

    store = opened(db, read_only=True)
    with busy(f"copying {store.where}") as progress:
        back_up(store, file, progress)
    typer.echo(f"written: {file}", err=True)


@guarded
def restore(file: Backup, db: New) -> None:
    """Make a new store of what a backup or an export holds. A store that is there is never changed."""
    from trueloop.jobs.db.copied import restore as restored
    from trueloop.storage.shown import shown

    with busy(f"restoring {file}") as progress:
        copied = restored(file, db, progress)
    typer.echo(f"made: {shown(db)}, {copied.count} rows", err=True)


@guarded
def migrate(db: Db = None) -> None:
    """Bring a store of an earlier version of trueloop to this version's form. What it holds stays as it is."""
    from trueloop.jobs.store.opened import migrated

    before, after, place = migrated(db)
    said = f"is of this version already, {after}" if before == after else f"brought from schema {before} to {after}"
    typer.echo(f"{place}: {said}", err=True)
