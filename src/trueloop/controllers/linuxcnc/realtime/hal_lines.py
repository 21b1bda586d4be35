"""Changes to a configuration of LinuxCNC so that the corrector stands between motion and the drives.

In the lines there are, `joint.N.motor-pos-cmd` becomes `rtec.out-A`, `joint.N.motor-pos-fb` becomes `rtec.drive-fb-A`:
whatever was wired to motion is wired to the corrector, whatever the drives are. All else is new. Nothing is edited.
Remarks list what an integrator has to decide.
"""

import shlex
import sys
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, Literal

from trueloop.controllers.linuxcnc.realtime.configuration import LIBRARY, Configuration, HalLine
from trueloop.controllers.linuxcnc.realtime.hal_checks import (
    AXES,
    added,
    check_compensation,
    check_free,
    check_image,
    joints_of,
    limits_of,
    mm_per_unit,
    units,
)
from trueloop.controllers.linuxcnc.realtime.signals.component import NAME as SIGNALS_COMPONENT
from trueloop.controllers.linuxcnc.realtime.watch import sampled_pins, sampler_lines
from trueloop.errors import Code, Place
from trueloop.realtime.image import Image

TO_MOTION: Final = (
    ("rtec.pause", "halui.program.pause", "a fault pauses the program"),
    ("rtec.active", "motion.homing-inhibit", "no homing while something is added: the switch would be met elsewhere"),
)


def remarks(configuration: Configuration, joints: dict[int, int], image: Image | None) -> Iterator[str]:
    """Sentences for the integrator."""
    own = sorted(
        {line.place.file or "" for line in configuration.hal if LIBRARY in Path(line.place.file or "").parents}
    )
    for file in own:
        yield f"{file} is LinuxCNC's own: copy it beside the INI file, and make the changes there."
    yield from _travels(configuration, joints, image)
    for from_, pin, why in TO_MOTION:
        if signal := configuration.signal_of(pin):
            yield f"{pin} is on signal {signal} already: bring {from_} there too, by an or2 ({why})."
    for joint in joints.values():
        for entry in configuration.all(f"JOINT_{joint}", "BACKLASH"):
            if float(entry.value or 0) != 0:
                yield f"Joint {joint} has BACKLASH = {entry.value}: a model that knows it too corrects it twice."
    if image is None:
        yield "Without an image signals are not wired and nothing is compared: name it with --image."
    yield "Enable is the integrator's: net a switch, or halui, to rtec.enable; nothing is added before."


def _travels(configuration: Configuration, joints: dict[int, int], image: Image | None) -> Iterator[str]:
    """Soft limits are motion's, which does not see what is added."""
    unit = mm_per_unit(configuration)
    for axis, joint in joints.items():
        limits = limits_of(configuration, joint, axis)
        low, high = limits.in_mm(unit)
        if image is None:
            if len(limits.entries) == 2:
                yield f"Soft limits of {AXES[axis]} are {low:g} and {high:g} mm: with --image they are compared."
            continue
        limit = image.limits.limit_mm
        inside = limits.inside_mm(unit, image.limits.travel_mm[axis])
        if min(inside) < limit:
            low, high = (max(value, 0.0) for value in inside)
            yield (
                f"Soft limits of {AXES[axis]} are {low:g} and {high:g} mm inside the image's travel: a correction "
                f"of up to {limit:g} mm towards an end has less room there, and faults. Set them {limit:g} mm inside."
            )


NEW_FILE: Final = "rtec.hal"
HANDLER: Final = "motion-command-handler"
CONTROLLER: Final = "motion-controller"


@dataclass(frozen=True)
class Change:
    """One change. `place`: the line that is replaced, or before or after which the text goes; without: a new file."""

    where: Literal["replace", "before", "after", "new"]
    place: Place
    text: str
    why: str
    old: str = ""


@dataclass(frozen=True)
class Wiring:
    """All changes, and what cannot be written as one."""

    changes: tuple[Change, ...]
    remarks: tuple[str, ...]


def wiring(configuration: Configuration, image: Image | None = None, image_file: str = "IMAGE.rtec") -> Wiring:
    """Determines what a configuration needs. `image`: signals and serial are taken from it.

    Raises RTC-HAL for a configuration that the corrector cannot be put into, by what stands in the way, and for an
    image of another machine.
    """
    check_free(configuration)
    joints = joints_of(configuration)
    check_compensation(configuration, joints)
    if image is not None:
        check_image(configuration, joints, image)
    changes = (
        *_loaded(configuration, image, image_file),
        *_replaced(configuration, joints),
        *_new_file(configuration, joints, image),
        *_ini(configuration),
    )
    return Wiring(changes, (*remarks(configuration, joints, image), *_to_be_linked(changes)))


