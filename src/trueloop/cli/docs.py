"""`trueloop docs`: the manual in the browser."""

from contextlib import suppress
from typing import Annotated

import typer

from trueloop.cli.failure import guarded


@guarded
def docs(
    words: Annotated[list[str] | None, typer.Argument(help="What to search for; left out, the first page.")] = None,
    port: Annotated[int, typer.Option("--port", min=0, max=65535, help="Port to serve at; 0: any that is free.")] = 0,
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Print the address and open no browser.")] = False,
) -> None:
    """Show the manual in the browser, served to this machine alone until Ctrl-C; no network is needed."""
    from trueloop.server import manual

    with manual.listening(manual.require_built(manual.folder()), port) as server:
        found = manual.address(server, " ".join(words or ()))
        typer.echo(f"the manual is at {found} (Ctrl-C ends it)")
        if not no_browser:
            import webbrowser

            webbrowser.open(found)
        with suppress(KeyboardInterrupt):
            server.serve_forever()
