"""`trueloop nc`: where a program sends the tool, what is odd about it, and how far two programs lie apart."""

import math
import re
import sys
from collections.abc import Iterable, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import chain, groupby
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from trueloop.cli.options import LARGEST_UM, STEEPEST, TOLERANCE_UM, ToleranceUm, map_options
from trueloop.cli.program_file import Decimals, ProgramFile, Reading, Tables, TablesAndOffsets, tables_of, vector_of
from trueloop.cli.shared_options import argument, not_negative, option
from trueloop.cli.terminal import AsJson, ExitStatus, Group, as_dict, busy, print_json, say, wide_console
from trueloop.errors import Code, Finding, Severity
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from collections.abc import Sequence

    from trueloop.domain.option import MapOptions
    from trueloop.errors import Finding, TrueloopError
    from trueloop.formats.tables.offsets_toml import OffsetTables
    from trueloop.geometry.feature import Feature
    from trueloop.geometry.setup_frame import SetupFrame
    from trueloop.loops.machine.mapped_program import Mapped
    from trueloop.loops.turned.cuts import CutFeature
    from trueloop.nc.field import Field
    from trueloop.nc.match.matching import FeatureMatch, MatchedMove
    from trueloop.nc.program.parts import Stretch
    from trueloop.nc.program.program import Program
    from trueloop.nc.program.tool_path import ToolPath


def check_program(file: ProgramFile, reading: Reading, tables: Tables, as_json: AsJson = False) -> None:
    """Print what is odd about a program, with its place. Exit status 1 when there is an error among it."""
    from trueloop.errors import Severity
    from trueloop.formats.called_files import of_folder
    from trueloop.formats.input_file import read_source
    from trueloop.nc.check.check import ProgramCheck, check, check_in_parts
    from trueloop.nc.program.program import read_program

    with busy(f"checking {file}"):
        source, dialect = read_source(file, reading.dialect)
        whole = of_folder(file, dialect, source)
        source = whole.text
        tools, skipped, parameters = tables.read().tools, reading.skipped_blocks, reading.parameters
        checked = None
        if not tools:
            checked = check_in_parts(source, dialect, str(file), reading.unit, parameters, skipped_blocks=skipped)
        if checked is None:
            program = read_program(source, dialect, str(file), reading.unit)
            findings = check(program, parameters, skipped_blocks=skipped, tools=tools)
            checked = ProgramCheck(findings, program.block_count)
    findings = whole.findings(checked.findings)
    errors = sum(finding.severity is Severity.ERROR for finding in findings)
    obstacles = _obstacles_to_any_field(file, reading, dialect)
    if as_json:
        found = [asdict(finding) for finding in findings]
        print_json(
            {"file": str(file), "dialect": dialect, "errors": errors, "findings": found}
            | {"obstacles_to_map": len(obstacles)}
        )
    else:
        _print_findings(findings, f"{dialect} program of {checked.block_count} blocks", errors)
        if obstacles:
            command = f"trueloop nc map {reading.options(file, dialect)} --scale {_SCALE_OF_CHECK:g} --dry-run"
            typer.echo(f"{_count(obstacles)} to `nc map`: `{command}` lists them")
    if errors:
        raise typer.Exit(ExitStatus.FINDINGS)


_SCALE_OF_CHECK: Final = 1.001
"""A field of 1 µm/mm that keeps lines, circles and their planes: it is refused for what is in the program alone."""


def _obstacles_to_any_field(file: Path, reading: Reading, dialect: str) -> "list[TrueloopError]":
    from trueloop.jobs.machine.mapped_program import program_obstacles
    from trueloop.nc.field import similarity_field

    options = Bounds().options(None, reading, 0)
    field = similarity_field(scale=_SCALE_OF_CHECK)
    found = program_obstacles(file, field, options, dialect=dialect, parameters=reading.parameters)
    return [error for error in found if error.code is not Code.CMP_TWICE]


def _count(obstacles: "Sequence[TrueloopError]") -> str:
    return f"{len(obstacles)} obstacle{'s' if len(obstacles) != 1 else ''}"


