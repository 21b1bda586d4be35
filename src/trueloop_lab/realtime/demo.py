"""The demo of the real-time corrector: a virtual lathe is measured, its model found, a part cut without and with it.

From the motions of the drives to the part: the lathe's truth, the nose's envelope, the virtual measuring machine.

Three parts are compared that differ in nothing but what is said: the same drift of the process, the same noise of the
measuring machine. Lengths in mm, X a radius, part errors positive where material is left on.

The residuals of the corrector on the virtual lathe, cause by cause: the errors of the tool's path in the cuts.

Only here is the truth asked. Components along the normal of the path, µm RMS; they add up along the path, not in RMS.
"""

import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.domain.record import sha256_of
from trueloop.formats.examples import example
from trueloop.formats.jobs.machine_toml import read_machine
from trueloop.formats.outputs import write_all
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.formats.realtime.samples_csv import samples_csv
from trueloop.formats.tables.model_file import model_to_json
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.jobs.machine.machine_model import hashes_of, readings_of
from trueloop.machine.identify.form import fit_form
from trueloop.machine.model.history import Clock, History, lag_signals
from trueloop.machine.model.model import MachineModel
from trueloop.probing.probe_plan import GaugingPoints, Spacing, equally_spaced
from trueloop.realtime.image import Identity, Image, RealTimeLimits, bank_of, signals_of
from trueloop.realtime.judge import DrivenRun, RunJudgement, due, error_mm, judge, travel_ways
from trueloop.report.realtime.page import run_page
from trueloop.report.realtime.run import FinishedPart, Residual, RunPage, timing_of, trace_of
from trueloop_lab.realtime.warming_run import (
    NOSE_RADIUS_MM,
    PERIOD_S,
    SET_AT_MM,
    TOOL_OFFSET_MM,
    WORK_ZERO_Z_MM,
    DemoProgram,
    Sensors,
    WarmingRun,
    demo_profile,
    demo_program,
    warming_run,
)
from trueloop_lab.simulator.lathe import (
    FASTER,
    UNTIL_S,
    X_TRAVEL_MM,
    Z_TRAVEL_MM,
    Reading,
    WarmLathe,
    WarmUp,
    measured_day,
    warm_up,
)
from trueloop_lab.simulator.machine import Repeatability, Stock, VirtualMachine
from trueloop_lab.simulator.mill import VirtualCmm
from trueloop_lab.simulator.nose import CentrePath, Nose, path_of_positions

POINTS_PER_MM: Final = 2.0
MARGIN_MM: Final = 0.6
"""From the ends of every feature: corners are not judged."""

PROCESS: Final = Repeatability(along_mm=0.0012, correlation_mm=1.0)
"""The parts of the process that do not repeat along a cut: those of [6811] (`simulator/presets.py`)."""

CMM: Final = VirtualCmm(frame_mm=0.0003, tilt_rad=2e-6, mpe_mm=0.0009, mpe_per_mm=0.9e-3 / 350)


@by_content
@dataclass(frozen=True)
class Drives:
    """Motion of the drives, period by period: time since the cold start (n,), positions in machine coordinates (n, 2),
    and which of them cut, one mask (n,) a cut.
    """

    time_s: Array
    position_mm: Array
    cuts: tuple[Flags, ...]


@by_content
@dataclass(frozen=True)
class MeasuredPart:
    """Part errors at the gauging points: as measured, and as they are without noise of process and measurement, mm."""

    points: GaugingPoints
    measured_mm: Array
    true_mm: Array

    @property
    def rms_um(self) -> float:
        """Returns the RMS of the measured errors."""
        return float(1e3 * np.sqrt(np.mean(self.measured_mm**2)))

    @property
    def worst_um(self) -> float:
        """Returns the largest of the measured errors."""
        return float(1e3 * np.abs(self.measured_mm).max())


