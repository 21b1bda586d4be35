"""Fanuc and Haas lathes, G code system A: G31 with results sent by DPRNT, and Renishaw-style macros.

A skip move leaves the axes' positions in #5061 and up, servo lag included, in the work system and in the program's
diameter mode: on a two-axis Fanuc lathe Z is #5062, on a Haas #5063. The macros P9810 (protected move) and P9811
(surface along one axis) take ball and lag off by themselves and leave the surface in #135 (X) and #137 (Z). Where the
axes stand is read from #5041 and up: on a move that was not skipped they stand at its end, whatever the control
leaves in #5061. So a touch that was missed, and a way that was obstructed, end in the alarms 101 and 102. Where a point
is touched twice, a probe that is still triggered where the second touch begins ends in alarm 103. Of this the
skip cycle, its servo lag and the macros' arguments were read in manuals; DPRNT's format, the variables of results and
those of the Haas are from memory: try the program on air first.
"""

from trueloop.controllers.probing.settings import Settings, heading
from trueloop.errors import Code
from trueloop.geometry.feature import Point
from trueloop.probing.probe_plan import PlannedTouch, ProbePlan

ALONG_AXIS = 1e-6
"""A normal this close to an axis is along it."""

AT_END_MM = 0.05
"""Axes this close to a move's end have come to it: servos settle closer, touches are expected 1 mm before it."""

MISSED, OBSTRUCTED, TRIGGERED = 101, 102, 103
"""Numbers of the program's own alarms, as #3000 gives them: nothing moves after one."""


def program(plan: ProbePlan, settings: Settings) -> str:
    """Writes a program with G31, results in #5061 and #5062."""
    return _skip_program(plan, settings, z_axis=2)


def haas_program(plan: ProbePlan, settings: Settings) -> str:
    """Writes a program with G31, results in #5061 and #5063."""
    return _skip_program(plan, settings, z_axis=3)


def macro_program(plan: ProbePlan, settings: Settings) -> str:
    """Writes a program with P9810 and P9811. Raises PRB-AXIS for a point whose surface faces neither axis."""
    lines = [*_begin(plan, settings), *(settings.probe_on or ("G65 P9832",)), "POPEN"]
    for touch in plan.touches:
        lines.append(_comment(f"point {touch.point} on {touch.feature}"))
        feed = settings.feed(settings.position_feed_mm_per_min)
        lines += [f"G65 P9810 {settings.words(place)} {feed}" for place in (*touch.way_mm, touch.start_mm)]
        lines.append(f"G65 P9811 {_axis_word(plan, touch, settings)} Q{settings.number(plan.approach.overtravel_mm)}")
        lines.append(_logged("#135", "#137", settings))
    feed = settings.feed(settings.position_feed_mm_per_min)
    back = [f"G65 P9810 {settings.words(place)} {feed}" for place in plan.retreat_mm]
    off = settings.probe_off or ("G65 P9833",)
    return "\n".join([*lines, "PCLOS", *back, *off, "M30", "%", ""])


def _skip_program(plan: ProbePlan, settings: Settings, z_axis: int) -> str:
    back = settings.feed(settings.position_feed_mm_per_min)
    lines = [*_begin(plan, settings), *settings.probe_on, "POPEN"]
    for touch in plan.touches:
        lines.append(_comment(f"point {touch.point} on {touch.feature}"))
        for place in (*touch.way_mm, touch.start_mm):
            lines += _protected(place, settings, z_axis)
        lines += _touched(touch, settings.probe_feed_mm_per_min, settings, z_axis)
        lines += _second(touch, plan, settings, z_axis)
        lines += ["#101=#5061", f"#102=#506{z_axis}", _logged("#101", "#102", settings)]
        lines += [f"G1 {settings.words(touch.start_mm)} {back}"]
    ways = [line for place in plan.retreat_mm for line in _protected(place, settings, z_axis)]
    return "\n".join([*lines, "PCLOS", *ways, *settings.probe_off, "M30", "%", ""])


