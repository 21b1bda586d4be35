"""The residuals of the corrector on the virtual lathe, cause by cause: the errors of the tool's path in the cuts.

Only here is the truth asked. Components along the normal of the path, µm RMS; they add up along the path, not in RMS.
"""

from collections.abc import Mapping, Sequence

import numpy as np

from trueloop.arrays import Array, Flags
from trueloop.loops.realtime.demo.part import TOOL_OFFSET_MM
from trueloop.machine.model.model import MachineModel
from trueloop.realtime.judge import DrivenRun, error_mm, travel_ways
from trueloop.simulator.lathe import WarmLathe, WarmUp


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
