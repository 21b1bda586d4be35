"""Siemens 840D: MEAS=1 with the result in R parameters, written to a file.

MEAS ends the move at the touch and deletes the rest of it; $AC_MEA[1] says whether there was one, $AA_MW the position
in the work system, read after STOPRE. All of this is from memory, as is that $AA_MW follows the program's diameter
mode: try the program on air first, with one touch at a known diameter.
"""

from trueloop.controllers.probing.settings import Settings, heading
from trueloop.gauging.probe_plan import ProbePlan


def program(plan: ProbePlan, settings: Settings) -> str:
    """The program as text. A missed touch is written as `MISSED` and stops the program with alarm 65000."""
    lines = [f"; {line}" for line in heading(plan, settings)]
    unit, mode = "G70" if settings.inch else "G71", "DIAMON" if settings.diameter else "DIAMOF"
    position, probe = (settings.feed(f) for f in (settings.position_feed_mm_per_min, settings.probe_feed_mm_per_min))
    log = settings.log.rsplit(".", 1)[0].upper()
    x, z = settings.safe_first(plan)
    lines += ["DEF INT FAULT", f"{unit} {mode} G18 G90 G40 G94 G{settings.work_offset}", f"T{settings.tool} D1", "M5"]
    lines += [f"G0 {x}", f"G0 {z}"]
    for touch in plan.touches:
        lines.append(f"; point {touch.point} on {touch.feature}")
        lines += [f"G1 {settings.words(place)} {position}" for place in (*touch.way_mm, touch.start_mm)]
        lines += [f"MEAS=1 G1 {settings.words(touch.target_mm)} {probe}", "STOPRE"]
        lines += ["R1=$AA_MW[X] R2=$AA_MW[Z] R3=$AC_MEA[1]", "IF R3==0", f'WRITE(FAULT,"{log}","MISSED")']
        lines += ["SETAL(65000)", "M0", "ENDIF", f'WRITE(FAULT,"{log}","X"<<R1<<" Z"<<R2)']
        lines += [f"G1 {settings.words(touch.start_mm)} {position}"]
    lines += [f"G1 {settings.words(place)} {position}" for place in plan.retreat_mm]
    return "\n".join([*lines, "M30", ""])
