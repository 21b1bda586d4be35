"""The image of the real-time corrector as a file: docs/realtime-image.md says what stands where.

`crates/rtec` reads the same file in the machine, and refuses by the same names.
"""

import hashlib
import struct
from collections.abc import Iterator, Sequence
from itertools import accumulate, chain, pairwise
from pathlib import Path
from typing import Final

import numpy as np

from trueloop.arrays import Array
from trueloop.domain.record import sha256_of
from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import FilePath, nearest_name
from trueloop.machine.model.chain import Vector
from trueloop.realtime.image import SIGNALS, Bank, Block, Body, Identity, Image, RealTimeLimits, Signal

MOST: Final = 1e3
"""Errors, rows of a table and limits, mm and rad; lengths are less than its square."""
MOST_SIGNAL: Final = 1e9
MOST_SLOPE: Final = 1.0
MOST_POWER: Final = 1e100


class NoImageError(Exception):
    """Why a file is not an image: the refusal's name, as in docs/realtime-image.md, and what was found."""

    def __init__(self, refusal: str, found: str) -> None:
        super().__init__(found)
        self.refusal = refusal


def check_numbers(limits: RealTimeLimits, bank: Bank, blocks: tuple[Block, ...]) -> None:
    """Raises NoImageError (limits, body, order) where the numbers do not make limits, functions and a table."""
    _require("limits", [*_of_limits(limits), *_of_bank(bank)])
    for number, body in enumerate(bank.bodies):
        _require("body", _of_body(f"body {number}", body, spans(bank.signals)))
    for before, after in pairwise(blocks):
        _require("order", [(f"program line {after.line} after {before.line}", before.line < after.line)])
    most = np.array([MOST**2, MOST**2, MOST, MOST])
    _require("limits", [(f"rows of line {b.line}", bool((np.abs(b.rows) <= most).all())) for b in blocks])


def _require(refusal: str, conditions: "list[tuple[str, bool]] | Iterator[tuple[str, bool]]") -> None:
    for what, holds in conditions:
        if not holds:
            raise NoImageError(refusal, what)


def spans(signals: tuple[Signal, ...]) -> Array:
    """Returns the largest difference of each signal from its reference within its range."""
    return np.array([max(abs(s.low - s.reference), abs(s.high - s.reference)) for s in signals])


def _of_limits(limits: RealTimeLimits) -> Iterator[tuple[str, bool]]:
    yield f"limit {limits.limit_mm:g} mm", 0 < limits.limit_mm <= MOST
    yield f"gate {limits.gate_mm:g} mm", 0 < limits.gate_mm <= MOST
    for axis, (low, high) in zip("XYZ", limits.travel_mm, strict=True):
        yield f"travel of {axis} from {low:g} to {high:g} mm", low <= high


def _of_bank(bank: Bank) -> Iterator[tuple[str, bool]]:
    yield f"tool {bank.tool_mm} mm", max(map(abs, bank.tool_mm)) <= MOST**2
    for s in bank.signals:
        small = max(abs(s.low), abs(s.high), abs(s.reference)) <= MOST_SIGNAL
        yield f"{s.name} from {s.low:g} to {s.high:g}, reference {s.reference:g}", small and s.low <= s.high
        yield f"steps of {s.name} up to {s.most_step:g}", s.most_step > 0
    slope = np.tensordot(np.array([1.0, *spans(bank.signals)]), np.abs(bank.slope), axes=1)
    yield f"squareness up to {slope.max():g}", bool((slope <= MOST_SLOPE).all())


def _of_body(name: str, body: Body, span: Array) -> Iterator[tuple[str, bool]]:
    places = [place for place, _ in body.per_unit]
    yield f"{name}: breaks {body.breaks.tolist()}", bool((np.diff(body.breaks) > 0).all())
    yield f"{name}: signals {places}", sorted(set(places)) == places
    reach = _reach(body.breaks, body.powers) + sum(span[k] * _reach(body.breaks, added) for k, added in body.per_unit)
    yield f"{name}: errors up to {reach:g} mm or rad", reach <= MOST
    largest = max(np.abs(powers).max() for powers in (body.powers, *(added for _, added in body.per_unit)))
    yield f"{name}: coefficients up to {largest:g}", bool(largest <= MOST_POWER)
    yield f"{name}: arm {body.arm_mm.tolist()} mm", bool((np.abs(body.arm_mm) <= MOST**2).all())
    yield f"{name}: carries {body.carries.tolist()}", bool((np.abs(body.carries) <= 1).all())


