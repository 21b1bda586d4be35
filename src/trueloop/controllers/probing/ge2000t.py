"""GE Mark Century 2000T, as in fast probing [6811 §4.1]: feed moves through the surface, latched from outside.

The control has no skip: a device in the position feedback latches the axes when the probe trips, and the probe's own
overtravel takes up the rest of the move, so that the overtravel of the plan must lie within it (6.5 mm along Z, 12.5°
of tilt for the probe of the report). The style of blocks is that of the programs of [6811 Appendix A]; no probing
program is printed there. The control does not see the probe either: no program can stop it when a touch is missed or a
way obstructed. That is for the latching device, by the machine's feed hold.
"""

from trueloop.controllers.probing.settings import Settings, heading
from trueloop.probing.probe_plan import ProbePlan


def program(plan: ProbePlan, settings: Settings) -> str:
    """Writes the program; X in diameters always, as the control takes it."""
    settings = Settings(**{**vars(settings), "diameter": True})
    position, probe = (settings.feed(f) for f in (settings.position_feed_mm_per_min, settings.probe_feed_mm_per_min))
    x, z = settings.safe_first(plan)
    blocks = [f"{'G70' if settings.inch else 'G71'}", "G94 M05", f"T{settings.tool:02d}{settings.tool:02d}"]
    blocks += [*settings.orient, f"G00 {x}", f"G00 {z}", *settings.probe_on]
    for touch in plan.touches:
        blocks.append(f"! Point {touch.point} on {touch.feature}")
        blocks += [f"G01 {settings.words(place)} {position}" for place in (*touch.way_mm, touch.start_mm)]
        blocks += [f"G01 {settings.words(touch.target_mm)} {probe}", f"G01 {settings.words(touch.start_mm)} {position}"]
    blocks += [*(f"G01 {settings.words(place)} {position}" for place in plan.retreat_mm), *settings.probe_off]
    lines = [
        f"(ID,PROG, {settings.program_number}, Probing)",
        "! The control does not see the probe: nothing here stops",
        *(f"! {line}" for line in heading(plan, settings)),
        *blocks,
        "M30",
    ]
    numbered = [f"N{10 * (k + 1):04d} {line}" for k, line in enumerate(lines)]
    return "\n".join([*numbered, "N9999 (END, PROG)", ""])
