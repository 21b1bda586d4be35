"""`trueloop machine`: a machine's own errors: found, looked at, checked, taken out of programs, given to controls."""

import math
from dataclasses import asdict, dataclass
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from trueloop.cli.options import (
    LARGEST_UM,
    STEEPEST,
    TOLERANCE_UM,
    AcceptRefused,
    Db,
    LimitUm,
    NoStore,
    Slope,
    Supersede,
    ToleranceUm,
    chosen,
    map_options,
    print_findings,
)
from trueloop.cli.program_file import (
    Decimals,
    DialectName,
    ProgramFile,
    Reading,
    UnitAtStart,
    parameters_of,
    tables_of,
    vector_of,
)
from trueloop.cli.shared_options import ModelOption, argument, not_negative, option, positive
from trueloop.cli.terminal import AsJson, Group, busy, print_json, print_lines
from trueloop.units import UM_PER_MM, URAD_PER_RAD

if TYPE_CHECKING:
    from collections.abc import Callable, Iterable, Mapping, Sequence

    from trueloop.arrays import Array
    from trueloop.machine.correct import Setup
    from trueloop.machine.identify.judge_fit import HeldOut
    from trueloop.machine.model.chain import Vector
    from trueloop.machine.model.model import MachineModel
    from trueloop.machine.standards import PlanarField

MachineFile = Annotated[Path, argument("Structure, travels and error terms.", metavar="MACHINE.toml")]
ReadingFiles = Annotated[
    list[Path], argument("CSV, or .toml that names instruments' own files.", metavar="READINGS.csv")
]
ModelFile = Annotated[Path, argument("As `trueloop machine fit` wrote it.", metavar="MODEL.json")]
Temperatures = Annotated[
    list[str] | None,
    option(
        "Value of a signal of the model, or LOG.csv, its past until now; may be repeated.",
        "--temperatures",
        "-t",
        metavar="T1=V",
    ),
]
HistoryFile = Annotated[
    Path | None, option("Log of temperatures and speeds on the clock of the readings.", "--history", metavar="LOG.csv")
]
Extrapolate = Annotated[
    list[str] | None, option("Axis or signal that may leave the range of the data.", "--extrapolate", metavar="NAME")
]


def signals_of(
    model: "MachineModel", texts: "Sequence[str] | None", until_s: float = math.inf
) -> "dict[str, Array | float]":
    """Values by name, and logs as they stand at their last row until then, lags among them. Raises MCH-HISTORY."""
    from trueloop.jobs.machine import machine_model

    values = parameters_of([text for text in texts or () if "=" in text], "--temperatures")
    return machine_model.signals_of(model, logs_of(texts), values, until_s)


def logs_of(texts: "Sequence[str] | None") -> list[Path]:
    """Returns the values that name files: those without an equals sign."""
    return [Path(text) for text in texts or () if "=" not in text]


def positions_of(model: "MachineModel", texts: "Sequence[str] | None") -> dict[str, float]:
    """`["Y=12", "A=30"]` as mm and rad. Raises MCH-AXIS for an axis that the machine does not have."""
    from trueloop.machine.model.chain import AxisKind

    chain = model.machine.chain
    rotary = {axis.name for axis in chain.axes if axis.kind is not AxisKind.LINEAR}
    values = parameters_of(texts, "--at")
    return {chain.axis(name).name: math.radians(v) if name in rotary else v for name, v in values.items()}


def numbered(texts: "Sequence[str]", option: str) -> "dict[int, Vector]":
    """`["1=10,20,30"]` as {1: (10, 20, 30)}; `*` is −1: any other."""
    found = {}
    for text in texts:
        number, _, vector = (part.strip() for part in text.partition("="))
        if not number.isdigit() and number != "*":
            raise typer.BadParameter(f"{text!r} is no number=X,Y,Z", param_hint=option)
        found[-1 if number == "*" else int(number)] = vector_of(vector, option)
    return found


