"""The tool offset as numbers to enter at the control, whatever else is written [4773 §2.1, Fig. 9].

A tool stands at machine = program + work offset + tool offset: by what is added to its offset, the tool moves.
"""

import math
from dataclasses import replace

from trueloop.domain.proposal import ExpandedU
from trueloop.nc.edit.edit import rounded_mm
from trueloop.nc.program.program import Program
from trueloop.nc.program.tool_path import ToolPath
from trueloop.turned.program.offsets import offset_state, tool_offset_updates
from trueloop.turned.program.wear_numbers import WearOffset
from trueloop.turned.program.wear_words import blocks_of, updates


def wear_offset(
    program: Program,
    path: ToolPath,
    cut: int,
    offset_mm: tuple[float, float],
    tool: int,
    is_diameter: bool | None,
    edge: int = 1,
    *,
    expanded_u_mm: ExpandedU | None = None,
) -> WearOffset:
    """Returns the tool's offset changed by (x as a radius, z) mm, in the words of the program's control.

    `cut` is a move of the finish pass: the unit is that of its words. `is_diameter` says how the control reads offsets
    on X; None: as the words on X, on Sinumerik as a radius. LinuxCNC always reads them as words. `edge` is the tool's.
    `tool` 0: its number is not known; there are no words for that offset then. `expanded_u_mm`: of both offsets, as
    they are given.
    """
    dialect, words = program.dialect, path.coordinate_state(cut)
    if dialect.offset_x == "words":
        is_diameter = None
    elif is_diameter is None and dialect.offset_x == "radius":
        is_diameter = False
    state = offset_state(words, is_diameter)
    decimals = max(0, round(-math.log10(dialect.step(state.inch))))
    mm = {axis: rounded_mm(dialect, axis, value, state) for axis, value in zip("XZ", offset_mm, strict=True)}
    x, z = (round(mm[axis] / state.unit_mm(axis), decimals) for axis in "XZ")
    u = None
    if expanded_u_mm is not None:
        x_u, z_u = (None if v is None else v / state.unit_mm(a) for a, v in zip("XZ", expanded_u_mm, strict=True))
        u = (x_u, z_u)
    wear = WearOffset(tool, x, z, state.diameter, "inch" if state.inch else "mm", decimals, edge, expanded_u=u)
    if not tool:
        return wear
    if dialect.wear_words == "ge2000t":
        own_mm = tool_offset_updates(program, state, (0.0, 0.0), tool)
        own = {axis: value_mm / state.unit_mm(axis) for axis, value_mm in own_mm.items()}
        return replace(wear, blocks=updates(wear, own))
    return replace(wear, blocks=blocks_of(dialect.wear_words, wear))
