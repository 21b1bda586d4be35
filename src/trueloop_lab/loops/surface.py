"""The loop of a surface on the virtual mill: cut parts, measure, model, correct the program, cut the next part.

The simulator knows the truth; the loop under trial sees only what the measuring machine reports.
"""

from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.errors import Code
from trueloop.geometry.surface import Surface
from trueloop.loops.surface.correction import RecordedCorrection, SurfaceInputs, correct_parts
from trueloop.loops.surface.surface import maps_of
from trueloop.nc.program.along import points_along
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import Motion
from trueloop.statistics import rms
from trueloop.surface.compensation.cutter import tool_axes
from trueloop.surface.compensation.shift import SurfaceJob, places
from trueloop.surface.deviations.alignment import count_told, form_size, rigid_motions, spread_of
from trueloop.surface.deviations.points import MeasuredPoints
from trueloop.units import UM_PER_MM
from trueloop_lab.loops.turned import random_of
from trueloop_lab.simulator.mill import REACH_MM, EndMill, MilledStock, Passes, VirtualMill, passes_over, turn_rad

JUDGED: Final = (101, 97)
"""The truth is given at so many places: close enough for every ridge, and in step with no program."""
MARGIN: Final = 0.01
"""Share of the surface along each edge that is not measured."""


@dataclass(frozen=True, eq=False)
class Grid:
    """Places of a surface: every u with every v, both in [0, 1], row by row, points and outward normals (n, 3)."""

    u: Array
    v: Array
    points_mm: Array
    normal: Array


@dataclass(frozen=True, eq=False)
class SurfaceTrial:
    """A surface's job ready to be simulated: its inputs without measured parts, the passes of its program, the places
    that are measured, and those at which the correction is judged by the truth.
    """

    inputs: SurfaceInputs
    passes: Passes
    cutter: EndMill
    touched: Grid
    judged: Grid


@dataclass(frozen=True, eq=False)
class SimulatedSurface:
    """The result of the loop from measured parts, and the truth. Deviations in mm, positive = material left on,
    compared as the job says: datum-bound, or after a best fit; measured ones at n places, true ones at m others, closer
    together.

    `truth_mm` (parts, m), `measured_mm` (parts, n): the parts as programmed; `predicted_mm` (parts, n): what the loop
    says each would keep, corrected by the others. `pattern_truth_mm` (m,): what every part has alike; `pattern_mm`,
    `pattern_u95_mm` (m,): what the loop found of it, with the half-width of its 95 % interval. `corrected_truth_mm`
    (m,), `corrected_measured_mm` (n,): the next part, cut with the corrected program. `ridges_mm` (m,): what the
    program leaves without any error.
    """

    recorded: RecordedCorrection
    truth_mm: Array
    measured_mm: Array
    predicted_mm: Array
    pattern_truth_mm: Array
    pattern_mm: Array
    pattern_u95_mm: Array
    corrected_truth_mm: Array
    corrected_measured_mm: Array
    ridges_mm: Array

    @property
    def figures(self) -> dict[str, object]:
        """Returns the RMS in µm of true and measured deviations, and the shares of places inside the pattern's band."""
        off_mm = np.abs(self.pattern_mm - self.pattern_truth_mm)
        smooth_mm = np.abs(self.pattern_mm - (self.pattern_truth_mm - self.ridges_mm))
        return {
            "record_id": self.recorded.record.id,
            "parts": len(self.truth_mm),
            "places_measured": self.measured_mm.shape[1],
            "places_told": self.truth_mm.shape[1],
            "programmed_truth_um": rms(self.truth_mm) * UM_PER_MM,
            "programmed_measured_um": rms(self.measured_mm) * UM_PER_MM,
            "corrected_truth_um": rms(self.corrected_truth_mm) * UM_PER_MM,
            "corrected_measured_um": rms(self.corrected_measured_mm) * UM_PER_MM,
            "corrected_predicted_um": rms(self.predicted_mm) * UM_PER_MM,
            "pattern_truth_um": rms(self.pattern_truth_mm) * UM_PER_MM,
            "pattern_found_um": rms(self.pattern_mm) * UM_PER_MM,
            "pattern_u95_um": float(np.mean(self.pattern_u95_mm)) * UM_PER_MM,
            "pattern_inside_u95": float(np.mean(off_mm <= self.pattern_u95_mm)),
            "pattern_inside_u95_without_ridges": float(np.mean(smooth_mm <= self.pattern_u95_mm)),
            "ridges_um": rms(self.ridges_mm) * UM_PER_MM,
        }


