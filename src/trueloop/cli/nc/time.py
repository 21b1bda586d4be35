"""`trueloop nc time`: how long a program takes."""

from typing import Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.nc.not_understood import path_may_differ, tell
from trueloop.cli.program_file import OffsetsFile, ProgramFile, Reading, tables_of
from trueloop.cli.shared_options import positive
from trueloop.cli.terminal import AsJson, busy, print_json


@guarded
def time_of_program(
    file: ProgramFile,
    reading: Reading,
    rapid_mm_min: Annotated[
        float, typer.Option("--rapid-mm-min", min=1.0, callback=positive, help="Rate of rapid moves, mm/min.")
    ],
    max_rpm: Annotated[
        float | None, typer.Option("--max-rpm", min=1.0, callback=positive, help="The spindle's greatest speed, 1/min.")
    ] = None,
    offsets_file: OffsetsFile = None,
    as_json: AsJson = False,
) -> None:
    """Print how long a program takes: cuts at their feed, rapid moves at a stated rate, dwells. Accelerations and tool
    changes are left out. How far it is to the machine's own places (G28, G53) depends on the offsets.
    """
    from trueloop.formats.program_file import read_source
    from trueloop.nc.program.program import read_program
    from trueloop.nc.program.program_time import program_time, time_in_parts

    with busy(f"running {file}"):
        source, known = read_source(file, reading.dialect)
        tables = tables_of(offsets_file)
        time = None if tables.tools else time_in_parts(
            source, known, str(file), reading.unit, reading.parameters, rapid_mm_min, max_rpm,
            skipped_blocks=reading.skipped_blocks, work_offsets_mm=dict(tables.work_mm),
        )  # fmt: skip
        if time is None:
            program = read_program(source, known, str(file), reading.unit)
            time = program_time(program, reading.run(program, tables), rapid_mm_min, max_rpm)
    parts = {"cutting": time.cutting_s, "rapid": time.rapid_s, "dwell": time.dwell_s, "total": time.total_s}
    tools = {str(tool) if tool >= 0 else "none": seconds for tool, seconds in time.by_tool_s.items()}
    unknown = path_may_differ(time.findings)
    if as_json:
        print_json({"file": str(file), "seconds": parts, "seconds_by_tool": tools, "not_understood": len(unknown)})
        return
    tell(unknown, str(file))
    for name, seconds in parts.items():
        print(f"{name:8} {seconds:10.1f} s")
    for tool, seconds in tools.items():
        print(f"  tool {tool}: {seconds:.1f} s at feed")
