"""`trueloop nc`: where a program sends the tool, what is odd about it, and how far two programs lie apart."""

from collections.abc import Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.failure import ExitStatus, guarded, say
from trueloop.cli.nc.features import features_of_job
from trueloop.cli.nc.map import map_program_file
from trueloop.cli.nc.not_understood import not_understood, tell_not_understood
from trueloop.cli.nc.time import time_of_program
from trueloop.cli.nc.translate import translate_program_file
from trueloop.cli.numbers import not_negative
from trueloop.cli.program_file import (
    DialectName,
    Offsets,
    OffsetsFile,
    ProgramFile,
    Settings,
    SkippedBlocks,
    Tools,
    UnitAtStart,
    offsets_of,
    parameters_of,
    read_program_file,
    tables_of,
    tools_of,
)
from trueloop.cli.terminal import AsJson, busy, print_json, wide_console

if TYPE_CHECKING:
    from trueloop.errors import Finding
    from trueloop.nc.program.tool_path import ToolPath

app = typer.Typer(
    help="NC programs: their tool path, and what is odd about them.", no_args_is_help=True, rich_markup_mode=None
)
app.command("features")(features_of_job)
app.command("map")(map_program_file)
app.command("time")(time_of_program)
app.command("translate")(translate_program_file)


@app.command("path")
@guarded
def path_of_program(
    file: ProgramFile,
    dialect: DialectName = None,
    settings: Settings = None,
    skipped_blocks: SkippedBlocks = False,
    tools: Tools = None,
    offsets: Offsets = None,
    offsets_file: OffsetsFile = None,
    unit: UnitAtStart = None,
    form: Annotated[Literal["csv", "json"], typer.Option("--format", "-f", help="How to print it.")] = "csv",
) -> None:
    """Print the tool path: a row a move with its line and column, mm, x as a radius.

    What a parameter without value would decide is left empty and said on stderr. Exit status 1 when a cut is unknown.
    """
    from trueloop.nc.program.understood import require_unit

    with busy(f"running {file}"):
        program, known = read_program_file(file, dialect, unit), tables_of(offsets_file)
        path = program.run(
            parameters_of(settings),
            skipped_blocks=skipped_blocks,
            tools=[*tools_of(tools), *known.tools],
            work_offsets_mm={**dict(known.work_mm), **offsets_of(offsets)},
            strict=False,
        )
        require_unit(path)
    if form == "csv":
        _print_csv(path)
        tell_not_understood(program, path)
    else:
        unknown = len(not_understood(program, path))
        print_json(
            {"file": str(file), "dialect": program.dialect.name, "not_understood": unknown, "moves": _moves(path)}
        )
    if _say_unknown(path, form == "json"):
        raise typer.Exit(ExitStatus.FINDINGS)


@app.command("check")
@guarded
def check_program(
    file: ProgramFile,
    dialect: DialectName = None,
    settings: Settings = None,
    skipped_blocks: SkippedBlocks = False,
    tools: Tools = None,
    offsets_file: OffsetsFile = None,
    unit: UnitAtStart = None,
    as_json: AsJson = False,
) -> None:
    """Print what is odd about a program, with its place. Exit status 1 when there is an error among it."""
    from trueloop.errors import Severity
    from trueloop.nc.check.check import check

    with busy(f"checking {file}"):
        program = read_program_file(file, dialect, unit)
        known = [*tools_of(tools), *tables_of(offsets_file).tools]
        findings = check(program, parameters_of(settings), skipped_blocks=skipped_blocks, tools=known)
    errors = sum(finding.severity is Severity.ERROR for finding in findings)
    if as_json:
        print_json(
            {
                "file": str(file),
                "dialect": program.dialect.name,
                "errors": errors,
                "findings": [asdict(finding) for finding in findings],
            }
        )
    else:
        _print_findings(findings, f"{program.dialect.name} program of {program.block_count} blocks", errors)
    if errors:
        raise typer.Exit(ExitStatus.FINDINGS)


