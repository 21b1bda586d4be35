"""Characters of a program as a serial line carries them: ASCII, ISO with even parity, EIA (RS-244) with odd parity.

Parity is computed here, not by the port: pyserial leaves the check of received characters switched off.

ISO 646 has seven bits and an eighth that makes their number even; EIA has channel 5 for an odd number. EIA knows
neither small letters nor `#`, `=`, `*`, brackets: a program that needs them cannot go over such a line.
"""

from collections.abc import Mapping
from typing import Final, Literal

from trueloop.errors import Code, TrueloopError

LineCode = Literal["ascii", "iso", "eia"]
WireCode = Literal["ascii", "iso", "odd", "eia"]
"""How characters stand on the line; iso and odd: seven bits, and an eighth for an even or an odd number."""
EIA: Final[Mapping[str, int]] = {
    **dict(zip("1234567890", bytes.fromhex("01021304151607081920"), strict=True)),
    **dict(zip("ABCDEFGHI", bytes.fromhex("616273647576676879"), strict=True)),
    **dict(zip("JKLMNOPQR", bytes.fromhex("515243544546575849"), strict=True)),
    **dict(zip("STUVWXYZ", bytes.fromhex("3223342526373829"), strict=True)),
    **dict(zip(" .,/+-&()\t%\n", bytes.fromhex("106b3b3170400e1a4a3e0b80"), strict=True)),
}
"""By what it stands for; `%` is EIA's end of record, a line feed its end of block."""
_FROM_EIA: Final = {byte: character for character, byte in EIA.items()}
_SKIPPED: Final[Mapping[WireCode, bytes]] = {
    "ascii": b"\x00\x7f\x11\x12\x13\x14\r",
    "iso": b"\x00\xff\x11\x12\x93\x14\x8d",
    "odd": b"\x00\x80\x7f\x91\x92\x13\x94\r",
    "eia": b"\x00\x7f\x11\x12\x14",
}
"""What carries nothing: leader, rubbed-out characters, device controls, carriage returns."""


def encoded(text: bytes, code: WireCode, line_end: bytes = b"\r\n") -> bytes:
    """A program of ASCII text as it goes over the line. Raises LNK-CODE for a character that the code does not have.

    EIA's end of block is one character, whatever `line_end` is.
    """
    line, column = 1, 0
    out = bytearray()
    for character in text.decode("latin-1").replace("\r\n", "\n").replace("\r", "\n"):
        column += 1
        byte = _byte(character, code, line_end)
        if byte is None:
            raise wrong(f"{character!r} cannot be sent in {_NAMES[code]}", line, column)
        out += byte
        if character == "\n":
            line, column = line + 1, 0
    return bytes(out)


def decoded(raw: bytes, code: WireCode) -> bytes:
    """What came over the line as ASCII text, its line ends LF. Raises LNK-CODE for a byte that is no character."""
    out = bytearray()
    for byte in raw:
        if byte in _SKIPPED[code]:
            continue
        character = _character(byte, code)
        if character is None:
            line, column = out.count(b"\n") + 1, len(out) - (out.rfind(b"\n") + 1) + 1
            raise wrong(f"the byte 0x{byte:02X} is no character of {_NAMES[code]}", line, column)
        out += character.encode("ascii")
    return bytes(out)


def blank(code: WireCode) -> bytes:
    """The bytes that stand between two programs: leader, rubbed-out characters, device controls, line ends."""
    return _SKIPPED[code] + encoded(b"\n", code, b"\n")


def leader(code: WireCode, count: int) -> bytes:
    """So many characters NUL, blank tape."""
    return bytes(count) if code != "odd" else b"\x80" * count


_NAMES: Final[Mapping[WireCode, str]] = {
    "ascii": "ASCII",
    "iso": "seven bits with even parity (ISO)",
    "odd": "seven bits with odd parity",
    "eia": "EIA code",
}


def _byte(character: str, code: WireCode, line_end: bytes) -> bytes | None:
    if code == "eia":
        byte = EIA.get(character.upper())
        return None if byte is None else bytes([byte])
    if not (character in "\t\n" or " " <= character <= "~"):
        return None
    plain = line_end if character == "\n" else character.encode("ascii")
    return plain if code == "ascii" else bytes(_with_parity(byte, code) for byte in plain)


def _character(byte: int, code: WireCode) -> str | None:
    if code == "eia":
        return _FROM_EIA.get(byte)
    if code != "ascii" and byte != _with_parity(byte & 0x7F, code):
        return None
    character = chr(byte if code == "ascii" else byte & 0x7F)
    return character if character in "\t\n" or " " <= character <= "~" else None


def _with_parity(byte: int, code: WireCode) -> int:
    return byte | 0x80 if byte.bit_count() % 2 == (code == "iso") else byte


def wrong(what: str, line: int, column: int) -> TrueloopError:
    """LNK-CODE."""
    return TrueloopError(
        Code.LNK_CODE,
        f"line {line}, column {column}: {what}",
        hint="compare `code`, `baud` and `parity` in the settings of this link with those of the control",
        values={"line": line, "column": column},
    )
