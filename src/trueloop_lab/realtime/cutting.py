"""From the motions of the drives to the part: the lathe's truth, the nose's envelope, the virtual measuring machine.

Three parts are compared that differ in nothing but what is said: the same drift of the process, the same noise of the
measuring machine. Lengths in mm, X a radius, part errors positive where material is left on.

The residuals of the corrector on the virtual lathe, cause by cause: the errors of the tool's path in the cuts.

Only here is the truth asked. Components along the normal of the path, µm RMS; they add up along the path, not in RMS.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from trueloop.arrays import Array, Flags, by_content
from trueloop.geometry.offset import nose_centre_path
from trueloop.geometry.profile import Profile
from trueloop.machine.model.model import MachineModel
from trueloop.probing.probe_plan import GaugingPoints, Spacing, equally_spaced
from trueloop.realtime.judge import DrivenRun, error_mm, travel_ways
from trueloop_lab.realtime.part import NOSE_RADIUS_MM, SET_AT_MM, TOOL_OFFSET_MM, WORK_ZERO_Z_MM
from trueloop_lab.simulator.lathe import WarmLathe, WarmUp
from trueloop_lab.simulator.machine import VirtualMachine
from trueloop_lab.simulator.mill import VirtualCmm
from trueloop_lab.simulator.nose import CentrePath, Nose, path_of_positions
from trueloop_lab.simulator.process import Repeatability, Stock

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
