"""`trueloop machine`: a machine's own errors: found, looked at, checked, taken out of programs, given to controls."""

import math
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.failure import guarded
from trueloop.cli.program_file import DialectName, ProgramFile, Settings, parameters_of, read_program_file
from trueloop.cli.terminal import AsJson, print_json

if TYPE_CHECKING:
    from collections.abc import Sequence

    from trueloop.geometry.feature import Array
    from trueloop.machine.axis_table import AxisTable
    from trueloop.machine.chain import Chain, Vector
    from trueloop.machine.history import Lag
    from trueloop.machine.model import MachineModel
    from trueloop.machine.observations import Observations

app = typer.Typer(
    help="A machine's own errors: found from readings, taken out of programs, handed to the control.",
    no_args_is_help=True,
    rich_markup_mode=None,
)

MachineFile = Annotated[Path, typer.Argument(metavar="MACHINE.toml", help="Structure, travels and error terms.")]
ReadingFiles = Annotated[list[Path], typer.Argument(metavar="READINGS.csv", help="Laser, straight edge, ball bar …")]
ModelFile = Annotated[Path, typer.Argument(metavar="MODEL.json", help="As `trueloop machine fit` wrote it.")]
ModelOption = Annotated[Path, typer.Option("--model", "-m", metavar="MODEL.json", help="The machine's model.")]
Temperatures = Annotated[
    list[str] | None,
    typer.Option(
        "--temperatures",
        "-t",
        metavar="T1=V",
        help="Value of a signal of the model, or LOG.csv, its past until now; may be repeated.",
    ),
]
HistoryFile = Annotated[
    Path | None,
    typer.Option("--history", metavar="LOG.csv", help="Log of temperatures and speeds on the clock of the readings."),
]
Extrapolate = Annotated[
    list[str] | None,
    typer.Option("--extrapolate", metavar="NAME", help="Axis or signal that may leave the range of the data."),
]


@app.command()
@guarded
def fit(
    machine: MachineFile,
    readings: ReadingFiles,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder of the results.")],
    history: HistoryFile = None,
    robust: Annotated[bool, typer.Option(help="Let outliers count less.")] = True,
    as_json: AsJson = False,
) -> None:
    """Find the model of a machine from readings. Writes model.json and machine.html."""
    from trueloop.compensation.record import sha256_of
    from trueloop.formats.machine_toml import read_machine
    from trueloop.formats.model_file import model_to_json
    from trueloop.formats.outputs import write_all
    from trueloop.machine.form import fit_form
    from trueloop.machine.hold_out import hold_out
    from trueloop.report.machine_page import machine_page

    named, form = read_machine(machine)
    data = _readings(readings, named.chain, history)
    found, chosen = fit_form(named, form, data, robust=robust)
    held = hold_out(data, lambda others: fit_form(named, form, others, robust=robust)[0].model)
    sources = (machine, *readings, *([history] if history else ()))
    made_from = {path.name: sha256_of(path.read_bytes()) for path in sources}
    page = machine_page(found, chosen, data.with_lags(found.model.lags), held)
    contents = {"model.json": model_to_json(found.model, made_from).encode(), "machine.html": page.encode()}
    write_all(out, contents, inputs=sources)
    if as_json:
        constants = {lag.name: [lag.constant_s, lag.u_relative * lag.constant_s] for lag in found.model.lags}
        scatter = {"scatter": found.scatter, "readings": len(data), "findings": [f.message for f in found.findings]}
        scatter |= {"chosen": [f"{c.error}·{c.signal}" for c in chosen], "constants_s_and_u": constants}
        print_json(scatter | {"held_out_rms_mm": {run.run: run.rms for run in held}})
        return
    typer.echo(f"{len(found.model.terms)} terms from {len(data)} readings; scatter {found.scatter:.3g}")
    for taken in chosen:
        typer.echo(f"  {taken.error} takes {taken.signal}: left out {taken.rms_without:.3g} → {taken.rms_with:.3g} RMS")
    for lag in found.model.lags:
        typer.echo(f"  {_lag_text(lag)}")
    for run in held:
        typer.echo(
            f"  run {run.run!r} predicted from the others: {1e3 * run.rms:.2f} µm RMS, without {1e3 * run.raw:.2f}"
        )
    for finding in found.findings:
        typer.echo(f"{finding.severity}: {finding.code}: {finding.message}", err=True)
    typer.echo(f"written: {out / 'model.json'}, {out / 'machine.html'}")