def nose_positions(lathe: WarmLathe, drives: Drives, warm: WarmUp, set_mm: Array) -> Array:
    """Returns the positions of the nose's centre, (n, 2), part coordinates; `set_mm`: taken out by setting the tool."""
    tool = -np.array(TOOL_OFFSET_MM)
    at = lathe.tool_mm(drives.position_mm, tool, warm.at(drives.time_s))
    return np.asarray(at - [0.0, WORK_ZERO_Z_MM] - set_mm)


def setting_mm(lathe: WarmLathe, cold: WarmUp, correction_mm: Array) -> Array:
    """Returns by how much the tool is off where it is set, (2,), with the corrector's addition there: setting takes it
    out.
    """
    commanded = np.array(SET_AT_MM) + TOOL_OFFSET_MM + [0.0, WORK_ZERO_Z_MM]
    slides = commanded + correction_mm + 0.5 * np.array([lathe.lost.x_mm, lathe.lost.z_mm])
    error = lathe.error_mm(slides[None], -np.array(TOOL_OFFSET_MM), cold.at(np.zeros(1)))[0]
    return np.asarray(slides + error - commanded)


def set_position(run: DrivenRun, cold: Mapping[str, Array]) -> DrivenRun:
    """Returns two periods of a run that comes to where the tool is set, in the direction in which it is set there."""
    at = np.array(SET_AT_MM) + TOOL_OFFSET_MM + [0.0, WORK_ZERO_Z_MM]
    command = np.array([[at[0] + 1.0, 0.0, at[1] + 1.0], [at[0], 0.0, at[1]]])
    tool = np.array([-TOOL_OFFSET_MM[0], 0.0, -TOOL_OFFSET_MM[1]])
    both = np.ones(2, dtype=bool)
    return DrivenRun(run.period_s, command, command, cold, np.zeros(2, dtype=np.intp), both, tool)


def gauging_points(profile: Profile) -> GaugingPoints:
    """Returns two gauging points a millimetre of what the nose reaches of every feature, away from its ends."""
    spacing = {
        f.name: Spacing(max(2, round(POINTS_PER_MM * f.length_mm)), MARGIN_MM, MARGIN_MM) for f in profile.features
    }
    return equally_spaced(profile, spacing, nose_centre_path(profile, NOSE_RADIUS_MM).reachable_mm)


def measured_part(nose_mm: Array, cuts: Sequence[Flags], points: GaugingPoints, seed: int) -> MeasuredPart:
    """Returns the part that a nose leaves whose centre was there, measured."""
    paths = [path_of_positions(nose_mm[cut]) for cut in cuts]
    rng = np.random.default_rng(seed)
    cut = _cut(paths, PROCESS, rng)
    found = CMM.measure(cut, points.nominal_mm, points.outward_normal, rng)
    true = _cut(paths, Repeatability(), rng).height_mm(points.nominal_mm, points.outward_normal)
    return MeasuredPart(points, found, true)


def _cut(paths: Sequence[CentrePath], process: Repeatability, rng: np.random.Generator) -> Stock:
    machine = VirtualMachine(nose=Nose(NOSE_RADIUS_MM), repeatability=process)
    return machine.cut(Stock(), paths, rng)


def causes_um(
    lathe: WarmLathe,
    run: DrivenRun,
    model: MachineModel,
    signals: Mapping[str, Array],
    warm: WarmUp,
    set_mm: Array,
    cuts: Sequence[Flags],
) -> dict[str, float]:
    """Returns the RMS of each, over all periods that cut.

    `warm` and `signals`, what sensors without noise would say, are those of each period; `set_mm` is what setting the
    tool took out.
    """
    drives, way = run.drive_mm[:, ::2], travel_ways(run.command_mm)
    slides = lathe.lost.follow(drives)
    lost = -0.5 * way[:, ::2] * [lathe.lost.x_mm, lathe.lost.z_mm]
    truth = lathe.error_mm(slides, -np.array(TOOL_OFFSET_MM), warm) + lost
    quiet = DrivenRun(run.period_s, run.command_mm, run.drive_mm, signals, run.line, run.in_force, run.tool_mm)
    modelled, as_felt = (error_mm(model, r, run.drive_mm, way)[:, ::2] for r in (quiet, run))
    parts = {
        "the model's form and its readings": truth - modelled - set_mm,
        "noise of the sensors": modelled - as_felt,
        "the corrector: numerics and slew": drives + as_felt - run.command_mm[:, ::2],
        "drives that turn round by less than their lost motion": slides - drives - lost,
    }
    return {name: _normal_rms_um(off, run, cuts) for name, off in parts.items()}


