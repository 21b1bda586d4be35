"""`trueloop db show`: the life of a part, or one row."""

import json
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.db.options import Db
from trueloop.cli.failure import guarded
from trueloop.cli.terminal import AsJson, print_json, print_lines, wide_console

if TYPE_CHECKING:
    from trueloop.domain.part import Part
    from trueloop.jobs.db.life import Entry

What = Annotated[
    str, typer.Argument(metavar="WHAT", help="A part's SERIAL, TYPE/SERIAL or label; a record's id; or a row.")
]


@guarded
def show(what: What, db: Db = None, as_json: AsJson = False) -> None:
    """Show the life of a part: inspections, corrections and cuts with their links; or one row as it is stored."""
    from trueloop.jobs.db.life import life_of_part
    from trueloop.jobs.db.named import NamedRow, named
    from trueloop.jobs.db.replaced import shown_row
    from trueloop.jobs.store.opened import opened

    store = opened(db, read_only=True)
    found = named(store, what)
    if isinstance(found, NamedRow):
        row = shown_row(store, found)
        if as_json:
            print_json(row)
        else:
            print_lines(json.dumps(row, indent=2, ensure_ascii=False).splitlines())
        return
    entries = life_of_part(store, found)
    if as_json:
        part = {"part_type": found.part_type.name, "revision": found.part_type.revision, "serial": found.serial}
        print_json({"part": part, "entries": [one.as_dict for one in entries]})
    else:
        _print(found, entries)


def _print(part: "Part", entries: "tuple[Entry, ...]") -> None:
    from rich.markup import escape
    from rich.table import Table

    kind = part.part_type
    stated = [kind.name, *([f"revision {kind.revision}"] if kind.revision else []), f"serial {part.serial}"]
    print_lines([", ".join([*stated, *([kind.material] if kind.material else [])])])
    table = Table(box=None, pad_edge=False)
    for name in ("time", "row", "", "links"):
        table.add_column(name)
    for one in entries:
        at = f"{one.at:%Y-%m-%d %H:%M}" if one.at else f"kept {one.kept_at:%Y-%m-%d %H:%M}"
        table.add_row(*map(escape, (at, one.row, one.said, "; ".join(one.links))))
    wide_console().print(table)