@app.command()
@guarded
def show(model: ModelFile, temperatures: Temperatures = None, as_json: AsJson = False) -> None:
    """Print every error of a model: its range over the travel and its largest standard uncertainty."""
    from trueloop.formats.model_file import read_model
    from trueloop.machine.overview import overview

    known = read_model(model)
    rows = overview(known, _signals(known, temperatures))
    if as_json:
        print_json({"terms": [row.__dict__ for row in rows], "lags": [lag.__dict__ for lag in known.lags]})
        return
    for lag in known.lags:
        typer.echo(_lag_text(lag))
    for row in rows:
        typer.echo(f"{row.error:<5} {row.least:+9.2f} to {row.most:+9.2f} {row.unit:<5} u {row.largest_u:.2f}")


@app.command()
@guarded
def check(
    model: ModelFile,
    readings: ReadingFiles,
    history: HistoryFile = None,
    limit_um: Annotated[float | None, typer.Option(help="Refuse when the RMS is larger.")] = None,
    extrapolate: Extrapolate = None,
    as_json: AsJson = False,
) -> None:
    """Compare a model with readings it was not made from. Exit status 1 when beyond the limit."""
    from trueloop.cli.failure import ExitStatus
    from trueloop.formats.model_file import read_model
    from trueloop.machine.hold_out import compare
    from trueloop.machine.validity import check_state

    known = read_model(model)
    data = _readings(readings, known.machine.chain, history).with_lags(known.lags)
    check_state(known, data.state, extrapolate or ())
    result = compare(known, data)
    if as_json:
        print_json(result.__dict__)
    else:
        typer.echo(f"{len(data)} readings: {1e3 * result.raw:.2f} µm RMS, after the model {1e3 * result.rms:.2f} µm")
    if limit_um is not None and 1e3 * result.rms > limit_um:
        raise typer.Exit(ExitStatus.FINDINGS)


@app.command()
@guarded
def compensate(
    file: ProgramFile,
    model: ModelOption,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder of the results.")],
    work_zero: Annotated[
        list[str], typer.Option(metavar="N=X,Y,Z", help="Machine coordinates of the zero of offset N (1 is G54), mm.")
    ],
    tool: Annotated[
        list[str] | None,
        typer.Option(metavar="T=X,Y,Z", help="Tool point from the last axis' frame, mm; T is * for all.  [default: 0]"),
    ] = None,
    at: Annotated[
        list[str] | None,
        typer.Option(metavar="A=V", help="Where a rotary axis stands, degrees; the program has to leave it alone."),
    ] = None,
    temperatures: Temperatures = None,
    tolerance_um: Annotated[float, typer.Option(help="How far a block may leave the corrected path.")] = 0.5,
    extrapolate: Extrapolate = None,
    serial: Annotated[str | None, typer.Option(help="Refuse a model of a machine with another serial number.")] = None,
    dialect: DialectName = None,
    settings: Settings = None,
    as_json: AsJson = False,
) -> None:
    """Take the machine's error out of a program: every position moved by COMP_MTG."""
    from trueloop.compensation.record import sha256_of
    from trueloop.formats.model_file import read_model
    from trueloop.formats.outputs import write_all
    from trueloop.loops.machine_program import compensate_program
    from trueloop.machine.commanded_path import Setup

    known = read_model(model)
    _require_machine(known, serial)
    setup = Setup(
        dict(map(_numbered, work_zero)),
        dict(map(_numbered, tool or ["*=0,0,0"])),
        _signals(known, temperatures),
        {axis: math.radians(angle) for axis, angle in parameters_of(at, "--at").items()},
    )
    done = compensate_program(
        read_program_file(file, dialect),
        known,
        setup,
        tolerance_mm=tolerance_um * 1e-3,
        parameters=parameters_of(settings),
        extrapolate=extrapolate or (),
        model_sha256=sha256_of(model.read_bytes()),
    )
    contents = {file.name: done.source, f"{file.stem}.record.json": done.record.to_json().encode()}
    write_all(out, contents, inputs=(file, model))
    if as_json:
        print_json({"record": done.record.id, "largest_mm": done.largest_mm, "blocks": done.blocks_after})
        return
    x, y, z = (1e3 * value for value in done.largest_mm)
    typer.echo(f"largest correction X {x:.1f} Y {y:.1f} Z {z:.1f} µm; {done.blocks_before} → {done.blocks_after} lines")
    typer.echo(f"written: {out / file.name}, record {done.record.id}")


