"""A good image, and files made of it that are none, by what should be said of each.

Hashes are made anew where the hash is not the point, so that the reader comes as far as the fault.
"""

import hashlib
import struct
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.domain.record import sha256_of
from trueloop.formats.realtime.image_file import image_to_bytes
from trueloop.realtime.image import Bank, Block, Body, Identity, Image, RealTimeLimits, Signal

SERIAL: Final = "4711"
PROGRAM: Final = b"N10 G1 X50 Z-10 F100\nN20 Z-30\nM2\n"
WORDS = 1024
LIMITS, TOOL, SIGNAL, SLOPES = 0, 8, 11, 16
"""Where groups of the good image begin, in words; one signal, one body, two blocks."""
BODY = SLOPES + 19
BREAKS = BODY + 11
TABLES = BREAKS + 3
PER_UNIT = TABLES + 24
BLOCKS = PER_UNIT + 26
ROWS = BLOCKS + 7


def good_image() -> Image:
    """A lathe with one temperature, whose Z grows, and a table of two blocks."""
    rng = np.random.default_rng(19)
    shape = (1, 2, 2, 6)
    body = Body(
        2,
        np.array([-300.0, -100.0, 0.0]),
        rng.normal(0, 1e-3, shape) * [[[[1, 1, 1, 1e-3, 1e-3, 1e-3]], [[1e-2] * 3 + [1e-5] * 3]]],
        ((0, rng.normal(0, 1e-5, shape)),),
        np.array([0.0, 0.0, 120.0]),
        np.array([1.0, 0.0, 0.0]),
    )
    signal = Signal("T1", "°C", 20.0, 15.0, 35.0, 2.0)
    bank = Bank((signal,), (body,), rng.normal(0, 1e-6, (2, 3, 3)), (0.0, 0.0, -50.0))
    blocks = (
        Block(1, np.array([[25.0, 0.0, 0.01, 0.0], [25.0, -10.0, 0.012, 0.001]])),
        Block(2, np.array([[25.0, -10.0, 0.012, 0.001], [25.0, -20.0, 0.0, 0.0], [25.0, -30.0, -0.01, 0.0]])),
    )
    identity = Identity("lathe", SERIAL, sha256_of(b"model"), "part.ngc", sha256_of(PROGRAM), "0123456789abcdef")
    limits = RealTimeLimits(((0.0, 200.0), (-0.15, 0.15), (-300.0, 0.0)), 0.15, 0.1)
    return Image(identity, limits, bank, blocks)


def rehashed(content: bytes) -> bytes:
    """The same with the hash of what it holds."""
    return content[:32] + hashlib.sha256(content[64:]).digest() + content[64:]


def sized(content: bytes) -> bytes:
    """The same with its own length in the head."""
    return content[:16] + struct.pack("<Q", len(content)) + content[24:]


def _word(number: int, value: float) -> Callable[[bytes], bytes]:
    """One word changed."""
    at = WORDS + 8 * number

    def changed(content: bytes) -> bytes:
        return rehashed(content[:at] + struct.pack("<d", value) + content[at + 8 :])

    return changed


def _flipped(content: bytes) -> bytes:
    """One bit of the last word."""
    return content[:-1] + bytes([content[-1] ^ 1])


def _other_serial(_: bytes) -> bytes:
    good = good_image()
    return image_to_bytes(replace(good, identity=replace(good.identity, serial="4712")))


def _other_program(_: bytes) -> bytes:
    good = good_image()
    return image_to_bytes(replace(good, identity=replace(good.identity, program_sha256=sha256_of(b"another"))))


