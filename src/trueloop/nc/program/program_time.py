"""The time of a program, as a whole and by tool; a long one is run in parts."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from trueloop.errors import Finding, TrueloopError
from trueloop.nc.program.dialect import dialect_named
from trueloop.nc.program.machining_time import machining_time
from trueloop.nc.program.parts import PART, parts
from trueloop.nc.program.program import Program, Unit
from trueloop.nc.program.tool_path import ToolPath


@dataclass(frozen=True)
class ProgramTime:
    """Seconds: at feed, of rapid moves, of dwells; at feed by tool (−1 before the first T), in the order of first use;
    and what was noticed in the program.
    """

    cutting_s: float = 0.0
    rapid_s: float = 0.0
    dwell_s: float = 0.0
    by_tool_s: Mapping[int, float] = field(default_factory=dict)
    findings: tuple[Finding, ...] = ()

    @property
    def total_s(self) -> float:
        """Moves and dwells."""
        return self.cutting_s + self.rapid_s + self.dwell_s

    def and_then(
        self,
        path: ToolPath,
        of_text: tuple[Finding, ...],
        rapid_mm_min: float,
        max_rpm: float | None,
        lead_along_thread: bool,
    ) -> "ProgramTime":
        """Returns the time with these moves added. Raises what `machining_time` does."""
        time = machining_time(path, rapid_mm_min, max_rpm, lead_along_thread=lead_along_thread)
        by_tool_s = dict(self.by_tool_s)
        for tool, move_s in zip(path.tool[~time.rapid].tolist(), time.move_s[~time.rapid].tolist(), strict=True):
            by_tool_s[tool] = by_tool_s.get(tool, 0.0) + move_s
        return ProgramTime(
            self.cutting_s + time.cutting_s,
            self.rapid_s + time.rapid_s,
            self.dwell_s + time.dwell_s,
            by_tool_s,
            (*self.findings, *of_text, *path.findings),
        )


def program_time(program: Program, path: ToolPath, rapid_mm_min: float, max_rpm: float | None = None) -> ProgramTime:
    """Returns the time of a program that was run. Raises what `machining_time` does.

    >>> program = trueloop.read_program(trueloop.example("linuxcnc/finish.ngc"))
    >>> time = trueloop.program_time(program, program.run(), rapid_mm_min=10_000, max_rpm=3000)
    >>> round(time.cutting_s, 1), round(time.rapid_s, 1)
    (33.2, 2.0)
    """
    along = program.dialect.lead_along_thread
    return ProgramTime().and_then(path, program.findings, rapid_mm_min, max_rpm, along)


def time_in_parts(
    source: bytes,
    dialect: str,
    file: str | None,
    unit: Unit | None,
    parameters: Mapping[str, float],
    rapid_mm_min: float,
    max_rpm: float | None = None,
    *,
    skipped_blocks: bool = False,
    work_offsets_mm: Mapping[int, tuple[float, float, float]] | None = None,
    size: int = PART,
) -> ProgramTime | None:
    """Returns the time of a long program in parts of `size` bytes, without tools; None where it must be run whole."""
    time, along = ProgramTime(), dialect_named(dialect).lead_along_thread
    every = parts(
        source, dialect, file, unit, parameters,
        skipped_blocks=skipped_blocks, work_offsets_mm=work_offsets_mm, size=size,
    )  # fmt: skip
    for part in every:
        if part is None:
            return None
        try:
            time = time.and_then(part.path, part.of_text, rapid_mm_min, max_rpm, along)
        except TrueloopError:  # the whole program's first move without a feed is named, whatever comes before it
            return None
    return time
