"""The process-intermittent loop on a real controller: LinuxCNC drives, the simulator cuts and is touched.

LinuxCNC runs the semi-finish program, the probing program and the corrected program. What it really drove, servo period
by servo period, is what the virtual nose cuts along, and what the virtual ball meets.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.controllers.probing.linuxcnc import program as probing_program
from trueloop.controllers.probing.settings import Settings
from trueloop.errors import Code, in_file
from trueloop.formats.measurements.touches_csv import parse_probe_log
from trueloop.geometry.curve import Curve
from trueloop.geometry.feature import Arc, Feature, Line, LineOrArc, pieces_within
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.geometry.validate import checked_profile
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.probing.calibration import BallCalibration, Stylus, calibrate, stock_obstacle
from trueloop.probing.probe_match import match_touches
from trueloop.probing.probe_plan import Approach, GaugingPoints, ProbePlan, Spacing, equally_spaced, probe_plan
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging, error_vectors
from trueloop_lab.linuxcnc.session import ProbedPart, Progress, cut, probe
from trueloop_lab.loops.turned import SimulatedPart, Trial, finish_along, finishing_machine, measured_part, random_of
from trueloop_lab.simulator.machine import Stock, VirtualProbe
from trueloop_lab.simulator.nose import CentrePath, path_of_positions
from trueloop_lab.simulator.presets import Workshop

CHORD_MM: Final = 1e-4
"""How far the chords of a curve deviate from it."""


def contour_program(features: Sequence[Feature], feed_mm_per_rev: float, spindle_rpm: float, clear_mm: float) -> bytes:
    """Features of the nose centre's path in order, chuck end first; mm, radii, straight in from `clear_mm` outside."""
    (x, z), (_, z_end) = features[0].start_mm, features[-1].end_mm
    out_mm = max(feature.start_mm[0] for feature in features) + clear_mm
    lines = ["G18 G21 G8 G90 G40 G54", f"G97 S{spindle_rpm:.0f} M3", f"G0 X{out_mm:.6f}", f"G0 Z{z:.6f}"]
    lines += [f"G95 F{feed_mm_per_rev:.6f}", f"G1 X{x:.6f}"]
    at = features[0].start_mm
    for feature in features:
        lines += _moves(feature, at)
        at = feature.end_mm
    return "\n".join([*lines, f"G0 Z{z_end + clear_mm:.6f}", f"G0 X{out_mm:.6f}", "M5", "M2", ""]).encode()


def _moves(feature: Feature, at: tuple[float, float]) -> list[str]:
    if isinstance(feature, Curve):
        s = np.linspace(0.0, feature.length_mm, pieces_within(feature, CHORD_MM) + 1)[1:]
        return [f"G1 X{x:.6f} Z{z:.6f}" for x, z in feature.point_mm(s)]
    return [_move(feature, at)]


def _move(feature: LineOrArc, at: tuple[float, float]) -> str:
    x, z = feature.end_mm
    end = f"X{x:.6f} Z{z:.6f}"
    if isinstance(feature, Line):
        return f"G1 {end}"
    code = "G2" if feature.sweep_rad > 0 else "G3"
    return f"{code} {end} I{feature.centre_mm[0] - at[0]:.6f} K{feature.centre_mm[1] - at[1]:.6f}"


DIALECT: Final = "linuxcnc"
SPINDLE_RPM: Final = 2400.0
FEED_MM_PER_REV: Final = 0.127
CLEAR_MM: Final = 5.0
NEAR_MM: Final = 0.5
SURFACE_STEP_MM: Final = 0.02
BAR_MM: Final = 500.0
STEM_RAD: Final = math.radians(45.0)
SPHERE_RADIUS_MM: Final = 12.5
SPHERE_CENTRE_MM: Final = (60.0, 0.0)
SPHERE_FROM_TO_DEG: Final = (150.0, -60.0)
SPHERE_OFF_MM: Final = (0.013, -0.008)
"""By how much the sphere stands elsewhere than expected: touches are latched once a servo period, a micrometre apart,
and would otherwise all come at the same moment of it."""
SPHERE_POINTS: Final = 25
SETTINGS: Final = Settings(diameter=True, probe_feed_mm_per_min=60.0)
TOUCHING: Final = Approach(stand_off_mm=0.5, overtravel_mm=0.5, margin_mm=0.4)
"""Short ways at probing speed: what the simulator left is within a tenth of a millimetre of where it should be."""

Say = Callable[[str], None]
"""Called with words on what is being done."""


