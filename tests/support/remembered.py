"""A real correction with earlier parts of its edge: MODBAS2 with three touches of its dome, after three parts."""

from dataclasses import replace
from functools import cache

import numpy as np

from tests.support.correction import example_inputs
from trueloop.domain.tool import Edge, Setting, Tool
from trueloop.geometry.feature import contact_angle_rad
from trueloop.loops.turned.correction import Correction, Inputs
from trueloop.loops.turned.deviations import cut_errors
from trueloop.loops.turned.made_parts import name_of
from trueloop.loops.turned.process_intermittent import compensate
from trueloop.memory.made_part import MadePart

FEW = (2, 9, 16)


def remembering_inputs(moved_mm: float = 0.0) -> Inputs:
    """Three earlier parts as the example's dome, each with its own setting and scatter; today's deviates by so much
    in x.
    """
    inputs = example_inputs("modbas2")
    touches, dome = inputs.touches, inputs.profile.names.index("dome")
    rows = touches.of_feature(dome)
    angle = contact_angle_rad(touches.outward_normal[rows])
    rng = np.random.default_rng(3)
    edge = Edge(Tool(1, "SVJBL"), "VCMT <110304>", "1")
    setting = " ".join(Setting(edge).identity)
    history = []
    for k in range(3):
        error = touches.error_mm[rows] + 0.004 * rng.standard_normal() * np.sin(angle)
        places = replace(
            cut_errors(inputs.profile, touches.chosen(np.union1d(rows, np.flatnonzero(touches.at_reference)))),
            standard_u_mm=np.full(len(rows), 0.0008),
        )
        touched = replace(places, error_mm=error + 0.0010 * rng.standard_normal(len(rows)))
        left = -0.003 + 0.0015 * rng.standard_normal(len(rows))
        found = replace(places, error_mm=left)
        made = MadePart(name_of(inputs.part), f"S{k}", setting, float(k), touched, found, error)
        history.append(replace(made, edge=" ".join(edge.identity)))
    few = touches.chosen(np.setdiff1d(np.arange(len(touches.point)), np.delete(rows, FEW)))
    few = replace(few, error_mm=few.error_mm + moved_mm * few.outward_normal[:, 0])
    return replace(inputs, touches=few, history=tuple(history), edge=edge)


@cache
def remembered_correction() -> Correction:
    """By those parts and three touches."""
    return compensate(remembering_inputs())