BAD: Final[Mapping[str, tuple[str, Callable[[bytes], bytes]]]] = {
    "nothing in it": ("empty", lambda good: b""),
    "text": ("magic", lambda good: b"G21\nM2\n"),
    "another magic": ("magic", lambda good: b"TLRTEC\n\0" + good[8:]),
    "a head alone": ("short", lambda good: good[:1000]),
    "magic alone": ("short", lambda good: good[:8]),
    "version 2": ("version", lambda good: good[:8] + struct.pack("<I", 2) + good[12:]),
    "a longer head": ("version", lambda good: good[:12] + struct.pack("<I", 1032) + good[16:]),
    "half a file": ("short", lambda good: good[: len(good) // 2]),
    "a byte less": ("short", lambda good: good[:-1]),
    "a byte more": ("long", lambda good: good + b"\0"),
    "a word more": ("long", lambda good: good + bytes(8)),
    "three bytes more that the head knows of": ("odd", lambda good: rehashed(sized(good + bytes(3)))),
    "a bit flipped": ("hash", _flipped),
    "another name over the same hash": ("hash", lambda good: good[:64] + b"other" + good[69:]),
    "another machine": ("serial", _other_serial),
    "a table for another program": ("program", _other_program),
    "a correction that is NaN": ("not finite", _word(ROWS + 2, float("nan"))),
    "a power that is infinite": ("not finite", _word(TABLES, float("inf"))),
    "a limit that is minus infinite": ("not finite", _word(LIMITS, float("-inf"))),
    "a word that nothing asks for": ("count", lambda good: rehashed(sized(good + bytes(8)))),
    "a word too few": ("count", lambda good: rehashed(sized(good[:-8]))),
    "17 signals": ("count", _word(SIGNAL, 17.0)),
    "half a signal": ("count", _word(SIGNAL, 0.5)),
    "9 bodies": ("count", _word(BODY - 1, 9.0)),
    "axis 3": ("count", _word(BODY, 3.0)),
    "1 break": ("count", _word(BODY + 1, 1.0)),
    "2 tables": ("count", _word(BODY + 2, 2.0)),
    "9 powers": ("count", _word(BODY + 3, 9.0)),
    "0 powers": ("count", _word(BODY + 3, 0.0)),
    "as many powers as nothing holds": ("count", _word(BODY + 1, 1e300)),
    "2 dependents of 1 signal": ("count", _word(BODY + 4, 2.0)),
    "a signal that there is not": ("count", _word(PER_UNIT, 1.0)),
    "minus one block": ("count", _word(BLOCKS - 1, -1.0)),
    "a block of one row": ("count", _word(BLOCKS + 2, 1.0)),
    "a block outside the table": ("count", _word(BLOCKS + 4, 3.0)),
    "line two and a half": ("count", _word(BLOCKS + 3, 2.5)),
    "no limit": ("limits", _word(LIMITS, 0.0)),
    "a gate below zero": ("limits", _word(LIMITS + 1, -0.1)),
    "a travel the other way round": ("limits", _word(LIMITS + 2, 300.0)),
    "a range the other way round": ("limits", _word(SIGNAL + 2, 36.0)),
    "no step between readings": ("limits", _word(SIGNAL + 4, 0.0)),
    "a gate of metres": ("limits", _word(LIMITS + 1, 1001.0)),
    "a tool that reaches the moon": ("limits", _word(TOOL + 2, 4e11)),
    "a signal of any size": ("limits", _word(SIGNAL + 3, 1e300)),
    "axes that lie along each other": ("limits", _word(SLOPES + 1, 1.5)),
    "axes that a degree turns round": ("limits", _word(SLOPES + 10, 0.1)),
    "a row that asks for metres": ("limits", _word(ROWS + 2, -1001.0)),
    "an error of metres": ("body", _word(TABLES, 1e300)),
    "an error of metres a degree": ("body", _word(PER_UNIT + 1, 100.0)),
    "an arm that reaches the moon": ("body", _word(BODY + 7, -4e11)),
    "an axis that carries itself twice": ("body", _word(BODY + 8, 2.0)),
    "a table that belongs to no program": ("program", lambda good: rehashed(good[:224] + bytes(32) + good[256:])),
    "the first letters of magic": ("short", lambda good: good[:3]),
    "a head that says less than it is": ("short", lambda good: good[:16] + bytes(8) + good[24:]),
    "something after the sizes": ("version", lambda good: good[:24] + b"x" + good[25:]),
    "breaks that do not ascend": ("body", _word(BREAKS + 1, -300.0)),
    "lines that do not ascend": ("order", _word(BLOCKS + 3, 1.0)),
    "a limit that is none over bad breaks": ("limits", lambda good: _word(0, -1.0)(_word(BREAKS + 1, 5.0)(good))),
}
"""What the file is, the refusal's name, and how it comes from a good one, for machine `SERIAL` and `PROGRAM`."""


def write_bad_images(folder: Path) -> dict[str, tuple[Path, str]]:
    """All of them as files, and one that is missing: path and refusal's name by what each is."""
    good = image_to_bytes(good_image())
    found = {"no file": (folder / "missing.img", "missing")}
    for number, (what, (refusal, made)) in enumerate(BAD.items()):
        path = folder / f"bad-{number}.img"
        path.write_bytes(made(good))
        found[what] = (path, refusal)
    return found
