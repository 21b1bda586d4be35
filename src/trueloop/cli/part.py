"""`trueloop part`: the nominal profile, shown, or made from a program, a drawing or a solid."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.program_file import AcceptUnknown, OfSide, OfTip, ProgramFile, Reading
from trueloop.cli.shared_options import argument, not_negative, option
from trueloop.cli.terminal import AsJson, Group, busy, print_json, wide_console
from trueloop.errors import in_file

if TYPE_CHECKING:
    from trueloop.domain.characteristic import Characteristic
    from trueloop.geometry.offset import CentrePath
    from trueloop.geometry.profile import Profile
    from trueloop.geometry.setup_frame import SetupFrame

app = Group("Nominal profiles: shown, or made from program, DXF or STEP.")


@app.command()
def show(job: Annotated[Path, argument("The job file.", metavar="JOB.toml")], as_json: AsJson = False) -> None:
    """Show a job's profile: features, junctions, the nose's reach."""
    from trueloop.jobs.turned.job import read_part
    from trueloop.report.turned.contour_picture import profile_as_dict

    with busy(f"reading {job}"):
        part = read_part(job)
        centre = part.centre_path
    if as_json:
        print_json(profile_as_dict(part.name, part.profile, centre, part.setups))
    else:
        print_profile(part.name, part.profile, centre, part.setups)


Picture = Annotated[
    Path | None, option("SVG file: what is drawn, its contours by number, the chosen one bold.", "--picture")
]


def draw(svg: str, picture: Path, source: Path) -> None:
    """Writes the picture, before a contour is chosen: it shows what there is to choose from."""
    from trueloop.formats.outputs import write_all

    write_all(picture.parent, [(picture.name, svg.encode())], [source])


@dataclass(frozen=True, kw_only=True)
class Table:
    """The table's name and folder."""

    name: Annotated[str | None, option("Name of the part.  [default: the file's name]")] = None
    output: Annotated[Path | None, option("File for the table.  [default: print it]", "--output", "-o")] = None

    def hand_over(
        self, profile: "Profile", notes: "Sequence[str]", source: Path, characteristics: "Sequence[Characteristic]" = ()
    ) -> None:
        """The table with the decisions as comments, and what is asked of the part, to the file or to stdout."""
        from trueloop.formats.jobs.profile_of_job import characteristics_toml, part_table_toml
        from trueloop.formats.outputs import write_all

        table = part_table_toml(self.name or source.stem, profile, notes) + characteristics_toml(characteristics)
        if self.output is None:
            typer.echo(table, nl=False)
        else:
            write_all(self.output.parent, [(self.output.name, table.encode())], [source])


@app.command()
def from_program(
    file: ProgramFile,
    nose_radius_mm: Annotated[float, option("Radius of the tool nose.", callback=not_negative)],
    reading: Reading,
    lines: Annotated[tuple[int, int] | None, option("First and last line of the finish pass.")] = None,
    side: OfSide = "outside",
    tip: OfTip = None,
    accept_unknown_words: AcceptUnknown = False,
    table: Table = Table(),
) -> None:
    """Make a [part] table from a finish program.

    The profile is the path of the nose centre less the nose radius. No CAD needed.
    """
    from trueloop.geometry.profile import Side
    from trueloop.loops.turned.commanded import Run

    with busy(f"reading {file}"):
        run = Run(reading.parameters, reading.skipped_blocks, lines, tip=tip, accept_unknown_words=accept_unknown_words)
        contour = run.contour(reading.program(file), nose_radius_mm, Side(side))
    table.hand_over(contour.profile, contour.notes, file)


@dataclass(frozen=True, kw_only=True)
class Drawing:
    """How a drawing is read."""

    side: OfSide = "outside"
    layer: Annotated[str | None, option("Layer to read.  [default: all]")] = None
    unit: Annotated[Literal["mm", "inch"] | None, option("Unit of the drawing.  [default: as it states]")] = None
    x_is: Annotated[Literal["radius", "diameter"], option("Whether the drawing's x is a radius.")] = "radius"
    outline: Annotated[int | None, option("Which contour, where that side has several.", min=1)] = None
    zero: Annotated[Literal["drawing", "free-end", "chuck-end"], option("From where z is counted.")] = "drawing"
    picture: Picture = None


