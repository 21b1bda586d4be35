"""`trueloop measure map`: what the columns of a table of measured values mean, as a file to keep and to change."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.terminal import guarded, print_lines

if TYPE_CHECKING:
    from trueloop.jobs.measure.table_mapping import Mapped

File = Annotated[Path, typer.Argument(metavar="FILE", help="A table of measured values: CSV, .xlsx, .xls or .ods.")]
Output = Annotated[
    Path | None, typer.Option("--output", "-o", help="Mapping to write.  [default: FILE.map.toml beside it]")
]
Sheet = Annotated[str, typer.Option("--sheet", help="Sheet of a workbook.  [default: the only one with headings]")]
Unit = Annotated[
    Literal["mm", "inch"] | None, typer.Option("--unit", help="Unit of its lengths.  [default: what it says]")
]
Columns = Annotated[
    list[str] | None,
    typer.Option(
        "--column",
        "-c",
        metavar="MEANING=HEADING",
        help="What a column holds: actual=Ist; several times. Of columns side by side: parts=, repeats=, "
        "characteristics=.",
    ),
]
SHOWN = 8


@guarded
def map_columns(
    file: File, output: Output = None, sheet: Sheet = "", unit: Unit = None, column: Columns = None
) -> None:
    """Propose what the columns of a table mean, show its first values as they would be read, and write the mapping."""
    from trueloop.errors import TrueloopError
    from trueloop.jobs.measure.table_mapping import map_table

    mapped = map_table(file, output, sheet, unit, _given(column or []))
    _print_columns(mapped)
    if isinstance(mapped.file, TrueloopError):
        typer.echo(f"written: {mapped.path}", err=True)
        raise mapped.file
    _print_values(mapped)
    typer.echo(f"written: {mapped.path}", err=True)


def _given(columns: list[str]) -> dict[str, list[str]]:
    from trueloop.formats.inspections.tables.mapping import Columns as Known

    given: dict[str, list[str]] = {}
    for text in columns:
        meaning, equals, heading = text.partition("=")
        if not equals or meaning not in Known.model_fields:
            known = ", ".join(Known.model_fields)
            raise typer.BadParameter(f"{text!r} is no MEANING=HEADING; meanings: {known}", param_hint="--column")
        given.setdefault(meaning, []).append(heading)
    return given


def _print_columns(mapped: "Mapped") -> None:
    mapping = mapped.mapping
    print_lines([f"headings in row {mapping.header_row}" + (f" of sheet {mapping.sheet!r}" if mapping.sheet else "")])
    print_lines(f"  {role:<16} {name}" for role, name in mapping.columns.named().items())
    for key in ("parts", "repeats", "characteristics", "ignored"):
        if names := getattr(mapping.columns, key):
            print_lines([f"  {key:<16} {', '.join(names)}"])
    said = {"unit": mapping.unit, "deviations": mapping.deviation, "lower tolerances": mapping.lower_tolerance}
    print_lines([f"  {key:<16} {value}" for key, value in said.items() if value])


def _print_values(mapped: "Mapped") -> None:
    from dataclasses import replace

    from trueloop.cli.measure.read import print_file
    from trueloop.formats.inspections.measured_file import MeasuredFile
    from trueloop.report.measured import FileOnPart, OnPart

    file = mapped.file
    if not isinstance(file, MeasuredFile):
        return
    shown = [replace(one, values=one.values[:SHOWN]) for one in file.inspections[:2]]
    print_lines([""])
    print_file(FileOnPart(file, tuple(OnPart(run, one) for run, one in enumerate(shown, 1))))