def accept(
    model: ModelFile,
    out: Annotated[Path, option("The accepted model.", "--out", "-o", metavar="NEW.json")],
    why: Annotated[str, option("Why it is accepted.  [default: not stated]")] = "",
    who: Annotated[str, option("Who accepts it.  [default: the user]")] = "",
    db: Db = None,
    no_store: NoStore = False,
) -> None:
    """Accept a refined model: programs may be corrected by it.

    The offered file stays as it is. With a store the decision is kept there, and both versions.
    """
    from trueloop.formats.tables.model_file import read_model
    from trueloop.jobs.machine.machine_model import accept_model

    written, kept = accept_model(model, out, why=why, who=who, db=chosen(db, no_store))
    version = read_model(written).version
    assert version is not None and version.accepted is not None
    typer.echo(f"version {version.number}: {version.reason}")
    typer.echo(version.judged)
    typer.echo(f"accepted by {version.accepted.who}; written: {written}")
    if kept is not None:
        typer.echo(kept.words)


@dataclass(frozen=True, kw_only=True)
class InMachine:
    """Where a program is in the machine, and how warm that is."""

    work_zero: Annotated[
        list[str] | None, option("Machine coordinates of the zero of offset N (1 is G54), mm.", metavar="N=X,Y,Z")
    ] = None
    tool: Annotated[
        list[str] | None,
        option(
            "Tool point from the last axis' frame, mm; T is * for all.  [default: 0, or as --offsets states]",
            metavar="T=X,Y,Z",
        ),
    ] = None
    offsets_file: Annotated[
        Path | None,
        option(
            "A TOML file of work offsets and tools: machine = program + work offset + tool offset in force. "
            "The command line comes first.",
            "--offsets",
            metavar="FILE",
        ),
    ] = None
    at: Annotated[
        list[str] | None, option("Where a rotary axis stands until the program positions it, degrees.", metavar="A=V")
    ] = None
    reference: Annotated[
        list[str] | None,
        option(
            "Machine coordinate of an axis with backlash at the start and after G28, mm.  [default: 0 where that is an "
            "end of its travel]",
            metavar="A=V",
        ),
    ] = None
    tool_point: Annotated[
        bool | None,
        option(
            "Tool point control is in force at the start.  [default: no; a LinuxCNC program that turns axes in cuts "
            "has to state it]",
            "--tool-point/--no-tool-point",
        ),
    ] = None
    temperatures: Temperatures = None
    zeroed_s: Annotated[
        float | None,
        option(
            "time_s of the log at which the work zero was set or last referenced: displacements drift from there.",
            metavar="T",
        ),
    ] = None

    @property
    def files(self) -> list[Path]:
        """Files that are read beside program and model."""
        return [*logs_of(self.temperatures), *([self.offsets_file] if self.offsets_file else [])]

    def setup(self, model: "MachineModel") -> "Setup":
        """As the loop takes it. Raises NC-FILE and what reading logs does."""
        from trueloop.machine.correct import Setup

        if not (self.work_zero or self.offsets_file):
            raise typer.BadParameter("give it, or --offsets", param_hint="--work-zero")
        tables = tables_of(self.offsets_file)
        return Setup(
            work_zero_mm={**dict(tables.work_mm), **numbered(self.work_zero or (), "--work-zero")},
            tool_mm=numbered(self.tool or ([] if self.offsets_file else ["*=0,0,0"]), "--tool"),
            signals=signals_of(model, self.temperatures),
            fixed={axis: math.radians(angle) for axis, angle in parameters_of(self.at, "--at").items()},
            table=tables.tools if self.offsets_file else None,
            zero_signals=None if self.zeroed_s is None else signals_of(model, self.temperatures, self.zeroed_s),
            reference_mm=parameters_of(self.reference, "--reference"),
            tool_point=self.tool_point,
        )


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """How closely the corrected path is followed, and what is refused."""

    tolerance_um: ToleranceUm = TOLERANCE_UM
    limit_um: LimitUm = LARGEST_UM
    slope: Slope = STEEPEST
    extrapolate: Extrapolate = None
    serial: Annotated[str | None, option("Refuse a model of a machine with another serial number.")] = None


def compensate(
    file: ProgramFile,
    model: ModelOption,
    out: Annotated[Path, option("Folder of the results.", "--out", "-o", metavar="DIR")],
    place: InMachine,
    bounds: Bounds,
    reading: Reading,
    decimals: Decimals = 0,
    as_json: AsJson = False,
) -> None:
    """Take the machine's error out of a program.

    Every position is moved by COMP_MTG. The model lives in machine coordinates: --work-zero and --tool, or --offsets,
    say where the program is in them.
    """
    from trueloop.cli.nc import print_mapped
    from trueloop.errors import in_file
    from trueloop.formats.tables.model_file import read_model
    from trueloop.jobs.machine.mapped_program import ModelFile, compensate_program
    from trueloop.machine.correct import references_mm
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
    for axis, at_mm in references_mm(known, setup).items():
        typer.echo(
            f"{axis} stands at {at_mm:g} mm of the machine at the start and after G28: its backlash counts from there"
        )


