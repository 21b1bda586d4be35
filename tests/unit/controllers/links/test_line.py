"""Programs over serial lines: characters by the standards' tables, and nothing lost whatever the line does."""

import os
import pty
import threading
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from scripts.line_transfers import transfer
from tests.support.serial_control import SIGNS, ZONES, eia, iso
from trueloop.controllers.links.line import EIA, Flow, Line, LineCode, Parity, decoded, encoded, framed
from trueloop.errors import Code, TrueloopError
from trueloop.jobs.links import Opened, drip, opened, send

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
            os.write(self.mine, b"\x11")
            self.reader = threading.Thread(target=self.read, daemon=True)
            self.reader.start()
        else:
            self.reader.join(10)
            os.write(self.mine, bytes(self.kept))

    def say(self, raw: bytes) -> Callable[[str], None]:
        """Puts these bytes out, whatever it is told."""

        def said(_: str) -> None:
            os.write(self.mine, raw)

        return said

    def close(self) -> None:
        self.done.set()
        os.close(self.mine)
        os.close(self.other)


@given(st.text(st.characters(min_codepoint=32, max_codepoint=126) | st.just("\n")))
def test_seven_bits_with_odd_parity_are_those_with_even_parity_and_the_eighth_bit_otherwise(text: str) -> None:
    raw = encoded(text.encode(), "odd", b"\n")
    assert list(raw) == [iso(one) ^ 0x80 for one in text]
    assert decoded(raw, "odd") == text.encode()


@pytest.mark.parametrize("parity", ["even", "odd"])
def test_parity_of_a_line_of_seven_bits_is_checked_here(parity: Parity) -> None:
    """pyserial leaves it unchecked: a bit that falls over would make another number."""
    terminal = Terminal()
    eighth = 0x80 if parity == "odd" else 0
    raw = bytearray(iso(one) ^ eighth for one in "%\nX1\n%")
    raw[3] ^= 2
    line = Line(terminal.name, 38400, 7, parity, silence_s=5, tell=terminal.say(bytes(raw)))
    try:
        with pytest.raises(TrueloopError, match="line 2, column 2") as refused:
            line.read("O1")
    finally:
        terminal.close()
    assert refused.value.code is Code.LNK_CODE


def test_of_two_programs_that_come_the_first_whole_one_is_taken() -> None:
    """The port was opened in the middle of the first: its end is no beginning."""
    terminal = Terminal()
    came = b"X9\nM30\n%\n\0\0\x14\x12\0%\nO2\nM2\n%\n"
    line = Line(terminal.name, 38400, 8, "none", silence_s=5, tell=terminal.say(came))
    try:
        assert line.read("O2") == b"%\nO2\nM2\n%\n"
    finally:
        terminal.close()


@pytest.mark.parametrize("text", [b"O1\n(FEED 50%)\nM30\n", b"%\nO1\n% (FEED)\nM30\n%\n"])
def test_an_end_mark_within_a_program_is_refused_before_the_first_byte(text: bytes) -> None:
    with pytest.raises(TrueloopError, match="'%' within") as refused:
        Line("/dev/no-such-port").send("O1", text)
    assert refused.value.code is Code.LNK_CODE and refused.value.values["line"] == 2


def test_nothing_is_sent_before_the_control_reads() -> None:
    terminal = Terminal()
    line = Line(terminal.name, 38400, 8, "none", silence_s=0.3, tell=lambda _: None)
    try:
        with pytest.raises(TrueloopError, match="no XON came, none of") as refused:
            line.send("O1", PROGRAM)
        os.set_blocking(terminal.mine, False)
        with pytest.raises(BlockingIOError):
            os.read(terminal.mine, 1)
    finally:
        terminal.close()
    assert refused.value.code is Code.LNK_LINE


@pytest.mark.parametrize(("flow", "await_xon"), [("none", True), ("xon-xoff", False)])
def test_a_program_is_fed_only_where_the_control_says_that_it_begins(flow: Flow, await_xon: bool) -> None:
    with pytest.raises(TrueloopError, match="in mid-program"):
        Line("/dev/no-such-port", flow=flow, await_xon=await_xon).feed("O1", PROGRAM)


def test_a_port_that_goes_away_while_it_is_written_to_is_named() -> None:
    terminal = Terminal()

    def tell(_: str) -> None:
        os.write(terminal.mine, b"\x11")
        threading.Timer(0.2, terminal.close).start()

    line = Line(terminal.name, 300, 8, "none", silence_s=20, tell=tell)
    with pytest.raises(TrueloopError, match=r"the line broke after \d+ of") as refused:
        line.send("O1", PROGRAM * 20)
    assert refused.value.code is Code.LNK_LINE


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
