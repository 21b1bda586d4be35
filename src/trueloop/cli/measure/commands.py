"""`trueloop measure`: what gauges and measuring machines are to measure, and what they reported."""

from pathlib import Path
from typing import Annotated, Literal

import typer

from trueloop.cli.measure.map import map_columns
from trueloop.cli.measure.next import next_measurement
from trueloop.cli.measure.plan import plan
from trueloop.cli.measure.read import read
from trueloop.cli.measure.sheet import sheet
from trueloop.cli.terminal import busy, guarded

File = Annotated[Path, typer.Argument(metavar="FILE", help="What a gauge, a measuring machine or a control wrote.")]
Output = Annotated[
    Path, typer.Option("--output", "-o", help="File to write: QIF 3.0 (.qif), Q-DAS (.dfq) or DMIS (.dmo).")
]
UnitOf = Annotated[
    Literal["mm", "inch"] | None, typer.Option("--unit", help="Unit of its lengths.  [default: what it says]")
]
Mapping = Annotated[
    Path | None, typer.Option("--mapping", "-m", help="TOML file that says what columns, variables and names mean.")
]


@guarded
def convert(file: File, output: Output, unit: UnitOf = None, mapping: Mapping = None) -> None:
    """Write an inspection file in another format: all its parts, in mm and degrees."""
    from trueloop.formats.inspections.measured_file import Stated
    from trueloop.jobs.measure.measured import convert as write_converted

    with busy(f"reading {file}"):
        read = write_converted(file, Stated(unit, mapping), output)
    for remark in read.remarks:
        typer.echo(f"{file}{'' if remark.line is None else f':{remark.line}'}: {remark.text}", err=True)
    values = sum(one.count for one in read.inspections)
    typer.echo(f"{read.format}: {len(read.inspections)} inspections, {values} values", err=True)
    typer.echo(f"written: {output}", err=True)


app = typer.Typer(
    help="Inspection files of gauges and measuring machines, and plans for them.",
    no_args_is_help=True,
    rich_markup_mode=None,
)
app.command()(convert)
app.command("next")(next_measurement)
app.command()(plan)
app.command()(read)
app.command()(sheet)
app.command("map")(map_columns)
