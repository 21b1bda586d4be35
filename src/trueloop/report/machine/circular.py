"""The circular test of ISO 230-4 as lines, as JSON and as a page with the polar diagram of the standard."""

from collections.abc import Iterator
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.machine.circular import Cause, Circle, CircularTest
from trueloop.report.markup import esc, figure_block, html_page, section, table
from trueloop.report.style import AFTER, FAINT, INK, SOFT, Figure, axis, layout, lines, note, plain, round_step, signed
from trueloop.units import UM_PER_MM

SIZE: Final = 620
CAPTION: Final = (
    "Δ from the nominal circle (dashed) about each way's least-squares centre, outwards where too far out; "
    "dark: counter-clockwise, light: clockwise. Rings are {ring} µm apart; Δ is drawn {times} times larger than "
    "the circle."
)
BAR: Final = "F and D are the machine's where the length of the bar is calibrated: its error is in them."


def circular_values(test: CircularTest) -> list[tuple[str, str, float]]:
    """Returns symbol, meaning and value of what the standard requires and the file gives, µm."""
    rows = [
        (
            f"G {way}",
            f"circular deviation ({plain(UM_PER_MM * test.about_centre_mm[way], 2)} about the least-squares centre)",
            zone,
        )
        for way, zone in test.zone_mm.items()
    ]
    about = plain(UM_PER_MM * test.both_about_centre_mm, 2)
    both = f"bidirectional circular deviation ({about} about the least-squares centre)"
    rows.append(("G(b)", both, test.both_zone_mm))
    for way, (highest, lowest) in test.extremes_mm.items():
        rows += [(f"Fmax {way}", "radial deviation, largest", highest), (f"Fmin {way}", "smallest", lowest)]
    rows.append(("D", "mean bidirectional radial deviation", test.mean_radial_mm))
    return [(symbol, meaning, UM_PER_MM * value) for symbol, meaning, value in rows if not np.isnan(value)]


def circular_lines(test: CircularTest) -> Iterator[str]:
    """Yields the values, the causes by what they make of the deviation, and the one that makes most."""
    for symbol, meaning, value in circular_values(test):
        yield f"{symbol:<9} {plain(value, 2):>8} µm  {meaning}"
    yield BAR
    for cause in test.causes:
        yield f"{cause.name:<28} {_amplitude(cause):<26} makes {plain(UM_PER_MM * cause.range_mm, 2)} µm"
    yield f"left by all causes: {plain(UM_PER_MM * test.left_mm, 2)} µm RMS"
    yield _verdict(test)


def circular_summary(test: CircularTest) -> dict[str, object]:
    """Returns values and causes as JSON; lengths in µm, amplitudes in their unit with U (k = 2)."""
    causes = [
        {
            "cause": cause.name,
            "amplitude": cause.amplitude,
            "expanded_u": cause.expanded_u,
            "unit": cause.unit,
            "range_um": UM_PER_MM * cause.range_mm,
            "detail": cause.detail,
        }
        for cause in test.causes
    ]
    about = {f"G {way}": UM_PER_MM * value for way, value in test.about_centre_mm.items()}
    return {
        "unit": "µm",
        "values": {symbol: value for symbol, _, value in circular_values(test)},
        "about_least_squares_centre": about,
        "causes": causes,
        "largest": None if test.largest is None else test.largest.name,
        "left_um_rms": UM_PER_MM * test.left_mm,
    }


def circular_page(name: str, test: CircularTest) -> str:
    """Writes the page: the polar diagram, the standard's values, the causes."""
    circle = test.circles[0]
    figure, ring_um, times = circular_figure(test)
    caption = CAPTION.format(ring=f"{ring_um:g}", times=f"{times:,.0f}")
    ways = " and ".join(circle.way for circle in test.circles)
    head = (
        '<header><p class="kicker">trueloop · circular test after ISO 230-4</p>'
        f"<h1>{esc(name)}</h1><p class='meta'>{esc(circle.plane)}, radius {circle.radius_mm:g} mm, {ways}</p>"
        f"<p class='note'>{esc(_verdict(test))}. {BAR}</p></header>"
    )
    values = [(esc(f"{symbol} – {meaning}"), plain(value, 2)) for symbol, meaning, value in circular_values(test)]
    causes = [(esc(cause.name), esc(_amplitude(cause)), plain(UM_PER_MM * cause.range_mm, 2)) for cause in test.causes]
    body = (
        section("plot", "Path", figure_block("circle", figure, caption))
        + section("values", "Values", table(("value", "µm"), values))
        + section("causes", "Causes", table(("cause", "amplitude ± U (k = 2)", "makes (µm)"), causes))
    )
    return html_page(f"{esc(name)} – ISO 230-4", head + body)


def circular_figure(test: CircularTest) -> tuple[Figure, float, float]:
    """Draws the paths in polar coordinates; returns the rings' step, µm, and by how much Δ is enlarged."""
    first, second = test.circles[0].plane[0], test.circles[0].plane[1]
    curves = [UM_PER_MM * circle.centred_mm for circle in test.circles]
    largest = max(float(np.abs(np.concatenate(curves)).max()), 1e-3)
    ring_um = round_step(2 * largest, 4)
    radius = 2.5 * largest
    turn = np.linspace(0, 2 * np.pi, 361)
    rings = [ring_um * k for k in range(-int(largest / ring_um), int(largest / ring_um) + 1)]
    traces = [
        lines(
            ((radius + ring) * np.cos(turn)).tolist(),
            ((radius + ring) * np.sin(turn)).tolist(),
            FAINT if ring else SOFT,
            0.7 if ring else 1.2,
            line={} if ring else {"dash": "dash"},
        )
        for ring in rings
    ]
    reach = 1.12 * (radius + largest)
    ends: list[list[float | None]] = [[-reach, reach], [0.0, 0.0]]
    traces += [lines(ends[k], ends[1 - k], FAINT, 0.7) for k in range(2)]
    for circle, curve in zip(test.circles, curves, strict=True):
        traces.append(_drawn(circle, radius + curve))
    notes = [note(0.0, radius + ring, f"{signed(ring, 1)}", font={"size": 11}) for ring in rings if ring]
    notes += [note(0.97 * reach, 0.05 * reach, f"+{first}"), note(0.07 * reach, 0.97 * reach, f"+{second}")]
    bare = axis("", -reach, reach, tickvals=[], ticktext=[], linecolor="#ffffff", zeroline=False)
    axes = {"xaxis": bare, "yaxis": bare | {"scaleanchor": "x", "scaleratio": 1}, "annotations": notes}
    margin = {"l": 10, "r": 10, "t": 10, "b": 10}
    times = UM_PER_MM * test.circles[0].radius_mm / radius
    return {"data": traces, "layout": layout(SIZE, SIZE, margin=margin, **axes)}, ring_um, times


def _drawn(circle: Circle, radius: Array) -> dict[str, object]:
    closed = np.append(circle.angle_rad, circle.angle_rad[0])
    around = np.append(radius, radius[0])
    colour = INK if circle.sense > 0 else AFTER
    return lines((around * np.cos(closed)).tolist(), (around * np.sin(closed)).tolist(), colour, 1.6)


def _amplitude(cause: Cause) -> str:
    decimals = 2 if cause.unit == "µm" else 1
    size = f"{signed(cause.amplitude, decimals)} ± {plain(cause.expanded_u, decimals)} {cause.unit}"
    return f"{size}, {cause.detail}" if cause.detail else size


def _verdict(test: CircularTest) -> str:
    largest = test.largest
    if largest is None:
        return "no cause is certain"
    return f"largest cause: {largest.name}, {_amplitude(largest)}"
