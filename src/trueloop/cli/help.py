"""`trueloop docs`, `trueloop examples` and `trueloop explain`: manual, examples and error codes."""

from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer

from trueloop.cli.shared_options import argument, option
from trueloop.cli.terminal import AsJson, guarded, print_json


@guarded
def docs(
    words: Annotated[list[str] | None, argument("Words to search for; left out, the first page.")] = None,
    port: Annotated[int, option("Port to serve at; 0: any that is free.", min=0, max=65535)] = 0,
    no_browser: Annotated[bool, option("Print the address and open no browser.", "--no-browser")] = False,
) -> None:
    """Show the manual in the browser; no network is needed.

    It is served to this machine alone, until Ctrl-C.
    """
    from trueloop.server import manual

    with manual.listening(manual.require_built(manual.folder()), port) as server:
        found = manual.address(server, " ".join(words or ()))
        typer.echo(f"the manual is at {found} (Ctrl-C ends it)")
        if not no_browser:
            import webbrowser

            webbrowser.open(found)
        with suppress(KeyboardInterrupt):
            server.serve_forever()


@guarded
def examples(
    names: Annotated[list[str] | None, argument("Which; left out, they are listed.", metavar="NAME")] = None,
    output: Annotated[Path | None, option("The folder that gets them.  [default: examples]", "--output", "-o")] = None,
) -> None:
    """Copy examples into folders of your own, or list them."""
    from trueloop.formats.examples import copy_example, titles

    known = titles()
    for name in names or ():
        if name not in known:
            raise typer.BadParameter(f"{name!r} is not one of {', '.join(known)}", param_hint="'NAME'")
    for name in names or ():
        folder = (output or Path("examples")) / name
        typer.echo(f"written: {folder}, {copy_example(name, folder)} files")
    if not names:
        for name, title in known.items():
            typer.echo(f"{name:10} {title}")


@guarded
def explain(
    code: Annotated[str, argument("As a message names it: CMP-SIZE.", metavar="CODE")], as_json: AsJson = False
) -> None:
    """Show the meaning of an error code and the values it carries."""
    from difflib import get_close_matches

    from trueloop.errors import Code

    name = code.upper().replace("_", "-")
    if name not in Code.__members__.values():
        near = get_close_matches(name, [str(one) for one in Code], n=3)
        meant = f"did you mean {' or '.join(near)}?" if near else "docs/errors.md lists all of them"
        raise typer.BadParameter(f"{code!r} is not an error code; {meant}", param_hint="'CODE'")
    found = Code(name)
    if as_json:
        print_json({"code": found, "meaning": found.meaning, "values": list(found.values)})
        return
    typer.echo(f"{found}: {found.meaning}.")
    if found.values:
        typer.echo(f"Values, in the JSON of a message: {', '.join(found.values)}.")
