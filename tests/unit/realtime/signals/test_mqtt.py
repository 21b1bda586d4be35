"""Sensors at a real broker."""

import json
import subprocess
import threading
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from paho.mqtt.client import Client
from paho.mqtt.enums import CallbackAPIVersion

from tests.support.mosquitto import Broker, broker
from tests.support.signals import Kept, Running, reading, until
from trueloop.controllers.linuxcnc.realtime.signals.mqtt import LARGEST, Mqtt, Topic, at_path

PLAIN = {"T1": Topic("lathe/T1")}


@contextmanager
def sensor(port: int, user: str = "", password: str = "") -> Iterator[Client]:
    """What publishes."""
    client = Client(CallbackAPIVersion.VERSION2)
    if user:
        client.username_pw_set(user, password)
    client.connect("127.0.0.1", port)
    client.loop_start()
    until(client.is_connected, "the sensor to be connected")
    try:
        yield client
    finally:
        client.disconnect()
        client.loop_stop()


def publish(client: Client, source: Running, topic: str, payload: str, name: str = "T1", *, qos: int = 0) -> None:
    """Again and again until it is read: a subscription takes a while."""

    def taken() -> bool:
        client.publish(topic, payload, qos)
        return name in source.board.readings()

    until(taken, payload)


@pytest.fixture
def server(tmp_path: Path) -> Iterator[Broker]:
    with broker(tmp_path) as running:
        yield running


@pytest.mark.parametrize("qos", [0, 1, 2])
def test_a_number_is_a_reading(server: Broker, qos: int) -> None:
    topics = {"T1": Topic("lathe/T1", qos=qos)}
    with sensor(server.port) as client, reading(Mqtt("127.0.0.1", server.port, topics)) as source:
        publish(client, source, "lathe/T1", "21.25", qos=qos)
        read = source.wait_for("T1")
        assert read.value == 21.25
        assert read.age_s(time.monotonic()) < 20


def test_numbers_are_found_in_json_with_the_time_they_were_read(server: Broker) -> None:
    topics = {"T1": Topic("box", "sensors.1.value", "at"), "T2": Topic("box", "room")}
    message = {"sensors": [{}, {"value": 21.25}], "room": "19.5", "at": time.time() - 100}
    with sensor(server.port) as client, reading(Mqtt("127.0.0.1", server.port, topics)) as source:
        publish(client, source, "box", json.dumps(message))
        assert source.wait_for("T1").value == 21.25
        assert 100 <= source.wait_for("T1").age_s(time.monotonic()) < 130
        assert source.wait_for("T2").value == 19.5
        assert source.wait_for("T2").age_s(time.monotonic()) < 30


def test_a_retained_message_is_as_old_as_it_says_or_no_reading(server: Broker) -> None:
    with sensor(server.port) as client:
        client.publish("lathe/T1", "21.25", qos=1, retain=True).wait_for_publish(10)
        stamped = json.dumps({"value": 22.5, "at": time.time() - 3600})
        client.publish("lathe/T2", stamped, qos=1, retain=True).wait_for_publish(10)
        topics = PLAIN | {"T2": Topic("lathe/T2", "value", "at")}
        with reading(Mqtt("127.0.0.1", server.port, topics)) as source:
            assert 3600 <= source.wait_for("T2").age_s(time.monotonic()) < 3630
            until(lambda: "retained" in source.reader.why("T1"))
            assert "T1" not in source.board.readings()
            client.publish("lathe/T1", "21.5")
            assert source.wait_for("T1").value == 21.5


def test_a_broker_that_goes_away_is_found_again(server: Broker) -> None:
    with reading(Mqtt("127.0.0.1", server.port, PLAIN)) as source:
        with sensor(server.port) as client:
            publish(client, source, "lathe/T1", "21.25")
        server.stop()
        until(lambda: source.said, "that the broker is gone")
        assert source.reader.is_alive()
        server.start()
        first = source.board.readings()["T1"]
        with sensor(server.port) as client:
            until(lambda: client.publish("lathe/T1", "22.5") and source.board.readings()["T1"] != first)
        assert source.wait_for("T1").value == 22.5


def test_user_and_password_are_asked_for(tmp_path: Path) -> None:
    (tmp_path / "users").write_text("lathe:secret\n")
    subprocess.run(["mosquitto_passwd", "-U", tmp_path / "users"], check=True)
    (tmp_path / "users").chmod(0o644)
    with broker(tmp_path, "allow_anonymous false", f"password_file {tmp_path / 'users'}") as server:
        asked = Mqtt("127.0.0.1", server.port, PLAIN, "lathe", "secret")
        assert "secret" not in repr(asked)
        with sensor(server.port, "lathe", "secret") as client, reading(asked) as source:
            publish(client, source, "lathe/T1", "21.25")
        for refused in (replace(asked, password="wrong"), replace(asked, user="", password="")):
            with reading(refused) as source:
                until(lambda source=source: source.said, "a refusal")  # type: ignore[misc]
                assert "refuses: Not authorized" in source.said[0]


