"""Options of every command on a program file, and reading that file."""

import re
import shlex
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.shared_options import argument, option

if TYPE_CHECKING:
    from trueloop.formats.tables.offsets_toml import OffsetTables
    from trueloop.nc.program.called import CutterTool
    from trueloop.nc.program.program import Program
    from trueloop.nc.program.tool_path import ToolPath

ProgramFile = Annotated[Path, argument("The NC program.", metavar="FILE")]
DialectName = Annotated[
    str | None, option("ge2000t, linuxcnc, siemens …  [default: from the program]", "--dialect", "-d", metavar="D")
]
OfSide = Annotated[
    Literal["outside", "inside"], option("Whether the finish pass turns an outside or a bore.", "--side")
]
OfTip = Annotated[
    int | None,
    option(
        "Orientation, by the control's number, of the tip that the program moves without G41 or G42.  "
        "[default: it moves the nose's centre]",
        "--tip",
        min=0,
        max=9,
    ),
]
AcceptUnknown = Annotated[
    bool, option("Go on although words or codes are unknown: taken to move nothing.", "--accept-unknown-words")
]
Settings = Annotated[
    list[str] | None, option("Value of a parameter, as P46=3.52; may be repeated.", "--set", "-s", metavar="P=V")
]
SkippedBlocks = Annotated[bool, option("Run the blocks that start with a slash as well.", "--skipped-blocks")]

UnitAtStart = Annotated[
    Literal["mm", "inch"] | None,
    option("Unit in force at the start of a program that does not state its own.", "--unit"),
]
Decimals = Annotated[
    int,
    option("Decimals of new coordinates, where the control and the program have fewer.", "--decimals", min=0, max=9),
]

OffsetsFile = Annotated[
    Path | None,
    option(
        "A TOML file of work offsets and tools, with the offsets that T0101 adds; the command line comes first.",
        "--offsets",
        metavar="FILE",
    ),
]

TOOL = re.compile(r"\s*(?:T?(\d+)\s*=)?\s*R([\d.]+)\s*(?:,\s*Q(\d))?\s*(?:,\s*L(-?[\d.]+))?\s*", re.IGNORECASE)
SETTING = re.compile(r"\s*([^=\s]+)\s*=\s*([^=]+?)\s*")


@dataclass(frozen=True, kw_only=True)
class Reading:
    """How a program is read and run."""

    dialect: DialectName = None
    settings: Settings = None
    skipped_blocks: SkippedBlocks = False
    unit: UnitAtStart = None

    def program(self, file: Path) -> "Program":
        """The program. Raises NC-FILE and NC-DIALECT."""
        from trueloop.formats.input_file import read_program

        return read_program(file, self.dialect, self.unit)

    def options(self, file: Path, dialect: str) -> str:
        """The file and these options as a shell takes them, for a command that reads the program alike."""
        words = [str(file), "--dialect", dialect]
        words += [f"--set={setting}" for setting in self.settings or ()]
        words += [f"--unit={self.unit}"] * bool(self.unit) + ["--skipped-blocks"] * self.skipped_blocks
        return shlex.join(words)

    @property
    def parameters(self) -> dict[str, float]:
        """The values of parameters."""
        return parameters_of(self.settings)

    def run(self, program: "Program", tables: "OffsetTables", *, strict: bool = True) -> "ToolPath":
        """The path of a program that was read, with these tools and work offsets."""
        return program.run(
            self.parameters,
            skipped_blocks=self.skipped_blocks,
            tools=tables.tools,
            work_offsets_mm=dict(tables.work_mm),
            strict=strict,
        )


