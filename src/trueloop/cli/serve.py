"""`trueloop serve`: the factory as a service, over HTTP."""

import os
import sys
import threading
import webbrowser
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final

import typer

from trueloop.cli.shared_options import Db, option
from trueloop.cli.terminal import busy, guarded

if TYPE_CHECKING:
    from trueloop.server.identity.keys import Role
    from trueloop.server.identity.oidc import Oidc
    from trueloop.server.run import Listening
    from trueloop.server.settings import Settings

SECRET: Final = "TRUELOOP_OIDC_SECRET"


@dataclass(frozen=True, kw_only=True)
class Where:
    """Address and port of the service."""

    host: Annotated[str, option("Address to listen at; others than this machine's need TLS.")] = "127.0.0.1"
    port: Annotated[int | None, option("0: any that is free.  [default: 8080, with TLS 8443]", min=0, max=65535)] = None
    tls_cert: Annotated[Path | None, option("Certificate and its chain, PEM.", metavar="FILE")] = None
    tls_key: Annotated[Path | None, option("Its key, PEM.", metavar="FILE")] = None
    forwarded_allow_ips: Annotated[
        list[str] | None,
        option(
            "Address of a proxy that answers TLS before it and passes X-Forwarded-For on; repeatable.",
            metavar="ADDRESS",
        ),
    ] = None
    name: Annotated[list[str] | None, option("A name by which browsers reach it; repeatable.", metavar="HOST")] = None

    def listening(self) -> "Listening":
        """As the server takes it."""
        from trueloop.server.run import Listening

        port = self.port if self.port is not None else 8443 if self.tls_cert else 8080
        return Listening(self.host, port, self.tls_cert, self.tls_key, self._proxies())

    def seen_by_browsers(self, at: str) -> str:
        """Returns the address of the first page; `at`: where the service listens."""
        if not self.name:
            return at
        port = "" if self.forwarded_allow_ips else f":{at.rstrip('/').rpartition(':')[2]}"
        return f"{at.partition(':')[0]}://{self.name[0]}{port}/"

    def _proxies(self) -> tuple[str, ...]:
        """Raises a usage error for anything that is not an address: anybody could then name himself."""
        from ipaddress import ip_network

        for given in self.forwarded_allow_ips or ():
            try:
                ip_network(given)
            except ValueError:
                raise typer.BadParameter(
                    f"--forwarded-allow-ips {given!r} is neither an address nor a network"
                ) from None
        return tuple(self.forwarded_allow_ips or ())


@dataclass(frozen=True, kw_only=True)
class SignOn:
    """Whom it trusts to say who signs in."""

    oidc_issuer: Annotated[str | None, option("Identity provider (OpenID Connect).", metavar="URL")] = None
    oidc_client_id: Annotated[str | None, option("Its name for this service.")] = None
    oidc_secret_file: Annotated[
        Path | None,
        option(
            f"The client's secret.  [default: the environment variable {SECRET}; without both, none]", metavar="FILE"
        ),
    ] = None
    oidc_label: Annotated[str, option("Its name on the sign-in page.")] = "Single sign-on"
    oidc_role_claim: Annotated[
        str | None, option("Claim that gives the role.  [default: the account's]", metavar="CLAIM")
    ] = None
    oidc_role: Annotated[
        list[str] | None, option("Which value of it gives which role; repeatable.", metavar="VALUE=ROLE")
    ] = None

    def trusted(self) -> "Oidc | None":
        """As the service takes it. Raises SRV-PROVIDER, CLI usage errors."""
        from trueloop.server.identity.oidc import Oidc, require_safe_issuer

        if self.oidc_issuer is None:
            return None
        if not self.oidc_client_id:
            raise typer.BadParameter("--oidc-issuer needs --oidc-client-id")
        require_safe_issuer(self.oidc_issuer)
        claim, roles = self.oidc_role_claim or "", tuple(map(_role, self.oidc_role or ()))
        if bool(claim) != bool(roles):
            raise typer.BadParameter("--oidc-role-claim and --oidc-role go together")
        return Oidc(
            issuer=self.oidc_issuer,
            client_id=self.oidc_client_id,
            secret=self._secret(),
            label=self.oidc_label,
            role_claim=claim,
            roles=roles,
        )

    def _secret(self) -> str:
        from trueloop.errors import Code
        from trueloop.formats.input_file import read_text

        if self.oidc_secret_file is None:
            return os.environ.get(SECRET, "")
        return read_text(self.oidc_secret_file, Code.SRV_PROVIDER, hint="write the secret into it, alone").strip()


def _role(text: str) -> "tuple[str, Role]":
    from trueloop.server.identity.keys import ROLES

    value, _, role = text.rpartition("=")
    if not value or role not in ROLES:
        raise typer.BadParameter(f"{text!r} is no VALUE=ROLE with a role of {', '.join(ROLES)}")
    return value, role


Links = Annotated[
    Path | None,
    option("Settings of links to controls, to be shown.  [default: no settings]", "--links", metavar="LINKS.toml"),
]


@guarded
def serve(
    where: Where,
    sign_on: SignOn,
    links: Links = None,
    db: Db = None,
    demo: Annotated[bool, option("Serve a shop of the examples, in trueloop-demo.db.", "--demo")] = False,
    no_browser: Annotated[bool, option("Print the address and open no browser.", "--no-browser")] = False,
) -> None:
    """Serve the store's pages and interface, until Ctrl-C.

    SIGTERM ends it as well. A folder without a store gets one.
    """
    if demo and db is not None:
        raise typer.BadParameter("a store of its own is made: leave out --db", param_hint="--demo")
    from trueloop.server.settings import require_packages

    require_packages()
    from trueloop.jobs.store.opened import BESIDE, make_store, open_store
    from trueloop.server.run import listen, require_safe
    from trueloop.server.run import serve as run

    listening = where.listening()
    require_safe(listening)
    oidc = sign_on.trusted()
    if links is not None:
        from trueloop.formats.links_toml import read_links

        read_links(links)  # refuses a wrong file now; it is read again where it is changed

    def ready(at: str, first: str) -> None:
        typer.echo(f"serving {store.where} at {at}")
        link = where.seen_by_browsers(at) + first
        if first:
            typer.echo(f"no account yet: make the first one, an administrator, at {link}")
        if not no_browser and sys.stdout.isatty():
            threading.Thread(target=webbrowser.open, args=(link,), daemon=True).start()

    with listen(listening) as socket:  # before a store is made: a port that is taken leaves none behind
        if demo:
            db = _example_shop()
        elif db is None and not Path(BESIDE).exists():
            make_store(BESIDE).close()
            typer.echo(f"made the store {BESIDE}", err=True)
        store = open_store(db)
        run(store, _settings(where, listening.tls, links), listening, ready, listening=socket, oidc=oidc)
        store.close()


def _example_shop() -> str:
    """Returns the store of the examples in the present folder, made where there is none."""
    from trueloop_lab.example_shop import FILE, make_example_shop

    if not Path(FILE).exists():
        with busy("filling the shop with the examples"):
            make_example_shop(Path(FILE))
        typer.echo(f"made the store {FILE} of the examples", err=True)
    return FILE


def _settings(where: Where, tls: bool, links: Path | None) -> "Settings":
    from trueloop.server.settings import LOOPBACK_NAMES, Settings

    host = f"[{where.host}]" if ":" in where.host else where.host
    given = (*LOOPBACK_NAMES, host, *(where.name or ()))
    names = tuple(dict.fromkeys(one.casefold() for one in given))
    return Settings(tls=tls, names=names, links=links)
