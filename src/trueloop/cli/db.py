"""`trueloop db`: the store of parts, tools, inspections and corrections."""

import json
from dataclasses import dataclass
from datetime import datetime
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.shared_options import Db, argument, option
from trueloop.cli.terminal import AsJson, ExitStatus, Group, as_dict, busy, print_json, print_lines, wide_console

if TYPE_CHECKING:
    from trueloop.domain.part import Part
    from trueloop.jobs.db.found import Entry, Row
    from trueloop.jobs.db.imported import Imported


def check(db: Db = None, as_json: AsJson = False) -> None:
    """Check rows, links, labels, order and times of a store.

    Rows must be what was kept, links must lead to rows; labels, order and times must agree.
    """
    from trueloop.jobs.db.imported import check_store
    from trueloop.jobs.store.opened import open_store

    store = open_store(db, read_only=True)
    with busy(f"checking {store.where}") as progress:
        done = check_store(store, progress)
    if as_json:
        odd = [{"severity": finding.severity, **as_dict(finding.as_error())} for finding in done.findings]
        print_json({"store": store.where, "rows": done.rows, "findings": odd})
    else:
        print_lines([*done.findings, f"{store.where}: {done.rows} rows, {len(done.findings)} findings"])
    if done.findings:
        raise typer.Exit(ExitStatus.FINDINGS)


Copy = Annotated[Path, argument("The file to write, which must be new.", metavar="FILE")]
Backup = Annotated[Path, argument("A backup, or what `export` wrote.", metavar="FILE")]
New = Annotated[str, option("The store to make, which must be new.", "--db", metavar="FILE|URL")]


def backup(file: Copy, db: Db = None) -> None:
    """Copy the store into a SQLite file, while it is in use.

    As it is at one moment.
    """
    from trueloop.jobs.db.copied import back_up
    from trueloop.jobs.store.opened import open_store

    store = open_store(db, read_only=True)
    with busy(f"copying {store.where}") as progress:
        back_up(store, file, progress)
    typer.echo(f"written: {file}", err=True)


def restore(file: Backup, db: New) -> None:
    """Make a new store of what a backup or an export holds. A store that is there is never changed."""
    from trueloop.jobs.db.copied import restore as restored
    from trueloop.storage.keeping import shown

    with busy(f"restoring {file}") as progress:
        copied = restored(file, db, progress)
    typer.echo(f"made: {shown(db)}, {copied.count} rows", err=True)


Output = Annotated[Path, option("File to write: JSON, one value a line.", "--output", "-o")]


def export(output: Output, db: Db = None) -> None:
    """Write the whole store into a text file.

    One value a line; imported into an empty store, it gives an equal one.
    """
    from trueloop.jobs.db.copied import export as write
    from trueloop.jobs.store.opened import open_store

    store = open_store(db, read_only=True)
    with busy(f"exporting {store.where}"):
        count = write(store, output)
    typer.echo(f"written: {output}, {count} values", err=True)


FindWhat = Annotated[str, argument("part, inspection, correction, cut, edge, transfer, …", metavar="WHAT")]


@dataclass(frozen=True, kw_only=True)
class Wanted:
    """Selects rows."""

    part_type: Annotated[str | None, option("Of this type of part, by its name.", "--type")] = None
    serial: Annotated[str | None, option("Of the part with this serial number.")] = None
    edge: Annotated[str | None, option("Of this edge: TOOL, TOOL/INSERT or TOOL/INSERT/CORNER.")] = None
    since: Annotated[
        datetime | None, option("Kept on or after that day or time, UTC.", formats=["%Y-%m-%d", "%Y-%m-%dT%H:%M"])
    ] = None
    superseded: Annotated[bool, option("Also rows that others supersede.", "--superseded")] = False


def find(what: FindWhat, wanted: Wanted, db: Db = None, as_json: AsJson = False) -> None:
    """List rows of the store, oldest first.

    Each has its name, by which `show` and `replace` take it.
    """
    from trueloop.jobs.db.found import NAMES, TRANSFERS, Sought, found_rows
    from trueloop.jobs.store.opened import open_store

    known = (*NAMES, TRANSFERS)
    if what not in known:
        raise typer.BadParameter(f"{what!r} is not one of {', '.join(known)}", param_hint="WHAT")
    sought = Sought(wanted.part_type, wanted.serial, wanted.edge, wanted.since, superseded=wanted.superseded)
    rows = found_rows(open_store(db), what, sought)
    if as_json:
        print_json({"what": what, "rows": [row.as_dict for row in rows]})
    else:
        _find_print(rows)


