"""`trueloop machine decompose`: the errors of a part taken apart."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.machine.options import Extrapolate, ModelOption, logs_of, signals_of
from trueloop.cli.program_file import vector_of
from trueloop.cli.store_options import Db, Supersede
from trueloop.units import UM_PER_MM, URAD_PER_RAD

if TYPE_CHECKING:
    from trueloop.arrays import Array
    from trueloop.domain.inspection import Vector
    from trueloop.jobs.machine.kept import Decomposed
    from trueloop.jobs.store.keep_facts import KeptFacts


@guarded
def decompose(
    inspections: Annotated[Path, typer.Argument(metavar="INSPECTIONS.csv", help="Touches and CMM points of one part.")],
    model: ModelOption,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder of the results.")],
    work_zero: Annotated[str, typer.Option(metavar="X,Y,Z", help="Machine coordinates of the part's zero, mm.")],
    cutting: Annotated[list[str], typer.Option(metavar="T1=V", help="T_CUTTING: a signal each, or LOG.csv.")],
    probing: Annotated[list[str], typer.Option(metavar="T1=V", help="T_PROBING: a signal each, or LOG.csv.")],
    tool: Annotated[str, typer.Option(metavar="X,Y,Z", help="Cutting tool, mm, of all points.")] = "",
    probe: Annotated[str, typer.Option(metavar="X,Y,Z", help="Probe stylus, mm, of all points.")] = "",
    compensated: Annotated[bool, typer.Option(help="The model was in force during cutting.")] = True,
    new_frame: Annotated[bool, typer.Option(help="Take out the part coordinate system discrepancy.")] = False,
    extrapolate: Extrapolate = None,
    part_type: Annotated[str, typer.Option("--type", help="The part type, for the store.  [default: none]")] = "",
    serial: Annotated[
        str, typer.Option("--serial", help="Serial number of the part: keep both inspections in the store.")
    ] = "",
    db: Db = None,
    supersede: Supersede = False,
) -> None:
    """Take the errors of a part apart: what the machine did, what the process, what the model left.

    Tools default to 0,0,0; columns tool_x_mm …, probe_x_mm … of the file state them point by point. With --serial both
    inspections are kept in the store, with how the machine stood: `trueloop diagnose machine` needs them.
    """
    from trueloop.domain.record import sha256_of
    from trueloop.errors import in_file
    from trueloop.formats.measurements.inspections_csv import components_csv, read_inspections
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables.model_file import read_model
    from trueloop.jobs.machine.kept import Decomposed
    from trueloop.loops.machine.post_process import decompose_part, states_of
    from trueloop.report.machine.components import components_page

    if db and not serial:
        raise typer.BadParameter("needs --serial: a part is known by its serial number", param_hint="--db")
    known = read_model(model, offered=True)
    points, seen = read_inspections(inspections)
    zero = vector_of(work_zero, "--work-zero")
    cut = states_of(known, seen, zero, _tool(tool, seen.tool_mm, "tool"), signals_of(known, cutting))
    touched = states_of(known, seen, zero, _tool(probe, seen.probe_mm, "probe"), signals_of(known, probing))
    allowed = extrapolate or ()
    with in_file(inspections):
        parts, frame = decompose_part(
            known, seen, cut, touched, compensated=compensated, new_frame=new_frame, extrapolate=allowed
        )
    contents = {
        "components.csv": components_csv(points, parts).encode(),
        "components.html": components_page(points, parts, frame).encode(),
    }
    sha256 = sha256_of(model.read_bytes())
    done = Decomposed(inspections, points, seen, known, sha256, zero, cut, touched, compensated, new_frame)
    kept = _kept(done, part_type, serial, db, supersede=supersede)
    write_all(out, contents.items(), inputs=(inspections, model, *logs_of([*cutting, *probing])))
    if frame is not None:
        typer.echo(
            f"part frame: shift {UM_PER_MM * frame.shift_mm} µm, turn {URAD_PER_RAD * frame.turn_rad} µrad taken out"
        )
    typer.echo(f"{len(points)} points; written: {out / 'components.csv'}, {out / 'components.html'}")
    if kept is not None:
        typer.echo(kept.words)


def _tool(given: str, by_point: "Array | None", name: str) -> "Array | Vector":
    """Of all points alike, or of each as the file states it."""
    if by_point is not None and given:
        raise typer.BadParameter(f"the file states it: column {name}_x_mm", param_hint=f"--{name}")
    return vector_of(given or "0,0,0", f"--{name}") if by_point is None else by_point


def _kept(done: "Decomposed", part_type: str, serial: str, db: str | None, *, supersede: bool) -> "KeptFacts | None":
    """What was kept in the store; None: no part is named, or there is no store."""
    if not serial:
        return None
    from trueloop.jobs.machine.kept import keep_both
    from trueloop.jobs.store.keeping import Keeping

    return keep_both(done, part_type, serial, Keeping(db, supersede=supersede))
