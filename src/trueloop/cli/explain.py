"""`trueloop explain`: what an error code means."""

from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, print_json


@guarded
def explain(
    code: Annotated[str, typer.Argument(metavar="CODE", help="As a message names it: CMP-SIZE.")],
    as_json: AsJson = False,
) -> None:
    """Show what an error code is about, and which values its errors carry."""
    from difflib import get_close_matches

    from trueloop.errors import Code

    name = code.upper().replace("_", "-")
    if name not in Code.__members__.values():
        near = get_close_matches(name, [str(one) for one in Code], n=3)
        meant = f"did you mean {' or '.join(near)}?" if near else "docs/errors.md lists all of them"
        raise typer.BadParameter(f"{code!r} is no error code; {meant}", param_hint="'CODE'")
    found = Code(name)
    if as_json:
        print_json({"code": found, "meaning": found.meaning, "values": list(found.values)})
        return
    typer.echo(f"{found}: {found.meaning}.")
    if found.values:
        typer.echo(f"Values, in the JSON of a message: {', '.join(found.values)}.")
