"""The image of the real-time corrector as a file: docs/realtime-image.md says what stands where.

`crates/rtec` reads the same file in the machine, and refuses by the same names.
"""

import hashlib
import struct
from collections.abc import Sequence
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import FilePath, nearest_name
from trueloop.formats.realtime.image_checks import NoImageError, check_numbers
from trueloop.formats.realtime.image_words import image_words, read_words
from trueloop.realtime.image import SIGNALS, Identity, Image

MAGIC: Final = b"TLRTEC\r\n"
VERSION: Final = 1
MOST_BYTES: Final = 64 << 20
HEAD: Final = struct.Struct("<8sIIQQ32s64s64s32s32s64s32s160s512s")
"""Magic, version, bytes of head and file, hash; machine, serial, model, program, its name, record; units and names."""
HASHED_FROM: Final = 64
TEXT_BYTES: Final = 64
RECORD_BYTES: Final = 32
UNIT_BYTES: Final = 10
NAME_BYTES: Final = 32
HINT: Final = "make one with `trueloop realtime image`"


def image_to_bytes(image: Image) -> bytes:
    """The file. Raises RTC-IMAGE for what `read_image` would refuse, texts that are too long among it."""
    try:
        content = _content(image)
        _read(content, None, None)
    except NoImageError as refused:
        raise _refusal(refused, "this") from refused
    return content


def _content(image: Image) -> bytes:
    identity, signals = image.identity, image.bank.signals if image.bank else ()
    units = [_text(s.unit, UNIT_BYTES) if len(s.unit.encode()) <= UNIT_BYTES else bytes(UNIT_BYTES) for s in signals]
    named = (
        _text(identity.machine, TEXT_BYTES),
        _text(identity.serial, TEXT_BYTES),
        bytes.fromhex(identity.model_sha256),
        bytes.fromhex(identity.program_sha256),
        _text(identity.program, TEXT_BYTES),
        _text(identity.record, RECORD_BYTES),
        b"".join(units),
        b"".join(_text(s.name, NAME_BYTES) for s in signals),
    )
    words = image_words(image).astype("<f8").tobytes()
    first = (MAGIC, VERSION, HEAD.size, HEAD.size + len(words))
    hashed = HEAD.pack(*first, 0, b"", *named)[HASHED_FROM:] + words
    return HEAD.pack(*first, 0, hashlib.sha256(hashed).digest(), *named) + words


def _text(text: str, size: int) -> bytes:
    content = text.encode()
    if len(content) > size or b"\0" in content:
        raise NoImageError("long", f"the name {text!r} takes {len(content)} bytes, {size} are there for it")
    return content.ljust(size, b"\0")


def read_image(path: FilePath, *, serial: str | None = None, program: bytes | None = None) -> Image:
    """Reads an image; `serial` of the machine and content of the `program` that it has to be for, where given.

    Raises RTC-IMAGE with the refusal's name.
    """
    path = Path(path)
    try:
        image = _read(_bytes_of(path), serial, program)
    except NoImageError as refused:
        raise _refusal(refused, repr(path.name), Place(str(path))) from refused
    except OSError as error:
        near = nearest_name(path)
        raise TrueloopError(
            Code.RTC_IMAGE,
            f"{str(path)!r} is no image: missing: {error.strerror or error}",
            hint=f"did you mean {str(path.with_name(near))!r}?" if near else HINT,
            place=Place(str(path)),
            values={"refusal": "missing"},
        ) from error
    return image


def _refusal(refused: NoImageError, what: str, place: Place | None = None) -> TrueloopError:
    return TrueloopError(
        Code.RTC_IMAGE,
        f"{what} is no image: {refused.refusal}: {refused}",
        hint=HINT,
        place=place,
        values={"refusal": refused.refusal},
    )


def _bytes_of(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(MOST_BYTES + 1)


def _read(content: bytes, serial: str | None, program: bytes | None) -> Image:
    """In the order of docs/realtime-image.md."""
    _check_frame(content)
    head = HEAD.unpack_from(content)
    if hashlib.sha256(memoryview(content)[HASHED_FROM:]).digest() != head[5]:
        raise NoImageError("hash", f"SHA-256 is not {head[5].hex()[:16]}…")
    machine, own_serial, own_program, record = (_read_text(head[k]) for k in (6, 7, 10, 11))
    model_sha256, program_sha256 = (part.hex() if any(part) else "" for part in (head[8], head[9]))
    identity = Identity(machine, own_serial, model_sha256, own_program, program_sha256, record)
    _check_identity(identity, serial, program)
    words = np.frombuffer(content, dtype="<f8", offset=HEAD.size)
    named = list(zip(_slots(head[-1], NAME_BYTES), _slots(head[-2], UNIT_BYTES), strict=True))
    limits, bank, blocks = read_words(words, named)
    check_numbers(limits, bank, blocks)
    if bool(blocks) != bool(program_sha256):
        raise NoImageError("program", f"{len(blocks)} blocks for the program of sha256 {program_sha256[:16]!r}")
    empty = not (model_sha256 or bank.signals or bank.bodies or bank.slope.any())
    return Image(identity, limits, None if empty else bank, blocks)


def _check_frame(content: bytes) -> None:
    """Empty, magic, version, and the length against what the head says."""
    if not content:
        raise NoImageError("empty", "0 bytes")
    if not MAGIC.startswith(content[: len(MAGIC)]):
        raise NoImageError("magic", f"it begins with {content[: len(MAGIC)]!r}")
    if len(content) < HEAD.size:
        raise NoImageError("short", f"{len(content)} bytes, its head alone has {HEAD.size}")
    _, version, head, said, zero, *_ = HEAD.unpack_from(content)
    if version != VERSION:
        raise NoImageError("version", f"version {version}, not {VERSION}")
    if head != HEAD.size or zero:
        raise NoImageError("version", f"its head has {head} bytes and ends its sizes by {zero}, not {HEAD.size} and 0")
    if len(content) > MOST_BYTES:
        raise NoImageError("long", f"more than {MOST_BYTES} bytes")
    if len(content) != said:
        refusal = "short" if len(content) < said or said < HEAD.size else "long"
        raise NoImageError(refusal, f"{len(content)} bytes, its head says {said}")
    if said % 8:
        raise NoImageError("odd", f"{said} bytes are no whole number of words of 8 bytes")


def _check_identity(identity: Identity, serial: str | None, program: bytes | None) -> None:
    if serial is not None and serial != identity.serial:
        raise NoImageError("serial", f"it is for the machine {identity.serial!r}, not {serial!r}")
    if program is not None and identity.program_sha256 not in ("", sha256_of(program)):
        raise NoImageError("program", f"its table is for {identity.program!r}, sha256 {identity.program_sha256[:16]}…")


def _slots(part: bytes, size: int) -> Sequence[str]:
    return [_read_text(part[k * size : (k + 1) * size]) for k in range(SIGNALS)]


def _read_text(part: bytes) -> str:
    return part.rstrip(b"\0").decode("utf-8", errors="replace")
