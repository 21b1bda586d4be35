"""The edge that a job's finish cut is made with, out of the store where the job states the tool's number alone."""

from dataclasses import replace
from datetime import datetime

from trueloop.domain.tool import Edge, Tool
from trueloop.jobs.tools.edge import edge_of, require_touches_since
from trueloop.loops.turned.correction import Inputs
from trueloop.storage.store import Store


def with_edge(store: Store, inputs: Inputs) -> Inputs:
    """The job with its edge and setting as the store knows them; as it is where neither says which edge cuts.

    The finish cut of touches after a semi-finish cut is still to be made: the edge is the one that is mounted as the
    correction is made. That of a finished part was made before its touches. Raises EDG errors, EDG-SETTING for touches
    of a semi-finished part that are older than the setting.
    """
    stated, number = inputs.edge, inputs.options.tool
    measured = [one.measured_at for one in inputs.inspections if one.measured_at is not None]
    finished = inputs.measured_finished
    at: datetime = min(measured) if finished and measured else inputs.made_at
    corner = None if inputs.called is None else inputs.called.corner
    setting = edge_of(
        store, stated, number, at, set_at=inputs.edge_set_at, machine=inputs.machine_tool, groove_corner=corner
    )
    if setting is None:
        return inputs
    if not finished and inputs.edge_set_at is None:
        require_touches_since(setting, min(measured, default=None))
    return replace(inputs, edge=_as_mounted(setting.edge, stated), edge_set_at=setting.set_at)


def _as_mounted(edge: Edge, stated: Edge | None) -> Edge:
    """The mounted edge; of the tool nothing that the job does not state itself, as the record has the job's radius."""
    number = edge.tool.number if stated is None or stated.tool.number is None else stated.tool.number
    return replace(edge, tool=Tool(number, edge.tool.name))
