"""`trueloop realtime image` and `show`: what the component in the servo thread loads."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.program_file import parameters_of, vector_of
from trueloop.cli.shared_options import positive
from trueloop.cli.terminal import AsJson, busy, print_json, print_lines
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.jobs.realtime.image import ImageOptions
    from trueloop.realtime.image import Image
    from trueloop.realtime.largest import Extent


@dataclass(frozen=True, kw_only=True)
class OfMachine:
    """Which machine, and where it may be sent."""

    model: Annotated[
        Path | None,
        typer.Option("--model", "-m", metavar="MODEL.json", help="The machine's model, beside a job or a correction."),
    ] = None
    serial: Annotated[str | None, typer.Option(help="Refuse a model of a machine with another serial number.")] = None
    tool: Annotated[
        str | None,
        typer.Option(
            metavar="X,Y,Z",
            help="Tool point from the last axis' frame while no tool offset is in force, mm.  [default: 0,0,0]",
        ),
    ] = None
    travel: Annotated[
        list[str] | None,
        typer.Option(metavar="X=LOW,HIGH", help="Where a drive may be sent, mm.  [default: the model's travel]"),
    ] = None
    standing: Annotated[
        list[str] | None, typer.Option(metavar="A", help="A rotary axis that stands at 0 while the image is in use.")
    ] = None


@dataclass(frozen=True, kw_only=True)
class OfSignals:
    """In which range signals are believed."""

    ranges: Annotated[
        list[str] | None,
        typer.Option("--range", metavar="T1=LOW,HIGH", help="Range of a signal.  [default: that of the model's data]"),
    ] = None
    steps: Annotated[
        list[str] | None,
        typer.Option("--step", metavar="T1=V", help="Largest step between two readings.  [default: 2 °C]"),
    ] = None


@dataclass(frozen=True, kw_only=True)
class OfTable:
    """Where the program of a table stands."""

    origin: Annotated[
        str | None,
        typer.Option(
            metavar="X,Z",
            help="Machine coordinates of the program's zero, X as a radius, mm: work offset plus tool offset.  "
            "[default: as [machine] of the job says]",
        ),
    ] = None
    tip: Annotated[int, typer.Option(min=0, max=9, help="LinuxCNC's orientation of the tool, where G41 is used.")] = 0
    db: Annotated[
        str | None,
        typer.Option(
            "--db",
            metavar="FILE|URL",
            help="Store of a record, and of a job's earlier parts; none: no store.  "
            "[default: store.db of the job, else trueloop.db beside it]",
        ),
    ] = None


@guarded
def image(
    source: Annotated[
        str, typer.Argument(metavar="SOURCE", help="MODEL.json, JOB.toml, record.json, or the id of a kept record.")
    ],
    out: Annotated[Path, typer.Option("--output", "-o", metavar="FILE.img", help="The image.")],
    of_machine: OfMachine,
    of_signals: OfSignals,
    of_table: OfTable,
    limit_um: Annotated[
        float, typer.Option(min=0.001, callback=positive, help="Largest correction of an axis that may pass.")
    ] = 150.0,
    gate_um: Annotated[
        float, typer.Option(min=0.001, callback=positive, help="How far off its path a row of the table still holds.")
    ] = 100.0,
    as_json: AsJson = False,
) -> None:
    """Write what the component in LinuxCNC's servo thread loads: a model, a table by program line, or both.

    A table takes the place of the corrected program: one of the two is run, never both.
    """
    from trueloop.jobs.realtime.image import make_image

    options = _options(of_machine, of_signals, of_table, limit_um / UM_PER_MM, gate_um / UM_PER_MM)
    with busy(f"making an image of {source}"):
        made = make_image(source, options)
        content = made.write(out)
    for note in made.notes:
        typer.echo(f"note: {note}", err=True)
    _print(made.image, made.extent, out, content, as_json)


@guarded
def show(
    file: Annotated[Path, typer.Argument(metavar="FILE.img", help="As `trueloop realtime image` wrote it.")],
    serial: Annotated[
        str | None, typer.Option(help="Refuse an image for a machine with another serial number.")
    ] = None,
    program: Annotated[
        Path | None, typer.Option(metavar="PROGRAM", help="Refuse an image whose table is for another program.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Print what an image holds, and check it as the component does."""
    from trueloop.errors import Code
    from trueloop.formats.input_file import read_input
    from trueloop.formats.realtime.image_file import read_image
    from trueloop.realtime.largest import extent_of

    own = read_input(program, Code.NC_FILE, hint="name the program that is to be run") if program else None
    read = read_image(file, serial=serial, program=own)
    _print(read, extent_of(read), file, file.read_bytes(), as_json)


def _print(image: "Image", extent: "Extent", file: Path, content: bytes, as_json: bool) -> None:
    from trueloop.domain.record import sha256_of
    from trueloop.report.realtime.image_summary import image_lines, image_summary

    if as_json:
        known = {"file": str(file), "bytes": len(content), "sha256": sha256_of(content)}
        print_json({**known, **image_summary(image, extent)})
        return
    print_lines([*image_lines(image, extent), f"{file}: {len(content)} bytes, sha256 {sha256_of(content)}"])


def _options(machine: OfMachine, signals: OfSignals, table: OfTable, limit_mm: float, gate_mm: float) -> "ImageOptions":
    from trueloop.jobs.realtime.image import ImageOptions
    from trueloop.realtime.bank import Stated

    return ImageOptions(
        machine.model,
        machine.serial,
        vector_of(machine.tool, "--tool") if machine.tool else (0.0, 0.0, 0.0),
        {axis.upper(): ends for axis, ends in _pairs(machine.travel, "--travel").items()},
        limit_mm,
        gate_mm,
        Stated(_pairs(signals.ranges, "--range"), parameters_of(signals.steps, "--step")),
        tuple(machine.standing or ()),
        _pair(table.origin, "--origin") if table.origin else None,
        table.tip,
        table.db,
    )


def _pairs(texts: list[str] | None, option: str) -> dict[str, tuple[float, float]]:
    """`["T1=15,35"]` as {"T1": (15, 35)}."""
    split = [text.rpartition("=") for text in texts or ()]
    return {name.strip(): _pair(ends, option) for name, _, ends in split}


def _pair(text: str, option: str) -> tuple[float, float]:
    try:
        first, second = (float(part) for part in text.split(","))
    except ValueError:
        first = second = math.nan
    if not (math.isfinite(first) and math.isfinite(second)):
        raise typer.BadParameter(f"{text!r} is not two numbers with a comma between them", param_hint=option)
    return first, second
