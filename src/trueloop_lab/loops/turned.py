"""The process-intermittent loop on the virtual machine: semi-finish, probe, compensate, finish, measure.

The simulator knows the truth; the loop under trial sees only what the control reports. Truth and estimate stand side by
side in the result.

Many simulated parts of one job: what the loop promises, held against what it does.

Every part is cut with the same pattern of errors and its own random ones. Three ways of correcting are compared on the
same parts: the loop as it is, the loop with tangent paths (`path`), and every touch taken out for itself with straight
lines between (`raw`), which is what can be done without a model.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import TrueloopError
from trueloop.geometry.feature import contact_angle_rad
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.loops.batch import run_batch
from trueloop.loops.turned.commanded import Run
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import NO_COMPENSATION
from trueloop.probing.calibration import BallCalibration, Stylus, calibrate, stock_obstacle
from trueloop.probing.probe_match import match_touches
from trueloop.probing.probe_plan import Approach, GaugingPoints, ProbePlan, probing_moves, require_ball_fits
from trueloop.statistics import rms
from trueloop.turned.compensation.displaced import centre_pieces, shifted_contour
from trueloop.turned.compensation.shift import ZERO, Shift, sampled
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop.turned.touches.touches import Gauging, error_vectors
from trueloop_lab.simulator.machine import Stock, VirtualMachine, VirtualProbe
from trueloop_lab.simulator.nose import CentrePath, path_along, path_of_positions, paths_of_program
from trueloop_lab.simulator.presets import Workshop

SPHERE_RADIUS_MM: Final = 12.5
SPHERE_CENTRE_MM: Final = (120.0, 0.0)
CALIBRATION_MARGIN_RAD: Final = math.radians(45.0)
LEAST_CALIBRATED_RAD: Final = math.pi
"""A shop touches the sphere well beyond the part's directions: over a quarter of it alone, its centre, the ball and the
lobing can hardly be separated."""
DIRECTIONS: Final = 33
REPEATS: Final = 5


@dataclass(frozen=True)
class SimulatedPart:
    """One part that went through the loop; arrays of shape (n,), part errors in mm, positive = material left on.

    `semifinish_truth_mm` and `finish_truth_mm` are the true errors at the gauging points, the first over the
    semi-finish contour; `touches` what the loop saw; `cmm_mm` what the measuring machine says of the finished part.
    """

    correction: Correction
    touches: ErrorVectors
    semifinish_truth_mm: Array
    finish_truth_mm: Array
    cmm_mm: Array
    finished: Stock

    @property
    def predicted_mm(self) -> Array:
        """Returns the loop's prediction of the errors after the finish cut."""
        return self.correction.prediction.after_mm

    @property
    def residual_rms_mm(self) -> float:
        """Returns the RMS of the true residual."""
        return rms(self.finish_truth_mm)

    @property
    def residual_worst_mm(self) -> float:
        """Returns the size of the largest true residual."""
        return float(np.max(np.abs(self.finish_truth_mm)))

    @property
    def coverage(self) -> float:
        """Returns the share of true residuals inside the predicted 95 % band."""
        return float(np.mean(np.abs(self.finish_truth_mm) <= self.correction.prediction.expanded_u_mm))


@dataclass(frozen=True)
class Trial:
    """A job ready to be simulated: the inputs of the loop, except the touches, which are made anew.

    `inputs.touches` says where to touch. `rough`, `semifinish` and `finish` are the commanded paths
    of the nose centre.
    """

    inputs: Inputs
    z_reference: str | None
    rough: tuple[CentrePath, ...]
    semifinish: tuple[CentrePath, ...]
    finish: tuple[CentrePath, ...]


def require_plan_fits(trial: Trial, probe: VirtualProbe) -> None:
    """Raises PRB-BALL for a touch at which the semi-finished part leaves the ball no room."""
    plan = _plan(trial, probe)
    obstacle = stock_obstacle(trial.inputs.profile, trial.inputs.allowance_mm)
    for touch in plan.touches:
        require_ball_fits(touch, obstacle, plan.stylus)


