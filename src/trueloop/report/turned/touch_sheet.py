"""The sheet that a person takes to the part: a drawing with numbered places, and a table with empty cells."""

from collections.abc import Sequence
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.characteristic import Characteristic, Quantity
from trueloop.geometry.profile import Profile
from trueloop.report import style
from trueloop.report.markup import esc, figure_block, html_page, section, table
from trueloop.report.style import Figure
from trueloop.report.turned.figures.part_drawing import diagonal_mm, feature_names, material, outline_mm
from trueloop.units import MM_PER_INCH

WIDTH: Final = 900
HIGHEST: Final = 620
"""Of the drawing, so that a page of paper has room for the table too."""
MARGIN: Final = 0.07
"""Free strip about the part, as a share of its diagonal, with the numbers."""
WHAT: Final = {Quantity.DIAMETER: "Ø", Quantity.LENGTH: "length", Quantity.RADIUS: "R", Quantity.ANGLE: "angle"}
FIELDS: Final = ("Serial", "Gauge, its U (k = 2)", "Measured by", "Date, time", "Temperature, °C")


def touch_sheet(part: str, profile: Profile, planned: Sequence[Characteristic], inch: bool = False) -> str:
    """Writes the page, for print: `planned` in the order of their numbers, lengths in the program's unit."""
    caption = "Numbers are those of the table; the chuck is on the left."
    body = (
        f"<h1>{esc(part)}: what to measure</h1>"
        + table(FIELDS, [["&nbsp;"] * len(FIELDS)], words=range(len(FIELDS)), name="stated")
        + figure_block("places", places_figure(profile, planned, inch), caption)
        + section("values", "Values", _values(planned, inch))
    )
    return html_page(f"{esc(part)} – what to measure", body)


def places_figure(
    profile: Profile, planned: Sequence[Characteristic], inch: bool = False, width: int = WIDTH
) -> Figure:
    """Draws the part with feature names and a numbered line across each size; z to the right, x a radius."""
    per = MM_PER_INCH if inch else 1.0
    outline = outline_mm(profile) / per
    largest, gap = float(outline[:, 0].max()), MARGIN * diagonal_mm(profile) / per
    traces, notes, rows = material(outline, profile.side), [], 0
    for number, characteristic in enumerate(planned, 1):
        if characteristic.quantity is Quantity.DIAMETER and characteristic.at_z_mm is not None:
            z, x, top = characteristic.at_z_mm / per, characteristic.nominal / 2 / per, largest + gap / 2
            traces.append(style.lines([z, z], [-x, top - 0.2 * gap], style.TAKEN, 1.2))
            notes.append(style.note(z, top, f"<b>{number}</b>", font={"color": style.INK}))
        elif characteristic.quantity is Quantity.LENGTH:
            rows += 1
            low, high = (end / per for end in _ends_z_mm(profile, characteristic))
            x = -largest - rows * gap
            traces.append(style.lines([low, high], [x, x], style.TAKEN, 1.2))
            notes.append(style.note((low + high) / 2, x + 0.35 * gap, f"<b>{number}</b>", font={"color": style.INK}))
    z_low, z_high = float(outline[:, 1].min()) - gap, float(outline[:, 1].max()) + gap
    x_low, x_high = -largest - (rows + 1) * gap, largest + gap
    height = min(HIGHEST, round(90 + (width - 80) * (x_high - x_low) / (z_high - z_low)))
    mm_per_px = per * max((z_high - z_low) / (width - 80), (x_high - x_low) / (height - 90))
    names = feature_names(profile, _marked_mm(profile, planned), [0.0] * len(profile.features), mm_per_px)
    notes += [{**name, "x": name["x"] / per, "y": name["y"] / per} for name in names]
    xaxis = style.axis(f"z ({'inch' if inch else 'mm'})", z_low, z_high)
    yaxis = style.axis("", x_low, x_high, zeroline=False, scaleanchor="x", scaleratio=1, constrain="domain")
    yaxis |= {"tickvals": [], "ticktext": []}  # below the axis are dimensions, no radii
    return {"data": traces, "layout": style.layout(width, height, annotations=notes, xaxis=xaxis, yaxis=yaxis)}


def _marked_mm(profile: Profile, planned: Sequence[Characteristic]) -> list[Array]:
    """Arc lengths at which the lines across diameters meet each feature."""
    found = []
    for feature in profile.features:
        start, end = (float(point[1]) for point in (feature.start_mm, feature.end_mm))
        at = [
            characteristic.at_z_mm
            for characteristic in planned
            if characteristic.feature == feature.name and characteristic.at_z_mm is not None
        ]
        per = 0.0 if start == end else feature.length_mm / (end - start)
        found.append(np.sort(np.array([(z - start) * per for z in at])))
    return found


def _ends_z_mm(profile: Profile, length: Characteristic) -> tuple[float, float]:
    """Where a length begins and ends along z."""
    faces = [profile.features[profile.names.index(name)] for name in (length.feature, length.other) if name]
    z = [float(face.point_mm(0.0)[1]) for face in faces]
    low, high = min(z), max(z)
    return (min(low, 0.0), max(high, 0.0)) if len(z) == 1 else (low, high)


def _values(planned: Sequence[Characteristic], inch: bool) -> str:
    unit, per, decimals = ("inch", MM_PER_INCH, 4) if inch else ("mm", 1.0, 3)

    def shown(value: float | None) -> str:
        return "" if value is None else style.plain(value / per, decimals)

    rows = [
        [
            str(number),
            esc(characteristic.feature),
            WHAT.get(characteristic.quantity, characteristic.quantity.value)
            + (f" from {esc(characteristic.other)}" if characteristic.other else ""),
            shown(characteristic.at_z_mm),
            shown(characteristic.nominal),
            shown(characteristic.lower_limit),
            shown(characteristic.upper_limit),
            "&nbsp;",
        ]
        for number, characteristic in enumerate(planned, 1)
    ]
    head = ("No.", "Feature", "What", f"at z, {unit}", f"Nominal, {unit}", "Least", "Most", f"Measured, {unit}")
    return table(head, rows, words=(1, 2), name="readings")