def _print_findings(findings: Sequence["Finding"], of: str, errors: int) -> None:
    from rich.text import Text

    console = wide_console()
    colours = {"error": "bold red", "warning": "yellow", "note": "cyan"}
    for finding in findings:
        text = Text(str(finding))
        text.highlight_words([f"{finding.severity} {finding.code}"], colours[finding.severity])
        console.print(text)
    console.print(f"{of}: {len(findings)} findings, {errors} of them errors", markup=False)


PATH_MAY_DIFFER: Final = (Code.NC_CODE, Code.NC_WORD, Code.NC_OPAQUE, Code.NC_UNIT, Code.NC_DIAMETER)
"""Warnings after which the machine may go elsewhere than the path does."""


def not_understood(program: "Program", path: "ToolPath") -> list[Finding]:
    """The warnings of a program after which its path may not be the machine's, in the order of the blocks."""
    return path_may_differ((*program.findings, *path.findings))


def path_may_differ(findings: Sequence[Finding]) -> list[Finding]:
    """Those of the findings, in the order of the blocks."""
    found = [
        finding for finding in findings if finding.severity is Severity.WARNING and finding.code in PATH_MAY_DIFFER
    ]
    return sorted(found, key=lambda finding: (finding.place.line or 0, finding.place.column or 0))


def tell_not_understood(program: "Program", path: "ToolPath") -> None:
    """Says the first of them on stderr, and how many there are."""
    tell(not_understood(program, path), program.file)


def tell(findings: Sequence[Finding], file: str | None) -> None:
    """Prints findings that a caller has already."""
    if not findings:
        return
    typer.echo(str(findings[0]), err=True)
    if len(findings) > 1:
        others = f"{file or 'program'}: {len(findings) - 1} more of this kind"
        typer.echo(f"{others}: the machine may go elsewhere\n  hint: `trueloop nc check` lists them", err=True)


@dataclass(frozen=True, kw_only=True)
class Other:
    """How the second program is read, where that is otherwise."""

    other_dialect: Annotated[str | None, option("Dialect of the second.  [default: as the first]", metavar="D")] = None
    other_unit: Annotated[Literal["mm", "inch"] | None, option("Unit of the second.  [default: as the first]")] = None

    def reading(self, first: Reading) -> Reading:
        """That of the second program."""
        dialect = first.dialect if self.other_dialect is None else self.other_dialect
        return replace(first, dialect=dialect, unit=self.other_unit or first.unit)