def decompose(
    inspections: Annotated[Path, argument("Touches and CMM points of one part.", metavar="INSPECTIONS.csv")],
    model: ModelOption,
    out: Annotated[Path, option("Folder of the results.", "--out", "-o", metavar="DIR")],
    work_zero: Annotated[str, option("Machine coordinates of the part's zero, mm.", metavar="X,Y,Z")],
    cutting: Annotated[list[str], option("T_CUTTING: a signal each, or LOG.csv.", metavar="T1=V")],
    probing: Annotated[list[str], option("T_PROBING: a signal each, or LOG.csv.", metavar="T1=V")],
    tool: Annotated[str, option("Cutting tool, mm, of all points.", metavar="X,Y,Z")] = "",
    probe: Annotated[str, option("Probe stylus, mm, of all points.", metavar="X,Y,Z")] = "",
    compensated: Annotated[bool, option("The model was in force during cutting.")] = True,
    new_frame: Annotated[bool, option("Take out the part coordinate system discrepancy.")] = False,
    extrapolate: Extrapolate = None,
    part_type: Annotated[str, option("The part type, for the store.  [default: none]", "--type")] = "",
    serial: Annotated[str, option("Serial number of the part: keep both inspections in the store.")] = "",
    db: Db = None,
    supersede: Supersede = False,
) -> None:
    """Divide a part's errors into machine, process and rest.

    The rest is what the machine's model left. Tools default to 0,0,0; columns tool_x_mm …, probe_x_mm … of the file
    state them point by point. With --serial both inspections are kept in the store, with how the machine stood:
    `trueloop diagnose machine` needs them.
    """
    from trueloop.domain.record import sha256_of
    from trueloop.errors import in_file
    from trueloop.formats.measurements.inspections_csv import components_csv, read_inspections
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables.model_file import read_model
    from trueloop.jobs.machine.machine_model import keep_both
    from trueloop.jobs.store.opened import Keeping
    from trueloop.loops.diagnosis.left_on_parts import BothSeen, decompose_part, states_of
    from trueloop.report.machine.summary import components_page

    if db and not serial:
        raise typer.BadParameter("needs --serial: a part is known by its serial number", param_hint="--db")
    known = read_model(model, offered=True)
    points, seen = read_inspections(inspections)
    zero = vector_of(work_zero, "--work-zero")
    cut = states_of(known, seen, zero, _tool(tool, seen.tool_mm, "tool"), signals_of(known, cutting))
    touched = states_of(known, seen, zero, _tool(probe, seen.probe_mm, "probe"), signals_of(known, probing))
    both = BothSeen(
        serial=serial,
        part_type=part_type,
        points=tuple(points),
        seen=seen,
        cutting=cut,
        probing=touched,
        compensated=compensated,
        new_frame=new_frame,
    )
    with in_file(inspections):
        parts, frame = decompose_part(known, both, extrapolate or ())
    contents = {
        "components.csv": components_csv(points, parts).encode(),
        "components.html": components_page(points, parts, frame).encode(),
    }
    kept = None
    if serial:
        sha256, keeping = sha256_of(model.read_bytes()), Keeping(db, supersede=supersede)
        kept = keep_both(both, inspections, known, sha256, zero, keeping=keeping)
    write_all(out, contents.items(), inputs=(inspections, model, *logs_of([*cutting, *probing])))
    if frame is not None:
        typer.echo(
            f"part frame: shift {UM_PER_MM * frame.shift_mm} µm, turn {URAD_PER_RAD * frame.turn_rad} µrad taken out"
        )
    typer.echo(f"{len(points)} points; written: {out / 'components.csv'}, {out / 'components.html'}")
    if kept is not None:
        typer.echo(kept.words)


