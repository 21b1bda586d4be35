"""`trueloop examples`: the files of an example, to work on."""

from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.failure import guarded


@guarded
def examples(
    names: Annotated[list[str] | None, typer.Argument(metavar="NAME", help="Which; left out, they are listed.")] = None,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="The folder that gets them.  [default: examples]")
    ] = None,
) -> None:
    """Copy examples that come with trueloop into folders of your own, or list them."""
    from trueloop.formats.examples import copy_example, titles

    known = titles()
    for name in names or ():
        if name not in known:
            raise typer.BadParameter(f"{name!r} is none of {', '.join(known)}", param_hint="'NAME'")
    for name in names or ():
        folder = (output or Path("examples")) / name
        typer.echo(f"written: {folder}, {copy_example(name, folder)} files")
    if not names:
        for name, title in known.items():
            typer.echo(f"{name:10} {title}")
