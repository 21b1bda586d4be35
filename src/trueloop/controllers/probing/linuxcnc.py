"""LinuxCNC: G38.2, its result logged from #5061 to #5069.

The log holds a line a touch, nine numbers in program units, the ball's centre in the work system; X is a radius even in
diameter mode: what PROBEOPEN writes as well, but of every probing move, also of the first touch of two, and without a
touch equal to the one before [measured on 2.9]. So each touch is logged by a line of its own, after the move that is to
be recorded. A missed touch stops the program with an error. So does a probe that is still triggered where a touch
begins, and one that trips on any other move: LinuxCNC's motion control looks at it all the time, so that the ways
between touches are plain feed moves. (G38.3 would write its end into the log, touched or not [measured on 2.9].)
"""

from trueloop.controllers.probing.settings import Settings, heading
from trueloop.probing.probe_plan import PlannedTouch, ProbePlan

RESULT = "(LOG," + " ".join(f"#{number}" for number in range(5061, 5070)) + ")"


def program(plan: ProbePlan, settings: Settings) -> str:
    """Writes the program."""
    lines = [f"({_plain(line)})" for line in heading(plan, settings)]
    unit, mode = "G20" if settings.inch else "G21", "G7" if settings.diameter else "G8"
    position, probe = (settings.feed(f) for f in (settings.position_feed_mm_per_min, settings.probe_feed_mm_per_min))
    x, z = settings.safe_first(plan)
    lines += [f"{unit} G18 {mode} G90 G40 G94 G{settings.work_offset}", f"T{settings.tool} M6 G43", "M5"]
    lines += [*settings.orient, f"G0 {x}", f"G0 {z}", *settings.probe_on, f"(LOGOPEN,{settings.log})"]
    for touch in plan.touches:
        lines.append(f"(point {_plain(touch.point)} on {_plain(touch.feature)})")
        lines += [f"G1 {settings.words(place)} {position}" for place in (*touch.way_mm, touch.start_mm)]
        lines += [f"G38.2 {settings.words(touch.target_mm)} {probe}", *_second(touch, plan, settings)]
        lines += [RESULT, f"G1 {settings.words(touch.start_mm)} {position}"]
    lines += ["(LOGCLOSE)", *(f"G1 {settings.words(place)} {position}" for place in plan.retreat_mm)]
    return "\n".join([*lines, *settings.probe_off, "M2", ""])


def _second(touch: PlannedTouch, plan: ProbePlan, settings: Settings) -> list[str]:
    """Back from where the probe touched, then again. #5061 is a radius also in diameter mode."""
    second = plan.approach.second
    if second is None:
        return []
    x, z = settings.added(touch.back_off_vector_mm(second))
    back = f"G1 X[{'2*' if settings.diameter else ''}#5061{x}] Z[#5063{z}]"
    return [
        f"{back} {settings.feed(settings.position_feed_mm_per_min)}",
        f"G38.2 {settings.words(touch.target_mm)} {settings.feed(second.feed_mm_per_min)}",
    ]


def _plain(text: str) -> str:
    """Without what would end or open a comment."""
    return text.replace("(", "[").replace(")", "]")
