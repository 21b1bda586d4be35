"""`trueloop db find`: what the store holds, as a table."""

from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, print_json, print_lines, wide_console

if TYPE_CHECKING:
    from trueloop.jobs.db.found import Row

What = Annotated[str, typer.Argument(metavar="WHAT", help="part, inspection, correction, cut, edge, transfer, …")]


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """Which rows."""

    part_type: Annotated[str | None, typer.Option("--type", help="Of this type of part, by its name.")] = None
    serial: Annotated[str | None, typer.Option("--serial", help="Of the part with this serial number.")] = None
    edge: Annotated[
        str | None, typer.Option("--edge", help="Of this edge: TOOL, TOOL/INSERT or TOOL/INSERT/CORNER.")
    ] = None
    since: Annotated[
        datetime | None,
        typer.Option("--since", formats=["%Y-%m-%d", "%Y-%m-%dT%H:%M"], help="Kept on or after that day or time, UTC."),
    ] = None
    superseded: Annotated[bool, typer.Option("--superseded", help="Also rows that others supersede.")] = False


@guarded
def find(what: What, wanted: Wanted, db: Db = None, as_json: AsJson = False) -> None:
    """List rows of the store, oldest first: each with its name, by which `show` and `replace` take it."""
    from trueloop.jobs.db.found import NAMES, TRANSFERS, Sought, found_rows
    from trueloop.jobs.store.opened import opened

    known = (*NAMES, TRANSFERS)
    if what not in known:
        raise typer.BadParameter(f"{what!r} is none of {', '.join(known)}", param_hint="WHAT")
    sought = Sought(wanted.part_type, wanted.serial, wanted.edge, wanted.since, superseded=wanted.superseded)
    rows = found_rows(opened(db), what, sought)
    if as_json:
        print_json({"what": what, "rows": [row.as_dict for row in rows]})
    else:
        _print(rows)


def _print(rows: "list[Row]") -> None:
    if rows:
        from rich.markup import escape
        from rich.table import Table

        table = Table(box=None, pad_edge=False)
        for name in ("row", "kept", *rows[0].cells):
            table.add_column(name.replace("_", " "), no_wrap=True)
        for row in rows:
            table.add_row(*(escape(cell) for cell in (row.name, f"{row.kept_at:%Y-%m-%d %H:%M}", *row.cells.values())))
        wide_console().print(table)
    print_lines([f"{len(rows)} {'row' if len(rows) == 1 else 'rows'}"])
