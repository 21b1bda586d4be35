"""A run of the real-time corrector judged by the machine model itself, in splines: nothing of the corrector is used.

What must hold in every period: drive + E(drive) = command + table(command). From the commands alone it follows which
way each axis travels, what correction is due, and where the limit of its slew keeps it from being there at once; those
periods are counted, and judged against what the slew allows. Lengths in mm, X of a lathe a radius.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array, Flags, by_content
from trueloop.machine.model.chain import ZERO, Vector
from trueloop.machine.model.model import MachineModel, State
from trueloop.realtime.image import Block

STEPS: Final = 6
"""Iterations of c = −E(q + c): each leaves a thousandth or less of what the one before left."""

STANDS_MM: Final = 1e-9
"""An axis that moves less than this stands: the rounding of positions."""

NM_PER_MM, UM_PER_MM = 1e6, 1e3


@by_content
@dataclass(frozen=True)
class DrivenRun:
    """Periods of a run in order, one after the other: `command_mm` and `drive_mm` (n, 3) of X, Y, Z without homing
    offsets, signals in use (n,) by name, program line (n,), and whether the correction was in force (n,).

    `tool_mm` (3,) or (n, 3) leads to the tool point from the frame of the last axis.
    """

    period_s: float
    command_mm: Array
    drive_mm: Array
    signals: Mapping[str, Array | float]
    line: NDArray[np.intp]
    in_force: Flags
    tool_mm: Array | Vector = ZERO


@by_content
@dataclass(frozen=True)
class Due:
    """The correction that model and table require, each array (n, 3) but `limited` (n,).

    `way`: +1, −1, 0 not known; `correction_mm` without the limit of the slew, `allowed_mm` with it; `limited` where the
    two differ; `table_mm` is its part from the table.
    """

    way: Array
    correction_mm: Array
    allowed_mm: Array
    table_mm: Array
    limited: Flags


@by_content
@dataclass(frozen=True)
class RunJudgement:
    """The errors that a run left. `residual_mm` (n, 3): where the tool is by the model, less where it was meant to be.

    `judged` marks periods in force and not limited; `limited` those that the slew keeps behind, judged by `behind_nm`:
    the largest difference from what the slew allows. `step_um` is the largest change of the correction in a period.
    """

    residual_mm: Array
    judged: Flags
    limited: Flags
    rms_nm: float
    worst_nm: float
    uncorrected_um: float
    reversals: int
    longest_limited_s: float
    behind_nm: float
    step_um: float
    most_step_um: float

    def within(self, rms_nm: float) -> bool:
        """Returns whether the run was judged at all, left `rms_nm` at most, and stayed within its slew."""
        stays = self.step_um <= self.most_step_um + 2e-3
        return bool(self.judged.any() and self.rms_nm <= rms_nm and stays)


def travel_ways(command_mm: Array) -> Array:
    """Returns which way each axis last moved by more than rounding, (n, 3): +1, −1, and 0 before its first move."""
    return np.stack([_ways(command.tolist()) for command in command_mm.T], axis=-1)


def due(run: DrivenRun, model: MachineModel | None, blocks: Sequence[Block], gate_mm: float, slew: float) -> Due:
    """Returns the correction due in each period; `slew` in mm/s for each axis."""
    way, table = travel_ways(run.command_mm), table_mm(run, blocks, gate_mm)
    correction = np.zeros_like(run.command_mm)
    if model is not None:
        for _ in range(STEPS):
            correction = -error_mm(model, run, run.command_mm + correction, way) + table
    else:
        correction = table
    allowed = _slewed(correction, run, slew * run.period_s)
    return Due(way, correction, allowed, table, np.any(allowed != correction, axis=1))


def error_mm(model: MachineModel, run: DrivenRun, at_mm: Array, way: Array) -> Array:
    """Returns E at positions (n, 3) under the run's signals and tool, (n, 3)."""
    chain = model.machine.chain
    columns = ["XYZ".index(name) for name in chain.order if name in "XYZ"]
    positions = chain.positions({"XYZ"[k]: at_mm[:, k] for k in columns})
    ways = np.zeros(positions.shape)
    for k in columns:
        ways[:, chain.order.index("XYZ"[k])] = way[:, k]
    return model.error_mm(State(positions, ways, run.signals, run.tool_mm))