def _reach(breaks: Array, powers: Array) -> float:
    """Returns a bound of the error of these powers: the largest sum of |power| times width over all segments."""
    width = np.diff(breaks)[:, None] ** np.arange(powers.shape[2])
    return float((np.abs(powers) * width[:, :, None]).sum(axis=2).max())


AXES: Final = 3
BODIES: Final = 8
POWERS: Final = 8
COMPONENTS: Final = 6
BREAKS: Final = 1 << 20
ROWS: Final = 1 << 21
LINE: Final = (1 << 31) - 1


def image_words(image: Image) -> Array:
    """Returns the words of an image, in their order."""
    limits, bank = image.limits, image.bank or Bank((), (), np.zeros((1, AXES, AXES)))
    signals = [(s.reference, s.low, s.high, s.most_step) for s in bank.signals]
    parts = [
        [limits.limit_mm, limits.gate_mm, *chain.from_iterable(limits.travel_mm)],
        bank.tool_mm,
        [len(signals), *chain.from_iterable(signals)],
        bank.slope.ravel(),
        [len(bank.bodies)],
        *chain.from_iterable(_body_words(body) for body in bank.bodies),
        *_block_words(image.blocks),
    ]
    return np.concatenate([np.asarray(part, dtype=np.float64) for part in parts])


def _body_words(body: Body) -> Iterator[Array | Sequence[float]]:
    tables, _, powers, _ = body.powers.shape
    yield [body.axis, len(body.breaks), tables, powers, len(body.per_unit)]
    yield from (body.arm_mm, body.carries, body.breaks, body.powers.ravel())
    for place, added in body.per_unit:
        yield [place]
        yield added.ravel()


def _block_words(blocks: tuple[Block, ...]) -> Iterator[Array | Sequence[float]]:
    ends = list(accumulate((len(block.rows) for block in blocks), initial=0))
    yield [len(blocks)]
    yield from ((block.line, first, len(block.rows)) for block, first in zip(blocks, ends, strict=False))
    yield [ends[-1]]
    yield from (block.rows.ravel() for block in blocks)


def read_words(words: Array, named: Sequence[tuple[str, str]]) -> tuple[RealTimeLimits, Bank, tuple[Block, ...]]:
    """Returns the words' content; `named`: signals' names and units. No model: an empty bank. Raises NoImageError."""
    for number in np.flatnonzero(~np.isfinite(words)):
        raise NoImageError("not finite", f"word {number} is {words[number]}")
    rest = _Words(words)
    limit, gate = rest.take(2)
    x, y, z = ((float(low), float(high)) for low, high in rest.take(2 * AXES).reshape(AXES, 2))
    limits = RealTimeLimits((x, y, z), float(limit), float(gate))
    tool = _vector(rest.take(AXES))
    count = rest.count("signals", 0, SIGNALS)
    numbers = rest.take(4 * count).reshape(count, 4).tolist()
    signals = tuple(Signal(name, unit, *four) for (name, unit), four in zip(named, numbers, strict=False))
    slope = rest.take((1 + count) * AXES**2).reshape(-1, AXES, AXES)
    bodies = tuple(_body(rest, count) for _ in range(rest.count("bodies", 0, BODIES)))
    blocks = _blocks(rest)
    if rest.left:
        raise NoImageError("count", f"{rest.left} words are left over")
    return limits, Bank(signals, bodies, slope, tool), blocks


