"""`trueloop offsets`: tool tables of controls, and a correction's offset in them."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from trueloop.cli.shared_options import Control, UnitOption
from trueloop.cli.terminal import AsJson, busy, guarded, print_json, print_lines, put

app = typer.Typer(
    help="Tool tables of controls: read, and written with the offset of a correction.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

OfCorrection = Annotated[
    Path, typer.Argument(metavar="JOB.toml|RECORD.json", help="The correction: its record, or its job, computed anew.")
]


@app.command()
@guarded
def read(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A control's tool table: docs/offsets.md lists them.")],
    unit: UnitOption = None,
    as_json: AsJson = False,
) -> None:
    """Show a tool table: tools, offsets, nose radii, tips and names, numbers as they stand in the file."""
    from trueloop.formats.tables.tool_tables.known import read_tool_table
    from trueloop.report.tool_tables import heading_words, table_as_dict, table_lines

    table = read_tool_table(file, unit)
    if as_json:
        print_json(table_as_dict(table))
        return
    typer.echo("\n".join([heading_words(table), "", *table_lines(table), *(f"- {one}" for one in table.remarks)]))


@app.command()
@guarded
def apply(
    correction: OfCorrection,
    table: Annotated[Path, typer.Option("--table", "-t", help="The control's tool table as it is in force.")],
    output: Annotated[Path, typer.Option("--output", "-o", help="The new table to write.")],
    unit: UnitOption = None,
    as_json: AsJson = False,
) -> None:
    """Write a tool table with the offset of a correction in it; all else of the table stays byte for byte."""
    from trueloop.jobs.turned.tool_offsets import apply_offset
    from trueloop.report.tool_tables import change_as_dict, change_words

    with busy(f"reading {correction}"):
        applied = apply_offset(correction, table, output, unit)
    if as_json:
        print_json(change_as_dict(applied.record_id, applied.table, applied.new, applied.written))
        return
    print_lines([f"Correction {applied.record_id}", *change_words(applied.table, applied.new)])
    typer.echo(f"written: {applied.written}", err=True)


@app.command()
@guarded
def program(
    correction: OfCorrection,
    control: Annotated[
        Control | None, typer.Option("--control", "-c", help="The control.  [default: the corrected program's]")
    ] = None,
    x_is: Annotated[
        Literal["radius", "diameter"] | None,
        typer.Option("--x-is", help="How another control than the program's counts offsets on X."),
    ] = None,
    output: Annotated[Path | None, typer.Option("--output", "-o", help="File to write.  [default: stdout]")] = None,
) -> None:
    """Write the offset of a correction as a small program in the control's own words, to be run once."""
    from trueloop.jobs.turned.tool_offsets import offset_words

    with busy(f"reading {correction}"):
        text = offset_words(correction, control, x_is)
    put(text, output, [correction])
