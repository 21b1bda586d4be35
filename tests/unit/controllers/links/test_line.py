"""Programs over serial lines: characters by the standards' tables, and nothing lost whatever the line does."""

import os
import pty
import threading
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scripts.line_transfers import transfer
from tests.support.serial_control import SIGNS, ZONES, eia, iso
from trueloop.controllers.links.line.codes import EIA, LineCode, decoded, encoded
from trueloop.controllers.links.line.line import Line, framed
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.links.by_line import drip
from trueloop.jobs.links.opened import Opened, opened
from trueloop.jobs.links.send import send

IN_EIA = "".join(ZONES) + "".join(SIGNS)
PROGRAM = b"O1\nG1 X1.5 Z-2\nM30\n"
CODES = {
    "none": {"sent"},
    "nul": {"sent"},
    "held for ever": {"LNK-LINE"},
    "cut sending": {"LNK-LINE"},
    "cut receiving": {"LNK-LINE"},
    "answers": {"LNK-LINE"},
    "noise": {"LNK-CODE", "LNK-DIFFERS", "LNK-LINE"},
    "edited": {"LNK-DIFFERS"},
}


def test_every_eia_character_is_that_of_its_zone_and_digit_with_odd_parity() -> None:
    assert {one: EIA[one] for one in IN_EIA} == {one: eia(one) for one in IN_EIA}
    assert all(byte.bit_count() % 2 for byte in EIA.values())
    assert len(set(EIA.values())) == len(EIA)


@given(st.text(st.characters(min_codepoint=32, max_codepoint=126) | st.just("\n")))
def test_what_is_sent_in_iso_has_even_parity_and_comes_back(text: str) -> None:
    raw = encoded(text.encode(), "iso", b"\n")
    assert list(raw) == [iso(one) for one in text]
    assert decoded(raw, "iso") == text.encode()


@given(st.text(st.sampled_from(IN_EIA)))
def test_what_is_sent_in_eia_comes_back(text: str) -> None:
    assert decoded(bytes(map(eia, text)), "eia") == text.encode()
    assert encoded(text.encode(), "eia") == bytes(map(eia, text))


@pytest.mark.parametrize(
    ("text", "code", "place"),
    [(b"G1\nX#1", "eia", (2, 2)), (b"G1 (\xe4)", "iso", (1, 5)), (b"\x0cM2", "ascii", (1, 1))],
)
def test_a_character_that_the_code_has_not_is_named_by_its_place(
    text: bytes, code: str, place: tuple[int, int]
) -> None:
    with pytest.raises(TrueloopError) as refused:
        encoded(text, code)  # type: ignore[arg-type]
    assert refused.value.code is Code.LNK_CODE
    assert (refused.value.values["line"], refused.value.values["column"]) == place


def test_a_byte_of_wrong_parity_is_named_by_its_place() -> None:
    raw = bytearray(map(iso, "%\nG1 X1\n%"))
    raw[5] ^= 4
    with pytest.raises(TrueloopError, match="line 2, column 4: the byte 0x"):
        decoded(bytes(raw), "iso")


@pytest.mark.parametrize("text", [PROGRAM, b"%\n" + PROGRAM + b"%\n", b"%\r\nO1\r\nG1 X1.5 Z-2\r\nM30\r\n%"])
def test_a_program_stands_between_two_percent_signs(text: bytes) -> None:
    assert framed(text) == b"%\nO1\nG1 X1.5 Z-2\nM30\n%\n"


def test_whatever_the_line_does_nothing_is_lost_and_each_failure_named(tmp_path: Path) -> None:
    seen = set()
    for seed in range(160):
        fault, outcome, wrong = transfer(seed, tmp_path)
        assert not wrong and outcome in CODES[fault], (seed, fault, outcome, wrong)
        seen.add(fault)
    assert seen == set(CODES)


class Terminal:
    """The other end of a pseudoterminal: keeps what comes, and puts it out when told."""

    def __init__(self, end: bytes = b"%") -> None:
        self.end = end
        self.mine, other = pty.openpty()
        self.name, self.other = os.ttyname(other), other
        self.kept = bytearray()
        self.done = threading.Event()

    def read(self) -> None:
        while self.kept.count(self.end) < 2 and not self.done.is_set():
            self.kept += os.read(self.mine, 64)

    def tell(self, said: str) -> None:
        if "read now" in said:
            self.reader = threading.Thread(target=self.read, daemon=True)
            self.reader.start()
        else:
            self.reader.join(10)
            os.write(self.mine, bytes(self.kept))

    def close(self) -> None:
        self.done.set()
        os.close(self.mine)
        os.close(self.other)


@pytest.mark.parametrize("code", ["ascii", "iso", "eia"])
def test_a_real_port_carries_a_program_there_and_back(tmp_path: Path, code: LineCode) -> None:
    terminal = Terminal(encoded(b"%", code))
    line = Line(terminal.name, 38400, 8, "none", 1, code=code, silence_s=20, tell=terminal.tell)
    try:
        done = send(Opened("old", line, frozenset(), tmp_path), PROGRAM, "O1")
    finally:
        terminal.close()
    assert done.written and done.kept is None


def test_what_is_replaced_comes_out_first_and_is_kept(tmp_path: Path) -> None:
    terminal = Terminal()
    terminal.kept += b"%\nO1\nM2\n%\n"
    terminal.reader = threading.Thread(target=lambda: None)
    terminal.reader.start()
    told = []

    def tell(said: str) -> None:
        told.append(said)
        if "read now" in said:
            terminal.kept.clear()
        terminal.tell(said)

    line = Line(terminal.name, 38400, 8, "none", 1, silence_s=20, tell=tell)
    control = Opened("old", line, frozenset(), tmp_path)
    try:
        with pytest.raises(TrueloopError) as refused:
            send(control, PROGRAM, "O1", replace=True)
        assert refused.value.code is Code.LNK_RUNNING and told == []
        done = send(control, PROGRAM, "O1", replace=True, not_running=True)
    finally:
        terminal.close()
    assert done.kept is not None and done.kept.read_bytes() == b"%\nO1\nM2\n%\n"
    assert [one.split()[0] for one in told] == ["have", "let", "have"]


def test_settings_name_a_line_and_only_a_line_is_fed(tmp_path: Path) -> None:
    settings = tmp_path / "links.toml"
    settings.write_text('[serial.old]\nport = "/dev/ttyS9"\ncode = "iso"\n[folder.new]\nfolder = "nc"\n')
    found = opened(settings, "old").link
    assert isinstance(found, Line) and (found.port, found.code, found.baud) == ("/dev/ttyS9", "iso", 9600)
    with pytest.raises(TrueloopError, match="takes whole programs"):
        drip(opened(settings, "new"), PROGRAM, "O1")