class _Words:
    """Words taken from the front."""

    def __init__(self, words: Array) -> None:
        self.words, self.at = words, 0

    @property
    def left(self) -> int:
        """Returns the number of words left."""
        return len(self.words) - self.at

    def take(self, count: int) -> Array:
        """Returns the next `count` words. Raises NoImageError where there are fewer."""
        if count > self.left:
            raise NoImageError("count", f"{count} words are needed from word {self.at} on, {self.left} are there")
        self.at += count
        return self.words[self.at - count : self.at].astype(np.float64)

    def count(self, what: str, low: int, high: int) -> int:
        """Returns the next word as a whole number. Raises NoImageError where it is none or outside `low` to `high`."""
        value = float(self.take(1)[0])
        if value != round(value) or not low <= value <= high:
            raise NoImageError("count", f"{what}: {value:g}, from {low} to {high}")
        return int(value)


def _vector(three: Array) -> Vector:
    x, y, z = three.tolist()
    return x, y, z


def _body(rest: _Words, signals: int) -> Body:
    axis, breaks = rest.count("axis", 0, AXES - 1), rest.count("breaks", 2, BREAKS)
    tables, powers = rest.count("tables", 1, AXES), rest.count("powers", 1, POWERS)
    if tables == 2:
        raise NoImageError("count", "tables: 2, where 1 or 3 are")
    dependents = rest.count("dependents", 0, signals)
    arm, carries, ends = rest.take(AXES), rest.take(AXES), rest.take(breaks)
    shape = (tables, breaks - 1, powers, COMPONENTS)
    size = int(np.prod(shape))
    rows = rest.take(size).reshape(shape)
    per_unit = tuple(
        (rest.count("place of a signal", 0, signals - 1), rest.take(size).reshape(shape)) for _ in range(dependents)
    )
    return Body(axis=axis, breaks=ends, powers=rows, per_unit=per_unit, arm_mm=arm, carries=carries)


def _blocks(rest: _Words) -> tuple[Block, ...]:
    listed = [
        (rest.count("program line", 0, LINE), rest.count("first row", 0, ROWS), rest.count("rows", 2, ROWS))
        for _ in range(rest.count("blocks", 0, ROWS))
    ]
    rows = rest.take(4 * rest.count("rows", 0, ROWS)).reshape(-1, 4)
    if bool(listed) != bool(len(rows)):
        raise NoImageError("count", f"{len(listed)} blocks, {len(rows)} rows")
    for line, first, count in listed:
        if first + count > len(rows):
            raise NoImageError("count", f"line {line}: rows {first} to {first + count} of {len(rows)}")
    return tuple(Block(line, rows[first : first + count]) for line, first, count in listed)


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
    """Returns the file's bytes. Raises RTC-IMAGE for what `read_image` would refuse, such as too long texts."""
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
    """Reads an image that is for a machine's `serial` and a `program`, where given. Raises RTC-IMAGE."""
    path = Path(path)
    try:
        image = _read(_bytes_of(path), serial, program)
    except NoImageError as refused:
        raise _refusal(refused, repr(path.name), Place(str(path))) from refused
    except OSError as error:
        near = nearest_name(path)
        raise Code.RTC_IMAGE.refusal(
            f"{str(path)!r} cannot be loaded: missing: {error.strerror or error}",
            hint=f"did you mean {str(path.with_name(near))!r}?" if near else HINT,
            place=Place(str(path)),
            values={"refusal": "missing"},
        ) from error
    return image


def _refusal(refused: NoImageError, what: str, place: Place | None = None) -> TrueloopError:
    return Code.RTC_IMAGE.refusal(
        f"{what} cannot be loaded: {refused.refusal}: {refused}",
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
    identity = Identity(
        machine=machine,
        serial=own_serial,
        model_sha256=model_sha256,
        program=own_program,
        program_sha256=program_sha256,
        record=record,
    )
    if serial is not None and serial != identity.serial:
        raise NoImageError("serial", f"it is for the machine {identity.serial!r}, not {serial!r}")
    if program is not None and identity.program_sha256 not in ("", sha256_of(program)):
        raise NoImageError("program", f"its table is for {identity.program!r}, sha256 {identity.program_sha256[:16]}…")
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


def _slots(part: bytes, size: int) -> Sequence[str]:
    return [_read_text(part[k * size : (k + 1) * size]) for k in range(SIGNALS)]


def _read_text(part: bytes) -> str:
    return part.rstrip(b"\0").decode("utf-8", errors="replace")