@app.command()
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
    at: Annotated[list[str] | None, typer.Option(metavar="Y=V", help="Position of another axis, mm.")] = None,
    opposite_sign: Annotated[
        bool, typer.Option(help="All values with the other sign, where trying it says so.")
    ] = False,
    temperatures: Temperatures = None,
) -> None:
    """Write a control's compensation table and print how far it is from the model."""
    from trueloop.formats import control_tables
    from trueloop.formats.model_file import read_model
    from trueloop.formats.outputs import write_all
    from trueloop.machine.axis_table import axis_table

    known = read_model(model)
    table = axis_table(known, axis, error_of or axis, count, parameters_of(at, "--at"), _signals(known, temperatures))
    files = {out.name: _table_text(control, table, opposite_sign)}
    if control == "heidenhain":
        files[out.with_suffix(".cma").name] = control_tables.heidenhain_cma(axis, out.name)
    write_all(out.parent, {name: text.encode() for name, text in files.items()}, inputs=(model,))
    typer.echo(
        f"{len(table.position_mm)} entries; off the model by {1e3 * table.deviation_mm:.3f} µm along the table, "
        f"up to {1e3 * table.elsewhere_mm:.1f} µm elsewhere in the travel"
    )
    if control != "linuxcnc":
        for words in control_tables.CAUTION:
            typer.echo(words, err=True)


def _table_text(control: str, table: "AxisTable", opposite: bool) -> str:
    from trueloop.formats import control_tables

    if control == "linuxcnc":
        if opposite:
            raise typer.BadParameter("LinuxCNC's sign is known", param_hint="--opposite-sign")
        return control_tables.linuxcnc_comp(table)
    if control == "siemens":
        return control_tables.siemens_cec(table, opposite=opposite)
    return control_tables.heidenhain_com(table, opposite=opposite)


