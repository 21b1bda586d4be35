"""`trueloop machine compensate` and `export`: a machine's errors out of programs, into controls' tables."""

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.limits import LARGEST_UM, STEEPEST, TOLERANCE_UM, LimitUm, Slope, ToleranceUm
from trueloop.cli.machine.options import (
    Extrapolate,
    ModelFile,
    ModelOption,
    Temperatures,
    logs_of,
    numbered,
    positions_of,
    signals_of,
)
from trueloop.cli.program_file import Decimals, ProgramFile, Reading, parameters_of, tables_of
from trueloop.cli.terminal import AsJson, busy, print_json
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.domain.map_options import MapOptions
    from trueloop.machine.correct.axis_table import AxisTable
    from trueloop.machine.correct.setup import Setup
    from trueloop.machine.model.model import MachineModel


@dataclass(frozen=True, kw_only=True)
class InMachine:
    """Where a program is in the machine, and how warm that is."""

    work_zero: Annotated[
        list[str] | None,
        typer.Option(metavar="N=X,Y,Z", help="Machine coordinates of the zero of offset N (1 is G54), mm."),
    ] = None
    tool: Annotated[
        list[str] | None,
        typer.Option(
            metavar="T=X,Y,Z",
            help="Tool point from the last axis' frame, mm; T is * for all.  [default: 0, or as --offsets says]",
        ),
    ] = None
    offsets_file: Annotated[
        Path | None,
        typer.Option(
            "--offsets",
            metavar="FILE",
            help="A TOML file of work offsets and tools: machine = program + work offset + tool offset in force. "
            "The command line comes first.",
        ),
    ] = None
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="A=V", help="Where a rotary axis stands, degrees; the program has to leave it alone."),
    ] = None
    temperatures: Temperatures = None
    zeroed_s: Annotated[
        float | None,
        typer.Option(
            metavar="T",
            help="time_s of the log at which the work zero was set or last referenced: displacements drift from there.",
        ),
    ] = None

    @property
    def files(self) -> list[Path]:
        """What is read beside program and model."""
        return [*logs_of(self.temperatures), *([self.offsets_file] if self.offsets_file else [])]

    def setup(self, known: "MachineModel") -> "Setup":
        """As the loop takes it. Raises NC-FILE and what reading logs does."""
        from trueloop.machine.correct.setup import Setup

        if not (self.work_zero or self.offsets_file):
            raise typer.BadParameter("give it, or --offsets", param_hint="--work-zero")
        tables = tables_of(self.offsets_file)
        return Setup(
            {**dict(tables.work_mm), **numbered(self.work_zero or (), "--work-zero")},
            numbered(self.tool or ([] if self.offsets_file else ["*=0,0,0"]), "--tool"),
            signals_of(known, self.temperatures),
            {axis: math.radians(angle) for axis, angle in parameters_of(self.at, "--at").items()},
            tables.tools if self.offsets_file else None,
            None if self.zeroed_s is None else signals_of(known, self.temperatures, self.zeroed_s),
        )


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """How closely the corrected path is followed, and what is refused."""

    tolerance_um: ToleranceUm = TOLERANCE_UM
    limit_um: LimitUm = LARGEST_UM
    slope: Slope = STEEPEST
    extrapolate: Extrapolate = None
    serial: Annotated[str | None, typer.Option(help="Refuse a model of a machine with another serial number.")] = None

    def options(self, reading: Reading, decimals: int) -> "MapOptions":
        """As the loop takes them."""
        from trueloop.domain.map_options import MapOptions

        return MapOptions(
            self.tolerance_um / UM_PER_MM,
            self.limit_um / UM_PER_MM,
            self.slope / UM_PER_MM,
            reading.skipped_blocks,
            reading.unit,
            decimals,
        )


@guarded
def compensate(
    file: ProgramFile,
    model: ModelOption,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder of the results.")],
    place: InMachine,
    bounds: Bounds,
    reading: Reading,
    decimals: Decimals = 0,
    as_json: AsJson = False,
) -> None:
    """Take the machine's error out of a program: every position moved by COMP_MTG.

    The model lives in machine coordinates: --work-zero and --tool, or --offsets, say where the program is in them.
    """
    from trueloop.cli.nc.map import print_mapped
    from trueloop.errors import in_file
    from trueloop.formats.tables.model_file import read_model
    from trueloop.jobs.mapped_program import ModelFile, compensate_program
    from trueloop.machine.model.validity import require_serial

    known = read_model(model)
    with in_file(model):
        require_serial(known, bounds.serial)
    setup = place.setup(known)
    with busy(f"correcting {file}"):
        done = compensate_program(
            file,
            out / file.name,
            ModelFile(known, model),
            setup,
            bounds.options(reading, decimals),
            dialect=reading.dialect,
            parameters=reading.parameters,
            extrapolate=bounds.extrapolate or (),
            inputs=place.files,
        )
    if as_json:
        print_json(asdict(done))
        return
    print_mapped(file, out / file.name, done)


@guarded
def export(
    model: ModelFile,
    control: Annotated[Literal["linuxcnc", "siemens", "heidenhain"], typer.Option(help="Whose table.")],
    axis: Annotated[str, typer.Option(metavar="X", help="Axis whose position the table runs over.")],
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="The table.")],
    error_of: Annotated[
        str | None, typer.Option(metavar="Y", help="Axis that is corrected.  [default: the same]")
    ] = None,
    count: Annotated[int, typer.Option(help="Entries.", min=2)] = 101,
    at: Annotated[list[str] | None, typer.Option(metavar="Y=V", help="Position of another axis, mm or °.")] = None,
    opposite_sign: Annotated[
        bool, typer.Option(help="All values with the other sign, where trying it says so.")
    ] = False,
    temperatures: Temperatures = None,
    extrapolate: Extrapolate = None,
) -> None:
    """Write a control's compensation table and print how far it is from the model."""
    from trueloop.errors import in_file
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables import control_tables
    from trueloop.formats.tables.model_file import read_model
    from trueloop.machine.correct.axis_table import axis_table

    known = read_model(model)
    base, signals = positions_of(known, at), signals_of(known, temperatures)
    with in_file(model):
        table = axis_table(known, axis, error_of or axis, count, base, signals, extrapolate=extrapolate or ())
    files = [(out.name, _table_text(control, table, opposite_sign))]
    if control == "heidenhain":
        files.append((out.with_suffix(".cma").name, control_tables.heidenhain_cma(axis, out.name)))
    write_all(out.parent, [(name, text.encode()) for name, text in files], inputs=(model, *logs_of(temperatures)))
    typer.echo(
        f"{len(table.position_mm)} entries; off the model by {UM_PER_MM * table.deviation_mm:.3f} µm along the table, "
        f"up to {UM_PER_MM * table.elsewhere_mm:.1f} µm elsewhere in the travel"
    )
    if control != "linuxcnc":
        for words in control_tables.CAUTION:
            typer.echo(words, err=True)


def _table_text(control: str, table: "AxisTable", opposite: bool) -> str:
    from trueloop.formats.tables import control_tables

    if control == "linuxcnc":
        if opposite:
            raise typer.BadParameter("LinuxCNC's sign is known", param_hint="--opposite-sign")
        return control_tables.linuxcnc_comp(table)
    if control == "siemens":
        return control_tables.siemens_cec(table, opposite=opposite)
    return control_tables.heidenhain_com(table, opposite=opposite)
