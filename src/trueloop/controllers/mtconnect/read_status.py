"""Runs under LinuxCNC's own Python: says several times a second what LinuxCNC's status and pins are, as JSON lines.

Called with the period in s and the names of pins. {"status": {…} or null, "pins": {name: value or null}}. It ends when
LinuxCNC ends, because what it is attached to then stands still and looks well; and when nobody reads it.
"""

import json
import os
import sys
import time
from contextlib import suppress
from pathlib import Path

import hal
import linuxcnc

LOOK_S = 1.0
MODES = {linuxcnc.MODE_MANUAL: "MANUAL", linuxcnc.MODE_AUTO: "AUTO", linuxcnc.MODE_MDI: "MDI"}
STATES = {linuxcnc.INTERP_IDLE: "IDLE", linuxcnc.INTERP_PAUSED: "PAUSED"}


def is_up() -> bool:
    """Returns whether LinuxCNC's process that reads programs is there."""
    for process in Path("/proc").iterdir():
        with suppress(OSError):
            if process.name.isdigit() and (process / "comm").read_text().strip() == "milltask":
                return True
    return False


def status_of(stat: "linuxcnc.stat") -> dict[str, object]:
    """Returns the reported part of the status; lengths in mm, angles in degrees, times in s. Raises linuxcnc.error."""
    stat.poll()
    mm = 1 / (stat.linear_units or 1.0)
    joints = range(stat.joints)
    return {
        "positions": [at * (1 if k in (3, 4, 5) else mm) for k, at in enumerate(stat.actual_position)],
        "estop": bool(stat.task_state == linuxcnc.STATE_ESTOP),
        "on": bool(stat.task_state == linuxcnc.STATE_ON),
        "mode": MODES.get(stat.task_mode, ""),
        "interpreter": STATES.get(stat.interp_state, "RUNNING"),
        "paused": bool(stat.paused),
        "program": stat.file,
        "line": stat.motion_line or stat.current_line,
        "velocity_mm_s": stat.current_vel * mm,
        "spindle_rpm": stat.spindle[0]["speed"] if stat.spindles else None,
        "joint_faults": [k for k in joints if stat.joint[k]["fault"]],
        "joints_at_limit": [k for k in joints if stat.joint[k]["min_hard_limit"] or stat.joint[k]["max_hard_limit"]],
    }


def pin(name: str) -> "float | None":
    """Returns a pin's value; nothing where there is no such pin."""
    try:
        return float(hal.get_value(name))
    except RuntimeError:
        return None


def main() -> None:
    """Prints the state until LinuxCNC ends."""
    every_s, pins = float(sys.argv[1]), sys.argv[2:]
    component, stat = None, None
    try:
        up, next_look = False, 0.0
        while up or component is None:
            if time.monotonic() >= next_look:
                up, next_look = is_up(), time.monotonic() + LOOK_S
            said: dict[str, object] = {"status": None, "pins": {}}
            with suppress(linuxcnc.error, SystemError):
                if up:
                    if component is None:  # without one no pin can be read; one without pins counts as false
                        component = hal.component(f"mtconnect-{os.getpid()}")
                    stat = stat or linuxcnc.stat()
                    said = {"status": status_of(stat), "pins": {name: pin(name) for name in pins}}
            print(json.dumps(said), flush=True)
            time.sleep(every_s)
    except (KeyboardInterrupt, BrokenPipeError):  # LinuxCNC's module makes the first of SIGTERM
        sys.stdout = None
    finally:
        if component is not None:
            component.exit()


if __name__ == "__main__":
    main()
