"""Runs inside LinuxCNC as its display program, under Debian's Python: carries out steps, one after the other.

Called without arguments in the configuration's folder. Reads `order.json`, {"steps": [[verb, argument, ...], ...],
"record": [pin, ...], "depth": rows}, and writes `answer.json`, {"error": message or null, "got": {name: value},
"messages": [text, ...], "columns": [pin, ...]}, and what was recorded to `samples.bin`.
"""

import json
import shutil
import struct
import subprocess
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING

import linuxcnc

if TYPE_CHECKING:
    from trueloop_lab.linuxcnc.run_program import PATIENCE_S, Operator
else:
    from run_program import PATIENCE_S, Operator

KINDS = {"float": "f", "s32": "s", "u32": "u", "bit": "b"}
"""Pins of the recorder by HAL's types, in the order of a row."""

RECORDED = "/tmp/linuxcnc.samples"
"""In memory; `session.sh` makes files of this name the session's own."""
WORDS = {"TRUE": True, "FALSE": False}


def hal(*words: object) -> str:
    """Runs a command of halcmd and returns its output. Raises RuntimeError with its words."""
    done = subprocess.run(["halcmd", "-s", *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        raise RuntimeError(f"halcmd {' '.join(map(str, words))}: {(done.stderr + done.stdout).strip()}")
    return done.stdout.strip()


def value(pin: str) -> float:
    """Returns the value of a pin or a parameter."""
    told = hal("getp", pin)
    return WORDS[told] if told in WORDS else float(told) if "." in told or "e" in told or "n" in told else int(told, 0)


def pin_of(name: str) -> "tuple[str, str] | None":
    """Returns type and signal ("": none) of a pin; nothing for a parameter."""
    rows = [line.split() for line in hal("show", "pin", name).splitlines()]
    found = [row for row in rows if name in row]
    if not found:
        return None
    row = found[0]
    return row[1], row[-1] if "=" in row[-2] else ""


class Player(Operator):
    """The operator who carries out steps. Every `do_` is a verb."""

    def __init__(self) -> None:
        self.got: dict[str, object] = {}
        self.messages: list[str] = []
        super().__init__()

    def heard(self, message: str) -> None:
        """Messages end nothing: they are kept."""
        self.messages.append(message.strip())

    def mode(self, mode: int) -> None:
        """Switches to manual, MDI or AUTO."""
        self.status.poll()
        if self.status.task_mode != mode:
            self.command.mode(mode)
            self.command.wait_complete(PATIENCE_S)

    def idle(self) -> bool:
        """Returns whether nothing is being done."""
        state = self.status
        settled = state.interp_state == linuxcnc.INTERP_IDLE and state.exec_state == linuxcnc.EXEC_DONE
        return bool(settled and state.inpos)

    def do_on(self) -> None:
        """Takes the machine out of the emergency stop and switches it on."""
        for state in (linuxcnc.STATE_ESTOP_RESET, linuxcnc.STATE_ON):
            self.switch(state)

    def switch(self, state: int) -> None:
        """Switches to a state of the task and waits until it is reached."""
        self.command.state(state)
        self.until(lambda: bool(self.status.task_state == state), PATIENCE_S)

    def do_estop(self) -> None:
        """Triggers the emergency stop."""
        self.switch(linuxcnc.STATE_ESTOP)

    def do_home(self, joint: int = -1) -> None:
        """Homes one joint, or all, and waits until they are homed."""
        self.do_start_home(joint)
        joints = range(self.status.joints) if joint < 0 else [joint]
        time.sleep(0.1)  # it is not homing at once
        self.until(
            lambda: all(value(f"joint.{k}.homed") and not value(f"joint.{k}.homing") for k in joints), PATIENCE_S
        )

    def do_start_home(self, joint: int = -1) -> None:
        """Starts homing without waiting."""
        self.mode(linuxcnc.MODE_MANUAL)
        self.command.teleop_enable(0)
        self.command.wait_complete(PATIENCE_S)
        self.command.home(joint)

    def do_mdi(self, block: str) -> None:
        """Executes a block, to its end or its first error."""
        self.mode(linuxcnc.MODE_MDI)
        before = len(self.messages)
        self.command.mdi(block)
        self.command.wait_complete(PATIENCE_S)
        self.until(lambda: self.idle() or len(self.messages) > before, PATIENCE_S)

    def do_start_mdi(self, block: str) -> None:
        """Starts a block without waiting."""
        self.mode(linuxcnc.MODE_MDI)
        self.command.mdi(block)

    def do_start(self, program: str, feed_override: float = 1.0) -> None:
        """Runs a program of the configuration's folder, and does not wait."""
        self.mode(linuxcnc.MODE_AUTO)
        self.command.feedrate(feed_override)
        self.command.program_open(str(Path(program).resolve()))
        self.command.wait_complete(PATIENCE_S)
        self.command.auto(linuxcnc.AUTO_RUN, 0)
        self.taken()
        # an empty program has run before it is seen
        end = time.monotonic() + 3.0
        self.until(lambda: self.status.interp_state != linuxcnc.INTERP_IDLE or time.monotonic() > end, PATIENCE_S)

    def do_finish(self, timeout_s: float = 600.0) -> None:
        """Waits until the program has ended."""
        self.until(self.idle, timeout_s)

    def do_run_program(self, program: str, feed_override: float = 1.0, timeout_s: float = 600.0) -> None:
        """Runs a program, to its end or its first error."""
        before = len(self.messages)
        self.do_start(program, feed_override)
        self.until(lambda: self.idle() or len(self.messages) > before, timeout_s)

    def do_pause(self) -> None:
        """Holds the feed."""
        self.command.auto(linuxcnc.AUTO_PAUSE)

    def do_resume(self) -> None:
        """Resumes after a pause."""
        self.command.auto(linuxcnc.AUTO_RESUME)

    def do_abort(self) -> None:
        """Aborts, as the stop button does."""
        self.command.abort()
        self.command.wait_complete(PATIENCE_S)

    def do_jog(self, joint: int, velocity_mm_per_s: float, distance_mm: float) -> None:
        """Moves a joint by hand, without waiting."""
        self.mode(linuxcnc.MODE_MANUAL)
        self.command.jog(linuxcnc.JOG_INCREMENT, self.status.motion_mode == 1, joint, velocity_mm_per_s, distance_mm)

    def do_set(self, name: str, to: float) -> None:
        """Sets a pin, by its signal where it is linked, or a parameter."""
        pin = pin_of(name)
        if pin and pin[1]:
            hal("sets", pin[1], to)
        else:
            hal("setp", name, to)

    def do_hal(self, *words: str) -> None:
        """Runs a command of halcmd."""
        hal(*words)

    def do_get(self, name: str, *pins: str) -> None:
        """Values under a name: one, or a list."""
        values = [value(pin) for pin in pins]
        self.got[name] = values[0] if len(values) == 1 else values

    def do_probed(self, name: str) -> None:
        """Stores whether and where the last probing move touched, work coordinates: X, Y, Z."""
        self.status.poll()
        self.got[name] = [bool(self.status.probe_tripped), *self.status.probed_position[:3]]

    def do_place(self, name: str) -> None:
        """Stores the position that the control displays, machine coordinates: X, Y, Z."""
        self.status.poll()
        self.got[name] = list(self.status.actual_position[:3])

    def do_status(self, name: str, field: str) -> None:
        """Stores a field of LinuxCNC's status."""
        self.status.poll()
        self.got[name] = getattr(self.status, field)

    def do_wait(self, name: str, wanted: float, timeout_s: float = PATIENCE_S) -> None:
        """Waits until a pin has a value, to a millionth. Raises TimeoutError."""
        try:
            self.until(lambda: abs(value(name) - wanted) < 1e-6, timeout_s)
        except TimeoutError:
            raise TimeoutError(f"{name} is {value(name)}, not {wanted}, after {timeout_s} s") from None

    def do_sleep(self, seconds: float) -> None:
        """Waits so many seconds, for what cannot be waited for."""
        end = time.monotonic() + seconds
        self.until(lambda: time.monotonic() > end, seconds + PATIENCE_S)

    def do_put(self, source: str, to: str) -> None:
        """Puts a file in place of another, as a whole."""
        shutil.copy(source, f"{to}.next")
        Path(f"{to}.next").replace(to)

    def do_remove(self, file: str) -> None:
        """Removes a file of the configuration's folder."""
        Path(file).unlink()

    def do_record(self, on: bool) -> None:
        """Switches recording on or off."""
        hal("setp", "recorder.enable", int(on))

    def do_note(self, name: str) -> None:
        """Rows recorded so far."""
        with Path(RECORDED).open("rb") as file:
            self.got[name] = int(struct.unpack("d", file.read(8))[0])


def link_recorder(pins: "list[str]", depth: int) -> "list[str]":
    """Wires pins to the recorder, beside the signals that they are on; the pins in the order of a row."""
    types = {name: pin for name in pins if (pin := pin_of(name))}
    unknown = [name for name in pins if name not in types]
    if unknown:
        raise RuntimeError(f"no pins of these names: {', '.join(unknown)}")
    by_kind = {kind: [name for name in pins if types[name][0] == kind] for kind in KINDS}
    counts = [
        f"{word}={len(by_kind[kind])}"
        for kind, word in zip(KINDS, ("floats", "signeds", "unsigneds", "bits"), strict=True)
    ]
    hal("loadrt", "recorder", f"file={RECORDED}", f"depth={depth}", *counts)
    hal("addf", "recorder", "servo-thread")
    for kind, letter in KINDS.items():
        for place, name in enumerate(by_kind[kind]):
            linked = types[name][1]
            hal("net", linked or f"recorded-{name}", *([] if linked else [name]), f"recorder.{letter}-{place}")
    return [name for kind in KINDS for name in by_kind[kind]]


def main() -> int:
    """Carries out the order; 0 when every step was done."""
    order = json.loads(Path("order.json").read_text())
    answer: dict[str, object] = {"error": None, "columns": [], "got": {}, "messages": []}
    try:
        player = Player()
        answer |= {"got": player.got, "messages": player.messages}
        if order["record"]:
            answer["columns"] = link_recorder(order["record"], order["depth"])
        for number, (verb, *arguments) in enumerate(order["steps"], 1):
            answer["step"] = f"step {number}, {verb} {' '.join(map(str, arguments))}".strip()
            getattr(player, f"do_{verb}")(*arguments)
    except (TimeoutError, RuntimeError, OSError, linuxcnc.error) as failed:
        answer["error"] = f"{failed}"
    finally:
        if Path(RECORDED).exists():
            shutil.copy(RECORDED, "samples.bin")
        Path("answer.json").write_text(json.dumps(answer))
    return 1 if answer["error"] else 0


if __name__ == "__main__":
    sys.exit(main())
