"""Semi-finish cut, probing and finish cut in LinuxCNC on a lathe that errs: model, touches and table by one corrector.

The machine's error is a formula typed here; the corrector holds a model of it. The part is NIST's, its nose is worn.
"""

import math
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from tests.support import erring_lathe
from tests.support.probing import EXAMPLES
from trueloop.arrays import Array
from trueloop.controllers.probing.linuxcnc import program as probing_program
from trueloop.controllers.probing.settings import Settings
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.geometry.offset import nose_centre_path
from trueloop.loops.realtime.process_table import PlacedCorrection, process_table
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.machine.model.model import MachineModel, State
from trueloop.nc.program.program import read_program
from trueloop.probing.calibration import BallCalibration, Stylus, stock_obstacle
from trueloop.probing.probe_match import match_touches
from trueloop.probing.probe_plan import Approach, GaugingPoints, ProbePlan, probe_plan
from trueloop.realtime.image import Block, Identity, Image, RealTimeLimits, bank_of, signals_of
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging, error_vectors
from trueloop_lab.files.virtual_machine_toml import workshop_and_trial
from trueloop_lab.linuxcnc.realtime.session import (
    QUIET,
    Driven,
    Setup,
    Step,
    drive,
    home,
    mdi,
    note,
    on,
    put,
    record,
    run,
    wait,
)
from trueloop_lab.linuxcnc.session import ProbedPart, virtual_part
from trueloop_lab.loops.linuxcnc import contour_program, paths_near_part, surface_mm
from trueloop_lab.loops.turned import Trial, random_of
from trueloop_lab.simulator.machine import Repeatability, Stock
from trueloop_lab.simulator.nose import SAME
from trueloop_lab.simulator.presets import Workshop

WARM_DEGC, SHARE = 27.0, 0.3
ORIGIN_MM = (0.0, -20.0)
PERIOD_S, IN_FORCE = 1e-3, 3
FEED_MM_PER_MIN = 60.0
LATE_MM = 0.5 * FEED_MM_PER_MIN / 60.0 * PERIOD_S
"""The touch is seen half a period after the contact, in the mean."""

TOUCHING = Approach(stand_off_mm=0.2, overtravel_mm=0.25, margin_mm=0.15)

OPEN = ((-500.0, 2000.0), (-1.0, 1.0), (-2000.0, 2000.0))
SETTINGS = Settings(diameter=True, probe_feed_mm_per_min=FEED_MM_PER_MIN, position_feed_mm_per_min=9000.0)
DRIVES = ("rtec.out-0", "rtec.out-2", "joint.0.motor-offset", "joint.1.motor-offset")
PINS = (*DRIVES, "joint.0.pos-fb", "joint.1.pos-fb", "motion.probe-input", "rtec.phase", "rtec.fault-code", "rtec.line")


def truth_mm(at_mm: Array) -> Array:
    """E where the drives stand, (n, 2), X and Z."""
    return SHARE * erring_lathe.error_mm(at_mm[:, 0], at_mm[:, 1], WARM_DEGC)


def model() -> MachineModel:
    whole = erring_lathe.model()
    return replace(whole, coefficients=SHARE * whole.coefficients)


def image(blocks: tuple[Block, ...] = ()) -> Image:
    bank = bank_of(model(), (0.0, 0.0, 0.0), signals_of(model()))
    named = Identity("erring lathe", "7", "11" * 32, "finish.ngc" if blocks else "", "22" * 32 if blocks else "")
    return Image(named, RealTimeLimits(OPEN, 0.3, 0.1), bank, blocks)


@cache
def given() -> tuple[Workshop, Trial]:
    """NIST's part and worn nose; nothing of process and probe is random."""
    workshop, trial = workshop_and_trial(EXAMPLES / "loop" / "modbas2.toml", EXAMPLES / "loop" / "machine.toml")
    program = trial.inputs.program
    kept = program.source.replace(b"G64 P0.0001", b"G64 P0.0001 Q0")
    trial = replace(
        trial,
        inputs=replace(trial.inputs, program=read_program(kept, program.dialect.name, program.file, program.unit)),
    )
    machine = replace(workshop.machine, repeatability=Repeatability(), transfer=SAME)
    probe = replace(workshop.probe, range_x_mm=0.0, range_z_mm=0.0, pre_travel_mm=0.0, lobing_mm=0.0)
    return replace(workshop, machine=machine, probe=probe), trial


def began(*, corrected: bool) -> list[Step]:
    set_up = [on(), home(), mdi(f"G21 G8 G10 L2 P1 X{ORIGIN_MM[0]} Z{ORIGIN_MM[1]}"), mdi("G64 P0.0001")]
    felt = [put("rtec.heartbeat", 1), put("rtec.signal-0", WARM_DEGC), put("rtec.program", 1)]
    return [*set_up, *felt, *(enabled() if corrected else [])]


def enabled() -> list[Step]:
    return [put("rtec.enable", 1), wait("rtec.phase", IN_FORCE)]


def tool_mm(driven: Driven) -> Array:
    """Where the nose's centre was, (n, 2), part coordinates."""
    drives = np.column_stack([driven[DRIVES[k]] - driven[DRIVES[2 + k]] for k in range(2)])
    return np.asarray(drives + truth_mm(drives) - ORIGIN_MM)


def cut_along(stock: Stock, driven: Driven, off_mm: float) -> Stock:
    workshop, trial = given()
    near = paths_near_part(tool_mm(driven), trial.inputs.profile, trial.inputs.nose_radius_mm + off_mm)
    return workshop.machine.cut(stock, near, random_of(0, 0))


