"""Sensors that publish at an MQTT broker: a topic for each signal, a number or JSON in it."""

import json
import math
import ssl
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from trueloop.controllers.linuxcnc.realtime.signals.readings import Intake, reported_s, unix_s
from trueloop.controllers.linuxcnc.realtime.signals.serial_lines import not_installed

KEEP_ALIVE_S: Final = 10
CONNECT_S: Final = 5.0
WAIT_S: Final = 0.2
LARGEST: Final = 65536


@dataclass(frozen=True)
class Topic:
    """Where a signal is published; `path` to its number in JSON and `time_path` to its time; without: the message."""

    topic: str
    path: str = ""
    time_path: str = ""
    qos: int = 0


@dataclass(frozen=True)
class Mqtt:
    """One broker. `user` and `password` are empty where it asks for none; `ca_file` empty: the system's authorities."""

    host: str
    port: int
    topics: Mapping[str, Topic]
    user: str = ""
    password: str = field(default="", repr=False)
    tls: bool = False
    ca_file: str = ""
    skew_s: float = 1.0

    def __call__(self, intake: Intake, stop: threading.Event) -> None:
        """Reads until the end. Raises `OSError` where the broker is not there, refuses or goes away."""
        client = paho()
        refused: list[str] = []
        client.on_connect = lambda client, _data, _flags, reason, _properties: self._connected(client, reason, refused)
        client.on_subscribe = lambda _client, _data, _mid, reasons, _properties: self._subscribed(reasons, intake)
        client.on_message = lambda _client, _data, message: self._take(message, intake)
        client.connect_timeout = CONNECT_S
        if self.user:
            client.username_pw_set(self.user, self.password or None)
        if self.tls:
            client.tls_set_context(ssl.create_default_context(cafile=self.ca_file or None))
        try:
            client.connect(self.host, self.port, KEEP_ALIVE_S)
            while not stop.is_set():
                lost = client.loop(WAIT_S)
                if refused or lost:
                    raise OSError(refused[0] if refused else f"the broker at {self.host}:{self.port} is gone")
        finally:
            client.disconnect()

    def _connected(self, client: Any, reason: Any, refused: list[str]) -> None:
        if reason.is_failure:
            refused.append(f"the broker at {self.host}:{self.port} refuses: {reason}")
            return
        client.subscribe([(topic.topic, topic.qos) for topic in self.topics.values()])

    def _subscribed(self, reasons: Any, intake: Intake) -> None:
        for (name, topic), reason in zip(self.topics.items(), reasons, strict=False):
            if reason.is_failure:
                intake.refuse(name, f"the broker refuses the topic {topic.topic!r}: {reason}")

    def _take(self, message: Any, intake: Intake) -> None:
        for name, topic in self.topics.items():
            if topic.topic == message.topic:
                try:
                    value, read_s = self._read(topic, message)
                except (ValueError, LookupError, TypeError, RecursionError) as error:
                    intake.refuse(name, str(error))
                else:
                    intake.put(name, value, read_s)

    def _read(self, topic: Topic, message: Any) -> tuple[float, float]:
        """The value and when it was read. A retained message without a time may be of last year."""
        now_s = time.monotonic()
        if len(message.payload) > LARGEST:
            raise ValueError(f"a message of {len(message.payload)} bytes; {LARGEST} at most are read")
        text = message.payload.decode("utf-8")
        content = json.loads(text) if topic.path or topic.time_path else float(text)
        value = number(at_path(content, topic.path))
        if topic.time_path:
            stamp_s = unix_s(at_path(content, topic.time_path))
            return value, reported_s(stamp_s, time.time(), now_s, self.skew_s)
        if message.retain:
            raise ValueError("a retained message without a time stamp: nobody knows how old it is")
        return value, now_s


def at_path(content: Any, path: str) -> Any:
    """Returns the JSON value at a path of names and list places, parted by dots. Raises `LookupError`."""
    for step in path.split(".") if path else ():
        try:
            content = content[int(step)] if isinstance(content, list) else content[step]
        except (LookupError, TypeError, ValueError):
            raise LookupError(f"{path!r} is not in {str(content)[:60]!r}") from None
    return content


def number(value: Any) -> float:
    """Returns a finite number; a text that is one counts. Raises `ValueError`."""
    if isinstance(value, bool) or not isinstance(value, (int, float, str)) or not math.isfinite(float(value)):
        raise ValueError(f"{str(value)[:40]!r} is no number")
    return float(value)


def paho() -> Any:
    """Makes a client, for which the broker keeps nothing while it is away. Raises RTC-SOURCE without paho-mqtt."""
    try:
        from paho.mqtt import client
        from paho.mqtt.enums import CallbackAPIVersion
    except ImportError as missing:
        raise not_installed("an MQTT broker", missing) from None
    return client.Client(CallbackAPIVersion.VERSION2, clean_session=True)
