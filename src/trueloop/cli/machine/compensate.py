"""`trueloop machine compensate`: a machine's errors out of programs."""

import math
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.limits import LARGEST_UM, STEEPEST, TOLERANCE_UM, LimitUm, Slope, ToleranceUm, map_options
from trueloop.cli.machine.options import (
    Extrapolate,
    ModelOption,
    Temperatures,
    logs_of,
    numbered,
    signals_of,
)
from trueloop.cli.program_file import Decimals, ProgramFile, Reading, parameters_of, tables_of
from trueloop.cli.terminal import AsJson, busy, print_json

if TYPE_CHECKING:
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
    from trueloop.jobs.machine.mapped_program import ModelFile, compensate_program
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
            map_options(reading, decimals, bounds.tolerance_um, bounds.limit_um, bounds.slope),
            dialect=reading.dialect,
            parameters=reading.parameters,
            extrapolate=bounds.extrapolate or (),
            inputs=place.files,
        )
    if as_json:
        print_json(asdict(done))
        return
    print_mapped(file, out / file.name, done)