def _tool(text: str, by_point: "Array | None", name: str) -> "Array | Vector":
    """Of all points alike, or of each as the file states it."""
    if by_point is not None and text:
        raise typer.BadParameter(f"the file states it: column {name}_x_mm", param_hint=f"--{name}")
    return vector_of(text or "0,0,0", f"--{name}") if by_point is None else by_point


LogFile = Annotated[Path, argument("time_s, NAME_um, NAME_degC, NAME_rpm.", metavar="LOG.csv")]


def drift_fit(
    log: LogFile,
    out: Annotated[Path, option("Folder of the results.", "--out", "-o", metavar="DIR")],
    hold_out: Annotated[
        float, option("Share of the time, at its end, that is predicted to judge.", min=0.05, max=0.9)
    ] = 0.3,
    as_json: AsJson = False,
) -> None:
    """Fit a model of drift: drift.json and drift.html.

    A channel at a time, from all inputs, each with a lag. The end of the log judges it, as read and where an operator's
    reference zeroes what is left every so many hours.
    """
    from trueloop.errors import in_file
    from trueloop.formats.measurements.history_csv import read_drift
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables.model_file import drift_to_json
    from trueloop.jobs.machine.machine_model import hashes_of
    from trueloop.machine.drift import held_out, judged_models
    from trueloop.report.machine.summary import drift_lines, drift_model_page, drift_summary

    test = read_drift(log)
    with in_file(log):
        runs = held_out(test, hold_out)
        models = judged_models(test, runs)
    page = drift_model_page(log.stem, test, models, runs)
    files = {"drift.json": drift_to_json(models, hashes_of([log])).encode(), "drift.html": page.encode()}
    write_all(out, files.items(), inputs=(log,))
    if as_json:
        print_json(drift_summary(models, runs))
    else:
        print_lines([*drift_lines(runs, hold_out), f"written: {out / 'drift.json'}, {out / 'drift.html'}"])


def drift_predict(
    model: Annotated[Path, argument("As `trueloop machine drift-fit` wrote it.", metavar="DRIFT.json")],
    log: LogFile,
    out: Annotated[Path, option("time_s and NAME_um, predicted.", "--out", "-o", metavar="PREDICTED.csv")],
    extrapolate: Extrapolate = None,
    as_json: AsJson = False,
) -> None:
    """Predict the displacements of a log from its temperatures.

    The log begins in equilibrium. Where it holds displacements too, prints what is left.
    """
    from trueloop.errors import in_file
    from trueloop.formats.measurements.history_csv import drift_csv, read_drift
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables.model_file import read_drift_models
    from trueloop.machine.drift import begun_warm, compared, predicted_um

    models, test = read_drift_models(model), read_drift(log, displacements=False)
    with in_file(log):
        found = predicted_um(models, test, extrapolate or ())
    print_findings(begun_warm(models, test))
    write_all(out.parent, [(out.name, drift_csv(test.time_s, found).encode())], inputs=(model, log))
    left = compared(found, test)
    if as_json:
        print_json(
            {"left_um_rms": {name: {"as_read": whole, "without_mean": rest} for name, (whole, rest) in left.items()}}
            | {"u_um": {name: known.left_um for name, known in models.items() if known.left_um}}
        )
        return
    for name, (whole, rest) in left.items():
        typer.echo(f"{name:<8} {whole:.2f} µm RMS off what was read, {rest:.2f} when zeroed on its mean")
    for name, known in models.items():
        if known.left_um:
            typer.echo(f"{name:<8} standard uncertainty {known.left_um:.2f} µm: RMS left in rows held out from the fit")
    typer.echo(f"written: {out}, {len(found)} channels at {len(test.time_s)} times")


