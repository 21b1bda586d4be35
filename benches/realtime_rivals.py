"""What is left of a lathe's errors in LinuxCNC: the corrector, and what one would use without it, by one judge.

Run: .venv/bin/python -m benches.realtime_rivals

LinuxCNC turns at 50 mm/s on a lathe whose drives are wires and whose errors are a machine model. Two models: smooth
errors of some 20 µm, as machines have them, and a ripple of 10 µm that comes 20 times a second, as worn screws have it.
Judged is where the tool is by the model in splines, against where the program wants it, while it cuts.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from scripts.realtime_faults import TOOL, TRAVEL, WARM, error_mm, image, lathe
from trueloop.arrays import Array
from trueloop.formats.tables.control_tables import linuxcnc_comp
from trueloop.machine.correct import axis_table
from trueloop.machine.model.chain import error_name
from trueloop.machine.model.model import MachineModel
from trueloop.machine.model.term import Part, Term, segments
from trueloop.realtime.judge import travel_ways
from trueloop_lab.linuxcnc.realtime import session
from trueloop_lab.linuxcnc.realtime.session import Driven, Setup, Step, put, sleep

FEED_MM_PER_S: Final = 50.0
RIPPLE_MM, RIPPLE_HZ = 0.010, 20.0
LINES: Final = (4, 6)
"""Of the program, that cut: the carriage to the chuck, the cross slide outwards."""
PROGRAM: Final = b"""G21 G18 G8 G90 G94 G64 P0.001 Q0
G0 X60 Z60
G0 X40 Z50
G1 X40 Z-200 F3000
G4 P0.2
G1 X140 Z-200
G4 P0.2
M2
"""
SAMPLED: Final = (
    *("joint.0.pos-cmd", "joint.1.pos-cmd", "joint.0.motor-offset", "joint.1.motor-offset", "rtec.out-0", "rtec.out-2"),
    *("axis.x.eoffset", "axis.z.eoffset", "motion.program-line"),
)
OFFSETS: Final = """
loadrt mult2 names=to-counts-x,to-counts-z
loadrt conv_float_s32 names=counts-x,counts-z
addf to-counts-x servo-thread
addf to-counts-z servo-thread
addf counts-x servo-thread
addf counts-z servo-thread
net counted-x to-counts-x.out counts-x.in
net counted-z to-counts-z.out counts-z.in
setp axis.x.eoffset-scale 1e-6
setp axis.z.eoffset-scale 1e-6
setp axis.x.eoffset-enable 1
setp axis.z.eoffset-enable 1
"""
EXTERNAL: Final = (
    OFFSETS
    + """
net model-x rtec.model-0 to-counts-x.in0
net model-z rtec.model-2 to-counts-z.in0
net count-x counts-x.out axis.x.eoffset-counts
net count-z counts-z.out axis.z.eoffset-counts
"""
)
POLLED: Final = (
    OFFSETS
    + """