def _loaded(configuration: Configuration, image: Image | None, image_file: str) -> Iterator[Change]:
    """The component, and its two functions around motion's."""
    handler, controller = (added(configuration, name) for name in (HANDLER, CONTROLLER))
    thread = handler.words[2]
    _require_one_word(image_file)
    serial = f" serial={image.identity.serial}" if image and image.identity.serial else ""
    load = f"loadrt rtec image={image_file}{serial}"
    first = f"{load}\naddf rtec.read {thread}"
    yield Change("before", handler.place, first, "the correction comes out of the feedback before motion sees it")
    last = f"addf rtec.write {thread}"
    yield Change(
        "after", controller.place, last, "the correction of this period goes into the command, before the drives"
    )


def _require_one_word(path: str) -> None:
    """HAL separates words at blanks and has no quotes. Raises RTC-HAL."""
    if len(path.split()) != 1:
        raise Code.RTC_HAL.refusal(
            f"the image's path {path!r} has a blank in it: HAL would take it for {len(path.split())} words",
            hint="copy the image into a folder without a blank in its path, and name it there",
            place=Place(path),
        )


def _replaced(configuration: Configuration, joints: dict[int, int]) -> Iterator[Change]:
    """Lines in which the corrector takes motion's place."""
    new = {f"joint.{joint}.motor-pos-cmd": f"rtec.out-{axis}" for axis, joint in joints.items()}
    new |= {f"joint.{joint}.motor-pos-fb": f"rtec.drive-fb-{axis}" for axis, joint in joints.items()}
    missing = [pin for pin in new if not configuration.using(pin)]
    if missing:
        raise Code.RTC_HAL.refusal(
            f"no line nets {', '.join(missing)}",
            hint="a drive that motion does not command cannot be corrected",
            place=Place(str(configuration.ini)),
        )
    for line in configuration.hal:
        if text := _with_pins(line, new):
            yield Change("replace", line.place, text, "the drive is wired to the corrector", old=line.text)


def _with_pins(line: HalLine, new: dict[str, str]) -> str:
    """The line with pins replaced; "" where it has none of them."""
    if not any(word in new for word in line.words[1:]):
        return ""
    command, hash_mark, comment = line.text.partition("#")
    for pin, by in new.items():
        command = " ".join(by if word == pin else word for word in command.split(" "))
        command = "\t".join(by if word == pin else word for word in command.split("\t"))
    return command + hash_mark + comment


def _new_file(configuration: Configuration, joints: dict[int, int], image: Image | None) -> Iterator[Change]:
    place = Place(str(configuration.ini.parent / NEW_FILE))
    unit = mm_per_unit(configuration)
    for axis, joint in joints.items():
        letter = AXES[axis].lower()
        yield Change(
            "new", place, _net(configuration, f"joint.{joint}.pos-cmd", f"rtec.at-{axis}"), "where it is asked for"
        )
        yield Change(
            "new", place, f"net rtec-{letter}-cmd joint.{joint}.motor-pos-cmd => rtec.cmd-{axis}", "what is commanded"
        )
        yield Change(
            "new", place, f"net rtec-{letter}-fb rtec.fb-{axis} => joint.{joint}.motor-pos-fb", "what motion sees"
        )
        tool = _net(configuration, f"motion.tooloffset.{letter}", f"rtec.tool-{axis}")
        yield Change("new", place, tool, "a longer tool has a longer arm")
    yield Change("new", place, f"setp rtec.mm-per-unit {unit:g}", f"[TRAJ]LINEAR_UNITS = {units(configuration).value}")
    for pin, to, why in STATES:
        if pin == PROBE and configuration.signal_of(pin) is None:
            continue  # no probe
        yield Change("new", place, _net(configuration, pin, to), why)
    for from_, pin, why in TO_MOTION:
        if configuration.signal_of(pin) is None:
            yield Change("new", place, f"net {from_.replace('.', '-')} {from_} => {pin}", why)
    for text in _signals(len(image.bank.signals) if image and image.bank else 0, bool(image and image.blocks)):
        yield Change("new", place, text, "signals, and which program runs")