@app.command()
def from_dxf(
    file: Annotated[Path, argument("The DXF drawing.", metavar="FILE")], drawing: Drawing, table: Table
) -> None:
    """Make a [part] table from a drawing: the outside or the bore."""
    from trueloop.formats.cad.dxf import read_dxf_sheet
    from trueloop.geometry.profile import Side
    from trueloop.geometry.validate import checked_profile

    with busy(f"reading {file}"):
        sheet = read_dxf_sheet(file, layer=drawing.layer, unit=drawing.unit, side=drawing.side)
        if drawing.picture is not None:
            from trueloop.report.turned.contour_picture import picture_of_sheet

            draw(picture_of_sheet(sheet, drawing.outline), drawing.picture, file)
        drawn = sheet.chosen(drawing.outline, x_is=drawing.x_is, zero=drawing.zero)
        with in_file(file):
            profile = checked_profile(drawn.features, side=Side(drawing.side))
    table.hand_over(profile, drawn.notes, file)


@dataclass(frozen=True, kw_only=True)
class Solid:
    """How a solid is read."""

    side: OfSide = "outside"
    outline: Annotated[int | None, option("Which contour, where that side has several.", min=1)] = None
    turned_round: Annotated[
        bool, option("The free end is at the small z of the file: z is counted back.", "--turned-round")
    ] = False
    from_z_mm: Annotated[float | None, option("Where the profile begins.  [default: the solid's left end]")] = None
    to_z_mm: Annotated[float | None, option("Where the profile ends.  [default: the solid's right end]")] = None
    picture: Picture = None


@app.command()
def from_step(
    file: Annotated[Path, argument("The solid: STEP or IGES.", metavar="FILE")], solid: Solid, table: Table
) -> None:
    """Make a [part] table from a turned solid, STEP or IGES.

    Its outside or its bore, exact, with the tolerances on its faces.
    """
    from trueloop.formats.cad.step_profile import read_step_solid
    from trueloop.formats.cad.step_tolerances import fitting
    from trueloop.geometry.profile import Side
    from trueloop.geometry.validate import checked_profile

    with busy(f"reading {file}"):
        whole = read_step_solid(file, turned_round=solid.turned_round)
        if solid.picture is not None:
            from trueloop.report.turned.contour_picture import picture_of_solid

            draw(picture_of_solid(whole, Side(solid.side), solid.outline), solid.picture, file)
        read = whole.chosen(solid.side, solid.outline, solid.from_z_mm, solid.to_z_mm)
        with in_file(file):
            profile = checked_profile(read.features, side=Side(solid.side))
        asked = fitting(read.characteristics, profile)
    table.hand_over(profile, (*read.notes, *asked.notes), file, asked.characteristics)


def print_profile(name: str, profile: "Profile", centre: "CentrePath", setups: "Sequence[SetupFrame]" = ()) -> None:
    """The features as a table, each with the junction that follows it; then the frames of several set-ups."""
    from rich.table import Table

    from trueloop.report.turned.contour_picture import kind_in_words

    console = wide_console()
    table = Table(box=None, pad_edge=False)
    for heading in ("feature", "kind"):
        table.add_column(heading, no_wrap=True)
    for heading in ("start x", "start z", "end x", "end z", "length", "reached from", "to"):
        table.add_column(heading, justify="right")
    table.add_column("next junction")
    followed_by = [*(f"{j.kind}, {math.degrees(j.turn_rad):+.3f}°" for j in profile.junctions), ""]
    for feature, reachable, junction in zip(profile.features, centre.reachable_mm, followed_by, strict=True):
        numbers = (*feature.start_mm, *feature.end_mm, feature.length_mm, *reachable)
        table.add_row(feature.name, kind_in_words(feature), *(f"{value:.4f}" for value in numbers), junction)
    console.print(f"{name}: {len(profile.features)} features, {profile.length_mm:.4f} mm of arc\n", markup=False)
    console.print(table)
    console.print(
        f"\nmm, x is a radius. Reached: by a nose of {centre.nose_radius_mm:.4f} mm, as arc length on the feature. "
        "Turns are positive at convex corners.",
        markup=False,
    )
    for setup in setups:
        turned = ", turned round" if setup.flipped else ", Z mirrored by the control" if setup.mirrored_z else ""
        console.print(f"Set-up {setup.name}{turned}: {setup.words} of the part.", markup=False)