def table_mm(run: DrivenRun, blocks: Sequence[Block], gate_mm: float) -> Array:
    """Returns what the table adds at the commands, (n, 3): of that line's block, at the nearest place of its path."""
    found = np.zeros_like(run.command_mm)
    for block in blocks:
        here = np.flatnonzero(run.line == block.line)
        if len(here):
            found[here, ::2] = _nearest(block.rows, run.command_mm[here, ::2], gate_mm)
    return found


def judge(
    run: DrivenRun,
    model: MachineModel | None,
    blocks: Sequence[Block] = (),
    *,
    slew_mm_per_s: float = 5.0,
    gate_mm: float = 0.1,
) -> RunJudgement:
    """Judges the run against model and table; `slew_mm_per_s` is what the component was given for every axis."""
    asked = due(run, model, blocks, gate_mm, slew_mm_per_s)
    error = error_mm(model, run, run.drive_mm, asked.way) if model is not None else np.zeros_like(run.drive_mm)
    meant = run.command_mm + asked.table_mm
    residual = run.drive_mm + error - meant
    judged, limited = run.in_force & ~asked.limited, run.in_force & asked.limited
    off = np.linalg.norm(residual[judged], axis=1) * NM_PER_MM
    bare = error_mm(model, run, run.command_mm, asked.way) if model is not None else 0.0 * error
    correction = run.drive_mm - run.command_mm
    behind = np.abs(correction - asked.allowed_mm)[limited] * NM_PER_MM
    turns = (asked.way[1:] != asked.way[:-1]) & (asked.way[:-1] != 0.0) & run.in_force[1:, None]
    return RunJudgement(
        residual_mm=residual,
        judged=judged,
        limited=limited,
        rms_nm=float(np.sqrt(np.mean(off**2))) if len(off) else float("nan"),
        worst_nm=float(off.max(initial=0.0)),
        uncorrected_um=float(np.sqrt(np.mean(np.sum((bare - asked.table_mm)[run.in_force] ** 2, axis=1)))) * UM_PER_MM,
        reversals=int(turns.sum()),
        longest_limited_s=_longest(limited) * run.period_s,
        behind_nm=float(behind.max(initial=0.0)),
        step_um=float(np.abs(np.diff(correction, axis=0)).max(initial=0.0)) * UM_PER_MM,
        most_step_um=slew_mm_per_s * run.period_s * UM_PER_MM,
    )


def _ways(command: list[float]) -> Array:
    found, way, seen = np.zeros(len(command)), 0.0, command[0]
    for k, position in enumerate(command):
        if abs(position - seen) > STANDS_MM:
            way, seen = (1.0 if position > seen else -1.0), position
        found[k] = way
    return found


def _nearest(rows: Array, at_mm: Array, gate_mm: float) -> Array:
    """Returns (dx, dz) at the nearest places of a polyline of rows x, z, dx, dz; 0 beyond the gate."""
    best, found = np.full(len(at_mm), gate_mm**2), np.zeros((len(at_mm), 2))
    for a, b in pairwise(rows):
        along = b[:2] - a[:2]
        share = np.clip((at_mm - a[:2]) @ along / max(float(along @ along), 1e-300), 0.0, 1.0)
        off = np.sum((at_mm - a[:2] - share[:, None] * along) ** 2, axis=1)
        nearer = off < best
        best[nearer] = off[nearer]
        found[nearer] = a[2:] + share[nearer, None] * (b[2:] - a[2:])
    return found


def _slewed(wanted: Array, run: DrivenRun, step_mm: float) -> Array:
    """Follows the wanted values by `step_mm` a period at most, from the correction in force at the beginning."""
    allowed, at = np.empty_like(wanted), run.drive_mm[0] - run.command_mm[0]
    for k, towards in enumerate(wanted):
        if not run.in_force[k]:
            at = run.drive_mm[k] - run.command_mm[k]
        else:
            change = towards - at
            at = np.where(np.abs(change) <= step_mm, towards, at + np.clip(change, -step_mm, step_mm))
        allowed[k] = at
    return allowed


def _longest(flags: Flags) -> int:
    ends = np.flatnonzero(np.diff(np.concatenate([[False], flags, [False]]).astype(int)))
    return int(max((b - a for a, b in zip(ends[::2], ends[1::2], strict=True)), default=0))