net model-z rtec.model-2
net count-z counts-z.out axis.z.eoffset-counts
loadusr -Wn poller python3 poller.py
net polled-z poller.z to-counts-z.in0
"""
)
POLLER: Final = b'''"""Reads where Z should be corrected to, and offsets it, twenty times a second."""
import time
import hal

component = hal.component("poller")
component.newpin("z", hal.HAL_FLOAT, hal.HAL_OUT)
component.ready()
while True:
    component["z"] = hal.get_value("rtec.model-2")
    time.sleep(0.05)
'''


@dataclass(frozen=True)
class Rival:
    """One way to correct: lines of HAL, whether the corrector is in force, and what else the configuration has."""

    name: str
    hal: str = ""
    enabled: bool = False
    table: bool = False
    av_ratio: float = 0.2


RIVALS: Final = (
    Rival("nothing"),
    Rival("the corrector", enabled=True),
    Rival("external offsets, OFFSET_AV_RATIO 0.2", EXTERNAL),
    Rival("external offsets, OFFSET_AV_RATIO 0.5", EXTERNAL, av_ratio=0.5),
    Rival("COMP_FILE of X and Z", table=True),
    Rival("a program that offsets Z 20 times a second", POLLED),
)


def rippled() -> MachineModel:
    """EXZ: a wave along the carriage that comes 20 times a second at the feed of the cut."""
    smooth = lathe(6517)
    count = round((TRAVEL["Z"][1] - TRAVEL["Z"][0]) / FEED_MM_PER_S * RIPPLE_HZ) * 6
    basis = segments(*TRAVEL["Z"], count, 3)
    at = np.linspace(*TRAVEL["Z"], 8 * count)
    wave = RIPPLE_MM * np.sin(2 * np.pi * RIPPLE_HZ / FEED_MM_PER_S * at)
    values = np.linalg.lstsq(basis.design(at), wave, rcond=None)[0]
    warm = [term for term in smooth.terms if str(term.name) in ("EXX", "EZZ")]
    terms = (Term(error_name("EXZ"), (Part(basis),)), *warm)
    size = sum(term.size for term in terms)
    coefficients = np.concatenate([values, np.zeros(size - len(values))])
    return MachineModel(smooth.machine, terms, coefficients, np.zeros((size, size)))


def driven(model: MachineModel, rival: Rival) -> Driven:
    """One run of the program."""
    files, ini = {"part.ngc": PROGRAM, "poller.py": POLLER}, []
    for axis in "XZ":
        ini.append((f"AXIS_{axis}", "OFFSET_AV_RATIO", f"{rival.av_ratio}"))
    if rival.table:
        for joint, axis in enumerate("XZ"):
            table = axis_table(model, axis, axis, 201, {}, WARM, tool_mm=TOOL)
            files[f"{axis}.comp"] = linuxcnc_comp(table).encode()
            ini += [(f"JOINT_{joint}", "COMP_FILE", f"{axis}.comp"), (f"JOINT_{joint}", "COMP_FILE_TYPE", "0")]
    setup = Setup(image(model), files, SAMPLED, session.QUIET + rival.hal, ini=ini)
    return session.drive(setup, _steps(rival))


def _steps(rival: Rival) -> Sequence[Step]:
    signals = [put(f"rtec.signal-{k}", value) for k, value in enumerate(WARM.values())]
    steps = [session.on(), session.home(), put("rtec.limit", 0.3), *signals, put("rtec.heartbeat", 1)]
    if rival.enabled:
        steps += [put("rtec.enable", 1), session.wait("rtec.phase", 3)]
    if rival.hal:  # counts are relative to what they are when the machine is switched on: zero until then
        steps += [put(f"to-counts-{axis}.in1", 1e6) for axis in "xz"]
    return [*steps, sleep(1.0), session.record(), session.run("part.ngc"), session.record(False)]


def left_um(model: MachineModel, run: Driven) -> float:
    """RMS of where the tool is less where the program wants it, while it cuts at the feed."""
    offset = np.column_stack([run["joint.0.motor-offset"], run["joint.1.motor-offset"]])
    moved = np.column_stack([run["axis.x.eoffset"], run["axis.z.eoffset"]])
    command = np.column_stack([run["joint.0.pos-cmd"], run["joint.1.pos-cmd"]])  # with external offsets
    drive = np.column_stack([run["rtec.out-0"], run["rtec.out-2"]]) - offset
    wanted = command - moved
    left = drive + error_mm(model, drive, travel_ways(command)) - wanted
    speed = np.linalg.norm(np.diff(wanted, axis=0, prepend=wanted[:1]), axis=1) * 1e3
    cuts = np.isin(run["motion.program-line"], LINES) & (np.abs(speed - FEED_MM_PER_S) < 0.5)
    cuts &= _settled(cuts)
    return float(1e3 * np.sqrt(np.mean(np.sum(left[cuts] ** 2, axis=1))))


def _settled(cuts: Array) -> Array:
    """Without the first 50 ms of each cut: who follows slowly is not charged for the reversal before it."""
    begun = np.flatnonzero(np.diff(cuts.astype(int), prepend=0) == 1)
    settled = np.ones(len(cuts), dtype=bool)
    for k in begun:
        settled[k : k + 50] = False
    return settled


def main() -> None:
    """The table."""
    models = {"smooth errors": lathe(6517), f"ripple, {RIPPLE_HZ:g} Hz": rippled()}
    print(f"µm RMS left at {FEED_MM_PER_S:g} mm/s  | " + " | ".join(models))
    for rival in RIVALS:
        found = [left_um(model, driven(model, rival)) for model in models.values()]
        print(f"{rival.name:45} | " + " | ".join(f"{value:12.6f}" for value in found), flush=True)


if __name__ == "__main__":
    main()
