"""Parts in a row cut by one edge in the simulator: each corrected by the parts before it, finished and measured.

The truth is a worn nose swept along the paths, springing tool and part, cuts that do not repeat, and a finish cut that
does otherwise in a way that is drawn anew for every part: straight lines between random errors at four angles.
"""

import math
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from typing import Any

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.life import Cut, Stage
from trueloop.domain.part import Part, PartType
from trueloop.domain.tool import Edge, Setting, Tool
from trueloop.loops.turned.correction import Correction
from trueloop.loops.turned.made_parts import made_part
from trueloop.loops.turned.outcome import expected_mm
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.memory.made_part import MadePart
from trueloop.turned.touches.error_vectors import ErrorVectors
from trueloop_lab.loops.turned import Trial, finish, semifinish_and_probe, true_errors_mm
from trueloop_lab.simulator.machine import Repeatability, Stock
from trueloop_lab.simulator.nose import Transfer
from trueloop_lab.simulator.presets import NIST_TRANSFER, Workshop, nist

EDGE = Edge(Tool(1, "SVJBL"), "VCMT 110304", "1")
SET_AT = datetime(2026, 1, 5, tzinfo=UTC)
WANDERS_MM = 0.0015
"""Standard deviation, at each of four angles, of what one finish cut does otherwise than all."""


@dataclass(frozen=True)
class CutPart:
    """One part: true errors left on its dome at the places of `points` (n,), and what was promised there, mm."""

    correction: Correction
    left_mm: Array
    expected_mm: Array
    expanded_u_mm: Array
    made: MadePart
    finished: Stock


def workshop_of(part: int, moved_mm: float = 0.0, seed: int = 7) -> Workshop:
    """The turning centre of NIST's parts as it cuts part number k; `moved_mm`: its tool is off in x by so much."""
    rng = np.random.default_rng([seed, part])
    at = np.radians([0.0, 30.0, 60.0, 90.0])
    own = WANDERS_MM * rng.standard_normal(4)
    common = np.interp(at, NIST_TRANSFER.angle_rad, NIST_TRANSFER.error_mm)
    transfer = Transfer(tuple(at.tolist()), tuple((2.0 * common + own).tolist()))
    made = nist(Repeatability(along_mm=0.0012, correlation_mm=1.0, cut_to_cut_mm=0.0015), transfer)
    return replace(made, machine=replace(made.machine, tool_offset_mm=(moved_mm, 0.0)))


def cut(trial: Trial, dome: int, few: tuple[int, ...] | None, history: tuple[MadePart, ...], workshop: Workshop,
        seed: int, **more: Any) -> CutPart:  # fmt: skip
    """One part through the loop; `few` of the dome's touches by their place among them, None: all."""
    stock, touches = semifinish_and_probe(trial, workshop, seed)
    rows = touches.of_feature(dome)
    left_out = np.empty(0, np.intp) if few is None else np.delete(rows, few)
    used = touches.chosen(np.setdiff1d(np.arange(len(touches.point)), left_out))
    part = Part(PartType(trial.inputs.part.name), f"S{len(history) + 1}")
    inputs = replace(trial.inputs, touches=used, history=history, edge=EDGE, edge_set_at=SET_AT, **more)
    correction = compensate(inputs)
    finished = finish(trial, workshop, correction, stock, seed)
    truth = true_errors_mm(trial, finished)
    s = trial.inputs.touches.arc_length_mm[rows]
    found = measured_vectors(trial, finished, workshop, seed)
    made = made_part(correction, cut_of(correction, part, len(history)), found)
    u = correction.next_cut(dome, s).expanded_u_mm
    return CutPart(correction, truth[rows], expected_mm(correction, dome, s), u, made, finished)


def cut_of(correction: Correction, part: Part, order: int) -> Cut:
    """The finish cut by the correction's program."""
    return Cut(part, Stage.FINISH, Setting(EDGE, SET_AT), correction=correction.record.id, order=order)


def measured_vectors(trial: Trial, finished: Stock, workshop: Workshop, seed: int) -> ErrorVectors:
    """What the measuring machine says of a finished part, z from the reference point, known to 1 µm."""
    plan = trial.inputs.touches
    error = workshop.cmm.measure(finished, plan.nominal_mm, plan.outward_normal, np.random.default_rng([seed, 2]))
    if trial.z_reference is not None:
        k = plan.point.index(trial.z_reference)
        error = error - plan.outward_normal[:, 1] / plan.outward_normal[k, 1] * error[k]
    return replace(plan, error_mm=error, standard_u_mm=np.full(len(error), 0.001))


def rms_um(values_mm: Array) -> float:
    return 1e3 * math.sqrt(float(np.mean(values_mm**2)))
