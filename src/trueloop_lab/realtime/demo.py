"""The demo of the real-time corrector: a virtual lathe is measured, its model found, a part cut without and with it."""

import time
from collections.abc import Callable, Iterable, Mapping
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
from trueloop.jobs.machine.machine_model import hashes_of, readings_of
from trueloop.machine.identify.form import fit_form
from trueloop.machine.model.history import Clock, History, lag_signals
from trueloop.machine.model.model import MachineModel
from trueloop.realtime.bank import bank_of, signals_of
from trueloop.realtime.image import Identity, Image, RealTimeLimits
from trueloop.realtime.judge import RunJudgement, due, judge
from trueloop.report.realtime.page import run_page
from trueloop.report.realtime.run import FinishedPart, Residual, RunPage, timing_of, trace_of
from trueloop_lab.realtime.cutting import (
    Drives,
    MeasuredPart,
    causes_um,
    gauging_points,
    measured_part,
    nose_positions,
    set_position,
    setting_mm,
)
from trueloop_lab.realtime.part import DemoProgram, demo_profile, demo_program
from trueloop_lab.realtime.warming_run import PERIOD_S, Sensors, WarmingRun, warming_run
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
