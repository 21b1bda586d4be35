"""An image read and evaluated apart from trueloop, as docs/realtime-image.md describes it: by struct and plain sums."""

import hashlib
import struct
from bisect import bisect_right
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any


@dataclass(frozen=True)
class Read:
    """Head by name, words in groups by name."""

    head: dict[str, Any]
    words: dict[str, Any]


def read(content: bytes) -> Read:
    """What stands in the file, which has to be a good one."""
    magic, version, head_bytes, size = struct.unpack_from("<8sIIQ", content, 0)
    assert (magic, version, head_bytes, size) == (b"TLRTEC\r\n", 1, 1024, len(content))
    assert content[24:32] == bytes(8)
    assert content[32:64] == hashlib.sha256(content[64:]).digest()
    head = {
        "machine": _text(content[64:128]),
        "serial": _text(content[128:192]),
        "model": content[192:224].hex(),
        "program_hash": content[224:256].hex(),
        "program": _text(content[256:320]),
        "record": _text(content[320:352]),
        "units": [_text(content[352 + 10 * k : 362 + 10 * k]) for k in range(16)],
        "signals": [_text(content[512 + 32 * k : 544 + 32 * k]) for k in range(16)],
    }
    words = iter(struct.unpack_from(f"<{(size - 1024) // 8}d", content, 1024))
    found = _words(words)
    assert next(words, None) is None
    return Read(head, found)


def _text(part: bytes) -> str:
    return part.split(b"\0")[0].decode("utf-8")


def _take(words: Iterator[float], count: float) -> list[float]:
    return [next(words) for _ in range(int(count))]


def _words(words: Iterator[float]) -> dict[str, Any]:
    found: dict[str, Any] = {"limit": next(words), "gate": next(words)}
    found["travel"] = [_take(words, 2) for _ in range(3)]
    found["tool"] = _take(words, 3)
    count = int(next(words))
    found["signals"] = [_take(words, 4) for _ in range(count)]
    found["slopes"] = [[_take(words, 3) for _ in range(3)] for _ in range(1 + count)]
    found["bodies"] = [_body(words) for _ in range(int(next(words)))]
    blocks = [_take(words, 3) for _ in range(int(next(words)))]
    rows = [_take(words, 4) for _ in range(int(next(words)))]
    found["blocks"] = [(int(line), rows[int(first) : int(first + many)]) for line, first, many in blocks]
    return found


def _body(words: Iterator[float]) -> dict[str, Any]:
    axis, breaks, tables, powers, dependents = map(int, _take(words, 5))
    body: dict[str, Any] = {"axis": axis, "powers": powers, "arm": _take(words, 3), "carries": _take(words, 3)}
    body["breaks"] = _take(words, breaks)
    many = tables * (breaks - 1) * powers
    body["tables"] = tables
    body["rows"] = [_take(words, 6) for _ in range(many)]
    body["added"] = [(int(next(words)), [_take(words, 6) for _ in range(many)]) for _ in range(dependents)]
    return body


def error_mm(
    found: Read, q: Sequence[float], travel: Sequence[float], signals: Sequence[float], offset: Sequence[float]
) -> list[float]:
    """E of the machine at a position; all as numbers of X, Y, Z, signals in the order of the file."""
    words = found.words
    beyond = [value - known[0] for value, known in zip(signals, words["signals"], strict=True)]
    factors = [1.0, *beyond]
    error = [
        sum(f * q[a] * slope[a][k] for f, slope in zip(factors, words["slopes"], strict=True) for a in range(3))
        for k in range(3)
    ]
    for body in words["bodies"]:
        d, r = _six(body, q, travel, beyond)
        arm = [body["arm"][k] + words["tool"][k] - offset[k] + body["carries"][k] * q[k] for k in range(3)]
        for k in range(3):
            i, j = (k + 1) % 3, (k + 2) % 3
            error[k] += d[k] + r[i] * arm[j] - r[j] * arm[i]
    return error


def _six(
    body: dict[str, Any], q: Sequence[float], travel: Sequence[float], beyond: Sequence[float]
) -> tuple[list[float], list[float]]:
    breaks = body["breaks"]
    at = min(max(q[body["axis"]], breaks[0]), breaks[-1])
    segment = min(bisect_right(breaks, at) - 1, len(breaks) - 2)
    way = travel[body["axis"]]
    table = 0 if body["tables"] == 1 or way == 0 else (1 if way > 0 else 2)
    first = (table * (len(breaks) - 1) + segment) * body["powers"]
    step = at - breaks[segment]
    six = [0.0] * 6
    for factor, rows in [(1.0, body["rows"]), *((beyond[place], rows) for place, rows in body["added"])]:
        for power in range(body["powers"]):
            six = [s + factor * c * step**power for s, c in zip(six, rows[first + power], strict=True)]
    return six[:3], six[3:]