def trial_of(inputs: Inputs, z_reference: str | None = None) -> Trial:
    """Runs the job's programs once: every part of a study is cut along the same commanded paths.

    The rough cut leaves one more allowance than the semi-finish cut. Without a semi-finish program
    the semi-finish path is that of the profile itself, the allowance off.
    """
    profile, nose_mm, allowance_mm = inputs.profile, inputs.nose_radius_mm, inputs.allowance_mm
    rough = path_along(nose_centre_path(profile, nose_mm + 2 * allowance_mm).features, side=profile.side)
    semifinish = (
        _paths(inputs, inputs.semifinish)
        if inputs.semifinish is not None
        else (path_along(nose_centre_path(profile, nose_mm + allowance_mm).features, side=profile.side),)
    )
    return Trial(inputs, z_reference, (rough,), semifinish, _paths(inputs, inputs.program))


def simulate(trial: Trial, workshop: Workshop, seed: int = 0) -> SimulatedPart:
    """Simulates one part through the whole loop. The same seed gives the same part, however it is corrected."""
    semifinished, touches = semifinish_and_probe(trial, workshop, seed)
    correction = compensate(replace(trial.inputs, touches=touches))
    finished = finish(trial, workshop, correction, semifinished, seed)
    return measured_part(trial, workshop, correction, touches, semifinished, finished, seed)


def semifinish_and_probe(trial: Trial, workshop: Workshop, seed: int) -> tuple[Stock, ErrorVectors]:
    """Returns the semi-finished part and its touches as the loop receives them."""
    rng, machine = random_of(seed, 0), workshop.machine
    semifinish_c, probing_c, _ = workshop.temperatures_c
    roughed = machine.cut(Stock(), trial.rough, rng, semifinish_c)
    semifinished = machine.cut(roughed, trial.semifinish, rng, semifinish_c)
    return semifinished, probe_part(trial, workshop, semifinished, rng, probing_c)


def finish(trial: Trial, workshop: Workshop, correction: Correction, semifinished: Stock, seed: int) -> Stock:
    """Cuts the part with the corrected program, or with the given one and tool offsets where these are enough."""
    machine = finishing_machine(workshop, correction)
    return finish_along(workshop, machine, corrected_paths(trial, correction), semifinished, seed)


def finishing_machine(workshop: Workshop, correction: Correction) -> VirtualMachine:
    """Returns the machine with the tool offsets of the correction, where these take the place of a changed contour."""
    machine = workshop.machine
    if not correction.decision.by_offset:
        return machine
    return _offset(machine, correction.decision.offset_mm)


def finish_along(
    workshop: Workshop, machine: VirtualMachine, paths: Sequence[CentrePath], semifinished: Stock, seed: int
) -> Stock:
    """Simulates the finish cut along any paths, with its difference from the cut before; its random errors depend on
    the seed alone.
    """
    return machine.cut(semifinished, paths, random_of(seed, 1), workshop.temperatures_c[2], machine.transfer)


def probe_part(
    trial: Trial, workshop: Workshop, stock: Stock, rng: np.random.Generator, temperature_c: float
) -> ErrorVectors:
    """Returns the touches of a semi-finished part, by a probe that was calibrated just before.

    The control's log is matched with the plan as one of a real control. Raises PRB-MISSED for a point where no part is.
    """
    asked, probe, profile = trial.inputs.touches, workshop.probe, trial.inputs.profile
    calibration = calibrated(workshop, rng, asked.outward_normal)
    plan = _plan(trial, probe)
    at = asked.nominal_mm + plan.approach.allowance_mm * asked.outward_normal
    reported = probe.touch(stock, at, asked.outward_normal, rng, workshop.machine.error, temperature_c)
    ends = np.array([touch.target_mm for touch in plan.touches])
    beyond = np.einsum("ij,ij->i", reported - ends, asked.outward_normal) < 0.0
    logged = np.where(beyond[:, None], ends, reported)
    try:
        matched = match_touches(plan, [(x, z) for x, z in logged.tolist()], range(len(logged)), calibration)
    except TrueloopError as refused:  # there is no file whose line could be named
        raise refused.code.refusal(refused.message, hint=refused.hint, values=refused.values) from refused
    gauging = Gauging(range_x_mm=probe.range_x_mm, range_z_mm=probe.range_z_mm, z_reference=trial.z_reference)
    return error_vectors(profile, [replace(touch, line=None) for touch in matched.touches], gauging)


def _plan(trial: Trial, probe: VirtualProbe) -> ProbePlan:
    """Returns the probing moves; a virtual stylus is its ball, so there are no ways to be kept clear."""
    asked, stylus = trial.inputs.touches, Stylus(probe.ball_radius_mm, 0.0)
    approach = Approach(allowance_mm=trial.inputs.allowance_mm)
    points = GaugingPoints(asked.feature_index, asked.arc_length_mm, asked.nominal_mm, asked.outward_normal)
    moves = probing_moves(trial.inputs.profile, points, stylus, approach, asked.point)
    return ProbePlan(moves, moves[0].start_mm, (), stylus, approach)