def _normal_rms_um(off_mm: Array, run: DrivenRun, cuts: Sequence[Flags]) -> float:
    """Returns the RMS along the normal of the commanded path; its mean stays in."""
    found = []
    for cut in cuts:
        along = np.gradient(run.command_mm[cut][:, ::2], axis=0)
        along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
        found.append(off_mm[cut, 0] * along[:, 1] - off_mm[cut, 1] * along[:, 0])
    return float(1e3 * np.sqrt(np.mean(np.concatenate(found) ** 2)))


HEADER: Final = "time_s,X_mm,Z_mm,travel_X,travel_Z,{along},{reading},{u},tool_x_mm,tool_z_mm,tool_y_mm,absolute,run"
VIRTUAL_WAYS: Final = {1: "+", -1: "-", 0: ""}
MACHINE: Final = "realtime/machine.toml"
NO_Y_MM: Final = (-1.0, 1.0)
LONGEST_S: Final = 90.0
COLD_FOR_S: Final = 1.5
"""From the beginning of the stream until the spindle turns: about when the program begins."""

SENSOR_STEP_S: Final = 0.1
DAY_STEP_S: Final = 0.5
WITHOUT, WITH, NO_ERRORS = "without the corrector", "with the corrector", "errors of the lathe switched off"

Say = Callable[[str], None]


@by_content
@dataclass(frozen=True)
class Demo:
    """The result: parts by name, the judge's figures of the run with the corrector, errors left by cause."""

    parts: dict[str, MeasuredPart]
    judged: RunJudgement
    causes_um: dict[str, float]
    files: tuple[Path, ...]

    @property
    def ratios(self) -> tuple[float, float]:
        """Returns RMS and worst of the part with the corrector as ratios to those of the part without errors."""
        corrected, plain = self.parts[WITH], self.parts[NO_ERRORS]
        return corrected.rms_um / plain.rms_um, corrected.worst_um / plain.worst_um


def demo(folder: Path, seed: int = 0, tell: Say = lambda doing: None) -> Demo:
    """Runs the whole demonstration, from the readings to the page.

    Raises CTL-LINUXCNC where LinuxCNC is missing or did not run the whole program in two attempts, RTC-BUILD, OUT
    errors. Nothing is written of a run that was interrupted.
    """
    lathe, profile = WarmLathe(), demo_profile()
    program = demo_program(profile)
    tell("measuring the cold and the warm lathe, fitting its model")
    model, model_files = _model(lathe, folder / "machine", seed)
    image = _image(model, model_files["model.json"])
    content = image_to_bytes(image)
    warm = warm_up(LONGEST_S, ((COLD_FOR_S, LONGEST_S),), ((COLD_FOR_S, LONGEST_S),))
    sensors = _sensors(model, warm, np.random.default_rng(seed + 1))
    runs = {}
    for name, corrected in ((WITHOUT, False), (WITH, True)):
        tell(f"LinuxCNC turns the part {name}")
        runs[name] = warming_run(image, program.text, sensors, corrected=corrected, tell=tell)
    tell("the virtual measuring machine measures")
    parts = _parts(lathe, program, runs, model, sensors, warm, seed)
    found = judge(runs[WITH].driven, model)
    set_mm = setting_mm(lathe, warm, _added_when_set(model, runs[WITH], sensors))
    causes = _causes(lathe, program, runs[WITH], model, warm, set_mm)
    made = Demo(parts, found, causes, ())
    samples = runs[WITH].samples
    files = {
        "samples.csv": samples_csv(samples),
        "image.rtec": content,
        "part.ngc": program.text.encode(),
        "model.json": model_files["model.json"],
        "report.html": run_page(_page(made, runs)).encode(),
    }
    written = write_all(folder, list(files.items()))
    return Demo(parts, found, causes, tuple(written))


