"""The lines that let a run be watched: HAL's `sampler` on the corrector's pins, beside the signals that they are on."""

from collections.abc import Iterable, Iterator
from typing import Final

from trueloop.controllers.linuxcnc.realtime.configuration import Configuration
from trueloop.controllers.linuxcnc.realtime.hal_checks import joints_of
from trueloop.controllers.linuxcnc.realtime.hal_lines import NEW_FILE, Change, Wiring
from trueloop.controllers.linuxcnc.realtime.sampled import sampled_pins, sampler_lines
from trueloop.errors import Code, Place, TrueloopError

WATCH_FILE: Final = "rtec-watch.hal"
ARROWS: Final = ("=>", "<=", "<=>")


def watching(configuration: Configuration, made: Wiring, signals: int) -> tuple[Change, ...]:
    """Makes a file of lines, to be loaded after that of the corrector. `signals`: how many the image needs.

    Raises RTC-HAL where the configuration loads a sampler of its own: it can be loaded once only.
    """
    for line in configuration.hal:
        if line.words[:2] == ("loadrt", "sampler"):
            raise TrueloopError(
                Code.RTC_HAL,
                f"line {line.place.line} loads a sampler, which can be done once only: {line.text.strip()!r}",
                hint="take it out, or add the streams of the record to its `depth` and `cfg` by hand",
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