def calibrated(workshop: Workshop, rng: np.random.Generator, outward_normal: Array) -> BallCalibration:
    """Returns the probe after touching a calibration sphere, every direction five times.

    Those that the machine file states, or those of the part and a margin beyond.
    """
    contact = contact_angle_rad(outward_normal)
    low, high = workshop.probe.calibrated_rad or _directions_of(contact)
    angles = np.repeat(np.linspace(low, high, DIRECTIONS), REPEATS)
    centres = workshop.probe.touch_sphere(SPHERE_CENTRE_MM, SPHERE_RADIUS_MM, angles, rng)
    return calibrate(centres, SPHERE_RADIUS_MM, lobes=workshop.probe.lobes)


def _directions_of(part_rad: Array) -> tuple[float, float]:
    """Returns the range of directions in which a shop calibrates for a part that is touched at these contact angles."""
    low, high = float(part_rad.min()) - CALIBRATION_MARGIN_RAD, float(part_rad.max()) + CALIBRATION_MARGIN_RAD
    wider = max(LEAST_CALIBRATED_RAD - (high - low), 0.0) / 2
    return low - wider, high + wider


def corrected_paths(trial: Trial, correction: Correction) -> tuple[CentrePath, ...]:
    """Returns the commanded paths of the finishing program: the corrected one, or the given one with an offset."""
    if correction.decision.by_offset:
        return trial.finish
    written = trial.inputs.program.rewritten(correction.corrected_program)
    return _paths(trial.inputs, written)


def measured_part(
    trial: Trial,
    workshop: Workshop,
    correction: Correction,
    touches: ErrorVectors,
    semifinished: Stock,
    finished: Stock,
    seed: int,
) -> SimulatedPart:
    """Returns truth and measurement of a part that has been finished."""
    plan = trial.inputs.touches
    before = true_errors_mm(trial, semifinished, trial.inputs.allowance_mm)
    after = true_errors_mm(trial, finished)
    cmm = workshop.cmm.measure(finished, plan.nominal_mm, plan.outward_normal, random_of(seed, 2))
    return SimulatedPart(correction, touches, before, after, _from_reference(trial, cmm), finished)


def true_errors_mm(trial: Trial, stock: Stock, allowance_mm: float = 0.0) -> Array:
    """Returns the true part errors at the gauging points, (n,), over the intended allowance."""
    plan = trial.inputs.touches
    at = plan.nominal_mm + allowance_mm * plan.outward_normal
    return _from_reference(trial, stock.height_mm(at, plan.outward_normal))


def _from_reference(trial: Trial, error_mm: Array) -> Array:
    """Errors with the part's z taken from the reference point, where the job has one."""
    if trial.z_reference is None:
        return error_mm
    k = trial.inputs.touches.point.index(trial.z_reference)
    facing = trial.inputs.touches.outward_normal[:, 1]
    relative: Array = error_mm - facing / facing[k] * error_mm[k]
    return relative


def random_of(seed: int, stage: int) -> np.random.Generator:
    """Returns the random numbers of one stage of a part: 0 up to probing, 1 the finish cut, 2 the measuring machine."""
    return np.random.default_rng([seed, stage])


def _offset(machine: VirtualMachine, offset_mm: tuple[float, float]) -> VirtualMachine:
    x, z = machine.tool_offset_mm
    return replace(machine, tool_offset_mm=(x + offset_mm[0], z + offset_mm[1]))


def _paths(inputs: Inputs, program: Program) -> tuple[CentrePath, ...]:
    """Returns the paths of the nose's centre, as the control drives it where it keeps the nose off by G41 or G42."""
    run, side = Run(inputs.parameters, inputs.execute_deleted_blocks), inputs.profile.side
    path = run.of(program)
    if np.all(path.compensation == NO_COMPENSATION):
        return paths_of_program(path, side)
    return paths_of_program(run.driven(program, inputs.nose_radius_mm), side, driven=True)


STEP_MM: Final = 0.02


@dataclass(frozen=True)
class StudyPart:
    """True residuals of one part at its gauging points, (n,), mm, by way of correcting, and what was promised.

    `expanded_u_mm` (n,) is the half width of the predicted 95 % band of the loop's own residual about zero,
    `alike_u_mm` the same without what is assumed to differ between the cuts. `path_mm` is empty where no part was cut
    along tangent paths.
    """

    loop_mm: Array
    path_mm: Array
    raw_mm: Array
    uncorrected_mm: Array
    expanded_u_mm: Array
    alike_u_mm: Array