def drive_part(
    trial: Trial, workshop: Workshop, *, seed: int = 0, feed_override: float = 8.0, say: Say = lambda doing: None
) -> SimulatedPart:
    """Takes one part through the loop with LinuxCNC as its controller.

    Raises CTL-DIALECT for a job in another dialect, CTL-LINUXCNC where LinuxCNC is missing, CTL-PROGRAM where it stops
    a program with an error; the error names that program's file.
    """
    inputs, machine = trial.inputs, workshop.machine
    _require_dialect(inputs)
    _require_unit(inputs)
    rng = random_of(seed, 0)
    roughed = machine.cut(Stock(), trial.rough, rng, workshop.temperatures_c[0])
    say("LinuxCNC runs the semi-finish program")
    with in_file(inputs.semifinish.file if inputs.semifinish is not None else "semi-finish program of the profile"):
        driven = cut(_semifinish_program(inputs), feed_override, _telling(say, "semi-finish"))
    near = paths_near_part(driven, inputs.profile, inputs.nose_radius_mm + inputs.allowance_mm)
    semifinished = machine.cut(roughed, near, rng, workshop.temperatures_c[0])
    say("LinuxCNC calibrates the probe on a sphere")
    calibration = _calibrate(workshop.probe)
    say("LinuxCNC probes the part")
    plan = _plan(inputs, workshop.probe)
    program = probing_program(plan, SETTINGS)
    surface = surface_mm(inputs.profile, inputs.nose_radius_mm, semifinished, inputs.allowance_mm)
    with in_file("probing program of the job"):
        log = probe(program.encode(), _probed(surface, workshop.probe), SETTINGS.log, _telling(say, "probing"))
    touches = _touches(trial, plan, log, calibration)
    say("trueloop corrects the finish program")
    correction = compensate(replace(inputs, touches=touches))
    say("LinuxCNC runs the corrected finish program")
    with in_file(f"{inputs.program.file}, corrected"):
        finishing = cut(_finish_program(inputs, correction), feed_override, _telling(say, "finish"))
    paths = paths_near_part(finishing, inputs.profile, inputs.nose_radius_mm)
    finished = finish_along(workshop, finishing_machine(workshop, correction), paths, semifinished, seed)
    return measured_part(trial, workshop, correction, touches, semifinished, finished, seed)


def paths_near_part(driven_mm: Array, profile: Profile, off_mm: float) -> tuple[CentrePath, ...]:
    """Returns the stretches of driven positions (n, 2) where the nose centre is near its path `off_mm` off the profile.

    The rest is in the air, where it would only be looked at in vain.
    """
    moved = np.concatenate([[True], np.any(np.diff(driven_mm, axis=0) != 0.0, axis=1)])
    driven = driven_mm[moved]
    near = profile.locate(driven).distance_mm < off_mm + NEAR_MM
    bounds = np.flatnonzero(np.diff(np.concatenate([[False], near, [False]]).astype(int)))
    stretches = [driven[a:b] for a, b in zip(bounds[::2], bounds[1::2], strict=True)]
    return tuple(path_of_positions(stretch) for stretch in stretches if len(stretch) > 1)


def surface_mm(profile: Profile, nose_radius_mm: float, stock: Stock, allowance_mm: float) -> Array:
    """Returns the true surface as a polyline (n, 2), chuck end first, the bar behind it, its mirror beyond the axis."""
    reachable = nose_centre_path(profile, nose_radius_mm + allowance_mm).reachable_mm
    points = []
    for feature, (low, high) in zip(profile.features, reachable, strict=True):
        s = np.linspace(low, high, max(2, round((high - low) / SURFACE_STEP_MM)))
        at, normal = feature.point_mm(s) + allowance_mm * feature.outward_normal(s), feature.outward_normal(s)
        points.append(at + stock.height_mm(at, normal)[:, None] * normal)
    surface = np.concatenate(points)
    bar, mirrored = surface[0] - [0.0, BAR_MM], surface[-1] * [-1.0, 1.0] - [BAR_MM, 0.0]
    return np.vstack([bar, surface, mirrored])


def _require_dialect(inputs: Inputs) -> None:
    name = inputs.program.dialect.name
    if name != DIALECT:
        raise Code.CTL_DIALECT.refusal(
            f"the finish program is written for {name!r}; LinuxCNC runs {DIALECT!r} only",
            hint="take a job whose programs are LinuxCNC's, as examples/loop/job.toml",
            values={"dialect": name},
        )