def _touched(touch: PlannedTouch, feed_mm_per_min: float, settings: Settings, z_axis: int) -> list[str]:
    """A skip move that ends in an alarm where it came to its end."""
    near = settings.number(AT_END_MM)
    return [
        f"G31 {settings.words(touch.target_mm)} {settings.feed(feed_mm_per_min)}",
        f"IF[{_off(touch.target_mm, settings, z_axis)}LT {near}]THEN #3000={MISSED}(MISSED TOUCH)",
    ]


def _second(touch: PlannedTouch, plan: ProbePlan, settings: Settings, z_axis: int) -> list[str]:
    """Back from where the probe touched, then again; an alarm where the probe trips before the axes have moved."""
    second = plan.approach.second
    if second is None:
        return []
    x, z = settings.added(touch.back_off_vector_mm(second))
    moved = f"[ABS[#5061-#101]+ABS[#506{z_axis}-#102]]"
    return [
        f"#101=#5061{x}",
        f"#102=#506{z_axis}{z}",
        f"G1 X#101 Z#102 {settings.feed(settings.position_feed_mm_per_min)}",
        *_touched(touch, second.feed_mm_per_min, settings, z_axis),
        f"IF[{moved}LT {settings.number(AT_END_MM)}]THEN #3000={TRIGGERED}(PROBE STILL TRIGGERED)",
    ]


def _protected(place: Point, settings: Settings, z_axis: int) -> list[str]:
    """A skip move that ends in an alarm where it did not come to its end."""
    near = settings.number(AT_END_MM)
    return [
        f"G31 {settings.words(place)} {settings.feed(settings.position_feed_mm_per_min)}",
        f"IF[{_off(place, settings, z_axis)}GE {near}]THEN #3000={OBSTRUCTED}(PATH OBSTRUCTED)",
    ]


def _off(place: Point, settings: Settings, z_axis: int) -> str:
    """An expression: how far the axes stand from a place, both ways added."""
    x, z = (word[1:] for word in settings.words(place).split())
    return f"[ABS[#5041-[{x}]]+ABS[#504{z_axis}-[{z}]]]"


def _begin(plan: ProbePlan, settings: Settings) -> list[str]:
    x, z = settings.safe_first(plan)
    lines = ["%", f"O{settings.program_number:04d}", *(_comment(line) for line in heading(plan, settings))]
    lines += [f"{'G20' if settings.inch else 'G21'} G18 G40 G98", "M5", *settings.orient]
    return [*lines, f"G{settings.work_offset}", f"T{settings.tool:02d}{settings.tool:02d}", f"G0 {x}", f"G0 {z}"]


def _axis_word(plan: ProbePlan, touch: PlannedTouch, settings: Settings) -> str:
    """The surface's nominal coordinate on the axis it faces."""
    allowance = plan.approach.allowance_mm
    x, z = (p + allowance * n for p, n in zip(touch.nominal_mm, touch.normal, strict=True))
    words = settings.words((x, z)).split()
    for axis in (0, 1):
        if abs(touch.normal[1 - axis]) < ALONG_AXIS:
            return words[axis]
    raise Code.PRB_AXIS.refusal(
        f"point {touch.point!r} on {touch.feature!r} faces ({touch.normal[0]:.4f}, {touch.normal[1]:.4f}); P9811 "
        "measures along X or Z only",
        hint="use the control's own skip cycle: --control fanuc",
        values={"point": touch.point, "feature": touch.feature, "normal": list(touch.normal)},
    )


def _logged(x: str, z: str, settings: Settings) -> str:
    """Eight digits a number, the most there are: to 0.1 µm or 0.00001 in, as coordinates are written."""
    digits = f"{8 - settings.decimals}{settings.decimals}"
    return f"DPRNT[X{x}[{digits}]Z{z}[{digits}]]"


def _comment(text: str) -> str:
    """Upper case in parentheses: what old controls can show."""
    return f"({text.upper().replace('(', '[').replace(')', ']')})"