def _find_print(rows: "list[Row]") -> None:
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


Files = Annotated[
    list[Path], argument("Inspection files, a job's touches, record.json, or exports of a store.", metavar="FILE…")
]


@dataclass(frozen=True, kw_only=True)
class Meant:
    """Facts that inspection files lack."""

    job: Annotated[
        Path | None, option("The job whose part was measured.  [default: as the file states]", "--job", "-j")
    ] = None
    serial: Annotated[str, option("Serial number of the part.  [default: the file's, the job's, the label's]")] = ""
    unit: Annotated[Literal["mm", "inch"] | None, option("Unit of its lengths.  [default: as it states]")] = None
    mapping: Annotated[
        Path | None, option("TOML file that states what columns, variables and names mean.", "--mapping", "-m")
    ] = None
    ignore_labels: Annotated[
        bool, option("Take a label in a file's name for no statement about the part.", "--ignore-labels")
    ] = False


def import_(files: Files, meant: Meant, db: Db = None, as_json: AsJson = False) -> None:
    """Keep files in the store, each whole or not at all. What is there already is found and not kept twice."""
    from trueloop.formats.inspections.measured_file import StatedFacts
    from trueloop.jobs.db.imported import InspectionOptions, import_files
    from trueloop.jobs.store.opened import open_store

    store = open_store(db)
    of = InspectionOptions(
        meant.job, meant.serial, StatedFacts(meant.unit, meant.mapping), heed_labels=not meant.ignore_labels
    )
    done: list[Imported] = []
    with busy(f"importing {files[0]}") as progress:
        for imported in import_files(store, files, of, progress):
            done.append(imported)
            if not as_json:
                print_lines([imported.words])
    if as_json:
        print_json({"files": [imported.as_dict for imported in done]})


Place = Annotated[
    str | None, argument("The store to make.  [default: trueloop.db in this folder]", metavar="[FILE|URL]")
]


def init(place: Place = None) -> None:
    """Make an empty store: a SQLite file, or in PostgreSQL.

    A PostgreSQL database is named by its URL.
    """
    from trueloop.jobs.store.opened import BESIDE, make_store
    from trueloop.storage.keeping import shown

    make_store(place or BESIDE)
    typer.echo(f"made: {shown(place or BESIDE)}", err=True)


RowId = Annotated[str, argument("The wrong row, as `find` names it: inspection:12.", metavar="ROW")]
File = Annotated[Path, argument("Output of `show ROW --json`, with the mistake mended.", metavar="FILE")]
Why = Annotated[str, option("The mistake in the row.", "--why")]
By = Annotated[str, option("Name of the person who decides.  [default: the user]", "--by")]


def replace(row: RowId, file: File, why: Why, by: By = "", db: Db = None) -> None:
    """Replace a row by the value in a file.

    The row stays, superseded, with the person and the reason.
    """
    from trueloop.jobs.db.found import left_behind, named_row, replace_row, row_name
    from trueloop.jobs.store.opened import open_store
    from trueloop.jobs.user import user_name

    store = open_store(db)
    wrong = named_row(store, row)
    kept = replace_row(store, wrong, file, by=by or user_name(), why=why)
    typer.echo(f"kept: {row_name(type(kept.value), kept.row)} supersedes {row}", err=True)
    for name in left_behind(store, wrong, kept):
        typer.echo(f"still names the row that was replaced: {name}; replace it too", err=True)


What = Annotated[str, argument("A part's SERIAL, TYPE/SERIAL or label; a record's id; or a row.", metavar="WHAT")]


def show(what: What, db: Db = None, as_json: AsJson = False) -> None:
    """Show the life of a part, or one row as it is stored.

    Inspections, corrections and cuts with their links.
    """
    from trueloop.jobs.db.found import NamedRow, life_of_part, named, shown_row
    from trueloop.jobs.store.opened import open_store

    store = open_store(db, read_only=True)
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
        print_json({"part": part, "entries": [entry.as_dict for entry in entries]})
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
    for entry in entries:
        at = f"{entry.at:%Y-%m-%d %H:%M}" if entry.at else f"kept {entry.kept_at:%Y-%m-%d %H:%M}"
        table.add_row(*map(escape, (at, entry.row, entry.said, "; ".join(entry.links))))
    wide_console().print(table)


app = Group("The store: parts, edges, inspections, cuts, corrections. Kept for the next part.")
app.add_all(init, import_, export, find, show, check, replace, backup, restore)
app.removed("migrate", "`trueloop db export` by the version that wrote the store, then `trueloop db restore` here")