def difference_of_programs(
    file: ProgramFile,
    other: ProgramFile,
    reading: Reading,
    second: Other,
    tables: Tables,
    rapids: Annotated[bool, option("Compare rapid moves as well as cuts.", "--rapids")] = False,
    tolerance_mm: Annotated[
        float | None, option("Exit status 1 when they lie further apart.", callback=not_negative)
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print where two tool paths lie furthest apart, and how far."""
    from trueloop.nc.match.difference import path_difference

    with busy(f"comparing {file} and {other}"):
        known = tables.read()
        both = [_run(file, reading, known, rapids), _run(other, second.reading(reading), known, rapids)]
        found = path_difference(*(path for _, path in both), rapids=rapids)
    here, there = (0, 1) if found.first else (1, 0)
    moves, positions = (found.move, found.nearest_move), (found.position_mm, found.nearest_mm)
    ends = [
        (str((file, other)[which]), int(both[which][1].line[move]), int(both[which][1].column[move]), at)
        for which, move, at in zip((here, there), moves, positions, strict=True)
    ]
    if as_json:
        unknown = [len(not_understood(*one)) for one in both]
        at, nearest = (dict(zip(("file", "line", "column", "position_mm"), end, strict=True)) for end in ends)
        print_json(
            {"distance_mm": found.distance_mm, "spacing_mm": found.spacing_mm, "at": at, "nearest": nearest}
            | {"not_understood": unknown}
        )
    else:
        for one in both:
            tell_not_understood(*one)
        print(f"largest distance {found.distance_mm:.6f} mm")
        for word, (name, line, column, at_mm) in zip(("at", "nearest"), ends, strict=True):
            position = " ".join(f"{axis} {value:.6f}" for axis, value in zip("xyz", at_mm, strict=True))
            print(f"  {word} {name}:{line}:{column}  {position} mm, x a radius")
    if tolerance_mm is not None and found.distance_mm > tolerance_mm:
        raise typer.Exit(ExitStatus.FINDINGS)


def _run(file: Path, reading: Reading, tables: "OffsetTables", rapids: bool) -> "tuple[Program, ToolPath]":
    from trueloop.errors import in_file
    from trueloop.nc.match.difference import compared_moves

    program = reading.program(file)
    path = reading.run(program, tables)
    with in_file(file):
        compared_moves(path, rapids)
    return program, path


SAMPLES = 65
LEGEND = (
    "From, to, of: mm of arc along the feature, chuck end first. Off nominal: µm, the largest over the block, "
    "positive outwards."
)


@dataclass(frozen=True)
class CuttingBlock:
    """One move over a feature: its block, the arc lengths where it starts and ends, its largest deviation by size."""

    line: int
    block: str
    motion: str
    path: str
    from_mm: float
    to_mm: float
    deviation_um: float


def features_of_job(
    job: Annotated[Path, argument("The job file; its touches need not exist yet.", metavar="JOB.toml")],
    as_json: AsJson = False,
) -> None:
    """Print which blocks and which tool cut which feature.

    Of a job with set-ups, in each. Exit status 1 where that is not clear.
    """
    from trueloop.jobs.turned.inputs import read_setups
    from trueloop.jobs.turned.job_files import JobFiles

    with busy(f"matching {job}"):
        files = JobFiles.of(job)
        setups = read_setups(files).found
        cuts = tuple(_cut(setup.setup.program, setup.cut_features, job, setup.setup.frame) for setup in setups.setups)
    doubtful = tuple(refusal.in_file(str(job)) for refusal in setups.doubtful)
    found = _FoundFeatures(files.job.part.name, cuts, setups.uncut, doubtful)
    refusals = [*found.doubtful, *(refusal for cut in found.cuts for refusal in cut.refused)]
    if as_json:
        print_json(found.as_dict())
    else:
        for cut in found.cuts:
            _print_table(f"{found.part}, {cut.words}", cut.rows, cut.several)
        wide_console().print(LEGEND, *found.uncut_words, sep="\n", markup=False)
        for refusal in refusals:
            say(refusal, as_json=False)
    if refusals:
        raise typer.Exit(ExitStatus.FINDINGS)


@dataclass(frozen=True)
class _Cut:
    """The features that one program cuts; `setup` is its frame where there are several."""

    file: str
    rows: "tuple[_Row, ...]"
    setup: "SetupFrame | None"

    @property
    def refused(self) -> "list[TrueloopError]":
        """Why it is not plain of some features."""
        from trueloop.errors import TrueloopError

        return [row.match for row in self.rows if isinstance(row.match, TrueloopError)]

    @property
    def tools(self) -> list[str]:
        """All that cut something."""
        return list(dict.fromkeys(row.tool for row in self.rows if row.tool))

    @property
    def several(self) -> bool:
        """True if the table says which tool."""
        return len(self.tools) > 1

    @property
    def words(self) -> str:
        """`cut by finish.nc with T3`, with the set-up in front."""
        by_one = f" with {self.tools[0]}" if len(self.tools) == 1 else ""
        where = "" if self.setup is None else f"set-up {self.setup.name} ({self.setup.words} of the part), "
        return f"{where}cut by {self.file}{by_one}"

    def as_dict(self) -> dict[str, object]:
        """Returns JSON-ready values."""
        named = {} if self.setup is None else {"name": self.setup.name, "z_of_program": self.setup.words}
        return {**named, "program": self.file, "features": [_object(row) for row in self.rows]}


@dataclass(frozen=True)
class _FoundFeatures:
    """The features that a job's programs cut. `uncut`, `doubtful`: features that no set-up cuts, and why others are of
    none.
    """

    part: str
    cuts: tuple[_Cut, ...]
    uncut: tuple[str, ...] = ()
    doubtful: "tuple[TrueloopError, ...]" = ()

    @property
    def uncut_words(self) -> list[str]:
        """Features that no set-up cuts."""
        return [f"Cut in no set-up: {', '.join(self.uncut)}."] if self.uncut else []

    def as_dict(self) -> dict[str, object]:
        """For machines: a program, or one by set-up."""
        if self.cuts[0].setup is None:
            return {"part": self.part, **self.cuts[0].as_dict()}
        setups = [
            {"name": cut.setup.name, "z_of_program": cut.setup.words, **cut.as_dict()} for cut in self.cuts if cut.setup
        ]
        doubtful = [as_dict(refusal) for refusal in self.doubtful]
        return {"part": self.part, "setups": setups, "uncut": list(self.uncut), "doubtful": doubtful}


def _cut(program: "Program", cut_features: "list[CutFeature]", job: Path, setup: "SetupFrame") -> _Cut:
    file = program.file or str(job)
    return _Cut(file, tuple(_row(program, feature, file) for feature in cut_features), setup if setup.name else None)


@dataclass(frozen=True)
class _Row:
    """A feature with the blocks that cut it."""

    feature: "Feature"
    tool: str
    match: "FeatureMatch | TrueloopError | None"
    blocks: tuple[CuttingBlock, ...]


def _row(program: "Program", cut_feature: "CutFeature", file: str) -> _Row:
    from trueloop.errors import TrueloopError

    if isinstance(cut_feature.match, TrueloopError):
        return _Row(cut_feature.feature, cut_feature.tool, cut_feature.match.in_file(file), ())
    blocks = () if cut_feature.match is None else _blocks(program, cut_feature.match)
    return _Row(cut_feature.feature, cut_feature.tool, cut_feature.match, blocks)


def _blocks(program: "Program", match: "FeatureMatch") -> tuple[CuttingBlock, ...]:
    return tuple(_block(program, match, moved) for moved in match.moves)


def _block(program: "Program", match: "FeatureMatch", moved: "MatchedMove") -> CuttingBlock:
    import numpy as np

    from trueloop.geometry.feature import Arc
    from trueloop.units import UM_PER_MM

    block, move = program.block(moved.move.line - 1), moved.move
    ends_mm = np.clip([moved.start_mm, moved.end_mm], 0.0, match.feature.length_mm)
    deviation_mm = match.deviation_mm(np.linspace(ends_mm[0], ends_mm[1], SAMPLES))
    return CuttingBlock(
        line=move.line,
        block=program.source[block.start : block.end].decode("latin-1").strip(),
        motion="arc" if isinstance(move.path, Arc) else "line",
        path=f"contour, G{move.compensation}" if move.on_contour else "nose centre",
        from_mm=moved.start_mm,
        to_mm=moved.end_mm,
        deviation_um=float(deviation_mm[np.argmax(np.abs(deviation_mm))]) * UM_PER_MM,
    )


def _object(row: _Row) -> dict[str, object]:
    from trueloop.errors import TrueloopError

    return {
        "name": row.feature.name,
        "length_mm": row.feature.length_mm,
        "tool": row.tool,
        "blocks": [asdict(block) for block in row.blocks],
        "error": as_dict(row.match) if isinstance(row.match, TrueloopError) else None,
    }


def _print_table(title: str, rows: "Sequence[_Row]", several: bool) -> None:
    from rich.table import Table
    from rich.text import Text

    table = Table(box=None, pad_edge=False)
    for heading in (
        "feature",
        *(("tool",) if several else ()),
        "line",
        "block",
        "motion",
        "path",
        "from",
        "to",
        "of",
        "off nominal",
    ):
        number = heading in ("line", "from", "to", "of", "off nominal")
        table.add_column(heading, justify="right" if number else "left", no_wrap=True)
    for row in rows:
        named = (Text(row.feature.name), *((row.tool or "–",) if several else ()))
        length_mm = row.feature.length_mm
        for b in row.blocks:
            numbers = (f"{b.from_mm:.4f}", f"{b.to_mm:.4f}", f"{length_mm:.4f}", f"{b.deviation_um:+z.2f}")
            table.add_row(*named, str(b.line), Text(b.block), b.motion, b.path, *numbers)
        if not row.blocks:
            why = "left alone" if row.match is None else "not known"
            table.add_row(*named, "–", why, *("",) * 4, f"{length_mm:.4f}", "")
    console = wide_console()
    console.print(title + "\n", markup=False)
    console.print(table)
    console.print()


@dataclass(frozen=True, kw_only=True)
class Displacements:
    """A field of displacements: a table, or shift, turn and scale."""

    table: Annotated[
        Path | None, option("Displacements at the nodes of a grid, added.", "--table", "-t", metavar="FIELD.csv")
    ] = None
    shift: Annotated[str | None, option("Shift, mm; X on the radius.", metavar="X,Y,Z")] = None
    rotate: Annotated[
        float | None, option("Turn about --axis, anticlockwise seen from its positive end.", metavar="DEG")
    ] = None
    axis: Annotated[Literal["X", "Y", "Z"], option("Axis of --rotate.")] = "Z"
    scale: Annotated[float | None, option("Scale, 1.001 for 1 mm a metre.", metavar="S")] = None
    about: Annotated[str, option("Centre of --rotate and --scale, mm.", metavar="X,Y,Z")] = "0,0,0"

    def field(self) -> "Field":
        """The field. Raises NC-FIELD."""
        from trueloop.formats.measurements.field_csv import read_field
        from trueloop.nc.field import similarity_field

        rigid = [option for option in (self.shift, self.rotate, self.scale) if option is not None]
        if bool(self.table) == bool(rigid):
            raise typer.BadParameter("give --table, or some of --shift, --rotate and --scale")
        if self.table is not None:
            return read_field(self.table)
        if self.scale is not None and not (math.isfinite(self.scale) and self.scale > 0):
            raise typer.BadParameter(f"{self.scale} is no scale", param_hint="--scale")
        if self.rotate is not None and not math.isfinite(self.rotate):
            raise typer.BadParameter(f"{self.rotate} is no angle in degrees", param_hint="--rotate")
        return similarity_field(
            shift_mm=vector_of("0,0,0" if self.shift is None else self.shift, "--shift"),
            rotation_rad=math.radians(self.rotate or 0.0),
            axis=self.axis,
            scale=1.0 if self.scale is None else self.scale,
            about_mm=vector_of(self.about, "--about"),
        )


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """How closely the displaced path is followed, and what is refused."""

    tolerance_um: ToleranceUm = TOLERANCE_UM
    limit_um: Annotated[
        float | None, option(f"A larger one is refused.  [default: {LARGEST_UM:g} for a table, else none]", min=0.0)
    ] = None
    slope: Annotated[
        float | None,
        option(f"A steeper one is refused, µm/mm.  [default: {STEEPEST:g} for a table, else none]", min=0.0),
    ] = None

    def options(self, table: Path | None, reading: Reading, decimals: int) -> "MapOptions":
        """As the loop takes them: a shift, a turn and a scale are not limited unless they are asked to be."""
        largest_um, steepest = (LARGEST_UM, STEEPEST) if table else (math.inf, math.inf)
        return map_options(
            reading,
            decimals,
            self.tolerance_um,
            largest_um if self.limit_um is None else self.limit_um,
            steepest if self.slope is None else self.slope,
        )


@dataclass(frozen=True, kw_only=True)
class Frame:
    """Where the field's positions are."""

    frame: Annotated[
        Literal["program", "machine"],
        option(
            "Positions of the field: the program's own, in the work offset in force, or the machine's, "
            "which are program + work offset + tool offset by the file of --offsets."
        ),
    ] = "program"
    offsets_file: Annotated[
        Path | None,
        option(
            "A TOML file of work offsets and tools: --frame machine needs it, --frame program refuses it.",
            "--offsets",
            metavar="FILE",
        ),
    ] = None

    def of(self, field: "Field") -> "Field":
        """The field as it is, or in the machine."""
        from trueloop.nc.field import field_in_machine

        if (self.frame == "machine") != (self.offsets_file is not None):
            raise typer.BadParameter("--frame machine and --offsets go together", param_hint="--frame")
        tables = tables_of(self.offsets_file)
        return field_in_machine(field, tables.tools, dict(tables.work_mm)) if self.offsets_file else field


def map_program_file(
    file: ProgramFile,
    displacements: Displacements,
    bounds: Bounds,
    frame: Frame,
    reading: Reading,
    out: Annotated[Path | None, option("The program to be written.", "--out", "-o", metavar="FILE")] = None,
    dry_run: Annotated[
        bool, option("Write nothing; list every block that would be refused, exit status 1 if any.", "--dry-run")
    ] = False,
    decimals: Decimals = 0,
    as_json: AsJson = False,
) -> None:
    """Add a field of displacements to every position of a program.

    The field is a table, or a shift, turn and scale. The program is read and written in streaming.
    """
    from trueloop.jobs.machine.mapped_program import displace_program, program_obstacles

    table, field = displacements.table, frame.of(displacements.field())
    if (out is None) != dry_run:
        raise typer.BadParameter("name the program to be written, or --dry-run instead", param_hint="--out")
    options = bounds.options(table, reading, decimals)
    if out is None:
        with busy(f"mapping {file}"):
            dialect, parameters = reading.dialect, reading.parameters
            found = program_obstacles(file, field, options, dialect=dialect, parameters=parameters)
        _print_obstacles(file, found, as_json=as_json)
        return
    with busy(f"mapping {file}"):
        done = displace_program(
            file,
            out,
            field,
            options,
            dialect=reading.dialect,
            parameters=reading.parameters,
            inputs=[file for file in (table, frame.offsets_file) if file],
        )
    if as_json:
        print_json(asdict(done) | {"file": str(out)})
        return
    print_mapped(file, out, done)


def _print_obstacles(file: Path, errors: "Sequence[TrueloopError]", *, as_json: bool) -> None:
    """Prints obstacles in the order of their lines; consecutive ones of one kind once, with the last line.

    Exit status 1 where there is one.
    """
    if as_json:
        print_json({"file": str(file), "obstacles": [as_dict(error) for error in errors]})
    else:
        for _, group in groupby(
            errors, key=lambda error: (error.code, re.sub(r"[\d.]+", "0", error.message), error.hint)
        ):
            first, *rest = group
            typer.echo(str(first))
            if rest:
                typer.echo(f"  and {len(rest)} more of this kind, to line {rest[-1].place.line}")
        typer.echo(f"{file}: {_count(errors)}, nothing is written")
    if errors:
        raise typer.Exit(ExitStatus.FINDINGS)


def print_mapped(file: Path, out: Path, done: "Mapped") -> None:
    """Prints the changes to a program; blocks that were not run are a warning on stderr."""
    x, y, z = (UM_PER_MM * value for value in done.largest_mm)
    typer.echo(f"largest displacement X {x:.1f} Y {y:.1f} Z {z:.1f} µm over {done.moves} moves")
    typer.echo(f"unit at the start: {done.unit['unit']}, stated by {done.unit['stated_by']}")
    typer.echo(f"{done.edits} edits, {done.added_blocks} blocks added to {done.blocks}")
    if done.not_run:
        typer.echo(
            f"{file}:{done.first_not_run_line}: warning NC-MAP: {done.not_run} blocks with coordinates were not run "
            "and stay as they are\n  hint: --skipped-blocks for those that start with a slash; write branches out",
            err=True,
        )
    if done.turns_back_line:
        typer.echo(
            f"{file}:{done.turns_back_line}: warning NC-MAP: the displaced contour turns back in X or Z, and a cycle "
            "roughs on it: a control that demands one way of G71 or G72 refuses\n"
            "  hint: rough with the uncorrected program then, and finish with this one",
            err=True,
        )
    for note in done.notes:
        typer.echo(f"{file}: note MCH-PROGRAM: {note}", err=True)
    beside = f", beside it {', '.join(done.called)}" if done.called else ""
    typer.echo(f"written: {out}{beside}, record {done.record}")


def path_of_program(
    file: ProgramFile,
    reading: Reading,
    tables: TablesAndOffsets,
    form: Annotated[Literal["csv", "json"], option("Format of the output.", "--format", "-f")] = "csv",
) -> None:
    """Print the tool path, a row a move: line, column, mm.

    X is a radius. A coordinate that follows from a parameter without value is left empty, and stderr names it. Exit
    status 1 if a cut is unknown.
    """
    from trueloop.formats.input_file import read_source
    from trueloop.nc.program.parts import PART, stretches
    from trueloop.nc.program.tool_path import rows_of

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


app = Group("NC programs: their tool path, and what is odd about them.")
app.add(features_of_job, "features")
app.add(map_program_file, "map")
app.add(path_of_program, "path")
app.add(check_program, "check")
app.add(difference_of_programs, "diff")

app.removed("translate", "post the program for the other control, and correct it with `trueloop nc map`")
app.removed("time", "it left out accelerations and tool changes: the control and the CAM system state the time")
