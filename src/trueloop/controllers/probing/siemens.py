"""Siemens 840D: MEAS=1 with the result in R parameters, written to a file.

MEAS ends the move at the touch and deletes the rest of it; $AC_MEA[1] says whether there was one, $AA_MW the position
in the work system, read after STOPRE. Positioning moves are MEAS moves as well, and end the program where they are
touched. Where a point is touched twice, a probe that is still triggered where the second touch begins ends the program
as well. All of this is from memory, as is that $AA_MW follows the program's diameter mode: try the program on air
first, with one touch at a known diameter.
"""

from collections.abc import Iterator

from trueloop.controllers.probing.settings import Settings, heading
from trueloop.geometry.feature import Point
from trueloop.probing.probe_plan import PlannedTouch, ProbePlan

AT_START_MM = 0.05
"""Axes this close to where a probing move began have not left it: a touch is expected twice as far away at least."""


def program(plan: ProbePlan, settings: Settings) -> str:
    """Writes the program.

    A missed touch is written as `MISSED` and stops it with alarm 65000, an obstacle with 65001, a probe that is still
    triggered where the second touch begins with 65002. After any of them no move follows: the program ends, also when
    it is started on.
    """
    lines = [f"; {line}" for line in heading(plan, settings)]
    unit, mode = "G700" if settings.inch else "G710", "DIAMON" if settings.diameter else "DIAMOF"
    log = settings.log.rsplit(".", 1)[0].upper()
    x, z = settings.safe_first(plan)
    lines += ["DEF INT FAULT", f"{unit} {mode} G18 G90 G40 G94 G{settings.work_offset}", f"T{settings.tool} D1", "M5"]
    lines += [*settings.orient, f"G0 {x}", f"G0 {z}", *settings.probe_on, *_touches(plan, settings, log)]
    lines += [*settings.probe_off, "M30"]
    lines += ["MISSED_TOUCH:", f'WRITE(FAULT,"{log}","MISSED")', "SETAL(65000)", "M0", "M30"]
    lines += ["OBSTRUCTED:", "SETAL(65001)", "M0", "M30"]
    if plan.approach.second:
        lines += ["STILL_TRIGGERED:", "SETAL(65002)", "M0", "M30"]
    return "\n".join([*lines, ""])


def _touches(plan: ProbePlan, settings: Settings, log: str) -> Iterator[str]:
    back = settings.feed(settings.position_feed_mm_per_min)
    for touch in plan.touches:
        yield f"; point {touch.point} on {touch.feature}"
        for place in (*touch.way_mm, touch.start_mm):
            yield from _protected(place, settings)
        yield from _touched(touch, settings.probe_feed_mm_per_min, settings)
        yield from _second(touch, plan, settings)
        yield "R1=$AA_MW[X] R2=$AA_MW[Z]"
        yield f'WRITE(FAULT,"{log}","X"<<R1<<" Z"<<R2)'
        yield f"G1 {settings.words(touch.start_mm)} {back}"
    for place in plan.retreat_mm:
        yield from _protected(place, settings)


def _touched(touch: PlannedTouch, feed_mm_per_min: float, settings: Settings) -> Iterator[str]:
    """A move that ends the program when the probe meets nothing."""
    yield f"MEAS=1 G1 {settings.words(touch.target_mm)} {settings.feed(feed_mm_per_min)}"
    yield from ("STOPRE", "IF $AC_MEA[1]==0 GOTOF MISSED_TOUCH")


def _second(touch: PlannedTouch, plan: ProbePlan, settings: Settings) -> Iterator[str]:
    """Back from where the probe touched, then again; the program ends where the probe trips before the axes move."""
    second = plan.approach.second
    if second is None:
        return
    x, z = settings.added(touch.back_off_vector_mm(second))
    yield f"R1=$AA_MW[X]{x} R2=$AA_MW[Z]{z}"
    yield f"G1 X=R1 Z=R2 {settings.feed(settings.position_feed_mm_per_min)}"
    yield from _touched(touch, second.feed_mm_per_min, settings)
    near = settings.number(AT_START_MM)
    yield f"IF ABS($AA_MW[X]-R1)+ABS($AA_MW[Z]-R2)<{near} GOTOF STILL_TRIGGERED"


def _protected(place: Point, settings: Settings) -> Iterator[str]:
    """A move that ends the program when the probe meets something."""
    yield f"MEAS=1 G1 {settings.words(place)} {settings.feed(settings.position_feed_mm_per_min)}"
    yield from ("STOPRE", "IF $AC_MEA[1]==1 GOTOF OBSTRUCTED")
