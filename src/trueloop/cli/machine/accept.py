"""`trueloop machine accept`: a refined model put in force, by whom and why."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.machine.options import ModelFile
from trueloop.cli.store_options import Db


@guarded
def accept(
    model: ModelFile,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="NEW.json", help="The accepted model.")],
    why: Annotated[str, typer.Option("--why", help="Why it is accepted.  [default: not said]")] = "",
    who: Annotated[str, typer.Option("--who", help="Who accepts it.  [default: the user]")] = "",
    db: Db = None,
) -> None:
    """Accept a refined model that is offered: by the new file programs may be corrected.

    The offered file stays as it is. With a store the decision is kept there, and both versions.
    """
    from trueloop.formats.tables.model_file import read_model
    from trueloop.jobs.machine.versions import accept_model

    written, kept = accept_model(model, out, why=why, who=who, db=db)
    version = read_model(written).version
    assert version is not None and version.accepted is not None
    typer.echo(f"version {version.number}: {version.reason}")
    typer.echo(version.judged)
    typer.echo(f"accepted by {version.accepted.who}; written: {written}")
    if kept is not None:
        typer.echo(kept.words)
