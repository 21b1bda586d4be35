"""What a proposal does to the characteristics of the next part: the error expected without it and with it."""

from collections.abc import Sequence
from typing import Final

from trueloop.domain.proposal import Effect
from trueloop.report import style
from trueloop.report.style import Figure, Trace
from trueloop.report.texts.texts import ENGLISH, Texts
from trueloop.statistics import NORMAL_95
from trueloop.units import UM_PER_MM

WIDTH: Final = 480
"""As wide as a telephone shows it."""
HEIGHT: Final = 300
APART: Final = 0.16
"""How far both marks of a characteristic stand from its middle."""
LONGEST: Final = 60
"""Letters of all names below the axis together."""


def proposal_figure(effects: Sequence[Effect], say: Texts = ENGLISH) -> Figure:
    """● without the proposal, red where material would be left on and blue where too much would be taken; ◆ with it.

    Bars hold 95 % of parts. Errors are actual less nominal size.
    """
    before, after = ([one.error_before_mm for one in effects], [one.error_after_mm for one in effects])
    u = [NORMAL_95 * one.standard_u_mm for one in effects]
    seen = [UM_PER_MM * (e + sign * w) for e, w in zip(before + after, u + u, strict=True) for sign in (-1, 1)]
    low, high = style.padded(seen)
    colours = [style.colour_of(UM_PER_MM * one) for one in before]
    data = [
        _marks(-APART, before, u, say, color=colours, symbol="circle", size=9),
        _marks(APART, after, u, say, color=style.AFTER, symbol="diamond", size=11),
    ]
    layout = style.layout(
        WIDTH,
        HEIGHT,
        margin={"l": 64, "r": 10, "t": 10, "b": 50},
        xaxis=style.axis(say("characteristic"), 0.5, len(effects) + 0.5) | _names(effects),
        yaxis=style.axis(say("error ({um})"), low * say.per_um, high * say.per_um, 6),
        separators=say.separators,
    )
    return {"data": data, "layout": layout}


def _names(effects: Sequence[Effect]) -> dict[str, list[object]]:
    most = max(LONGEST // len(effects), 3)
    names = [one if len(one) <= most else f"{one[: most - 1]}…" for one in (each.characteristic for each in effects)]
    return {"tickvals": [k + 1 for k in range(len(effects))], "ticktext": [style.label(one) for one in names]}


def _marks(shift: float, errors_mm: Sequence[float], u_mm: Sequence[float], say: Texts, **marker: object) -> Trace:
    um = [one * UM_PER_MM * say.per_um for one in errors_mm]
    bars = [one * UM_PER_MM * say.per_um for one in u_mm]
    hover = [
        f"{say.error(UM_PER_MM * e)} ± {say.size(UM_PER_MM * w)} {say.um}" for e, w in zip(errors_mm, u_mm, strict=True)
    ]
    x = [k + 1 + shift for k in range(len(um))]
    error_y = {"type": "data", "array": bars, "color": style.INK, "thickness": 1.2, "width": 3}
    return style.dots(x, um, hover, **marker) | {"error_y": error_y}
