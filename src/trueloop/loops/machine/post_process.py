"""The post-process loop's first step: one part's inspections taken apart into machine, process and what was left."""

from collections.abc import Collection

import numpy as np

from trueloop.arrays import Array
from trueloop.diagnosis.components import (
    Components,
    FrameDiscrepancy,
    Inspections,
    error_components,
    fit_frame_discrepancy,
    without_discrepancy,
)
from trueloop.machine.model.chain import Vector
from trueloop.machine.model.model import MachineModel, State
from trueloop.machine.model.term import Signals
from trueloop.machine.model.validity import check_state


def states_of(model: MachineModel, seen: Inspections, zero: Vector, tool: Array | Vector, signals: Signals) -> State:
    """Axis positions that bring the tool point to each gauging point: part + zero − tool, one tool or (n, 3)."""
    axes = seen.nominal_mm + np.array(zero) - np.array(tool)
    chain = model.machine.chain
    given = {name: axes[:, k] for k, name in enumerate("XYZ") if name in chain.order}
    return State(chain.positions(given), 0.0, signals, tool)


def decompose_part(
    model: MachineModel,
    seen: Inspections,
    cutting: State,
    probing: State,
    *,
    compensated: bool,
    new_frame: bool,
    extrapolate: Collection[str] = (),
) -> tuple[Components, FrameDiscrepancy | None]:
    """Components at each gauging point; with `new_frame` after the part coordinate system discrepancy is taken out.

    Raises MCH-TRAVEL and MCH-RANGE for states at which the model is not known to hold; `extrapolate` names what may
    leave the range of the data.
    """
    check_state(model, cutting, extrapolate)
    check_state(model, probing, extrapolate)
    found = error_components(model, seen, cutting, probing, compensated=compensated)
    if not new_frame:
        return found, None
    frame = fit_frame_discrepancy(seen, found.error_proc_resid)
    mended = without_discrepancy(seen, frame)
    return error_components(model, mended, cutting, probing, compensated=compensated), frame
