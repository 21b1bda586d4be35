"""Many simulated parts of one job: what the loop promises, held against what it does.

Every part is cut with the same pattern of errors and its own random ones. Three ways of correcting are compared on the
same parts: the loop as it is, the loop with tangent paths (`path`), and every touch taken out for itself with straight
lines between (`raw`), which is what can be done without a model.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.geometry.profile import JunctionKind, Profile
from trueloop.loops.batch import run_batch
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.statistics import rms
from trueloop.turned.compensation.contour import centre_pieces, shifted_contour
from trueloop.turned.compensation.shift import ZERO, Shift, sampled
from trueloop.turned.fit.chain_fit import TangentPolicy
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop_lab.loops.turned import Trial, finish, finish_along, semifinish_and_probe, true_errors_mm
from trueloop_lab.simulator.nose import CentrePath, path_of_positions
from trueloop_lab.simulator.presets import Workshop

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
