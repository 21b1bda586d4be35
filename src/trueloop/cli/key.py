"""`trueloop key`: keys of machines' cells and of programs that read the service's figures."""

from typing import Annotated

import typer

from trueloop.cli.shared_options import Db, argument, option
from trueloop.cli.terminal import AsJson, Group, print_json, print_table

app = Group("Keys by which cells of machines and monitoring get in.")


@app.command()
def add(
    name: Annotated[str, argument("What to call it: who or what uses it.", metavar="NAME")],
    machine: Annotated[str, option("The machine whose cell it is for.")] = "",
    days: Annotated[int, option("How many days it holds.")] = 365,
    metrics: Annotated[bool, option("For /metrics instead of a machine.", "--metrics")] = False,
    db: Db = None,
) -> None:
    """Make a key and print it, this once: the store holds its hash alone."""
    from trueloop.server.settings import require_packages

    require_packages()
    from trueloop.jobs.store.opened import opened
    from trueloop.jobs.user import user_name
    from trueloop.server.identity.keys import NewKey, add_key
    from trueloop.server.settings import now

    new = NewKey(machine, name, days, "metrics" if metrics else "cell")
    made = add_key(opened(db), new, user_name(), now())
    typer.echo(made.key)
    typer.echo(f"made: key {made.row.id}, until {made.row.expires_at:%Y-%m-%d}; it is not shown again", err=True)


@app.command()
def list_(db: Db = None, as_json: AsJson = False) -> None:
    """List the keys, newest first, without what they are used by."""
    from trueloop.server.settings import require_packages

    require_packages()
    from trueloop.jobs.store.opened import opened
    from trueloop.server.identity.keys import keys

    found = keys(opened(db))
    if as_json:
        rows = [
            {
                "id": one.id,
                "machine": one.machine,
                "name": one.name,
                "scope": one.scope,
                "made_by": one.made_by,
                "expires_at": one.expires_at.isoformat(),
                "ended_at": one.ended_at.isoformat() if one.ended_at else None,
            }
            for one in found
        ]
        print_json({"keys": rows})
        return
    cells = [
        (str(one.id), one.machine, one.name, one.scope, f"{one.expires_at:%Y-%m-%d}", "ended" if one.ended_at else "")
        for one in found
    ]
    print_table(("key", "machine", "name", "for", "until", ""), cells)


@app.command()
def end(number: Annotated[int, argument("Its number, as `key list` shows it.", metavar="KEY")], db: Db = None) -> None:
    """End a key: from now on nothing gets in by it."""
    from trueloop.server.settings import require_packages

    require_packages()
    from trueloop.jobs.store.opened import opened
    from trueloop.jobs.user import user_name
    from trueloop.server.identity.keys import end_key
    from trueloop.server.settings import now

    end_key(opened(db), number, now(), by=user_name())
    typer.echo(f"ended: key {number}", err=True)
