"""`trueloop offsets` and `trueloop record`: a correction's offset in tool tables of controls, and its record."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from trueloop.cli.shared_options import Control, UnitOption, argument, option
from trueloop.cli.terminal import AsJson, Group, busy, print_json, print_lines, put

app = Group("Tool tables of controls, read and written with an offset. The offset is that of a correction.")

OfCorrection = Annotated[
    Path, argument("The correction: its record, or its job, computed anew.", metavar="JOB.toml|RECORD.json")
]


@app.command()
def read(
    file: Annotated[Path, argument("A control's tool table: docs/offsets.md lists them.", metavar="FILE")],
    unit: UnitOption = None,
    as_json: AsJson = False,
) -> None:
    """Show a tool table: offsets, nose radii, tips, names.

    Numbers as they stand in the file.
    """
    from trueloop.formats.tables.tool_tables.known import read_tool_table
    from trueloop.report.tool_tables import heading_words, table_as_dict, table_lines

    table = read_tool_table(file, unit)
    if as_json:
        print_json(table_as_dict(table))
        return
    typer.echo("\n".join([heading_words(table), "", *table_lines(table), *(f"- {remark}" for remark in table.remarks)]))


@app.command()
def apply(
    correction: OfCorrection,
    table: Annotated[Path, option("The control's tool table as it is in force.", "--table", "-t")],
    output: Annotated[Path, option("The new table to write.", "--output", "-o")],
    unit: UnitOption = None,
    as_json: AsJson = False,
) -> None:
    """Write a tool table with a correction's offset in it.

    All else of the table stays byte for byte.
    """
    from trueloop.jobs.turned.outputs import apply_offset
    from trueloop.report.tool_tables import change_as_dict, change_words

    with busy(f"reading {correction}"):
        applied = apply_offset(correction, table, output, unit)
    if as_json:
        print_json(change_as_dict(applied.record_id, applied.table, applied.new, applied.written))
        return
    print_lines([f"Correction {applied.record_id}", *change_words(applied.table, applied.new)])
    typer.echo(f"written: {applied.written}", err=True)


@app.command()
def program(
    correction: OfCorrection,
    control: Annotated[
        Control | None, option("The control.  [default: the corrected program's]", "--control", "-c")
    ] = None,
    x_is: Annotated[
        Literal["radius", "diameter"] | None, option("Offsets on X at another control than the program's.")
    ] = None,
    output: Annotated[Path | None, option("File to write.  [default: stdout]", "--output", "-o")] = None,
) -> None:
    """Write a correction's offset as a program to run once.

    In the control's own words.
    """
    from trueloop.jobs.turned.outputs import offset_words

    with busy(f"reading {correction}"):
        text = offset_words(correction, control, x_is)
    put(text, output, [correction])


records = Group("Records of corrections: inputs, model, limits, decision.")


@records.callback()
def _commands() -> None:
    """Makes typer keep the name of a single command."""


@records.command()
def show(
    file: Annotated[Path, argument("A record.json or STEM.record.json.", metavar="RECORD.json")],
    as_json: AsJson = False,
) -> None:
    """Show a correction's inputs, model, limits and decision.

    Also by whom, and when.
    """
    from trueloop.formats.record_file import read_record
    from trueloop.report.record import as_dict, words

    record = read_record(file)
    if as_json:
        print_json(as_dict(record))
        return
    typer.echo(f"Correction {record.id}")
    for heading, lines in words(record):
        typer.echo("\n".join([f"\n{heading}", *(f"  {line}" for line in lines)]))
