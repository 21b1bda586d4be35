"""`trueloop machine export`: a machine's errors into a control's compensation table."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.machine.options import Extrapolate, ModelFile, Temperatures, logs_of, positions_of, signals_of
from trueloop.units import UM_PER_MM


@dataclass(frozen=True, kw_only=True)
class TableOptions:
    """Which table, and where it is."""

    control: Annotated[Literal["linuxcnc", "siemens", "heidenhain"], typer.Option(help="Whose table.")]
    axis: Annotated[str, typer.Option(metavar="X", help="Axis whose position the table runs over.")]
    out: Annotated[Path, typer.Option("--out", "-o", metavar="FILE", help="The table.")]
    error_of: Annotated[str | None, typer.Option(metavar="Y", help="Axis that is corrected.  [default: the same]")] = (
        None
    )
    count: Annotated[int, typer.Option(help="Entries.", min=2)] = 101
    at: Annotated[list[str] | None, typer.Option(metavar="Y=V", help="Position of another axis, mm or °.")] = None
    opposite_sign: Annotated[bool, typer.Option(help="All values with the other sign, where trying it says so.")] = (
        False
    )


@guarded
def export(
    model: ModelFile, wanted: TableOptions, temperatures: Temperatures = None, extrapolate: Extrapolate = None
) -> None:
    """Write a control's compensation table and print how far it is from the model."""
    from trueloop.errors import in_file
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables.control_tables import TABLES
    from trueloop.formats.tables.model_file import read_model
    from trueloop.machine.correct.axis_table import axis_table

    known, tables, out = read_model(model), TABLES[wanted.control], wanted.out
    base, signals = positions_of(known, wanted.at), signals_of(known, temperatures)
    with in_file(model):
        table = axis_table(
            known,
            wanted.axis,
            wanted.error_of or wanted.axis,
            wanted.count,
            base,
            signals,
            extrapolate=extrapolate or (),
        )
    if wanted.opposite_sign and not tables.caution:
        raise typer.BadParameter("LinuxCNC's sign is known", param_hint="--opposite-sign")
    files = tables.files(table, out.name, opposite=wanted.opposite_sign)
    write_all(out.parent, [(name, text.encode()) for name, text in files], inputs=(model, *logs_of(temperatures)))
    typer.echo(
        f"{len(table.position_mm)} entries; off the model by {UM_PER_MM * table.deviation_mm:.3f} µm along the table, "
        f"up to {UM_PER_MM * table.elsewhere_mm:.1f} µm elsewhere in the travel"
    )
    for words in tables.caution:
        typer.echo(words, err=True)