def _require_unit(inputs: Inputs) -> None:
    """LinuxCNC starts in mm here: a program that is meant in inches has to state them itself."""
    for program in (inputs.semifinish, inputs.program):
        if program is not None and program.unit == "inch":
            path = replace(program, unit=None).run(inputs.parameters, strict=False)
            for found in (found for found in path.findings if found.code is Code.NC_UNIT):
                raise found.code.refusal(
                    f"programs.unit is inch, LinuxCNC starts in mm, and {found.message}",
                    hint="write G20 at the program's start",
                    place=found.place,
                    values=found.values,
                )


def _semifinish_program(inputs: Inputs) -> bytes:
    """The job's own, or the profile's contour with the allowance on."""
    if inputs.semifinish is not None:
        return inputs.semifinish.source
    path = nose_centre_path(inputs.profile, inputs.nose_radius_mm + inputs.allowance_mm)
    return contour_program(path.features, FEED_MM_PER_REV, SPINDLE_RPM, CLEAR_MM)


def _finish_program(inputs: Inputs, correction: Correction) -> bytes:
    """The corrected program; the given one where the tool offsets take the correction (they are set in the machine)."""
    return inputs.program.source if correction.decision.by_offset else correction.corrected_program


def _calibrate(virtual: VirtualProbe) -> BallCalibration:
    """Touches a sphere of known size with LinuxCNC, as the part will be touched."""
    profile = _sphere()
    sphere = profile.features[1]
    margin = SPHERE_RADIUS_MM * math.radians(15.0)
    points = equally_spaced(profile, {"sphere": Spacing(SPHERE_POINTS, margin, margin)})
    plan = probe_plan(profile, points, stock_obstacle(profile), _stylus(virtual), TOUCHING)
    s = np.linspace(0.0, sphere.length_mm, round(sphere.length_mm / SURFACE_STEP_MM))
    surface = SPHERE_OFF_MM + np.vstack([[profile.features[0].start_mm], sphere.point_mm(s)])
    log = probe(probing_program(plan, SETTINGS).encode(), _probed(surface, virtual), SETTINGS.log)
    touched = parse_probe_log(log, SETTINGS.log, DIALECT)
    return calibrate(np.array([touch.position_mm for touch in touched]), SPHERE_RADIUS_MM, lobes=virtual.lobes)


def _sphere() -> Profile:
    """The calibration sphere on its stalk, three quarters round: half a turn of it sets radius and lobing apart."""
    x, z = SPHERE_CENTRE_MM
    from_rad, to_rad = (math.radians(angle) for angle in SPHERE_FROM_TO_DEG)
    start, end = (
        (x + SPHERE_RADIUS_MM * math.sin(angle), z + SPHERE_RADIUS_MM * math.cos(angle)) for angle in (from_rad, to_rad)
    )
    stalk = Line("stalk", (start[0], start[1] - SPHERE_RADIUS_MM), start)
    return checked_profile([stalk, Arc("sphere", start, end, SPHERE_CENTRE_MM, from_rad - to_rad)])


def _plan(inputs: Inputs, virtual: VirtualProbe) -> ProbePlan:
    at = inputs.touches
    points = GaugingPoints(at.feature_index, at.arc_length_mm, at.nominal_mm, at.outward_normal)
    obstacle = stock_obstacle(inputs.profile, inputs.allowance_mm)
    approach = replace(TOUCHING, allowance_mm=inputs.allowance_mm)
    return probe_plan(inputs.profile, points, obstacle, _stylus(virtual), approach, at.point)


def _stylus(virtual: VirtualProbe) -> Stylus:
    return Stylus(virtual.ball_radius_mm, virtual.ball_radius_mm / 2, stem_angle_rad=STEM_RAD)


def _probed(surface: Array, virtual: VirtualProbe) -> ProbedPart:
    return ProbedPart(
        surface,
        virtual.ball_radius_mm,
        virtual.pre_travel_mm,
        virtual.lobing_mm,
        virtual.lobes,
        virtual.lobing_phase_rad,
    )


def _touches(trial: Trial, plan: ProbePlan, log: str, calibration: BallCalibration) -> ErrorVectors:
    logged = parse_probe_log(log, SETTINGS.log, DIALECT)
    positions, lines = [touch.position_mm for touch in logged], [touch.line for touch in logged]
    matched = match_touches(plan, positions, lines, calibration)
    return error_vectors(trial.inputs.profile, matched.touches, Gauging(z_reference=trial.z_reference))


def _telling(say: Say, what: str) -> Progress:
    return lambda line, x, z: say(f"{what}: line {line}, X {x:.3f} Z {z:.3f} mm")
