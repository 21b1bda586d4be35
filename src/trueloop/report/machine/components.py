"""The page of the components of a part's error at its gauging points [6876 §3]."""

from trueloop.diagnosis.components import Components
from trueloop.diagnosis.part_frame import FrameDiscrepancy
from trueloop.report.diagnosis.surfaces import surface_figures
from trueloop.report.diagnosis.values import point_shape
from trueloop.report.markup import esc, section, table
from trueloop.report.shell import figure_block, html_page
from trueloop.report.style import plain, signed
from trueloop.units import UM_PER_MM, URAD_PER_RAD

FIGURES = 12
"""Points that get a figure of their own, those of the largest ERROR_PP first."""


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
        figure_block(f"point-{k}", surface_figures(point_shape(points[k], parts, k)), f"<b>{esc(points[k])}</b>")
        for k in furthest
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