def test_a_topic_that_may_not_be_read_is_said(tmp_path: Path) -> None:
    """With MQTT 3.1.1 mosquitto grants the subscription and sends nothing: then it stays at that."""
    intake = Kept()
    mqtt = Mqtt("127.0.0.1", 1883, {"T1": Topic("a"), "T2": Topic("b")})
    mqtt._subscribed([SimpleNamespace(is_failure=False), SimpleNamespace(is_failure=True)], intake)
    assert list(intake.refused) == ["T2"]


@pytest.mark.filterwarnings("ignore::pytest.PytestUnraisableExceptionWarning")  # paho closes no refused socket itself
def test_tls_checks_the_certificate(tmp_path: Path) -> None:
    subprocess.run(
        [
            *("openssl", "req", "-x509", "-newkey", "rsa:2048", "-nodes", "-days", "2", "-subj", "/CN=127.0.0.1"),
            *("-addext", "subjectAltName=IP:127.0.0.1", "-keyout", tmp_path / "key.pem", "-out", tmp_path / "ca.pem"),
        ],
        check=True,
        capture_output=True,
    )
    (tmp_path / "key.pem").chmod(0o644)
    lines = ("allow_anonymous true", f"certfile {tmp_path / 'ca.pem'}", f"keyfile {tmp_path / 'key.pem'}")
    with broker(tmp_path, *lines) as server:
        with reading(Mqtt("127.0.0.1", server.port, PLAIN, tls=True)) as source:
            until(lambda: source.said, "a refusal")
            assert "CERTIFICATE_VERIFY_FAILED" in source.said[0]
        trusted = Mqtt("127.0.0.1", server.port, PLAIN, tls=True, ca_file=str(tmp_path / "ca.pem"))
        with reading(trusted) as source, _secure_sensor(server.port, tmp_path / "ca.pem") as client:
            publish(client, source, "lathe/T1", "21.25")


@contextmanager
def _secure_sensor(port: int, authorities: Path) -> Iterator[Client]:
    client = Client(CallbackAPIVersion.VERSION2)
    client.tls_set(str(authorities))
    client.connect("127.0.0.1", port)
    client.loop_start()
    try:
        yield client
    finally:
        client.disconnect()
        client.loop_stop()


def message(payload: bytes, *, retain: bool = False, topic: str = "t") -> Any:
    return SimpleNamespace(topic=topic, payload=payload, retain=retain)


@pytest.mark.parametrize(
    ("topic", "payload"),
    [
        (Topic("t"), b"warm"),
        (Topic("t"), b"nan"),
        (Topic("t"), b"inf"),
        (Topic("t"), b""),
        (Topic("t"), b"\xff\xfe"),
        (Topic("t", "a"), b"{"),
        (Topic("t", "a"), b"{}"),
        (Topic("t", "a"), b'{"a": true}'),
        (Topic("t", "a"), b'{"a": null}'),
        (Topic("t", "a"), b'{"a": NaN}'),
        (Topic("t", "a"), b'{"a": [1]}'),
        (Topic("t", "a.b"), b'{"a": 1}'),
        (Topic("t", "a.2"), b'{"a": [1]}'),
        (Topic("t", "a", "at"), b'{"a": 1}'),
        (Topic("t", "a", "at"), b'{"a": 1, "at": "noon"}'),
        (Topic("t", "a", "at"), b'{"a": 1, "at": 99999999999}'),
        (Topic("t", "a"), b"[" * 100_000),
        (Topic("t"), b"1" * (LARGEST + 1)),
    ],
)
def test_what_is_no_reading_is_refused_and_ends_nothing(topic: Topic, payload: bytes) -> None:
    intake = Kept()
    Mqtt("", 0, {"T1": topic})._take(message(payload), intake)
    assert not intake.given
    assert intake.refused["T1"]


def test_a_path_goes_through_lists_and_objects() -> None:
    assert at_path({"a": [{"b": 7}]}, "a.0.b") == 7
    assert at_path(7, "") == 7


def test_two_signals_may_be_in_one_message() -> None:
    intake = Kept()
    Mqtt("", 0, {"T1": Topic("t", "a"), "T2": Topic("t", "b"), "T3": Topic("u")})._take(
        message(b'{"a": 1, "b": 2}'), intake
    )
    assert [(name, value) for name, value, _ in intake.given] == [("T1", 1.0), ("T2", 2.0)]
    assert not intake.refused


def test_a_broker_that_is_not_there_is_an_os_error() -> None:
    with pytest.raises(OSError, match="refused"):
        Mqtt("127.0.0.1", 1, PLAIN)(Kept(), threading.Event())
