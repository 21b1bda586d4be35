"""Runs inside LinuxCNC as its display program, under Debian's Python: switches the machine on and runs programs.

Called without arguments in the configuration's folder. Reads `order.json`, {"program", "feed_override", "sample"}, and
writes `answer.json`, {"error": message or null, "line"}, and with "sample" the positions of every servo period to
`positions.txt`. Progress goes to `progress.txt`, a line of position every tenth of a second.
"""

import json
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import linuxcnc

PATH_MODE = "G64 P0.0001"
"""Corners are rounded by a tenth of a micrometre at most, unless the program says otherwise. As a start-up code in the
configuration it does not reach programs, and what LinuxCNC does by itself rounds corners by millimetres."""

PATIENCE_S = 60.0
"""For what takes a moment, on a computer that has much else to do."""

UNSEEN_S = 5.0
"""A program that was not seen running for this long has run, or has nothing in it. Idle at once means not yet begun: a
busy computer takes its time."""

LATE_S = 0.5
"""The reason why a program ended may be printed after its end."""

UNNAMED = "an error that it does not name"
ERRORS = (linuxcnc.NML_ERROR, linuxcnc.OPERATOR_ERROR)


class Operator:
    """LinuxCNC's command, status and error channels."""

    def __init__(self) -> None:
        self.status, self.command, self.channel = linuxcnc.stat(), linuxcnc.command(), linuxcnc.error_channel()
        self.error: str | None = None
        self.unnamed = False
        self.until(lambda: True, PATIENCE_S)

    def heard(self, message: str) -> None:
        """Keeps the message of an error: the first one counts."""
        self.error = self.error or message

    def until(self, reached: Callable[[], bool], timeout_s: float) -> None:
        """Polls until something holds."""
        end = time.monotonic() + timeout_s
        while True:
            try:
                self.status.poll()
                said = self.channel.poll()
                if said and said[0] in ERRORS:
                    self.heard(said[1])
                if reached():
                    return
            except linuxcnc.error:
                pass  # the status buffer comes up a moment after the display program
            if time.monotonic() > end:
                waited = "LinuxCNC carried out no command" if timeout_s == PATIENCE_S else "the program did not end"
                raise TimeoutError(f"{waited} within {timeout_s:g} s")
            time.sleep(0.002)

    def taken(self) -> None:
        """Waits until LinuxCNC has taken the last command, which a busy computer puts off by seconds."""
        self.until(lambda: bool(self.status.echo_serial_number == self.command.serial), PATIENCE_S)

    def mode(self, mode: int) -> None:
        """Switches to another mode and waits for it: a command of that mode is refused before."""
        self.command.mode(mode)
        self.until(lambda: self.status.task_mode == mode, PATIENCE_S)

    def switch_on(self) -> None:
        """Takes the machine out of the emergency stop, switches it on and homes it where it stands."""
        self.command.state(linuxcnc.STATE_ESTOP_RESET)
        self.until(lambda: self.status.task_state == linuxcnc.STATE_ESTOP_RESET, PATIENCE_S)
        self.command.state(linuxcnc.STATE_ON)
        self.until(lambda: self.status.task_state == linuxcnc.STATE_ON, PATIENCE_S)
        self.command.mode(linuxcnc.MODE_MANUAL)
        self.command.wait_complete()
        self.command.teleop_enable(0)
        self.command.wait_complete()
        self.command.home(-1)
        self.until(lambda: all(self.status.homed[: self.status.joints]), PATIENCE_S)
        self.mode(linuxcnc.MODE_MDI)
        self.command.mdi(PATH_MODE)
        self.command.wait_complete(5)

    def run(self, program: Path, feed_override: float, timeout_s: float) -> "int | None":
        """Runs a program to its end or its first error; the line it was at then."""
        self.mode(linuxcnc.MODE_AUTO)
        self.command.feedrate(feed_override)
        self.command.program_open(str(program.resolve()))
        self.command.wait_complete()
        self.command.auto(linuxcnc.AUTO_RUN, 0)
        self.taken()
        line = None
        with Path("progress.txt").open("w", buffering=1) as progress:
            started, next_report, begun = time.monotonic(), 0.0, False

            def ended() -> bool:
                nonlocal line, next_report, begun
                idle = self.status.interp_state == linuxcnc.INTERP_IDLE
                if not idle or self.error:
                    line = self.status.motion_line or self.status.current_line or line
                now = time.monotonic()
                if now >= next_report:
                    x, z = self.status.actual_position[0], self.status.actual_position[2]
                    print(f"{self.status.motion_line} {x:.3f} {z:.3f}", file=progress)
                    next_report = now + 0.1
                begun = begun or not idle or now - started > UNSEEN_S
                done = begun and idle and self.status.exec_state == linuxcnc.EXEC_DONE
                return done or self.error is not None

            self.until(ended, timeout_s)
        settled = time.monotonic() + LATE_S
        self.until(lambda: self.error is not None or time.monotonic() > settled, 2 * LATE_S)
        self.unnamed = self.error is None and self.status.state == linuxcnc.RCS_ERROR
        return line


def drained() -> bool:
    """Returns whether halsampler has emptied the buffer: what is left in it is lost when halsampler ends."""
    return int(subprocess.check_output(["halcmd", "getp", "sampler.0.curr-depth"])) == 0


def main() -> int:
    """Carries out the order; 0 when the program ran to its end."""
    order = json.loads(Path("order.json").read_text())
    answer: dict[str, object] = {"error": None, "line": None}
    operator = Operator()
    sampler = None
    try:
        operator.switch_on()
        if order["sample"]:
            sampler = subprocess.Popen(["halsampler", "positions.txt"])
            subprocess.run(["halcmd", "setp", "sampler.0.enable", "1"], check=True)
        answer["line"] = operator.run(Path(order["program"]), order["feed_override"], order["timeout_s"])
        answer["error"] = operator.error or (UNNAMED if operator.unnamed else None)
        if sampler:
            subprocess.run(["halcmd", "setp", "sampler.0.enable", "0"], check=True)
            operator.until(drained, PATIENCE_S)
            answer["overruns"] = int(subprocess.check_output(["halcmd", "getp", "sampler.0.overruns"]))
    except TimeoutError as late:
        answer["error"] = operator.error or str(late)
    finally:
        if sampler:
            sampler.terminate()
            sampler.wait(PATIENCE_S)
        Path("answer.json").write_text(json.dumps(answer))
    return 1 if answer["error"] else 0


if __name__ == "__main__":
    sys.exit(main())
