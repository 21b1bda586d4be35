"""The surface/error diagram of [6876 §3]: every surface and vector at one gauging point, and a page of all points.

All vectors are collinear, along the outward normal; the diagram sets them side by side to be seen.
"""

from trueloop.diagnosis.components import Components
from trueloop.diagnosis.part_frame import FrameDiscrepancy
from trueloop.report.markup import esc, section, table
from trueloop.report.shell import figure_block, html_page
from trueloop.report.style import (
    AFTER,
    INK,
    LEFT_ON,
    SOFT,
    TAKEN,
    Figure,
    apart,
    axis,
    dots,
    label,
    layout,
    lines,
    note,
    padded,
    plain,
    signed,
)
from trueloop.units import UM_PER_MM, URAD_PER_RAD

SURFACES = (
    ("NOMINALSURFACE CMM", None),
    ("NOMINALSURFACE MT", "nominal_surface_mt"),
    ("UNCOMPENSATED NOMINALSURFACE MT, hypothetical", "uncompensated_nominal_surface_mt"),
    ("detected surface", "detected_surface"),
    ("GT compensated surface", "gt_compensated_surface"),
    ("uncompensated surface, hypothetical", "uncompensated_surface"),
)
FIGURES = 12
"""Points that get a figure of their own, those of the largest ERROR_PP first."""


def surface_error_diagram(parts: Components, k: int) -> Figure:
    """One gauging point: surfaces as lines at their height, vectors as arrows between them, µm."""
    heights = {name: 0.0 if field is None else UM_PER_MM * float(getattr(parts, field)[k]) for name, field in SURFACES}
    nominal_mt, free_mt = heights[SURFACES[1][0]], heights[SURFACES[2][0]]
    detected, gt, free = heights["detected surface"], heights[SURFACES[4][0]], heights[SURFACES[5][0]]
    vectors = (
        ("ERROR_PP", 0.0, detected, LEFT_ON),
        ("ERROR_MTG", 0.0, free_mt, INK),
        ("COMP_MTG", free_mt, nominal_mt, AFTER),
        ("ERROR_MTG,RESID", 0.0, nominal_mt, INK),
        ("ERROR_PROC", nominal_mt, gt, TAKEN),
        ("COMP_PROC", gt, detected, AFTER),
        ("ERROR_PROC,RESID", nominal_mt, detected, TAKEN),
        ("COMP_MTG + COMP_PROC", free, detected, AFTER),
    )
    low, high = padded([*heights.values()], share=0.35)
    row = 0.06 * (high - low)
    places = apart(heights, row)
    traces = [lines([0.0, 9.0], [height, height], SOFT, 1, line={"dash": "dot"}) for height in heights.values()]
    notes = [note(9.1, places[name], label(f"{name} {signed(h)}"), xanchor="left") for name, h in heights.items()]
    for column, (name, start, end, colour) in enumerate(vectors, 1):
        traces.append(lines([column, column], [start, end], colour, 3))
        head = "triangle-up" if end >= start else "triangle-down"
        traces.append(dots([column], [end], [f"{name} {signed(end - start)} µm"], color=colour, symbol=head, size=9))
        notes.append(note(column, max(start, end) + row, signed(end - start)))
        # names are wider than columns: they take turns in three rows
        notes.append(note(column, low - row * (1 + column % 3), name))
    axes = {
        "xaxis": axis("", 0, 15.5, visible=False),
        "yaxis": axis(
            "along the outward normal (µm)", min(low - 4 * row, *places.values()), max(high, *places.values())
        ),
        "annotations": notes,
    }
    return {"data": traces, "layout": layout(980, 420, **axes)}


def components_page(points: tuple[str, ...], parts: Components, frame: FrameDiscrepancy | None) -> str:
    """All points as a table, and the diagram of the points that are furthest off."""
    columns = (
        "error_pp",
        "error_mtg",
        "error_mtg_resid",
        "error_proc",
        "error_proc_resid",
        "u_error_mtg",
        "u_error_proc",
    )
    rows = [(esc(point), *(_cell(parts, name, k) for name in columns)) for k, point in enumerate(points)]
    furthest = sorted(range(len(points)), key=lambda k: -abs(float(parts.error_pp[k])))[:FIGURES]
    figures = [
        figure_block(f"point-{k}", surface_error_diagram(parts, k), f"<b>{esc(points[k])}</b>") for k in furthest
    ]
    body = (
        '<header><p class="kicker">trueloop · error components at gauging points</p><h1>Machine, process, and the rest'
        "</h1><p class='note'>µm along the outward normal, + is material left on; u are standard uncertainties.</p>"
        f"{_frame(frame)}</header>"
        + section("table", "Components", table(("point", *columns), rows))
        + section("diagrams", "Surface/error diagrams", *figures)
    )
    return html_page("Error components", body)


def _cell(parts: Components, name: str, k: int) -> str:
    """µm; an uncertainty has no sign."""
    value = UM_PER_MM * float(getattr(parts, name)[k])
    return plain(value, 2) if name.startswith("u_") else signed(value, 2)


def _frame(frame: FrameDiscrepancy | None) -> str:
    if frame is None:
        return ""
    shift = ", ".join(signed(UM_PER_MM * float(v), 1) for v in frame.shift_mm)
    turn = ", ".join(signed(URAD_PER_RAD * float(v), 0) for v in frame.turn_rad)
    return (
        f"<p>Part coordinate system discrepancy taken out: shift ({shift}) µm, turn ({turn}) µrad; differences along "
        f"the normals {UM_PER_MM * frame.rms_before_mm:.1f} → {UM_PER_MM * frame.rms_after_mm:.1f} µm RMS.</p>"
    )
