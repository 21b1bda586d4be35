"""Figures of a machine's diagnosis: residuals over position and temperature; refinement before and after."""

from collections import defaultdict
from typing import Final

import numpy as np
from numpy.typing import NDArray

from trueloop.arrays import Array
from trueloop.report import style
from trueloop.report.diagnosis.machine_shapes import LeftOutShape, MachineDiagnosisShape, RefinementShape
from trueloop.report.style import Figure
from trueloop.report.texts.texts import ENGLISH, Texts

WIDTH: Final = 480
HEIGHT: Final = 300
POINTS: Final = 800
"""Marks of one figure: more would not be seen."""
BINS: Final = 9
SPEAKS: Final = 200


def residual_figures(found: MachineDiagnosisShape, say: Texts = ENGLISH) -> dict[str, Figure]:
    """Draws residuals over each axis, less the mean of their part and by colder and warmer halves; over each
    temperature unchanged. By name; what does not vary has none.
    """
    if not found.residuals:
        return {}
    warm = warmer(found)
    figures = {}
    for axis in found.residuals[0].position_mm:
        at = np.array([one.position_mm.get(axis, np.nan) for one in found.residuals]) * say.per_mm
        if np.ptp(at) > 0.0:
            name = say("position of {axis} ({mm})", axis=style.label(axis))
            figures[name] = _scatter(name, at, without_set_up(found), warm, found, say)
    for signal, values in found.temperatures.items():
        at = np.array(values)
        if np.ptp(at) > 0.0:
            name = say("temperature {signal} (°C)", signal=style.label(signal))
            as_found = np.array([one.residual_um for one in found.residuals])
            figures[name] = _scatter(name, at, as_found, None, found, say)
    return figures


def signal_of(found: MachineDiagnosisShape) -> str | None:
    """Returns the temperature that the likeliest errors follow, else the one that varies most; None: none varies."""
    varying = {name: float(np.ptp(at)) for name, at in found.temperatures.items() if at and np.ptp(at) > 0.0}
    named = [error.follows for one in found.sets for error in one.errors if error.follows in varying]
    return named[0] if named else max(varying, key=lambda name: varying[name], default=None)


def warmer(found: MachineDiagnosisShape) -> NDArray[np.bool_] | None:
    """Returns which points are of the warmer half; None where no temperature varies."""
    signal = signal_of(found)
    if signal is None:
        return None
    at = np.array(found.temperatures[signal])
    half: NDArray[np.bool_] = at > np.median(at)
    return half


def without_set_up(found: MachineDiagnosisShape) -> Array:
    """Residuals less the mean of their part, µm."""
    by_part: dict[str, list[float]] = defaultdict(list)
    for one in found.residuals:
        by_part[one.part].append(one.residual_um)
    return np.array([one.residual_um - float(np.mean(by_part[one.part])) for one in found.residuals])


def _scatter(
    name: str, at: Array, values_um: Array, warm: NDArray[np.bool_] | None, found: MachineDiagnosisShape, say: Texts
) -> Figure:
    values = values_um * say.per_um
    every = np.arange(len(at)) % max(1, -(-len(at) // POINTS)) == 0
    marks, means = [], []
    groups = {style.SOFT: np.ones(len(at), dtype=bool)} if warm is None else {style.TAKEN: ~warm, style.LEFT_ON: warm}
    for colour, rows in groups.items():
        shown = np.flatnonzero(rows & every)
        says = [_hover(found.residuals[k].part, values_um[k], say) if len(at) <= SPEAKS else "" for k in shown]
        marks.append(
            style.dots(at[shown].tolist(), values[shown].tolist(), says, color=colour, size=3) | {"opacity": 0.5}
        )
        if rows.any():
            middles, levels = binned(at[rows], values[rows])
            means.append(style.lines(list(middles), list(levels), style.INK if warm is None else colour, 3))
    low, high = style.padded(values.tolist(), 0.08, 1.0)
    span = 0.04 * float(np.ptp(at))
    layout = style.layout(
        WIDTH,
        HEIGHT,
        margin={"l": 64, "r": 10, "t": 10, "b": 50},
        xaxis=style.axis(name, float(at.min()) - span, float(at.max()) + span, 6),
        yaxis=style.axis(say("residual ({um})"), low, high, 6),
        separators=say.separators,
    )
    return {"data": marks + means, "layout": layout}


def _hover(part: str, um: float, say: Texts) -> str:
    return f"{style.label(part)}: {say.error(float(um))} {say.um}"


def binned(at: Array, values: Array) -> tuple[list[float], list[float]]:
    """Means of neighbours: of groups alike in number, none of which parts equal places."""
    places, inverse = np.unique(at, return_inverse=True)
    seen = np.cumsum(np.bincount(inverse)) - np.bincount(inverse)
    group = (seen * min(BINS, len(places)) // len(at))[inverse]
    middles = [float(at[group == g].mean()) for g in np.unique(group)]
    means = [float(values[group == g].mean()) for g in np.unique(group)]
    return middles, means


def left_out_name(one: LeftOutShape, say: Texts = ENGLISH) -> str:
    """Names what was left out."""
    return say("parts, in {n} groups", n=one.groups) if one.of == "parts" else say("part types, {n}", n=one.groups)


def left_out_figure(one: RefinementShape, say: Texts = ENGLISH) -> Figure:
    """Draws for parts and part types left out a line from what the model leaves (○) to that of the refined one (●)."""
    row = [float(len(one.left_out) - k) for k in range(len(one.left_out))]
    before = [left.before_um * say.per_um for left in one.left_out]
    after = [left.after_um * say.per_um for left in one.left_out]
    colours = [style.AFTER if b <= a else style.OUT for a, b in zip(before, after, strict=True)]
    data = [style.lines([a, b], [y, y], c, 2) for a, b, y, c in zip(before, after, row, colours, strict=True)]
    says = [f"{say.size(left.before_um, 2)} → {say.size(left.after_um, 2)} {say.um}" for left in one.left_out]
    data.append(style.dots(list(before), row, [""] * len(row), color=style.SOFT, symbol="circle-open", size=8))
    data.append(style.dots(list(after), row, says, color=colours, size=8))
    layout = style.layout(
        WIDTH,
        30 * len(row) + 80,
        margin={"l": 145, "r": 12, "t": 10, "b": 54},
        xaxis=style.axis(
            say("ERROR_MTG,RESID, root mean square ({um})"), 0.0, 1.08 * max(*before, *after, say.per_um), 5
        ),
        yaxis=style.axis(
            "",
            0.4,
            len(row) + 0.6,
            tickvals=row,
            ticktext=[left_out_name(left, say) for left in one.left_out],
            gridcolor=style.PALE_STEEL,
        ),
        separators=say.separators,
    )
    return {"data": data, "layout": layout}