@dataclass(frozen=True)
class Study:
    """All parts of a study."""

    parts: tuple[StudyPart, ...]

    def rms_mm(self, way: str) -> float:
        """Returns the RMS over all parts and points: `loop_mm`, `path_mm`, `raw_mm` or `uncorrected_mm`."""
        return rms(np.concatenate([getattr(part, way) for part in self.parts]))

    @property
    def coverage(self) -> float:
        """Returns the share of true residuals inside the predicted 95 % band."""
        return float(np.mean(self.inside("expanded_u_mm")))

    def inside(self, band: str) -> Array:
        """Returns the share of each part's true residuals inside `expanded_u_mm` or `alike_u_mm`."""
        return np.array([np.mean(np.abs(part.loop_mm) <= getattr(part, band)) for part in self.parts])


def study(
    trial: Trial,
    workshop: Workshop,
    parts: int,
    *,
    first_seed: int = 0,
    workers: int = 2,
    tangent_paths: bool = True,
    progress: Callable[[int], None] = lambda done: None,
) -> Study:
    """Simulates `parts` parts on several processes; `progress` is called with how many are done. Seeds count up.

    Parts cut along `tangent_paths` as well take nearly twice the time.
    """
    seeds = range(first_seed, first_seed + parts)
    made: list[StudyPart] = []
    for part in run_batch(partial(study_part, trial, workshop, tangent_paths=tangent_paths), seeds, workers=workers):
        made.append(part)
        progress(len(made))
    return Study(tuple(made))


def study_part(trial: Trial, workshop: Workshop, seed: int, *, tangent_paths: bool = True) -> StudyPart:
    """Simulates one part, corrected in every way; along tangent paths only if these are wanted."""
    semifinished, touches = semifinish_and_probe(trial, workshop, seed)
    inputs = replace(trial.inputs, touches=touches)
    loop = compensate(inputs, sources=False)
    raw = path_of_shifts(inputs.profile, inputs.nose_radius_mm, raw_shifts(inputs.profile, touches))

    def finished(paths: Sequence[CentrePath]) -> Array:
        return true_errors_mm(trial, finish_along(workshop, workshop.machine, paths, semifinished, seed))

    def corrected(correction: Correction) -> Array:
        return true_errors_mm(trial, finish(trial, workshop, correction, semifinished, seed))

    tangent = replace(inputs, options=replace(inputs.options, junctions=TangentPolicy.PATH))
    return StudyPart(
        loop_mm=corrected(loop),
        path_mm=corrected(compensate(tangent, sources=False)) if tangent_paths else np.empty(0),
        raw_mm=finished([raw]),
        uncorrected_mm=finished(trial.finish),
        expanded_u_mm=loop.prediction.expanded_u_mm,
        alike_u_mm=loop.prediction.budget.alike.expanded_u_mm,
    )


def raw_shifts(profile: Profile, touches: ErrorVectors) -> tuple[Shift, ...]:
    """Returns the shift of every touch by itself, straight lines between; nothing where a feature was not touched."""
    shifts = []
    for index in range(len(profile.features)):
        mine = touches.of_feature(index)
        shifts.append(sampled(touches.arc_length_mm[mine], -touches.error_mm[mine]) if len(mine) else ZERO)
    return tuple(shifts)


def path_of_shifts(profile: Profile, nose_radius_mm: float, shifts: Sequence[Shift]) -> CentrePath:
    """Returns the path of the nose centre along a shifted contour, as positions 0.02 mm apart."""
    positions = []
    tangent = [False, *(junction.kind is JunctionKind.TANGENT for junction in profile.junctions), False]
    for k, piece in enumerate(centre_pieces(profile, shifted_contour(profile, shifts, nose_radius_mm))):
        # Where shifts of tangent neighbours differ, the path steps over at the junction.
        start_mm = 0.0 if tangent[k] else piece.start_mm
        end_mm = piece.shifted.feature.length_mm if tangent[k + 1] else piece.end_mm
        count = max(2, round((end_mm - start_mm) / STEP_MM))
        positions.append(piece.shifted.centre_mm(np.linspace(start_mm, end_mm, count)))
    return path_of_positions(np.concatenate(positions), profile.side)
