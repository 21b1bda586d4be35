"""The surface/error diagram of [6876 Fig. 12–15]: every surface and every vector at one gauging point.

All of them lie on one line, along the outward normal; the diagram draws them one below the other. Surfaces are places,
counted from NOMINALSURFACE_CMM; errors and compensations are arrows from one surface to another.
"""

from typing import Final

from trueloop.report import style
from trueloop.report.diagnosis.shapes import PointShape
from trueloop.report.style import Figure, Trace
from trueloop.report.texts.texts import ENGLISH, Texts

WIDE: Final = (980, 190)
NARROW: Final = (480, 188)
"""Width of the picture and of the names at its left."""
ROW: Final = 23
FIRST: Final = "NOMINALSURFACE CMM"


def surfaces_um(point: PointShape, say: Texts = ENGLISH) -> dict[str, float]:
    """Returns the place of each surface, µm, by its name in the report."""
    compensated = point.comp_mtg_um + point.comp_proc_um
    return {
        FIRST: 0.0,
        "NOMINALSURFACE MT": point.error_mtg_resid_um,
        say("the same, uncompensated"): point.error_mtg_um,
        say("detected surface"): point.error_pp_um,
        say("GT compensated surface"): point.error_pp_um - point.comp_proc_um,
        say("uncompensated surface"): point.error_pp_um - compensated,
    }


def vectors_um(point: PointShape) -> dict[str, tuple[float, float]]:
    """Returns start and end of each vector, µm, by its name in the report."""
    detected, nominal, free_nominal = point.error_pp_um, point.error_mtg_resid_um, point.error_mtg_um
    gt = detected - point.comp_proc_um
    return {
        "ERROR_PP": (0.0, detected),
        "ERROR_MTG": (0.0, free_nominal),
        "COMP_MTG": (free_nominal, nominal),
        "ERROR_MTG,RESID": (0.0, nominal),
        "ERROR_PROC": (nominal, gt),
        "COMP_PROC": (gt, detected),
        "ERROR_PROC,RESID": (nominal, detected),
        "COMP_MTG + PROC": (gt - point.comp_mtg_um, detected),
    }


def surface_figures(point: PointShape, say: Texts = ENGLISH) -> dict[str, Figure]:
    """Draws the diagram for a wide and for a narrow window."""
    return {"wide": surface_figure(point, say, WIDE), "narrow": surface_figure(point, say, NARROW)}


def surface_figure(point: PointShape, say: Texts = ENGLISH, size: tuple[int, int] = WIDE) -> Figure:
    """Draws one gauging point. ◆ surfaces, with a dotted line over all rows; arrows: red where material is left on,
    blue where too much was taken, green compensations; behind them what the part errs by.
    """
    surfaces, vectors, scale = surfaces_um(point, say), vectors_um(point), say.per_um
    names = [*surfaces, *vectors]
    row = {name: float(len(names) - k) for k, name in enumerate(names)}
    low, high = (end * scale for end in style.padded(surfaces.values(), 0.24))
    beside = (high - low) * (0.02 if size is WIDE else 0.035)
    detected = point.error_pp_um
    data = [_behind(detected * scale, len(names), style.colour_of(detected))]
    notes = []
    for name, at in surfaces.items():
        data += _surface(at * scale, row[name], name == FIRST)
        notes.append(_value(at * scale, row[name], say.error(at), beside, "left", style.INK))
    for name, (start, end) in vectors.items():
        colour = style.AFTER if name.startswith("COMP") else style.colour_of(end - start)
        data += _arrow(start * scale, end * scale, row[name], colour)
        right = end >= start
        beyond = beside if right else -beside
        notes.append(
            _value(end * scale, row[name], say.error(end - start), beyond, "left" if right else "right", colour)
        )
    layout = style.layout(
        size[0],
        ROW * len(names) + 76,
        margin={"l": size[1], "r": 12, "t": 8, "b": 54},
        xaxis=style.axis(say("along the outward normal ({um})"), low, high, 8 if size is WIDE else 5),
        yaxis=style.axis(
            "", 0.3, len(names) + 0.7, tickvals=list(row.values()), ticktext=names, gridcolor=style.PALE_STEEL
        ),
        annotations=notes,
        separators=say.separators,
    )
    return {"data": data, "layout": layout}


def _behind(detected: float, rows: int, colour: str) -> Trace:
    """From the nominal to the detected surface, in the colour of the part's error."""
    return style.area(
        [0.0, detected, detected, 0.0], [0.3, 0.3, rows + 0.7, rows + 0.7], f"rgba({_channels(colour)},0.09)"
    )


def _channels(colour: str) -> str:
    return ",".join(str(int(colour[k : k + 2], 16)) for k in (1, 3, 5))


def _surface(at: float, row: float, first: bool) -> list[Trace]:
    """A mark in its row, and a line from there down over all vectors."""
    line = style.lines([at, at], [0.3, row], style.SOFT if first else style.FAINT, 1.2, line={"dash": "dot"})
    return [line, style.dots([at], [row], [""], color=style.INK, symbol="diamond", size=9)]


def _arrow(start: float, end: float, row: float, colour: str) -> list[Trace]:
    head = "triangle-right" if end >= start else "triangle-left"
    return [
        style.lines([start, end], [row, row], colour, 3),
        style.dots([end], [row], [""], color=colour, symbol=head if start != end else "circle-open", size=8),
    ]


def _value(at: float, row: float, text: str, beyond: float, anchor: str, colour: str) -> dict[str, object]:
    return style.note(at + beyond, row, text, xanchor=anchor, font={"color": colour})