@cache
def semifinished() -> tuple[Stock, Driven]:
    """The part after the semi-finish cut, the machine's errors corrected by the model, and that run."""
    workshop, trial = given()
    centre = nose_centre_path(trial.inputs.profile, trial.inputs.nose_radius_mm + trial.inputs.allowance_mm)
    program = contour_program(centre.features, 0.127, 2400.0, 5.0)
    steps = [*began(corrected=True), record(), run("semi.ngc", 10.0), record(on=False)]
    driven = drive(Setup(image_to_bytes(image()), {"semi.ngc": program}, PINS, hal=QUIET), steps)
    roughed = workshop.machine.cut(Stock(), trial.rough, random_of(0, 0))
    return cut_along(roughed, driven, trial.inputs.allowance_mm), driven


@dataclass(frozen=True)
class Probed:
    """Positions that the control latched at the touches, (n, 2), part coordinates, with the corrector off and on."""

    off_mm: Array
    on_mm: Array


@cache
def probed() -> Probed:
    """The ball meets the surface where drive + E(drive) does: the surface is laid out in what the drives show."""
    workshop, trial = given()
    stock, driven = semifinished()
    seen = surface_mm(trial.inputs.profile, trial.inputs.nose_radius_mm, stock, trial.inputs.allowance_mm) + ORIGIN_MM
    drives = seen.copy()
    for _ in range(6):
        drives = seen - truth_mm(drives)
    homing = np.array([driven[DRIVES[2]][0], driven[DRIVES[3]][0]])
    part = ProbedPart(drives + homing, workshop.probe.ball_radius_mm)
    hal = QUIET + "\n".join(
        [
            "loadrt virtual_part",
            "addf virtual-part.0 servo-thread",
            "net x-drive => virtual-part.0.x",
            "net z-drive => virtual-part.0.z",
            "net probe virtual-part.0.contact => motion.probe-input rtec.touch",
            "",
        ]
    )
    program = probing_program(plan(), SETTINGS)
    files = {"probe.ngc": program.encode(), "surface.bin": part.to_bytes()}
    once = [record(), run("probe.ngc"), record(on=False), note("first")]
    again = [put("rtec.probe-corrected", 1), *enabled(), record(), run("probe.ngc"), record(on=False)]
    setup = Setup(
        image_to_bytes(image()), files, PINS, hal=hal, modules={"virtual_part.so": virtual_part()}, depth=400_000
    )
    found = drive(setup, [*began(corrected=False), *once, *again])
    assert not found.messages and not found["rtec.fault-code"].any(), found.messages
    latched = np.column_stack([found["joint.0.pos-fb"], found["joint.1.pos-fb"]]) - ORIGIN_MM
    rises = np.flatnonzero(np.diff(found["motion.probe-input"]) > 0) + 2
    first = int(found.got["first"])
    return Probed(latched[rises[rises < first]], latched[rises[rises >= first]])


@cache
def plan() -> ProbePlan:
    """NIST's gauging points, approached over a short way."""
    workshop, trial = given()
    inputs, ball = trial.inputs, workshop.probe.ball_radius_mm
    at = inputs.touches
    points = GaugingPoints(at.feature_index, at.arc_length_mm, at.nominal_mm, at.outward_normal)
    obstacle = stock_obstacle(inputs.profile, inputs.allowance_mm)
    stylus = Stylus(ball, ball / 2, stem_angle_rad=math.radians(45.0))
    return probe_plan(
        inputs.profile, points, obstacle, stylus, replace(TOUCHING, allowance_mm=inputs.allowance_mm), at.point
    )


def error_vectors_of(latched_mm: Array) -> ErrorVectors:
    """Part errors from actual ball centres, (n, 2), part coordinates."""
    workshop, trial = given()
    ball = BallCalibration(workshop.probe.ball_radius_mm - LATE_MM)
    positions = [(x, z) for x, z in latched_mm.tolist()]
    touches = match_touches(plan(), positions, range(1, len(positions) + 1), ball).touches
    return error_vectors(trial.inputs.profile, touches, Gauging(z_reference=trial.z_reference))


def actual_mm(controller_mm: Array) -> Array:
    """COORDS_ACTUAL = COORDS_CONTROLLER − COMP_MTG [6876 §3.3], part coordinates, of ball centres."""
    known, at = model(), controller_mm + ORIGIN_MM
    positions = known.machine.chain.positions({"X": at[:, 0], "Z": at[:, 1]})
    comp_mtg = known.comp_mtg_mm(State(positions, 0.0, {"T1": WARM_DEGC}))[:, [0, 2]]
    return np.asarray(controller_mm - comp_mtg)


@cache
def finished() -> tuple[Stock, Driven, int]:
    """The finished part, the run, and rows in the table; the image with it is taken while the corrector is off."""
    trial = given()[1]
    latched = probed()
    touches = error_vectors_of(latched.on_mm)
    inputs = replace(trial.inputs, touches=touches)
    correction = compensate(inputs)
    table = process_table(inputs.program, inputs.run, correction, PlacedCorrection(ORIGIN_MM))
    held = image(table.blocks)
    files = {"finish.ngc": inputs.program.source, "table.rtec": image_to_bytes(held)}
    exchanged: list[Step] = [("put", "table.rtec", "image.rtec"), put("rtec.reload", 1), wait("rtec.generation", 2)]
    steps = [*began(corrected=True), put("rtec.enable", 0), wait("rtec.phase", 0), *exchanged, *enabled()]
    steps += [record(), run("finish.ngc", 10.0), record(on=False)]
    driven = drive(Setup(image_to_bytes(image()), files, PINS, hal=QUIET), steps)
    stock = cut_along(semifinished()[0], driven, 0.0)
    return stock, driven, sum(len(block.rows) for block in table.blocks)
