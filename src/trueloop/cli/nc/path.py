"""`trueloop nc path`: where a program sends the tool."""

import sys
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.failure import ExitStatus, guarded, say
from trueloop.cli.nc.not_understood import not_understood, tell_not_understood
from trueloop.cli.program_file import ProgramFile, Reading, TablesAndOffsets
from trueloop.cli.terminal import busy, print_json

if TYPE_CHECKING:
    from trueloop.nc.program.tool_path import ToolPath


@guarded
def path_of_program(
    file: ProgramFile,
    reading: Reading,
    tables: TablesAndOffsets,
    form: Annotated[Literal["csv", "json"], typer.Option("--format", "-f", help="How to print it.")] = "csv",
) -> None:
    """Print the tool path: a row a move with its line and column, mm, x as a radius.

    What a parameter without value would decide is left empty and said on stderr. Exit status 1 when a cut is unknown.
    """
    from trueloop.nc.program.path_rows import rows_of
    from trueloop.nc.program.tool_path import CSV_HEADER, csv_text
    from trueloop.nc.program.understood import require_unit

    with busy(f"running {file}"):
        program = reading.program(file)
        path = reading.run(program, tables.read(), strict=False)
        require_unit(path)
    if form == "csv":
        sys.stdout.write(",".join(CSV_HEADER) + "\n")
        sys.stdout.writelines(csv_text(path))
        sys.stdout.flush()
        tell_not_understood(program, path)
    else:
        unknown, moves = len(not_understood(program, path)), rows_of(path)
        print_json({"file": str(file), "dialect": program.dialect.name, "not_understood": unknown, "moves": moves})
    if _say_unknown(path, form == "json"):
        raise typer.Exit(ExitStatus.FINDINGS)


def _say_unknown(path: "ToolPath", as_json: bool) -> bool:
    """Says on stderr what kept the path from being known; whether a cut is among it, or the run ended early."""
    import numpy as np

    from trueloop.errors import Code, Severity, TrueloopError

    errors = [finding for finding in path.findings if finding.severity is Severity.ERROR]
    for found in errors:
        say(TrueloopError(found.code, found.message, hint=found.hint, place=found.place), as_json=as_json)
    ended_early = any(found.code in (Code.NC_FLOW, Code.NC_LIMIT) for found in errors)
    return ended_early or bool(np.any(np.isnan(path.end_mm[~path.rapid])))