@app.command()
@guarded
def decompose(
    inspections: Annotated[Path, typer.Argument(metavar="INSPECTIONS.csv", help="Touches and CMM points of one part.")],
    model: ModelOption,
    out: Annotated[Path, typer.Option("--out", "-o", metavar="DIR", help="Folder of the results.")],
    work_zero: Annotated[str, typer.Option(metavar="X,Y,Z", help="Machine coordinates of the part's zero, mm.")],
    cutting: Annotated[list[str], typer.Option(metavar="T1=V", help="T_CUTTING: a signal each, or LOG.csv.")],
    probing: Annotated[list[str], typer.Option(metavar="T1=V", help="T_PROBING: a signal each, or LOG.csv.")],
    tool: Annotated[str, typer.Option(metavar="X,Y,Z", help="Cutting tool, mm.")] = "0,0,0",
    probe: Annotated[str, typer.Option(metavar="X,Y,Z", help="Probe stylus, mm.")] = "0,0,0",
    compensated: Annotated[bool, typer.Option(help="The model was in force during cutting.")] = True,
    new_frame: Annotated[bool, typer.Option(help="Take out the part coordinate system discrepancy.")] = False,
) -> None:
    """Take the errors of a part apart: what the machine did, what the process, what the model left."""
    from trueloop.formats.inspections_csv import components_csv, read_inspections, states_of
    from trueloop.formats.model_file import read_model
    from trueloop.formats.outputs import write_all
    from trueloop.loops.post_process import decompose_part
    from trueloop.report.machine_components import components_page

    known = read_model(model)
    points, seen = read_inspections(inspections)
    zero = _vector(work_zero)
    cut = states_of(known, seen, zero, _vector(tool), _signals(known, cutting))
    touched = states_of(known, seen, zero, _vector(probe), _signals(known, probing))
    parts, frame = decompose_part(known, seen, cut, touched, compensated=compensated, new_frame=new_frame)
    contents = {
        "components.csv": components_csv(points, parts).encode(),
        "components.html": components_page(points, parts, frame).encode(),
    }
    write_all(out, contents, inputs=(inspections, model))
    if frame is not None:
        typer.echo(f"part frame: shift {1e3 * frame.shift_mm} µm, turn {1e6 * frame.turn_rad} µrad taken out")
    typer.echo(f"{len(points)} points; written: {out / 'components.csv'}, {out / 'components.html'}")


def _readings(paths: "Sequence[Path]", chain: "Chain", history: Path | None) -> "Observations":
    from trueloop.formats.history_csv import read_history
    from trueloop.formats.readings_csv import read_readings
    from trueloop.machine.observations import joined

    past = read_history(history) if history else None
    return joined([read_readings(path, chain, past) for path in paths])


def _signals(model: "MachineModel", given: "Sequence[str] | None") -> "dict[str, Array | float]":
    """Values by name, and logs as they stand at their last row, lags among them. Raises MCH-HISTORY."""
    from trueloop.formats.history_csv import read_history
    from trueloop.machine.history import check_lags_given, signals_at_end

    logs = [Path(text) for text in given or () if "=" not in text]
    signals: dict[str, Array | float] = {}
    for log in logs:
        signals |= signals_at_end(read_history(log), model.lags)
    signals |= parameters_of([text for text in given or () if "=" in text], "--temperatures")
    check_lags_given(model.lags, signals)
    return signals


def _lag_text(lag: "Lag") -> str:
    power = f"^{lag.power}" if lag.power > 1 else ""
    sought = f" ± {2 * lag.u_relative * lag.constant_s:.2g} (95 %)" if lag.between_s else ", given"
    return f"{lag.name}: {lag.of}{power} after {lag.constant_s:.4g} s{sought}"


def _numbered(text: str) -> "tuple[int, Vector]":
    """`1=10,20,30` as (1, (10, 20, 30)); `*` is −1: any other."""
    number, _, vector = text.partition("=")
    if not number.strip().isdigit() and number.strip() != "*":
        raise typer.BadParameter(f"{text!r} is no number=X,Y,Z")
    return (-1 if number.strip() == "*" else int(number)), _vector(vector)


def _vector(text: str) -> "Vector":
    try:
        x, y, z = (float(part) for part in text.split(","))
    except ValueError:
        raise typer.BadParameter(f"{text!r} is not X,Y,Z in mm") from None
    return x, y, z


def _require_machine(model: "MachineModel", serial: str | None) -> None:
    from trueloop.errors import Code, TrueloopError

    if serial is not None and serial != model.machine.serial:
        raise TrueloopError(
            Code.MCH_MACHINE,
            f"the model is of {model.machine.name!r}, serial number {model.machine.serial!r}, not {serial!r}",
            hint="every machine errs in its own way: make a model of this one",
        )
