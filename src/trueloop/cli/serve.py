"""`trueloop serve`: the factory as a service, over HTTP."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded

if TYPE_CHECKING:
    from trueloop.server.run import Listening
    from trueloop.server.settings import Settings

HELD_OPEN: Final = 16
"""Connections to a store in a file that stay open: opening one costs as much as reading a part's life."""


@dataclass(frozen=True, kw_only=True)
class Where:
    """Where it listens."""

    host: Annotated[str, typer.Option("--host", help="Address to listen at; others than this machine's need TLS.")] = (
        "127.0.0.1"
    )
    port: Annotated[
        int | None,
        typer.Option("--port", min=0, max=65535, help="0: any that is free.  [default: 8080, with TLS 8443]"),
    ] = None
    tls_cert: Annotated[
        Path | None, typer.Option("--tls-cert", metavar="FILE", help="Certificate and its chain, PEM.")
    ] = None
    tls_key: Annotated[Path | None, typer.Option("--tls-key", metavar="FILE", help="Its key, PEM.")] = None
    name: Annotated[
        list[str] | None, typer.Option("--name", metavar="HOST", help="A name by which browsers reach it; repeatable.")
    ] = None

    def listening(self) -> "Listening":
        """As the server takes it."""
        from trueloop.server.run import Listening

        port = self.port if self.port is not None else 8443 if self.tls_cert else 8080
        return Listening(self.host, port, self.tls_cert, self.tls_key)


@guarded
def serve(where: Where, db: Db = None) -> None:
    """Serve the store's pages and interface, until Ctrl-C or SIGTERM."""
    from trueloop.server.packages import require_packages

    require_packages()
    from trueloop.jobs.store.opened import opened
    from trueloop.server.identity.accounts import accounts
    from trueloop.server.run import require_safe
    from trueloop.server.run import serve as run

    listening = where.listening()
    require_safe(listening)
    store = opened(db, held_open=HELD_OPEN)
    if not accounts(store):
        typer.echo("note: there is no account yet: trueloop user add NAME --role admin", err=True)
    run(store, _settings(where), listening, lambda at: typer.echo(f"serving {store.where} at {at}"))
    store.close()


def _settings(where: Where) -> "Settings":
    from trueloop.server.settings import LOOPBACK_NAMES, Settings

    host = f"[{where.host}]" if ":" in where.host else where.host
    given = (*LOOPBACK_NAMES, host, *(where.name or ()))
    names = tuple(dict.fromkeys(one.casefold() for one in given))
    return Settings(tls=where.tls_cert is not None, names=names)
