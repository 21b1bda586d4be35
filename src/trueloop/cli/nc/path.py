"""`trueloop nc path`: where a program sends the tool."""

import sys
from collections.abc import Iterable, Sequence
from itertools import chain
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.failure import ExitStatus, guarded, say
from trueloop.cli.nc.not_understood import path_may_differ, tell
from trueloop.cli.program_file import ProgramFile, Reading, TablesAndOffsets
from trueloop.cli.terminal import busy, print_json

if TYPE_CHECKING:
    from trueloop.errors import Finding
    from trueloop.nc.program.parts import Stretch
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
    from trueloop.formats.program_file import read_source
    from trueloop.nc.program.parts import PART, stretches
    from trueloop.nc.program.path_rows import rows_of

    with busy(f"running {file}"):
        source, dialect = read_source(file, reading.dialect)
        known = tables.read()
        rest = stretches(
            source, dialect, str(file), reading.unit, reading.parameters,
            skipped_blocks=reading.skipped_blocks, tools=known.tools, work_offsets_mm=dict(known.work_mm),
            size=PART if form == "csv" else len(source),
        )  # fmt: skip
        first = next(rest)
    if form == "csv":
        last, is_unknown = _print_csv(chain([first], rest))
        tell(path_may_differ(last.findings), str(file))
    else:
        last, is_unknown = first, _has_unknown_cut(first.path)
        unknown, moves = len(path_may_differ(first.findings)), rows_of(first.path)
        print_json({"file": str(file), "dialect": dialect, "not_understood": unknown, "moves": moves})
    if _say_errors(last.of_run, form == "json") or is_unknown:
        raise typer.Exit(ExitStatus.FINDINGS)


def _print_csv(stretches: "Iterable[Stretch]") -> "tuple[Stretch, bool]":
    """Prints their moves; the last of them, and whether a cut among the moves is unknown."""
    from trueloop.nc.program.tool_path import CSV_HEADER, csv_text

    sys.stdout.write(",".join(CSV_HEADER) + "\n")
    is_unknown = False
    for stretch in stretches:
        sys.stdout.writelines(csv_text(stretch.path, stretch.first))
        is_unknown |= _has_unknown_cut(stretch.path)
    sys.stdout.flush()
    return stretch, is_unknown


def _has_unknown_cut(path: "ToolPath") -> bool:
    import numpy as np

    return bool(np.any(np.isnan(path.end_mm[~path.rapid])))


def _say_errors(findings: "Sequence[Finding]", as_json: bool) -> bool:
    """Says on stderr what kept the path from being known; whether the run ended early by it."""
    from trueloop.errors import Code, Severity

    errors = [finding for finding in findings if finding.severity is Severity.ERROR]
    for found in errors:
        say(found.as_error(), as_json=as_json)
    return any(found.code in (Code.NC_FLOW, Code.NC_LIMIT) for found in errors)