def surface_trial(inputs: SurfaceInputs, grid: tuple[int, int]) -> SurfaceTrial:
    """Lays the places and the passes. Raises SIM-MILL for what the virtual mill cannot cut."""
    program, cutter = _program_and_cutter(inputs)
    return SurfaceTrial(
        inputs=replace(inputs, inspections=(), program_sha256=None),
        passes=_passes(inputs.surface, program, cutter),
        cutter=_end_mill(cutter),
        touched=_grid(inputs.surface, grid),
        judged=_grid(inputs.surface, JUDGED),
    )


def simulate_surface(trial: SurfaceTrial, mill: VirtualMill, parts: int = 10, seed: int = 0) -> SimulatedSurface:
    """Simulates so many parts as programmed, the correction by their measurements, and the next part. The same seed
    gives the same parts. Raises SIM-MILL where the program does not reach, and what correcting refuses.
    """
    cut = [_part(trial, mill, trial.passes, seed, k) for k in range(parts)]
    measured = tuple(_as_points(trial.touched, found, k) for k, (_, found) in enumerate(cut))
    recorded = correct_parts(replace(trial.inputs, parts=measured), datetime.now(UTC))
    model, judged = recorded.correction.model, trial.judged
    truth_mm, found_mm = _part(trial, mill, _corrected_passes(trial, recorded), seed, parts)
    ridges = MilledStock().cut_by(trial.cutter, trial.passes.centres_mm, axes=trial.passes.axes)
    return SimulatedSurface(
        recorded=recorded,
        truth_mm=np.array([truth for truth, _ in cut]),
        measured_mm=np.array([_compared_mm(trial, trial.touched, found) for _, found in cut]),
        predicted_mm=np.array([maps.predicted_mm for maps, _ in maps_of(model)]),
        pattern_truth_mm=_truth_mm(trial, mill.cut(trial.passes, trial.cutter, None)),
        pattern_mm=model.pattern.mean.grid_mm(judged.u, judged.v).ravel(),
        pattern_u95_mm=model.pattern.uncertainty_grid_mm(judged.u, judged.v).ravel(),
        corrected_truth_mm=truth_mm,
        corrected_measured_mm=_compared_mm(trial, trial.touched, found_mm),
        ridges_mm=_truth_mm(trial, ridges),
    )


def _grid(surface: Surface, counts: tuple[int, int]) -> Grid:
    (u0, u1), (v0, v1) = surface.domain
    u, v = (np.linspace(MARGIN, 1.0 - MARGIN, count) for count in counts)
    at = u0 + (u1 - u0) * np.repeat(u, len(v)), v0 + (v1 - v0) * np.tile(v, len(u))
    return Grid(u, v, surface.point_mm(*at), surface.normal(*at))


def _part(trial: SurfaceTrial, mill: VirtualMill, passes: Passes, seed: int, number: int) -> tuple[Array, Array]:
    """Returns the true deviations of one part, and its measured heights; its number sets its random errors."""
    rng, touched = random_of(seed, number), trial.touched
    stock = mill.cut(passes, trial.cutter, mill.process.variation(rng))
    return _truth_mm(trial, stock), mill.measure(stock, touched.points_mm, touched.normal, rng)


def _truth_mm(trial: SurfaceTrial, stock: MilledStock) -> Array:
    height_mm = stock.height_mm(trial.judged.points_mm, trial.judged.normal)
    uncut = np.count_nonzero(height_mm >= REACH_MM)
    if uncut:
        raise Code.SIM_MILL.refusal(
            f"{uncut} of {len(height_mm)} places are not cut by the program, or stay {REACH_MM:g} mm proud",
            hint="does the program finish this surface, with this cutter, in the surface's coordinates?",
        )
    return _compared_mm(trial, trial.judged, height_mm)