PROBE: Final = "motion.probe-input"
STATES: Final = (
    ("motion.is-all-homed", "rtec.homed", "zero while not homed: motion takes it away while a joint is homing"),
    ("motion.motion-enabled", "rtec.machine-on", "zero while the drives are off"),
    ("motion.motion-type", "rtec.motion-type", "zero while probing, unless rtec.probe-corrected"),
    ("motion.program-line", "rtec.line", "chooses the block of the table"),
    (PROBE, "rtec.touch", "latches where the tool really was"),
)


def _net(configuration: Configuration, pin: str, to: str) -> str:
    """A line that brings a pin of motion to the corrector, by the signal that it is on."""
    signal = configuration.signal_of(pin)
    return f"net {signal} => {to}" if signal else f"net {to.replace('.', '-')} {pin} => {to}"


def _command() -> str:
    """The program by its path, which a shell need not know; by its name where HAL cannot quote a blank in it."""
    program = str(Path(sys.executable).with_name("trueloop"))
    return program if len(program.split()) == 1 else "trueloop"


def _to_be_linked(changes: Sequence[Change]) -> Iterator[str]:
    """How LinuxCNC finds the program by its name."""
    if any(change.text.startswith(f"loadusr -Wn {SIGNALS_COMPONENT} trueloop ") for change in changes):
        program = Path(sys.executable).with_name("trueloop")
        yield f"HAL has no words with a blank: sudo ln -s {shlex.quote(str(program))} /usr/local/bin/trueloop"


def _signals(count: int, table: bool) -> Iterator[str]:
    if count or table:
        yield f"loadusr -Wn {SIGNALS_COMPONENT} {_command()} realtime signals SIGNALS.toml"
        yield "net rtec-heartbeat rtec-signals.heartbeat => rtec.heartbeat"
        yield "net rtec-program rtec-signals.program => rtec.program"
    for k in range(count):
        yield f"net rtec-signal-{k} rtec-signals.signal-{k} => rtec.signal-{k}"
        yield f"net rtec-age-{k} rtec-signals.age-{k} => rtec.age-{k}"


def _ini(configuration: Configuration) -> Iterator[Change]:
    last = configuration.all("HAL", "HALFILE")[-1]
    yield Change("after", last.place, f"HALFILE = {NEW_FILE}", "the new lines")
    if not configuration.value("HAL", "HALUI"):
        yield Change("after", last.place, "HALUI = halui", "rtec.pause needs halui.program.pause")


def by_file(changes: Sequence[Change]) -> dict[str, list[Change]]:
    """Changes by the file they are in, in the order of its lines."""
    files: dict[str, list[Change]] = {}
    for change in changes:
        files.setdefault(change.place.file or "", []).append(change)
    return {file: sorted(found, key=lambda change: change.place.line or 0) for file, found in files.items()}


WATCH_FILE: Final = "rtec-watch.hal"
ARROWS: Final = ("=>", "<=", "<=>")


def watching(configuration: Configuration, made: Wiring, signals: int) -> tuple[Change, ...]:
    """Makes a file of lines, to be loaded after that of the corrector. `signals`: how many the image needs.

    Raises RTC-HAL where the configuration loads a sampler of its own: it can be loaded once only.
    """
    for line in configuration.hal:
        if line.words[:2] == ("loadrt", "sampler"):
            raise Code.RTC_HAL.refusal(
                f"line {line.place.line} loads a sampler, which can be done once only: {line.text.strip()!r}",
                hint="take it out, or add the streams of the record to its `depth=` and `cfg=` by hand",
                place=line.place,
            )
    linked = dict(_linked([line.text for line in configuration.hal]))
    linked |= dict(_linked([text for change in made.changes for text in change.text.splitlines()]))
    place = Place(str(configuration.ini.parent / WATCH_FILE))
    lines = sampler_lines(sampled_pins(joints_of(configuration), signals), linked)
    last = configuration.all("HAL", "HALFILE")[-1]
    why = f"after {NEW_FILE}: `trueloop realtime watch` records every period"
    return (
        *(Change("new", place, text, "recorded in every period") for text in lines),
        Change("after", last.place, f"HALFILE = {WATCH_FILE}", why),
    )


def _linked(lines: Iterable[str]) -> Iterator[tuple[str, str]]:
    """The signal of each pin that lines net; of two lines about one pin the later one holds."""
    for text in lines:
        words = text.partition("#")[0].split()
        if words[:1] == ["net"]:
            yield from ((pin, words[1]) for pin in words[2:] if pin not in ARROWS)