def add_drift(
    model: ModelFile,
    drift: Annotated[Path, argument("As `trueloop machine drift-fit` wrote it.", metavar="DRIFT.json")],
    channels: Annotated[
        list[str],
        option(
            "Channel and the displacement of place that it is, as z=EZ0S; z=-EZ0S where it reads the other way.",
            "--channel",
            metavar="NAME=ERROR",
        ),
    ],
    out: Annotated[Path, option("The model with the drift.", "--out", "-o", metavar="FILE.json")],
) -> None:
    """Add drifts to a machine model as terms, for `compensate`.

    A channel is the tool as seen from the work.
    """
    from trueloop.errors import in_file
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables.model_file import model_to_json, read_drift_models, read_model
    from trueloop.jobs.machine.machine_model import hashes_of
    from trueloop.machine.drift import turned, with_drift
    from trueloop.machine.model.chain import error_name

    known, drifts = read_model(model), read_drift_models(drift)
    for text in channels:
        channel, _, error = (part.strip() for part in text.partition("="))
        if channel not in drifts:
            raise typer.BadParameter(f"{channel!r} is not one of {', '.join(drifts)}", param_hint="--channel")
        one = turned(drifts[channel]) if error.startswith("-") else drifts[channel]
        with in_file(model):
            known = with_drift(known, one, error_name(error.removeprefix("-")))
    made = model_to_json(known, hashes_of([model, drift])).encode()
    write_all(out.parent, [(out.name, made)], inputs=(model, drift))
    typer.echo(f"written: {out}, {len(known.terms)} terms, {len(known.lags)} lags; give `compensate` a log: -t LOG.csv")


@dataclass(frozen=True, kw_only=True)
class TableOptions:
    """Which table, and where it is."""

    control: Annotated[Literal["linuxcnc", "siemens", "heidenhain"], option("Whose table.")]
    axis: Annotated[str, option("Axis whose position the table runs over.", metavar="X")]
    out: Annotated[Path, option("The table.", "--out", "-o", metavar="FILE")]
    error_of: Annotated[str | None, option("Axis that is corrected.  [default: the same]", metavar="Y")] = None
    count: Annotated[int, option("Entries.", min=2)] = 101
    at: Annotated[list[str] | None, option("Position of another axis, mm or °.", metavar="Y=V")] = None
    opposite_sign: Annotated[bool, option("All values with the other sign, where a trial shows the need.")] = False


def export(
    model: ModelFile, wanted: TableOptions, temperatures: Temperatures = None, extrapolate: Extrapolate = None
) -> None:
    """Write a control's compensation table.

    Prints how far the table is from the model.
    """
    from trueloop.errors import in_file
    from trueloop.formats.outputs import write_all
    from trueloop.formats.tables.control_tables import TABLES
    from trueloop.formats.tables.model_file import read_model
    from trueloop.machine.correct import axis_table

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


def fit(
    machine: MachineFile,
    readings: ReadingFiles,
    out: Annotated[Path, option("Folder of the results.", "--out", "-o", metavar="DIR")],
    history: HistoryFile = None,
    robust: Annotated[bool, option("Let outliers count less.")] = True,
    accept: AcceptRefused = None,
    as_json: AsJson = False,
) -> None:
    """Find the model of a machine from readings. Writes model.json and machine.html."""
    from trueloop.jobs.machine.machine_model import fit_machine
    from trueloop.report.machine.summary import fit_lines, fit_summary

    made = fit_machine(machine, readings, history, robust=robust, accept=accept or ())
    made.write(out)
    summarised = (made.found, made.chosen, made.held, len(made.data))
    if as_json:
        print_json(fit_summary(*summarised))
        return
    for line in fit_lines(*summarised):
        typer.echo(line)
    for finding in made.found.findings:
        typer.echo(str(finding), err=True)
    typer.echo(f"written: {out / 'model.json'}, {out / 'machine.html'}")


def show(
    model: ModelFile, temperatures: Temperatures = None, extrapolate: Extrapolate = None, as_json: AsJson = False
) -> None:
    """Print every error of a model: range and uncertainty.

    The range is over the travel; the uncertainty is the largest standard uncertainty there.
    """
    from trueloop.errors import in_file
    from trueloop.formats.tables.model_file import read_model
    from trueloop.machine.model.model import overview
    from trueloop.machine.model.validity import check_signals
    from trueloop.report.machine.summary import lag_line

    known = read_model(model, offered=True)
    signals = signals_of(known, temperatures)
    with in_file(model):
        check_signals(known, signals, extrapolate or ())
        rows = overview(known, signals)
    if as_json:
        print_json({"terms": [row.__dict__ for row in rows], "lags": [lag.__dict__ for lag in known.lags]})
        return
    for lag in known.lags:
        typer.echo(lag_line(lag))
    for row in rows:
        typer.echo(f"{row.error:<5} {row.least:+9.2f} to {row.most:+9.2f} {row.unit:<5} u {row.largest_u:.2f}")


