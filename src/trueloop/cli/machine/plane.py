"""`trueloop machine plates` and `points`: errors in a plane, from drilled plates, out of drilling programs."""

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.limits import LARGEST_UM, LimitUm
from trueloop.cli.numbers import not_negative, positive
from trueloop.cli.program_file import Decimals, DialectName, ProgramFile, UnitAtStart
from trueloop.cli.terminal import AsJson, busy, print_json
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.machine.standards.planar_field import PlanarField


@guarded
def plates(
    reports: Annotated[list[Path], typer.Argument(metavar="REPORT.txt", help="CMM reports of drilled plates, mm.")],
    out: Annotated[
        Path | None,
        typer.Option("--out", "-o", metavar="FIELD.csv", help="The correction as a table of displacements."),
    ] = None,
    step_mm: Annotated[
        float, typer.Option(callback=positive, help="Largest step between the nodes of the table.")
    ] = 10.0,
    margin_mm: Annotated[
        float,
        typer.Option(callback=not_negative, help="How far the table reaches beyond the holes, where it is a guess."),
    ] = 0.0,
    as_json: AsJson = False,
) -> None:
    """Find what drilled plates have in common: each one's own similarity, then a pattern of errors in the plane."""
    from trueloop.errors import Code
    from trueloop.formats.measurements.field_csv import plane_csv
    from trueloop.formats.measurements.plate_report import read_plate_report
    from trueloop.formats.outputs import write_all
    from trueloop.machine.standards.plates import judged_pattern
    from trueloop.report.machine.summary import plates_lines, plates_summary

    read, names = [read_plate_report(path) for path in reports], [path.name for path in reports]
    with busy(f"a pattern of {sum(len(plate.nominal_mm) for plate in read)} holes on {len(read)} plates") as progress:
        judged = judged_pattern(read, names, step_mm, margin_mm, progress)
    table = judged.table
    if out is not None:
        content = plane_csv(table.x_mm, table.y_mm, table.correction_mm, judged.left)
        write_all(out.parent, [(out.name, content.encode())], inputs=reports)
    if as_json:
        print_json(plates_summary(names, judged))
        return
    for line in plates_lines(names, judged):
        typer.echo(line)
    if why := judged.not_repeating:
        typer.echo(
            f"warning {Code.MCH_PATTERN}: {why}; `machine points` refuses the table without --unproven", err=True
        )
    if out is not None:
        typer.echo(
            f"written: {out}, {len(table.x_mm)} × {len(table.y_mm)} nodes, up to "
            f"{UM_PER_MM * table.deviation_mm:.2f} µm off the pattern between them"
        )


@dataclass(frozen=True, kw_only=True)
class PlaneErrors:
    """Errors in the plane: a form, or a table."""

    quadrupole: Annotated[
        str | None,
        typer.Option(
            metavar="M,DEG", help="X and Y times 1 − M cos 2(θ − DEG), θ the point's direction from the zero."
        ),
    ] = None
    table: Annotated[
        Path | None,
        typer.Option(
            "--table", "-t", metavar="FIELD.csv", help="Displacements at the nodes of a grid, as of `plates`."
        ),
    ] = None
    unproven: Annotated[
        bool, typer.Option("--unproven", help="Also by a table of plates whose pattern is not known to repeat.")
    ] = False

    def read(self) -> "tuple[PlanarField, dict[str, object]]":
        """The field, and what identifies it. Raises NC-FIELD and MCH-PATTERN."""
        from trueloop.machine.standards.planar_field import QuadrupoleField

        if (self.quadrupole is None) == (self.table is None):
            raise typer.BadParameter("give --quadrupole or --table, one of them")
        if self.table is not None:
            return _table(self.table, unproven=self.unproven)
        assert self.quadrupole is not None
        try:
            magnitude, degrees = (float(part) for part in self.quadrupole.split(","))
        except ValueError:
            magnitude = degrees = math.nan
        if not (math.isfinite(degrees) and abs(magnitude) < 0.01):
            raise typer.BadParameter(
                f"{self.quadrupole!r} is not M,DEG with M below 0.01, such as 32e-6,-38.3", param_hint="--quadrupole"
            )
        return QuadrupoleField(magnitude, math.radians(degrees)), {"quadrupole": [magnitude, degrees]}


def _table(table: Path, *, unproven: bool) -> "tuple[PlanarField, dict[str, object]]":
    from trueloop.errors import in_file
    from trueloop.formats.measurements.field_csv import read_field, read_left_out
    from trueloop.machine.correct.point_program import TableField
    from trueloop.machine.standards.plates import require_repeating

    with in_file(table):
        known = TableField(read_field(table))
        require_repeating(None if unproven else read_left_out(table))
    return known, known.field.identity | ({"unproven": True} if unproven else {})


@guarded
def points(
    file: ProgramFile,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="The program to be written.")],
    errors: PlaneErrors,
    all_words: Annotated[
        bool,
        typer.Option("--all-words", help="Also X and Y of G10, G28, G52, G53 and G92 blocks, as if they were points."),
    ] = False,
    limit_um: LimitUm = LARGEST_UM,
    dialect: DialectName = None,
    unit: UnitAtStart = None,
    decimals: Decimals = 0,
    as_json: AsJson = False,
) -> None:
    """Take errors in the plane out of a drilling program: every X and Y word, whatever cycles and macros it calls."""
    from trueloop.formats.program_file import read_program
    from trueloop.jobs.machine.points import write_corrected_points

    field, provenance = errors.read()
    done = write_corrected_points(
        read_program(file, dialect, unit, decimals),
        out,
        field,
        provenance,
        all_words=all_words,
        limit_mm=limit_um / UM_PER_MM,
        inputs=(file, *([errors.table] if errors.table else ())),
    )
    if as_json:
        print_json(asdict(done) | {"file": str(out)})
        return
    x, y = (UM_PER_MM * value for value in done.largest_mm)
    typer.echo(f"largest correction X {x:.1f} Y {y:.1f} µm over {done.points} points; {done.edits} words changed")
    typer.echo(f"written: {out}, record {done.record}")
