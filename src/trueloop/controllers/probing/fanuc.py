"""Fanuc and Haas lathes, G code system A: G31 with results sent by DPRNT, and Renishaw-style macros.

A skip move leaves the axes' positions in #5061 and up, servo lag included, in the work system and in the program's
diameter mode: on a two-axis Fanuc lathe Z is #5062, on a Haas #5063. The macros P9810 (protected move) and P9811
(surface along one axis) take ball and lag off by themselves and leave the surface in #135 (X) and #137 (Z). Of this the
skip cycle, its servo lag and the macros' arguments were read in manuals; DPRNT's format, the variables of results and
those of the Haas are from memory: try the program on air first.
"""

from trueloop.controllers.probing.settings import Settings, heading
from trueloop.errors import Code, TrueloopError
from trueloop.gauging.probe_plan import PlannedTouch, ProbePlan

ALONG_AXIS = 1e-6
"""A normal this close to an axis is along it."""


def program(plan: ProbePlan, settings: Settings) -> str:
    """G31, results in #5061 and #5062."""
    return _skip_program(plan, settings, z_result="#5062")


def haas_program(plan: ProbePlan, settings: Settings) -> str:
    """G31, results in #5061 and #5063."""
    return _skip_program(plan, settings, z_result="#5063")


def macro_program(plan: ProbePlan, settings: Settings) -> str:
    """P9810 and P9811. Raises PRB-AXIS for a point whose surface faces neither axis."""
    lines = [*_begin(plan, settings), "G65 P9832", "POPEN"]
    for touch in plan.touches:
        lines.append(_comment(f"point {touch.point} on {touch.feature}"))
        feed = settings.feed(settings.position_feed_mm_per_min)
        lines += [f"G65 P9810 {settings.words(place)} {feed}" for place in (*touch.way_mm, touch.start_mm)]
        lines.append(f"G65 P9811 {_axis_word(plan, touch, settings)} Q{settings.number(plan.approach.overtravel_mm)}")
        lines.append(_logged("#135", "#137", settings))
    feed = settings.feed(settings.position_feed_mm_per_min)
    back = [f"G65 P9810 {settings.words(place)} {feed}" for place in plan.retreat_mm]
    return "\n".join([*lines, "PCLOS", *back, "G65 P9833", "M30", "%", ""])


def _skip_program(plan: ProbePlan, settings: Settings, z_result: str) -> str:
    position, probe = (settings.feed(f) for f in (settings.position_feed_mm_per_min, settings.probe_feed_mm_per_min))
    lines = [*_begin(plan, settings), "POPEN"]
    for touch in plan.touches:
        lines.append(_comment(f"point {touch.point} on {touch.feature}"))
        lines += [f"G1 {settings.words(place)} {position}" for place in (*touch.way_mm, touch.start_mm)]
        lines += [f"G31 {settings.words(touch.target_mm)} {probe}"]
        lines += ["#101=#5061", f"#102={z_result}", _logged("#101", "#102", settings)]
        lines += [f"G1 {settings.words(touch.start_mm)} {position}"]
    back = [f"G1 {settings.words(place)} {position}" for place in plan.retreat_mm]
    return "\n".join([*lines, "PCLOS", *back, "M30", "%", ""])


def _begin(plan: ProbePlan, settings: Settings) -> list[str]:
    x, z = settings.safe_first(plan)
    lines = ["%", "O9100", *(_comment(line) for line in heading(plan, settings))]
    lines += [f"{'G20' if settings.inch else 'G21'} G18 G40 G98", "M5"]
    return [*lines, f"G{settings.work_offset}", f"T{settings.tool:02d}{settings.tool:02d}", f"G0 {x}", f"G0 {z}"]


def _axis_word(plan: ProbePlan, touch: PlannedTouch, settings: Settings) -> str:
    """The surface's nominal coordinate on the axis it faces."""
    allowance = plan.approach.allowance_mm
    x, z = (p + allowance * n for p, n in zip(touch.nominal_mm, touch.normal, strict=True))
    words = settings.words((x, z)).split()
    for axis in (0, 1):
        if abs(touch.normal[1 - axis]) < ALONG_AXIS:
            return words[axis]
    raise TrueloopError(
        Code.PRB_AXIS,
        f"point {touch.point!r} on {touch.feature!r} faces ({touch.normal[0]:.4f}, {touch.normal[1]:.4f}); P9811 "
        "measures along X or Z only",
        hint="use the control's own skip cycle: --control fanuc",
    )


def _logged(x: str, z: str, settings: Settings) -> str:
    """Eight digits a number, the most there are: to 0.1 µm or 0.00001 in, as coordinates are written."""
    digits = f"{8 - settings.decimals}{settings.decimals}"
    return f"DPRNT[X{x}[{digits}]Z{z}[{digits}]]"


def _comment(text: str) -> str:
    """Upper case in parentheses: what old controls can show."""
    return f"({text.upper().replace('(', '[').replace(')', ']')})"
