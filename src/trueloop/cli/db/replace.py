"""`trueloop db replace`: a right row in the stead of a wrong one."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded

Row = Annotated[str, typer.Argument(metavar="ROW", help="The wrong row, as `find` names it: inspection:12.")]
File = Annotated[Path, typer.Argument(metavar="FILE", help="What `show ROW --json` printed, with the mistake mended.")]
Why = Annotated[str, typer.Option("--why", help="What was wrong.")]
By = Annotated[str, typer.Option("--by", help="Who says so.  [default: the user]")]


@guarded
def replace(row: Row, file: File, why: Why, by: By = "", db: Db = None) -> None:
    """Keep the value in a file in the stead of a row, which stays, superseded, with who did it and why."""
    from trueloop.jobs.db.found import row_name
    from trueloop.jobs.db.named import named_row
    from trueloop.jobs.db.replaced import left_behind, replace_row
    from trueloop.jobs.store.opened import opened
    from trueloop.jobs.user import user_name

    store = opened(db)
    wrong = named_row(store, row)
    kept = replace_row(store, wrong, file, by=by or user_name(), why=why)
    typer.echo(f"kept: {row_name(type(kept.value), kept.row)} supersedes {row}", err=True)
    for name in left_behind(store, wrong, kept):
        typer.echo(f"still names the row that was replaced: {name}; replace it too", err=True)
