"""What an agent holds, read over HTTP without a gap: `/probe`, `/current`, then `/sample` from number to number.

An agent that was started anew numbers from the beginning, and one that is asked too late no longer has what was missed:
both are told, and reading goes on with what is current.
"""

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Final
from urllib.error import HTTPError

from trueloop.controllers.linuxcnc.realtime.signals.mtconnect import (
    LARGEST,
    Current,
    Observation,
    fetched,
    is_address,
    read_current,
)
from trueloop.errors import Code, TrueloopError

AT_ONCE: Final = 500
EVERY_S: Final = 0.5
LEVELS: Final = ("Normal", "Warning", "Fault", "Unavailable")

Say = Callable[[str], None]


@dataclass(frozen=True)
class Item:
    """A data item as the device model has it; without one, as far as its observations tell."""

    id: str
    name: str = ""
    type: str = ""
    units: str = ""


@dataclass(frozen=True)
class Seen:
    """An observation with its item. `value`: as the agent says it, of a condition its level."""

    item: Item
    stamp: str
    sequence: int
    value: str


def read(url: str, until: Callable[[], bool], say: Say, stop: threading.Event | None = None) -> Iterator[Seen]:
    """What is current, then what comes, until `until` says so: it is asked after every answer.

    Raises MTC-AGENT where the agent does not answer, or not as one.
    """
    _require_address(url)
    stop, url = stop or threading.Event(), url.rstrip("/")
    items = {one["id"]: _item(one) for one in _asked(f"{url}/probe").items}
    answer = _asked(f"{url}/current")
    while True:
        yield from _seen(answer, items)
        following, instance = _next(url, answer), answer.header.get("instanceId", "")
        if until() or stop.wait(0.0 if len(answer.all) >= AT_ONCE else EVERY_S):
            return
        answer = _asked(f"{url}/sample?from={following}&count={AT_ONCE}", may_refuse=True)
        if answer.errors or answer.header.get("instanceId", "") != instance:
            answer = _anew(url, following, instance, say)


def for_seconds(seconds: float) -> Callable[[], bool]:
    """Whether so long has passed since this call."""
    end = time.monotonic() + seconds
    return lambda: time.monotonic() >= end


def _anew(url: str, following: int, instance: str, say: Say) -> Current:
    """Begins again at what is current, and says what was missed."""
    answer = _asked(f"{url}/current")
    first = answer.header.get("firstSequence", "?")
    if answer.header.get("instanceId", "") != instance:
        say(f"{url}: the agent was started anew: its numbers begin again")
    else:
        say(f"{url}: from {following} on the agent no longer has all: it begins at {first}; what is current is taken")
    return answer


def _asked(url: str, *, may_refuse: bool = False) -> Current:
    try:
        try:
            document = fetched(url)
        except HTTPError as refusal:  # newer agents refuse with a status; what they say is in the body all the same
            with refusal:
                document = refusal.read(LARGEST)
            if not read_current(document).errors:
                raise
        answer = read_current(document)
    except OSError as error:
        raise _refused(url, str(error)) from error
    if not answer.header:
        raise _refused(url, "the answer has no Header: it is none of an agent")
    if answer.errors and not may_refuse:
        raise _refused(url, "; ".join(f"{code} {text}".strip() for code, text in answer.errors))
    return answer


def _next(url: str, answer: Current) -> int:
    following = answer.header.get("nextSequence", "")
    if not following.isdecimal():
        raise _refused(url, f"nextSequence is {following[:40]!r}, no number")
    return int(following)


def _seen(answer: Current, items: Mapping[str, Item]) -> Iterator[Seen]:
    for one in sorted(answer.all, key=lambda one: one.sequence):
        value = one.kind.upper() if one.kind in LEVELS else one.text
        yield Seen(items.get(one.item) or _unknown(one), one.stamp, one.sequence, value)


def _unknown(one: Observation) -> Item:
    return Item(one.item, one.name, one.kind)


def _item(given: Mapping[str, str]) -> Item:
    return Item(given["id"], given.get("name", ""), given.get("type", ""), given.get("units", ""))


def _require_address(url: str) -> None:
    if not is_address(url):
        raise _refused(url, "it is no address of an agent, such as http://10.0.0.7:5000/lathe")


def _refused(url: str, why: str) -> TrueloopError:
    return TrueloopError(
        Code.MTC_AGENT,
        f"{url}: {why}",
        hint="open the address in a browser: an agent shows its devices there",
        values={"url": url},
    )