@app.command("diff")
@guarded
def difference_of_programs(
    file: ProgramFile,
    other: ProgramFile,
    dialect: DialectName = None,
    other_dialect: Annotated[
        str | None, typer.Option("--other-dialect", metavar="D", help="Dialect of the second.  [default: as the first]")
    ] = None,
    settings: Settings = None,
    skipped_blocks: SkippedBlocks = False,
    tools: Tools = None,
    offsets_file: OffsetsFile = None,
    unit: UnitAtStart = None,
    other_unit: Annotated[
        Literal["mm", "inch"] | None, typer.Option("--other-unit", help="Unit of the second.  [default: as the first]")
    ] = None,
    rapids: Annotated[bool, typer.Option("--rapids", help="Compare rapid moves as well as cuts.")] = False,
    tolerance_mm: Annotated[
        float | None,
        typer.Option("--tolerance-mm", callback=not_negative, help="Exit status 1 when they lie further apart."),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print where the tool paths of two programs lie furthest apart, and how far."""
    from trueloop.errors import in_file
    from trueloop.nc.match.difference import compared_moves, path_difference

    with busy(f"comparing {file} and {other}"):
        parameters = parameters_of(settings)
        programs = [
            read_program_file(file, dialect, unit),
            read_program_file(other, dialect if other_dialect is None else other_dialect, other_unit or unit),
        ]
        tables = tables_of(offsets_file)
        known, zeros = [*tools_of(tools), *tables.tools], dict(tables.work_mm)
        paths = [
            program.run(parameters, skipped_blocks=skipped_blocks, tools=known, work_offsets_mm=zeros)
            for program in programs
        ]
        for named, path in zip((file, other), paths, strict=True):
            with in_file(named):
                compared_moves(path, rapids)
        found = path_difference(*paths, rapids=rapids)
    here, there = (0, 1) if found.first else (1, 0)
    names, moves = (str(file), str(other)), (found.move, found.nearest_move)
    places = [
        {"file": names[which], "line": int(paths[which].line[move]), "column": int(paths[which].column[move])}
        for which, move in zip((here, there), moves, strict=True)
    ]
    positions = (found.position_mm, found.nearest_mm)
    if as_json:
        ends = [place | {"position_mm": at} for place, at in zip(places, positions, strict=True)]
        unknown = [len(not_understood(*both)) for both in zip(programs, paths, strict=True)]
        print_json(
            {"distance_mm": found.distance_mm, "spacing_mm": found.spacing_mm, "at": ends[0], "nearest": ends[1]}
            | {"not_understood": unknown}
        )
    else:
        for both in zip(programs, paths, strict=True):
            tell_not_understood(*both)
        print(f"largest distance {found.distance_mm:.6f} mm")
        for word, place, at in zip(("at", "nearest"), places, positions, strict=True):
            position = " ".join(f"{axis} {value:.6f}" for axis, value in zip("xyz", at, strict=True))
            print(f"  {word} {place['file']}:{place['line']}:{place['column']}  {position} mm, x a radius")
    if tolerance_mm is not None and found.distance_mm > tolerance_mm:
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


def _print_csv(path: "ToolPath") -> None:
    import sys

    from trueloop.nc.program.tool_path import CSV_HEADER, csv_text

    sys.stdout.write(",".join(CSV_HEADER) + "\n")
    sys.stdout.writelines(csv_text(path))
    sys.stdout.flush()


def _moves(path: "ToolPath") -> list[dict[str, object]]:
    """The rows of the CSV as objects: numbers as numbers, empty cells as null."""
    from trueloop.nc.program.tool_path import CSV_HEADER, csv_text

    words = {"motion", "feed_unit"}
    whole = {"line", "column", "tool"}
    return [
        {
            name: cell if name in words else None if not cell else int(cell) if name in whole else float(cell)
            for name, cell in zip(CSV_HEADER, row.split(","), strict=True)
        }
        for text in csv_text(path)
        for row in text.splitlines()
    ]


def _print_findings(findings: Sequence["Finding"], of: str, errors: int) -> None:
    from rich.text import Text

    console = wide_console()
    colours = {"error": "bold red", "warning": "yellow", "note": "cyan"}
    for finding in findings:
        text = Text(str(finding))
        text.highlight_words([f"{finding.severity} {finding.code}"], colours[finding.severity])
        console.print(text)
    console.print(f"{of}: {len(findings)} findings, {errors} of them errors", markup=False)