@dataclass(frozen=True, kw_only=True)
class Tables:
    """The control's tools and work offsets, which a program does not carry."""

    tools: Annotated[
        list[str] | None,
        option(
            "A tool for G41, G42 and G43, as 2=R0.4,Q3 or 2=R5,L120: number, radius in mm, tip on a lathe, "
            "length; may be repeated. "
            "The path is then that of the controlled point.  [default: the programmed contour]",
            "--tool",
            "-t",
            metavar="[N=]R[,Q][,L]",
        ),
    ] = None
    offsets_file: OffsetsFile = None

    def read(self) -> "OffsetTables":
        """The offsets file with the tools of the command line before its own. Raises NC-FILE."""
        known = tables_of(self.offsets_file)
        return replace(known, tools=(*tools_of(self.tools), *known.tools))


@dataclass(frozen=True, kw_only=True)
class TablesAndOffsets(Tables):
    """Tables of a control, with work offsets from the command line."""

    offsets: Annotated[
        list[str] | None,
        option(
            "Where the zero of a work offset is, as G54=0,0,-120 or G54.1P2=…: machine coordinates in mm, x a "
            "radius; may be repeated.  [default: 0,0,0]",
            "--offset",
            metavar="G=X,Y,Z",
        ),
    ] = None

    def read(self) -> "OffsetTables":
        """The offsets file with what the command line says before its own. Raises NC-FILE."""
        known = super().read()
        return replace(known, work_mm=tuple({**dict(known.work_mm), **offsets_of(self.offsets)}.items()))


def parameters_of(settings: Sequence[str] | None, option: str = "--set") -> dict[str, float]:
    """`["P46=3.52"]` as a mapping; anything else is a fault of the command line."""
    import math

    parameters: dict[str, float] = {}
    for setting in settings or ():
        found = SETTING.fullmatch(setting)
        try:
            value = float(found[2] if found else "")
        except ValueError:
            value = math.nan
        if found is None or not math.isfinite(value):
            raise typer.BadParameter(f"{setting!r} is no name=number, such as P46=3.52", param_hint=option)
        parameters[found[1]] = value
    return parameters


def tools_of(texts: Sequence[str] | None) -> "list[CutterTool]":
    """`["2=R0.4,Q3", "R5"]` as tools; anything else is a fault of the command line."""
    from trueloop.nc.program.called import CutterTool

    tools: list[CutterTool] = []
    for text in texts or ():
        found = TOOL.fullmatch(text)
        try:
            number, radius, tip = (found[1], float(found[2]), found[3]) if found else (None, float(""), None)
            length = float(found[4]) if found and found[4] else None
        except ValueError:
            raise typer.BadParameter(f"{text!r} is no tool, such as 2=R0.4,Q3", param_hint="--tool") from None
        tip, number = (None if text is None else int(text) for text in (tip, number))
        tools.append(CutterTool(radius, tip, number, length))
    return tools


def offsets_of(texts: Sequence[str] | None) -> dict[int, tuple[float, float, float]]:
    """`["G54=0,0,-120"]` as zeros by the number of the work offset; anything else is a fault of the command line."""
    from trueloop.nc.program.called import offset_number

    offsets: dict[int, tuple[float, float, float]] = {}
    for text in texts or ():
        name, equals, place = text.partition("=")
        number = offset_number(name.strip())
        if number is None or not equals:
            raise typer.BadParameter(f"{text!r} is no work offset, such as G54=0,0,-120", param_hint="--offset")
        offsets[number] = vector_of(place, "--offset")
    return offsets


def tables_of(file: Path | None) -> "OffsetTables":
    """Reads the offsets file, where one is given. Raises NC-FILE."""
    from trueloop.formats.tables.offsets_toml import OffsetTables, read_offsets

    return OffsetTables() if file is None else read_offsets(file)


def vector_of(text: str, option: str) -> tuple[float, float, float]:
    """`"1,2,3"` as numbers; anything else is a fault of the command line."""
    import math

    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        x = y = z = math.nan
    if not all(map(math.isfinite, (x, y, z))):
        raise typer.BadParameter(f"{text!r} is not X,Y,Z in mm", param_hint=option)
    return x, y, z
