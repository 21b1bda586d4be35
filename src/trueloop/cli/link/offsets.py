"""`trueloop link offsets`: a control's tool table in force, shown, or written with the offset of a correction."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.link.link_of import LinkOf, NotRunning
from trueloop.cli.offsets import UnitOption
from trueloop.cli.terminal import AsJson, print_json, print_lines

if TYPE_CHECKING:
    from trueloop.jobs.links.offsets import AtControl


@guarded
def offsets(
    control: LinkOf,
    correction: Annotated[
        Path | None,
        typer.Option(
            "--apply",
            help="A correction, its record or its job: write the table with its offset.",
            metavar="JOB.toml|RECORD.json",
        ),
    ] = None,
    table: Annotated[
        str | None,
        typer.Option("--table", "-t", help="The table's name at the control.  [default: the settings' tool_table]"),
    ] = None,
    unit: UnitOption = None,
    not_running: NotRunning = False,
    as_json: AsJson = False,
) -> None:
    """Show a control's tool table as it is in force, or write it with the offset of a correction in it."""
    from trueloop.jobs.links.offsets import apply_at, fetched_table, with_table
    from trueloop.report.tool_tables import heading_words, table_as_dict, table_lines

    opened = with_table(control.opened(), table, unit)
    if correction is not None:
        _show(apply_at(opened, correction, not_running=not_running), as_json)
        return
    found = fetched_table(opened)
    if as_json:
        print_json(table_as_dict(found))
        return
    print_lines([heading_words(found), "", *table_lines(found), *(f"- {one}" for one in found.remarks)])


def _show(done: "AtControl", as_json: bool) -> None:
    from trueloop.report.tool_tables import change_as_dict, change_words

    sent = done.sent
    kept = None if sent.kept is None else str(sent.kept)
    if as_json:
        change = change_as_dict(done.record_id, done.table, done.new, sent.name)
        hashes = {"sent_sha256": sent.sent_sha256, "read_back_sha256": sent.read_back_sha256}
        print_json(change | hashes | {"kept": kept})
        return
    print_lines([f"Correction {done.record_id}", *change_words(done.table, done.new)])
    typer.echo(f"{sent.name}: read back as it was sent, {sent.read_back_sha256[:16]}; the table before it: {kept}")