def form_alone_mm(points_mm: Array, normal: Array, u: Array, v: Array, error_mm: Array, setup_mm: float) -> Array:
    """Deviations (n,) less what a best fit of these points would take out of them, to first order."""
    centre = np.mean(points_mm, axis=0)
    motions = rigid_motions(points_mm, normal, centre, spread_of(points_mm, centre))
    shapes = motions.shapes[:, : count_told(motions, form_size(motions, u, v, error_mm), setup_mm)]
    return np.asarray(error_mm - shapes @ (shapes.T @ error_mm))


def _compared_mm(trial: SurfaceTrial, grid: Grid, height_mm: Array) -> Array:
    """Deviations as the job wants them: a best fit takes out what the set-up may have done."""
    options = trial.inputs.options
    if not options.best_fit:
        return height_mm
    u, v = np.repeat(grid.u, len(grid.v)), np.tile(grid.v, len(grid.u))
    return form_alone_mm(grid.points_mm, grid.normal, u, v, height_mm, options.setup_mm)


def _as_points(grid: Grid, height_mm: Array, number: int) -> MeasuredPoints:
    points_mm = grid.points_mm + height_mm[:, None] * grid.normal
    return MeasuredPoints(points_mm, shape=(len(grid.u), len(grid.v)), name=f"S{number + 1:02d}")


def _corrected_passes(trial: SurfaceTrial, recorded: RecordedCorrection) -> Passes:
    program, cutter = _program_and_cutter(trial.inputs)
    written = recorded.correction.program
    assert written is not None  # there is a program to correct
    corrected = program.rewritten(written.source)
    return _passes(trial.inputs.surface, corrected, cutter)


def _program_and_cutter(inputs: SurfaceInputs) -> tuple[Program, SurfaceJob]:
    if inputs.program is None or inputs.cutter is None:
        raise Code.SIM_MILL.refusal(
            "the job has 0 programs to cut with",
            hint="give it tables [program] and [cutter]; `trueloop surface path` makes a program",
        )
    if inputs.cutter.further:
        raise Code.SIM_MILL.refusal(
            f"the job states {len(inputs.cutter.by_tool)} cutters; the virtual mill has one",
            hint="simulate a program of one tool, with its [cutter]",
        )
    return inputs.program, inputs.cutter


def _end_mill(job: SurfaceJob) -> EndMill:
    x, y, z = (np.asarray(job.axis) / np.linalg.norm(job.axis)).tolist()
    return EndMill(job.cutter, (x, y, z))


def _passes(surface: Surface, program: Program, job: SurfaceJob) -> Passes:
    """Returns the cutter's end along each uninterrupted run of straight feed moves; rapid moves cut nothing here.

    The tip goes straight, as tool centre point control has it, and the words that turn the tool change evenly with it:
    places lie so close that the edge leaves its way by no more than `TURN_MM` between them.
    """
    path = program.run(job.parameters)
    arcs, cutting = np.count_nonzero(path.motion == Motion.ARC), np.flatnonzero(path.motion == Motion.LINE)
    if arcs or not len(cutting):
        raise Code.SIM_MILL.refusal(
            f"{arcs} of {len(path)} moves are arcs" if arcs else f"0 of {len(path)} moves are straight ones at feed",
            hint="the virtual mill follows straight moves at feed: write the program in lines",
        )
    turning, mill = tool_axes(program, path, job.rotary, job.axis), _end_mill(job)
    centres, axes = [], []
    for run in np.split(cutting, np.flatnonzero(np.diff(cutting) > 1) + 1):
        move, share = places(path, turning, run, np.inf, np.degrees(turn_rad(job.cutter)))
        directions = turning.directions(move, share)
        centres.append(points_along(path, move, share) + job.cutter.corner_mm * directions)
        axes.append(directions)
    return passes_over(surface, centres, mill, axes)