def _model(lathe: WarmLathe, folder: Path, seed: int) -> tuple[MachineModel, dict[str, bytes]]:
    """As `trueloop machine fit` finds it from files, without holding out runs, which would take minutes."""
    day, readings = measured_day(lathe, seed)
    logged = day.at(np.arange(0.0, UNTIL_S, DAY_STEP_S))
    sensors = logged.sensors(np.random.default_rng(seed + 2))
    texts = {"lengths.csv": lengths_csv(readings), "angles.csv": angles_csv(readings)}
    texts["day.csv"] = signals_csv(logged.time_s, sensors)
    texts["machine.toml"] = example(MACHINE).read_text()
    write_all(folder, [(name, text.encode()) for name, text in texts.items()])
    machine, form = read_machine(folder / "machine.toml")
    files = [folder / "lengths.csv", folder / "angles.csv"]
    data = readings_of(files, machine.chain, folder / "day.csv")
    found = fit_form(machine, form, data)[0].model
    text = model_to_json(found, hashes_of([folder / name for name in texts]))
    return found, {"model.json": text.encode()}


def _image(model: MachineModel, content: bytes) -> Image:
    bank = bank_of(model, (0.0, 0.0, 0.0), signals_of(model))
    limits = RealTimeLimits((X_TRAVEL_MM, NO_Y_MM, Z_TRAVEL_MM))
    return Image(Identity(model.machine.name, model.machine.serial, sha256_of(content)), limits, bank)


def _sensors(model: MachineModel, warm: WarmUp, rng: np.random.Generator | None) -> Sensors:
    """Returns the corrector's inputs: ten readings a second with their noise, and lags computed from them."""
    times = np.arange(0.0, LONGEST_S, SENSOR_STEP_S)
    read = warm.at(times).sensors(rng)
    log = History(times, {name: np.round(values, 2) if rng else values for name, values in read.items()})
    lagged = lag_signals(model.lags, Clock(times, np.zeros(len(times), dtype=np.intp), (log,)))
    every = np.arange(0.0, LONGEST_S - SENSOR_STEP_S, PERIOD_S)
    row = np.searchsorted(times, every, side="right") - 1
    known = {**log.signals, **{lag.name: lagged[lag.name] for lag in model.lags}}
    return Sensors(every, {name: values[row] for name, values in known.items()})


def _cuts(program: DemoProgram, run: WarmingRun) -> tuple[Flags, ...]:
    line = run.samples.count("line")
    return tuple((line >= first) & (line <= last) for first, last in program.cuts)


def _parts(
    lathe: WarmLathe,
    program: DemoProgram,
    runs: dict[str, WarmingRun],
    model: MachineModel,
    sensors: Sensors,
    warm: WarmUp,
    seed: int,
) -> dict[str, MeasuredPart]:
    """All three, from the same noise of process and measurement. The one without errors is cut by the first run."""
    points = gauging_points(demo_profile())
    made = {}
    for name, machine, run in (
        (WITHOUT, lathe, runs[WITHOUT]),
        (WITH, lathe, runs[WITH]),
        (NO_ERRORS, lathe.without_errors(), runs[WITHOUT]),
    ):
        added = _added_when_set(model, run, sensors) if name == WITH else np.zeros(2)
        cuts = _cuts(program, run)
        drives = Drives(run.clock_s, run.driven.drive_mm[:, ::2], cuts)
        nose = nose_positions(machine, drives, warm, setting_mm(machine, warm, added))
        made[name] = measured_part(nose, cuts, points, seed)
    return made


def _added_when_set(model: MachineModel, run: WarmingRun, sensors: Sensors) -> Array:
    """Returns the corrector's displacement where the tool is set, machine cold, (2,): it is in force then, too."""
    asked = set_position(run.driven, {name: values[:1] for name, values in sensors.values.items()})
    return due(asked, model, (), 0.1, 1e9).correction_mm[-1, ::2]


