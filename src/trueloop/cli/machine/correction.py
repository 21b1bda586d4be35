"""`trueloop machine compensate` and `export`: a machine's errors out of programs, into controls' tables."""

import math
from dataclasses import asdict
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
from trueloop.cli.program_file import (
    Decimals,
    DialectName,
    ProgramFile,
    Settings,
    SkippedBlocks,
    UnitAtStart,
    parameters_of,
    tables_of,
)
from trueloop.cli.terminal import AsJson, busy, print_json
from trueloop.units import UM_PER_MM

if TYPE_CHECKING:
    from trueloop.machine.correct.axis_table import AxisTable
    from trueloop.machine.model.model import MachineModel


@guarded
def compensate(
    file: ProgramFile,
    model: ModelOption,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder of the results.")],
    work_zero: Annotated[
        list[str] | None,
        typer.Option(metavar="N=X,Y,Z", help="Machine coordinates of the zero of offset N (1 is G54), mm."),
    ] = None,
    tool: Annotated[
        list[str] | None,
        typer.Option(
            metavar="T=X,Y,Z",
            help="Tool point from the last axis' frame, mm; T is * for all.  [default: 0, or as --offsets says]",
        ),
    ] = None,
    offsets_file: Annotated[
        Path | None,
        typer.Option(
            "--offsets",
            metavar="FILE",
            help="A TOML file of work offsets and tools: machine = program + work offset + tool offset in force. "
            "The command line comes first.",
        ),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="A=V", help="Where a rotary axis stands, degrees; the program has to leave it alone."),
    ] = None,
    temperatures: Temperatures = None,
    zeroed_s: Annotated[
        float | None,
        typer.Option(
            metavar="T",
            help="time_s of the log at which the work zero was set or last referenced: displacements drift from there.",
        ),
    ] = None,
    tolerance_um: ToleranceUm = TOLERANCE_UM,
    limit_um: LimitUm = LARGEST_UM,
    slope: Slope = STEEPEST,
    extrapolate: Extrapolate = None,
    serial: Annotated[str | None, typer.Option(help="Refuse a model of a machine with another serial number.")] = None,
    dialect: DialectName = None,
    settings: Settings = None,
    skipped_blocks: SkippedBlocks = False,
    unit: UnitAtStart = None,
    decimals: Decimals = 0,
    as_json: AsJson = False,
) -> None:
    """Take the machine's error out of a program: every position moved by COMP_MTG.

    The model lives in machine coordinates: --work-zero and --tool, or --offsets, say where the program is in them.
    """
    from trueloop.cli.nc.map import tell_mapped
    from trueloop.domain.map_options import MapOptions
    from trueloop.errors import in_file
    from trueloop.formats.tables.model_file import read_model
    from trueloop.jobs.mapped_program import ModelFile, compensate_program
    from trueloop.machine.correct.setup import Setup

    known = read_model(model)
    with in_file(model):
        _require_machine(known, serial)
    if not (work_zero or offsets_file):
        raise typer.BadParameter("give it, or --offsets", param_hint="--work-zero")
    tables = tables_of(offsets_file)
    setup = Setup(
        {**dict(tables.work_mm), **numbered(work_zero or (), "--work-zero")},
        numbered(tool or ([] if offsets_file else ["*=0,0,0"]), "--tool"),
        signals_of(known, temperatures),
        {axis: math.radians(angle) for axis, angle in parameters_of(at, "--at").items()},
        tables.tools if offsets_file else None,
        None if zeroed_s is None else signals_of(known, temperatures, zeroed_s),
    )
    with busy(f"correcting {file}"):
        done = compensate_program(
            file,
            out / file.name,
            ModelFile(known, model),
            setup,
            MapOptions(
                tolerance_um / UM_PER_MM, limit_um / UM_PER_MM, slope / UM_PER_MM, skipped_blocks, unit, decimals
            ),
            dialect=dialect,
            parameters=parameters_of(settings),
            extrapolate=extrapolate or (),
            inputs=[*logs_of(temperatures), *([offsets_file] if offsets_file else [])],
        )
    if as_json:
        print_json(asdict(done))
        return
    tell_mapped(file, out / file.name, done)


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


def _require_machine(model: "MachineModel", serial: str | None) -> None:
    from trueloop.errors import Code, TrueloopError

    if serial is not None and serial != model.machine.serial:
        raise TrueloopError(
            Code.MCH_MACHINE,
            f"the model is of {model.machine.name!r}, serial number {model.machine.serial!r}, not {serial!r}",
            hint="every machine errs in its own way: make a model of this one",
        )
