"""Sensors of a machine that an MTConnect agent reports, asked for over HTTP.

An agent passes on only what changes [MTConnect part 1]: the time stamp of a steady temperature is old although the
value holds. A source says whether ages count from the stamp or, the agent vouching for the value until it says
UNAVAILABLE, from when it was asked.
"""

import threading
import time
import urllib.request
from collections.abc import Mapping
from dataclasses import dataclass, field
from http.client import HTTPException
from typing import Final
from urllib.parse import urlsplit
from xml.parsers import expat

from trueloop.controllers.linuxcnc.realtime.signals.mqtt import number
from trueloop.controllers.linuxcnc.realtime.signals.readings import Intake, reported_s, unix_s, wait

LARGEST: Final = 4_000_000
TIMEOUT_S: Final = 3.0
CHUNK: Final = 65536
UNAVAILABLE: Final = "UNAVAILABLE"

OPENER: Final = urllib.request.build_opener(urllib.request.ProxyHandler({}))
"""An agent stands in the machine's own network."""


@dataclass(frozen=True)
class Observation:
    """An agent's report of one data item. `kind` is the element's name: the type, for a condition its level."""

    text: str
    stamp: str
    item: str = ""
    name: str = ""
    kind: str = ""
    sequence: int = 0


@dataclass(frozen=True)
class Current:
    """An answer: when the agent made it, by its clock, and the latest observations by `dataItemId`.

    `all`: every one, as they come. `header`: its attributes. `errors`: code and text of each. `items`: attributes of
    each data item that a device model lists.
    """

    created: str
    observations: Mapping[str, Observation]
    all: tuple[Observation, ...] = ()
    header: Mapping[str, str] = field(default_factory=dict)
    errors: tuple[tuple[str, str], ...] = ()
    items: tuple[Mapping[str, str], ...] = ()


@dataclass(frozen=True)
class MtConnect:
    """One agent. `items` are data items by signal; `held`: a value holds until the agent says it does not."""

    url: str
    items: Mapping[str, str]
    every_s: float = 1.0
    held: bool = False
    skew_s: float = 1.0

    def __call__(self, intake: Intake, stop: threading.Event) -> None:
        """Asks for what is current until the end. Raises `OSError` where the agent does not answer, or not as one."""
        created_s = float("-inf")
        while not stop.is_set():
            asked_s = time.monotonic()
            current = read_current(fetched(f"{self.url.rstrip('/')}/current"))
            now_s = _agents_time(current)
            if now_s > created_s:  # else a cache answered once more
                self._take(current, now_s, asked_s, intake)
            created_s = now_s
            wait(stop, asked_s, self.every_s)

    def _take(self, current: Current, agent_now_s: float, asked_s: float, intake: Intake) -> None:
        for name, item in self.items.items():
            seen = current.observations.get(item)
            try:
                value, stamp_s = _value(item, seen)
                stamp_s = max(stamp_s, agent_now_s) if self.held else stamp_s
                read_s = reported_s(stamp_s, agent_now_s, asked_s, self.skew_s)
            except ValueError as error:
                intake.refuse(name, str(error))
            else:
                intake.put(name, value, read_s)


def _agents_time(current: Current) -> float:
    try:
        return unix_s(current.created)
    except ValueError as error:
        raise OSError(f"the agent does not say when it answered: {error}") from error


def _value(item: str, observation: Observation | None) -> tuple[float, float]:
    """Returns value and time of an item. Raises `ValueError`."""
    if observation is None:
        raise ValueError(f"the agent reports no data item {item!r}")
    if observation.text.upper() == UNAVAILABLE:
        raise ValueError(f"{item!r} is UNAVAILABLE")
    return number(observation.text), unix_s(observation.stamp)


def fetched(url: str) -> bytes:
    """Fetches a server's answer, all of it within some seconds. Raises `OSError`."""
    last_s, parts = time.monotonic() + 2 * TIMEOUT_S, []
    try:
        with OPENER.open(url, timeout=TIMEOUT_S) as answer:
            while part := answer.read1(CHUNK):
                parts.append(part)
                if time.monotonic() > last_s or sum(map(len, parts)) > LARGEST:
                    raise OSError(f"{url} sends for longer than {2 * TIMEOUT_S:g} s, or more than {LARGEST} bytes")
    except HTTPException as error:
        raise OSError(f"{url}: {type(error).__name__} {error}") from error
    return b"".join(parts)


def read_current(document: bytes) -> Current:
    """Parses an agent's answer. Raises `OSError` for anything else, and a DOCTYPE: its entities may be of any size."""
    reader = _Reader()
    try:
        reader.parser.Parse(document, True)
    except expat.ExpatError as error:
        raise OSError(f"the agent's answer is no whole XML: {error}") from error
    found = {seen.item: seen for seen in reader.all}
    created = reader.header.get("creationTime", "")
    return Current(
        created=created,
        observations=found,
        all=tuple(reader.all),
        header=reader.header,
        errors=tuple(reader.errors),
        items=tuple(reader.items),
    )


class _Reader:
    def __init__(self) -> None:
        self.header, self.items = dict[str, str](), list[Mapping[str, str]]()
        self.all, self.errors = list[Observation](), list[tuple[str, str]]()
        self._of: tuple[str, dict[str, str]] = "", {}
        self._text: list[str] = []
        self.parser = expat.ParserCreate(namespace_separator=" ")
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end
        self.parser.CharacterDataHandler = self._text.append
        self.parser.StartDoctypeDeclHandler = self._doctype

    def _start(self, name: str, attributes: dict[str, str]) -> None:
        kind = name.rpartition(" ")[2]
        if kind == "Header":
            self.header = attributes
        elif kind == "DataItem" and "id" in attributes:
            self.items.append(attributes)
        self._of = kind, attributes
        self._text.clear()

    def _end(self, _name: str) -> None:
        kind, given = self._of
        text = "".join(self._text).strip()
        if item := given.get("dataItemId"):
            sequence = given.get("sequence", "")
            number = int(sequence) if sequence.isdecimal() else 0
            self.all.append(
                Observation(
                    text=text,
                    stamp=given.get("timestamp", ""),
                    item=item,
                    name=given.get("name", ""),
                    kind=kind,
                    sequence=number,
                )
            )
        elif kind == "Error":
            self.errors.append((given.get("errorCode", ""), text))
        self._of = "", {}
        self._text.clear()

    def _doctype(self, *_: object) -> None:
        raise OSError("the agent's answer has a DOCTYPE, which no agent needs")


def is_address(url: str) -> bool:
    """Returns whether a text names a server by http or https."""
    parts = urlsplit(url)
    return parts.scheme in ("http", "https") and bool(parts.hostname)
