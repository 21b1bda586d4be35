"""A device at a serial port, played at the far end of a pseudo-terminal."""

import os
import pty
import re
import termios
import threading
import tty
from collections.abc import Iterator
from pathlib import Path

import pytest

from tests.support.signals import Running, reading, until
from trueloop.controllers.linuxcnc.realtime.signals.serial_lines import LONGEST_LINE, LinePart, SerialLines


@pytest.fixture
def line() -> Iterator[tuple[int, str]]:
    """The device's end, and the name of the port."""
    device, port = pty.openpty()
    tty.setraw(device)
    tty.setraw(port)
    yield device, os.ttyname(port)
    for end in (device, port):
        os.close(end)


COLUMNS = {"T1": LinePart(column=1), "T2": LinePart(column=3)}


def _say(device: int, *lines: str) -> None:
    for text in lines:
        os.write(device, text.encode())


def test_columns_of_a_line_are_signals(line: tuple[int, str]) -> None:
    device, port = line
    with reading(SerialLines(port, 9600, COLUMNS)) as source:
        _speak_until_read(device, source, "x\r\n21.5,ok,-3.25\r\n")
        assert source.wait_for("T1").value == 21.5
        assert source.wait_for("T2").value == -3.25


def _speak_until_read(device: int, source: Running, text: str) -> None:
    """What is sent before the port is open is thrown away with what the port held."""

    def spoken() -> bool:
        _say(device, text)
        return bool(source.board.readings())

    until(spoken, text)


def test_a_pattern_finds_the_number() -> None:
    part = LinePart(re.compile(r"\bT2=([-+.\d]+)C"))
    assert part.value("T1=20.0C T2=-21.25C") == -21.25
    assert part.value("T1=20.0C") is None
    assert part.value("T2=-.-C") is None


@pytest.mark.parametrize("text", ["", "20.1", "20.1,", "a,b,c", ",,", "1,2,--"])
def test_a_line_that_lacks_the_number_is_no_reading(text: str) -> None:
    assert LinePart(column=3).value(text) is None


def test_what_begins_in_the_middle_of_a_line_is_no_reading(line: tuple[int, str]) -> None:
    """`…21.5` cut off is 1.5 °C: a number, and wrong."""
    device, port = line
    kept = _given_by(port, device, "1.5\n21.7\n")
    assert kept[0] == 21.7


def _given_by(port: str, device: int, text: str) -> list[float]:
    """Readings in their order of what is sent once the port is being read."""
    values: list[float] = []
    opened, stop = threading.Event(), threading.Event()

    class Intake:
        def put(self, name: str, value: float, time_s: float) -> None:
            values.append(value)
            stop.set()

        def refuse(self, name: str, why: str) -> None: ...

    class Watched(SerialLines):
        def _read(self, port: object, intake: object, stop: threading.Event) -> None:
            opened.set()
            super()._read(port, intake, stop)  # type: ignore[arg-type]

    thread = threading.Thread(target=Watched(port, 9600, {"T1": LinePart()}), args=(Intake(), stop), daemon=True)
    thread.start()
    assert opened.wait(10)
    while not stop.wait(0.05):
        os.write(device, text.encode())
    thread.join(10)
    return values


def test_a_line_without_end_is_thrown_away(line: tuple[int, str]) -> None:
    device, port = line
    with reading(SerialLines(port, 115200, {"T1": LinePart()})) as source:
        _speak_until_read(device, source, "x\n1.0\n")
        for _ in range(3 * LONGEST_LINE // 1000):
            os.write(device, b"9" * 1000)
        os.write(device, b"9\n7.25\n")
        assert source.wait_for("T1", lambda one: one.value != 1.0).value == 7.25


def test_a_device_is_asked_where_it_wants_to_be(line: tuple[int, str]) -> None:
    device, port = line
    with reading(SerialLines(port, 9600, {"T1": LinePart()}, ask="R\r\n", every_s=0.05)) as source:
        for answer in (b"20.5\r\n", b"20.75\r\n"):
            assert os.read(device, 3) == b"R\r\n"
            os.write(device, answer)
        assert source.wait_for("T1", lambda one: one.value == 20.75)


def test_a_port_that_is_not_there_is_said_once_and_tried_again(line: tuple[int, str], tmp_path: Path) -> None:
    device, port = line
    link = tmp_path / "port"
    with reading(SerialLines(str(link), 9600, {"T1": LinePart()})) as source:
        until(lambda: source.said, "a refusal")
        link.symlink_to(port)
        _speak_until_read(device, source, "x\n19.5\n")
        assert source.wait_for("T1").value == 19.5
        assert len([said for said in source.said if "tried again" in said]) == 1
        assert "is read again" in source.said[-1]


def test_a_device_that_goes_away_ends_nothing(line: tuple[int, str]) -> None:
    device, port = line
    with Path("/dev/null").open() as null, reading(SerialLines(port, 9600, {"T1": LinePart()})) as source:
        _speak_until_read(device, source, "x\n19.5\n")
        os.dup2(null.fileno(), device)
        until(lambda: source.said, "that it went away")
        assert source.reader.is_alive()
        assert source.board.readings()["T1"].value == 19.5


def test_what_the_system_says_of_a_port_is_an_os_error() -> None:
    with pytest.raises((OSError, ValueError)):
        SerialLines("/dev/null", 9600, {})(None, threading.Event())  # type: ignore[arg-type]
    assert not issubclass(termios.error, OSError)