def check(
    model: ModelFile,
    readings: ReadingFiles,
    history: HistoryFile = None,
    limit_um: Annotated[float | None, option("Refuse when the RMS of the lengths is larger.")] = None,
    limit_urad: Annotated[float | None, option("Refuse when the RMS of the angles is larger.")] = None,
    extrapolate: Extrapolate = None,
    as_json: AsJson = False,
) -> None:
    """Compare a model with readings it was not made from. Exit status 1 when beyond a limit."""
    from dataclasses import asdict

    from trueloop.cli.terminal import ExitStatus
    from trueloop.errors import in_file
    from trueloop.formats.tables.model_file import read_model
    from trueloop.jobs.machine.machine_model import readings_of
    from trueloop.machine.identify.judge_fit import compare
    from trueloop.machine.model.validity import check_state

    known = read_model(model, offered=True)
    data = readings_of(readings, known.machine.chain, history).with_lags(known.lags)
    with in_file(readings[0] if len(readings) == 1 else model):
        check_state(known, data.state, extrapolate or ())
    result = compare(known, data)
    beyond = [_beyond(result, "µm", "--limit-um", limit_um), _beyond(result, "µrad", "--limit-urad", limit_urad)]
    if as_json:
        print_json(asdict(result))
    else:
        for unit, left in result.by_unit.items():
            typer.echo(f"{left.readings} readings: {left.raw:.2f} {unit} RMS, after the model {left.rms:.2f} {unit}")
    if any(beyond):
        raise typer.Exit(ExitStatus.FINDINGS)


def _beyond(result: "HeldOut", unit: str, option: str, limit: float | None) -> bool:
    """A limit on what was not read would always pass: it is refused as a mistyped option."""
    if limit is None:
        return False
    if unit not in result.by_unit:
        raise typer.BadParameter(f"no reading is in {unit}, {limit:g} limits nothing", param_hint=option)
    return not result.by_unit[unit].rms <= limit


def plates(
    reports: Annotated[list[Path], argument("CMM reports of drilled plates, mm.", metavar="REPORT.txt")],
    out: Annotated[
        Path | None, option("The correction as a table of displacements.", "--out", "-o", metavar="FIELD.csv")
    ] = None,
    step_mm: Annotated[float, option("Largest step between the nodes of the table.", callback=positive)] = 10.0,
    margin_mm: Annotated[
        float, option("Reach of the table beyond the holes, where it is a guess.", callback=not_negative)
    ] = 0.0,
    as_json: AsJson = False,
) -> None:
    """Find the errors that drilled plates have in common.

    Each plate's own similarity is taken off, then a pattern of errors in the plane is fitted.
    """
    from trueloop.errors import Code
    from trueloop.formats.measurements.field_csv import plane_csv
    from trueloop.formats.measurements.positioning_data import read_plate_report
    from trueloop.formats.outputs import write_all
    from trueloop.machine.standards import judged_pattern
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
        option("X and Y times 1 − M cos 2(θ − DEG), θ the point's direction from the zero.", metavar="M,DEG"),
    ] = None
    table: Annotated[
        Path | None,
        option("Displacements at the nodes of a grid, as of `plates`.", "--table", "-t", metavar="FIELD.csv"),
    ] = None
    unproven: Annotated[
        bool, option("Also by a table of plates whose pattern is not known to repeat.", "--unproven")
    ] = False

    def read(self) -> "tuple[PlanarField, dict[str, object]]":
        """The field, and what identifies it. Raises NC-FIELD and MCH-PATTERN."""
        from trueloop.machine.standards import QuadrupoleField

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
    from trueloop.machine.correct import TableField
    from trueloop.machine.standards import require_repeating

    with in_file(table):
        known = TableField(read_field(table))
        require_repeating(None if unproven else read_left_out(table))
    return known, known.field.identity | ({"unproven": True} if unproven else {})


def points(
    file: ProgramFile,
    out: Annotated[Path, option("The program to be written.", "--out", "-o", metavar="FILE")],
    errors: PlaneErrors,
    all_words: Annotated[
        bool, option("Also X and Y of G10, G28, G52, G53 and G92 blocks, as if they were points.", "--all-words")
    ] = False,
    limit_um: LimitUm = LARGEST_UM,
    dialect: DialectName = None,
    unit: UnitAtStart = None,
    decimals: Decimals = 0,
    as_json: AsJson = False,
) -> None:
    """Take errors in the plane out of a drilling program.

    Every X and Y word, whatever cycles and macros it calls.
    """
    from trueloop.formats.input_file import read_program
    from trueloop.jobs.machine.mapped_program import write_corrected_points

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