def _causes(
    lathe: WarmLathe, program: DemoProgram, run: WarmingRun, model: MachineModel, warm: WarmUp, set_mm: Array
) -> dict[str, float]:
    quiet = _sensors(model, warm, None)
    felt = {name: np.interp(run.clock_s, quiet.time_s, values) for name, values in quiet.values.items()}
    return causes_um(lathe, run.driven, model, felt, warm.at(run.clock_s), set_mm, _cuts(program, run))


def _page(made: Demo, runs: dict[str, WarmingRun]) -> RunPage:
    profile = demo_profile()
    parts = tuple(
        FinishedPart(
            name,
            np.array([profile.start_of(int(i)) for i in part.points.feature_index]) + part.points.arc_length_mm,
            1e3 * part.measured_mm,
            tuple(profile.names[int(i)] for i in part.points.feature_index),
        )
        for name, part in made.parts.items()
    )
    judged, samples = made.judged, runs[WITH].samples
    why = "limited by the slew at reversals, or not in force"
    left = Residual(
        "drive + E(drive) − command, E of the model",
        int(judged.judged.sum()),
        judged.rms_nm,
        judged.worst_nm,
        judged.uncorrected_um,
        int((~judged.judged).sum()),
        why,
    )
    rms_ratio, worst_ratio = made.ratios
    causes = [f"Left on the path in the cuts by {name}: {value:.3f} µm RMS." for name, value in made.causes_um.items()]
    return RunPage(
        "A part turned while the lathe warms up",
        f"With the corrector the part is within {rms_ratio:.2f} × (RMS) and {worst_ratio:.2f} × (worst place) of the "
        f"part that the same lathe cuts with its errors switched off.",
        {
            "lathe": f"simulated: its truth by plain transforms, warming up {FASTER:g} times faster than a real one",
            "control": "LinuxCNC, headless, servo period 1 ms, no real-time kernel asked for; drives are a wire",
            "process and measuring machine": "simulated, the same noise for all three parts",
            "page made": time.strftime("%Y-%m-%d %H:%M"),
        },
        parts,
        trace_of(samples),
        (left,),
        (timing_of("rtec.write", samples.columns["write_ns"]), timing_of("servo thread", samples.columns["thread_ns"])),
        notes=tuple(causes),
    )


def lengths_csv(readings: Iterable[Reading]) -> str:
    """Displacements along directions; angles are left out."""
    along = "along_x,along_y,along_z"
    rows = [
        _row(reading, f"{reading.along[0]:.9f},0,{reading.along[1]:.9f}") for reading in readings if not reading.angle
    ]
    return "\n".join([HEADER.format(along=along, reading="reading_um", u="u_um"), *rows, ""])


def angles_csv(readings: Iterable[Reading]) -> str:
    """Rotations about Y; displacements are left out."""
    rows = [_row(reading, "B") for reading in readings if reading.angle]
    return "\n".join([HEADER.format(along="along", reading="reading_urad", u="u_urad"), *rows, ""])


def signals_csv(time_s: Array, signals_degc: Mapping[str, Array]) -> str:
    """Temperatures over time, as sensors of a hundredth of a kelvin give them."""
    header = ",".join(["time_s", *(f"{name}_degC" for name in signals_degc)])
    rows = zip(time_s.tolist(), *(values.tolist() for values in signals_degc.values()), strict=True)
    return "\n".join([header, *(f"{t:.3f}," + ",".join(f"{v:.2f}" for v in values) for t, *values in rows), ""])


def _row(reading: Reading, along: str) -> str:
    (x, z), (way_x, way_z), (tool_x, tool_z) = reading.at_mm, reading.way, reading.tool_mm
    ways = f"{VIRTUAL_WAYS[way_x]},{VIRTUAL_WAYS[way_z]}"
    absolute = "slope" if reading.slope_known else "no"
    value, tool = f"{reading.value:.3f},{reading.u:g}", f"{tool_x:g},{tool_z:g},0"
    return f"{reading.time_s:.3f},{x:.6f},{z:.6f},{ways},{along},{value},{tool},{absolute},{reading.run}"
