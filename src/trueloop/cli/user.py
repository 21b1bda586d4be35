"""`trueloop user` and `trueloop key`: accounts of people, keys of cells and of programs that read the figures."""

import sys
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.shared_options import Db, argument, option
from trueloop.cli.terminal import AsJson, Group, print_json, print_table

if TYPE_CHECKING:
    from trueloop.storage.store import Store

app = Group("Accounts of the service: who may sign in, and as what.")
Name = Annotated[str, argument("The account.", metavar="NAME")]
RoleOption = Annotated[str, option("viewer, operator, engineer or admin.", "--role")]
FromStdin = Annotated[
    bool, option("Read the password from stdin, one line, instead of asking for it.", "--password-stdin")
]


@app.command()
def add(
    name: Name,
    role: RoleOption,
    display: Annotated[str, option("Name to be shown.  [default: NAME]")] = "",
    language: Annotated[str, option("Of the pages: en or de.")] = "en",
    password_stdin: FromStdin = False,
    db: Db = None,
) -> None:
    """Make an account. The password is prompted for, twice."""
    store = _store(db)
    from trueloop.jobs.user import user_name
    from trueloop.server.identity.accounts import NewAccount, add_account
    from trueloop.server.settings import now

    password = _password(password_stdin)
    made = add_account(store, NewAccount(name, role, password, display, language), now(), by=user_name())  # type: ignore[arg-type]  # what is not a role is refused there
    typer.echo(f"made: {made.name}, {made.role}", err=True)


@app.command()
def list_(db: Db = None, as_json: AsJson = False) -> None:
    """List the accounts."""
    store = _store(db)
    from trueloop.server.identity.accounts import accounts

    found = accounts(store)
    if as_json:
        rows = [{"name": row.name, "display": row.display, "role": row.role, "disabled": row.disabled} for row in found]
        print_json({"accounts": rows})
        return
    cells = [(row.name, row.display, row.role, "disabled" if row.disabled else "") for row in found]
    print_table(("name", "shown as", "role", ""), cells)


@app.command()
def disable(name: Name, enable: Annotated[bool, option("Let it in again.", "--enable")] = False, db: Db = None) -> None:
    """Let an account in no more, and end its sessions."""
    _changed(name, db, disabled=not enable)


@app.command()
def role(name: Name, role: Annotated[str, typer.Argument(metavar="ROLE")], db: Db = None) -> None:
    """Give an account another role, and end its sessions.

    Viewer, operator, engineer or admin.
    """
    _changed(name, db, role=role)


@app.command()
def link(
    name: Name,
    subject: Annotated[str, argument("The person's `sub` there; '' ends the link.", metavar="SUBJECT")],
    issuer: Annotated[str, option("The identity provider, as the service names it.")],
    db: Db = None,
) -> None:
    """Let a person of an identity provider sign in to an account. Its sessions end."""
    from trueloop.server.settings import require_packages

    require_packages()
    from trueloop.server.identity.accounts import subject_of

    _changed(name, db, subject=subject_of(issuer, subject) if subject else "")


@app.command()
def password(name: Name, password_stdin: FromStdin = False, db: Db = None) -> None:
    """Give an account a new password, which is prompted for. Its sessions end."""
    _changed(name, db, password=_password(password_stdin))


def _store(db: str | None) -> "Store":
    """Returns the store. Raises SRV errors where the service's packages are not installed."""
    from trueloop.server.settings import require_packages

    require_packages()
    from trueloop.jobs.store.opened import open_store

    return open_store(db)


def _changed(name: str, db: str | None, **what: object) -> None:
    store = _store(db)
    from trueloop.jobs.user import user_name
    from trueloop.server.identity.accounts import Change, change_account
    from trueloop.server.settings import now

    changed = change_account(store, name, Change(**what), now(), by=user_name())  # type: ignore[arg-type]
    state = "disabled" if changed.disabled else changed.role
    typer.echo(f"changed: {changed.name}, {state}; its sessions have ended", err=True)


def _password(from_stdin: bool) -> str:
    if from_stdin:
        return sys.stdin.readline().rstrip("\r\n")
    return str(typer.prompt("Password", hide_input=True, confirmation_prompt=True, err=True))


keys = Group("Keys by which cells of machines and monitoring get in.")


@keys.command("add")
def add_key(
    name: Annotated[str, argument("Name of the key: its user.", metavar="NAME")],
    machine: Annotated[str, option("The machine whose cell it is for.")] = "",
    days: Annotated[int, option("Days for which it holds.")] = 365,
    metrics: Annotated[bool, option("For /metrics instead of a machine.", "--metrics")] = False,
    db: Db = None,
) -> None:
    """Make a key and print it, this once: the store holds its hash alone."""
    store = _store(db)
    from trueloop.jobs.user import user_name
    from trueloop.server.identity import keys as of_service
    from trueloop.server.settings import now

    new = of_service.NewKey(machine, name, days, "metrics" if metrics else "cell")
    made = of_service.add_key(store, new, user_name(), now())
    typer.echo(made.key)
    typer.echo(f"made: key {made.row.id}, until {made.row.expires_at:%Y-%m-%d}; it is not shown again", err=True)


@keys.command("list")
def list_keys(db: Db = None, as_json: AsJson = False) -> None:
    """List the keys, newest first, without what they are used by."""
    store = _store(db)
    from trueloop.server.identity import keys as of_service

    found = of_service.keys(store)
    if as_json:
        rows = [
            {
                "id": key_row.id,
                "machine": key_row.machine,
                "name": key_row.name,
                "scope": key_row.scope,
                "made_by": key_row.made_by,
                "expires_at": key_row.expires_at.isoformat(),
                "ended_at": key_row.ended_at.isoformat() if key_row.ended_at else None,
            }
            for key_row in found
        ]
        print_json({"keys": rows})
        return
    cells = [
        (
            str(key_row.id),
            key_row.machine,
            key_row.name,
            key_row.scope,
            f"{key_row.expires_at:%Y-%m-%d}",
            "ended" if key_row.ended_at else "",
        )
        for key_row in found
    ]
    print_table(("key", "machine", "name", "for", "until", ""), cells)


@keys.command("end")
def end_key(
    number: Annotated[int, argument("Its number, as `key list` shows it.", metavar="KEY")], db: Db = None
) -> None:
    """End a key: from now on nothing gets in by it."""
    store = _store(db)
    from trueloop.jobs.user import user_name
    from trueloop.server.identity import keys as of_service
    from trueloop.server.settings import now

    of_service.end_key(store, number, now(), by=user_name())
    typer.echo(f"ended: key {number}", err=True)