Page = Annotated[Path | None, option("Page with the plots.", "--out", "-o", metavar="PAGE.html")]


def _print_evaluation(
    read: Path,
    page: "tuple[Path | None, Callable[[], str]]",
    lines: "Iterable[str]",
    summary: "Mapping[str, object]",
    as_json: bool,
) -> None:
    """Writes the page where one is wanted, and prints the evaluation of a test as lines or JSON."""
    from trueloop.formats.outputs import write_all

    out, content = page
    if out is not None:
        write_all(out.parent, [(out.name, content().encode())], inputs=(read,))
    if as_json:
        print_json(summary)
        return
    for line in lines:
        typer.echo(line)
    if out is not None:
        typer.echo(f"written: {out}")


def positioning(
    test: Annotated[Path, argument("Target, approach, cycle, actual.", metavar="TEST.csv")],
    out: Page = None,
    unit: Annotated[
        Literal["mm", "um", "in", "deg", "arcsec"] | None,
        option("Unit of the readings, in place of that of their heading.  [default: the heading's]"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Analyse a positioning test: A, R, E, B, M of ISO 230-2.

    Every raw deviation is on a page.
    """
    from trueloop.formats.measurements.positioning_data import read_positioning
    from trueloop.report.machine.positioning import positioning_page
    from trueloop.report.machine.summary import positioning_lines, positioning_summary

    found = read_positioning(test, unit)
    page = partial(positioning_page, test.stem, found)
    _print_evaluation(test, (out, page), positioning_lines(found), positioning_summary(found), as_json)


def circular(
    bar: Annotated[Path, argument("A ball bar's circles, one or one each way.", metavar="BALLBAR.csv")],
    out: Page = None,
    unit: Annotated[
        Literal["mm", "um"] | None,
        option("Unit of the deviations, in place of that of their heading.  [default: the heading's]"),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Analyse a circular test: G, G(b), F, D of ISO 230-4.

    Its causes are listed; the largest is named.
    """
    from trueloop.errors import in_file
    from trueloop.formats.measurements.instrument_files import read_circles
    from trueloop.machine.circular import circular_test
    from trueloop.report.machine.circular import circular_lines, circular_page, circular_summary

    circles = read_circles(bar, unit)
    with in_file(bar):
        found = circular_test(circles)
    page = partial(circular_page, bar.stem, found)
    _print_evaluation(bar, (out, page), circular_lines(found), circular_summary(found), as_json)


def drift(
    log: Annotated[Path, argument("time_s, NAME_um, NAME_degC, NAME_rpm.", metavar="LOG.csv")],
    out: Page = None,
    window_h: Annotated[float, option("Time over which the largest drift is looked for, h.", callback=positive)] = 1.0,
    as_json: AsJson = False,
) -> None:
    """Analyse a drift test: the ranges of ISO 230-3.

    Ranges over all and within a time; plots beside the temperatures.
    """
    from trueloop.formats.measurements.history_csv import read_drift
    from trueloop.machine.drift import drift as analysed
    from trueloop.report.machine.positioning import drift_page

    test = read_drift(log)
    found = [analysed(test.time_s, values, name, 3600 * window_h) for name, values in test.displacement_mm.items()]
    lines = [
        f"{item.channel:<8} {UM_PER_MM * item.total_range:9.2f} µm over all, {UM_PER_MM * item.window_range:.2f} "
        f"within {window_h:g} h from {item.window_start_s / 3600:.2f} h"
        for item in found
    ]
    page = partial(drift_page, log.stem, test, found)
    _print_evaluation(log, (out, page), lines, {"channels": [item.__dict__ for item in found]}, as_json)


app = Group("A machine's own errors: identified, taken out, exported. From readings, out of programs, to the control.")
app.add_all(
    fit,
    show,
    check,
    accept,
    compensate,
    export,
    decompose,
    positioning,
    circular,
    drift,
    drift_fit,
    drift_predict,
    add_drift,
    plates,
    points,
)
