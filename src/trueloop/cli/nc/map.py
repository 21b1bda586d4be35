"""`trueloop nc map`: a field of displacements over a program."""

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.limits import LARGEST_UM, STEEPEST, TOLERANCE_UM, ToleranceUm, map_options
from trueloop.cli.program_file import Decimals, ProgramFile, Reading, tables_of, vector_of
from trueloop.cli.terminal import AsJson, busy, print_json
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.domain.map_options import MapOptions
    from trueloop.loops.machine.mapped_program import Mapped
    from trueloop.nc.field.field import Field


@dataclass(frozen=True, kw_only=True)
class Displacements:
    """A field of displacements: a table, or shift, turn and scale."""

    table: Annotated[
        Path | None,
        typer.Option("--table", "-t", metavar="FIELD.csv", help="Displacements at the nodes of a grid, added."),
    ] = None
    shift: Annotated[str | None, typer.Option(metavar="X,Y,Z", help="Shift, mm; X on the radius.")] = None
    rotate: Annotated[
        float | None, typer.Option(metavar="DEG", help="Turn about --axis, anticlockwise seen from its positive end.")
    ] = None
    axis: Annotated[Literal["X", "Y", "Z"], typer.Option(help="Axis of --rotate.")] = "Z"
    scale: Annotated[float | None, typer.Option(metavar="S", help="Scale, 1.001 for 1 mm a metre.")] = None
    about: Annotated[str, typer.Option(metavar="X,Y,Z", help="Centre of --rotate and --scale, mm.")] = "0,0,0"

    def field(self) -> "Field":
        """The field. Raises NC-FIELD."""
        from trueloop.formats.measurements.field_csv import read_field
        from trueloop.nc.field.field import similarity_field

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
        float | None,
        typer.Option(min=0.0, help=f"A larger one is refused.  [default: {LARGEST_UM:g} for a table, else none]"),
    ] = None
    slope: Annotated[
        float | None,
        typer.Option(min=0.0, help=f"A steeper one is refused, µm/mm.  [default: {STEEPEST:g} for a table, else none]"),
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
        typer.Option(
            help="What the field's positions are: the program's own, in the work offset in force, or the machine's, "
            "which are program + work offset + tool offset by the file of --offsets."
        ),
    ] = "program"
    offsets_file: Annotated[
        Path | None,
        typer.Option(
            "--offsets",
            metavar="FILE",
            help="A TOML file of work offsets and tools: --frame machine needs it, --frame program refuses it.",
        ),
    ] = None

    def of(self, field: "Field") -> "Field":
        """The field as it is, or in the machine."""
        from trueloop.nc.field.machine_frame import field_in_machine

        if (self.frame == "machine") != (self.offsets_file is not None):
            raise typer.BadParameter("--frame machine and --offsets go together", param_hint="--frame")
        tables = tables_of(self.offsets_file)
        return field_in_machine(field, tables.tools, dict(tables.work_mm)) if self.offsets_file else field


@guarded
def map_program_file(
    file: ProgramFile,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="The program to be written.")],
    displacements: Displacements,
    bounds: Bounds,
    frame: Frame,
    reading: Reading,
    decimals: Decimals = 0,
    as_json: AsJson = False,
) -> None:
    """Add a field of displacements to every position of a program, in streaming: a table, or shift, turn and scale."""
    from trueloop.jobs.machine.mapped_program import displace_program

    table, field = displacements.table, frame.of(displacements.field())
    with busy(f"mapping {file}"):
        done = displace_program(
            file,
            out,
            field,
            bounds.options(table, reading, decimals),
            dialect=reading.dialect,
            parameters=reading.parameters,
            inputs=[file for file in (table, frame.offsets_file) if file],
        )
    if as_json:
        print_json(asdict(done) | {"file": str(out)})
        return
    print_mapped(file, out, done)


def print_mapped(file: Path, out: Path, done: "Mapped") -> None:
    """What was done to a program, for people; what was not run is a warning on stderr."""
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
    typer.echo(f"written: {out}, record {done.record}")
