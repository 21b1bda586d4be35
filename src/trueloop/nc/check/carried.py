"""Moves taken out of a path and put before others: what a program checked in parts carries over from part to part."""

from typing import Any, Final

import numpy as np

from trueloop.arrays import Integers
from trueloop.nc.program.tool_path import ToolPath

_COLUMNS: Final = (
    *("motion", "start_mm", "end_mm", "centre_mm", "sweep_rad", "programmed_radius_mm"),
    *("block", "column", "word", "state", "call"),
)


def picked(path: ToolPath, moves: Integers) -> ToolPath:
    """Returns some moves (k,) of a path with their states, copied, without dwells and findings."""
    columns: dict[str, Any] = {name: getattr(path, name)[moves] for name in _COLUMNS}
    used, columns["state"] = np.unique(columns["state"], return_inverse=True)
    states = {name: values[used] for name, values in path.states.items()}
    return ToolPath(
        **columns, states=states, calls=path.calls, unit_stated=None,
        dwell_before=np.empty(0, dtype=np.int64), dwell_s=np.empty(0),
    )  # fmt: skip


def chained(before: ToolPath | None, path: ToolPath) -> ToolPath:
    """Returns the moves of both, one after the other, without dwells and findings; neither is made in a call."""
    if before is None or not len(before):
        return path
    both: dict[str, Any] = {name: np.concatenate([getattr(before, name), getattr(path, name)]) for name in _COLUMNS}
    both["state"][len(before) :] += len(before.states["tool"])
    states = {name: np.concatenate([values, path.states[name]]) for name, values in before.states.items()}
    return ToolPath(
        **both, states=states, calls=path.calls, unit_stated=None,
        dwell_before=np.empty(0, dtype=np.int64), dwell_s=np.empty(0),
    )  # fmt: skip
