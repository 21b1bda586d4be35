"""`trueloop nc time`: how long a program takes."""

from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.nc.not_understood import not_understood, tell_not_understood
from trueloop.cli.numbers import positive
from trueloop.cli.program_file import (
    DialectName,
    OffsetsFile,
    ProgramFile,
    Settings,
    SkippedBlocks,
    UnitAtStart,
    parameters_of,
    read_program_file,
    tables_of,
)
from trueloop.cli.terminal import AsJson, busy, print_json

if TYPE_CHECKING:
    from trueloop.nc.program.machining_time import MachiningTime
    from trueloop.nc.program.tool_path import ToolPath


@guarded
def time_of_program(
    file: ProgramFile,
    rapid_mm_min: Annotated[
        float, typer.Option("--rapid-mm-min", min=1.0, callback=positive, help="Rate of rapid moves, mm/min.")
    ],
    max_rpm: Annotated[
        float | None, typer.Option("--max-rpm", min=1.0, callback=positive, help="The spindle's greatest speed, 1/min.")
    ] = None,
    dialect: DialectName = None,
    settings: Settings = None,
    skipped_blocks: SkippedBlocks = False,
    offsets_file: OffsetsFile = None,
    unit: UnitAtStart = None,
    as_json: AsJson = False,
) -> None:
    """Print how long a program takes: cuts at their feed, rapid moves at a stated rate, dwells. Accelerations and tool
    changes are left out. How far it is to the machine's own places (G28, G53) hangs on the offsets.
    """
    from trueloop.nc.program.machining_time import machining_time

    with busy(f"running {file}"):
        program = read_program_file(file, dialect, unit)
        tables = tables_of(offsets_file)
        path = program.run(
            parameters_of(settings),
            skipped_blocks=skipped_blocks,
            tools=tables.tools,
            work_offsets_mm=dict(tables.work_mm),
        )
        time = machining_time(path, rapid_mm_min, max_rpm, lead_along_thread=program.dialect.lead_along_thread)
    parts = {"cutting": time.cutting_s, "rapid": time.rapid_s, "dwell": time.dwell_s, "total": time.total_s}
    tools = _by_tool(path, time)
    if as_json:
        unknown = len(not_understood(program, path))
        print_json({"file": str(file), "seconds": parts, "seconds_by_tool": tools, "not_understood": unknown})
        return
    tell_not_understood(program, path)
    for name, seconds in parts.items():
        print(f"{name:8} {seconds:10.1f} s")
    for tool, seconds in tools.items():
        print(f"  tool {tool}: {seconds:.1f} s at feed")


def _by_tool(path: "ToolPath", time: "MachiningTime") -> dict[str, float]:
    """Seconds at feed of each tool, in the order of first use."""
    seconds: dict[str, float] = {}
    for tool, move_s in zip(path.tool[~time.rapid].tolist(), time.move_s[~time.rapid].tolist(), strict=True):
        name = str(tool) if tool >= 0 else "none"
        seconds[name] = seconds.get(name, 0.0) + move_s
    return seconds
