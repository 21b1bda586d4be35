"""The lines by which a LinuxCNC program witnesses its own run: `witnessed`, `log_lines`.

The interpreter writes `KEY started` into LOG_FILE, a file of LinuxCNC's folder, as it begins to read, and `KEY ended`
once all motion before the end is done: `M66` empties the queue of moves. It opens the file again for that, as a program
may have a log of its own and LinuxCNC writes one at a time. A key that LinuxCNC has begun it refuses to begin again,
whoever presses Cycle Start.
"""

import re
from collections.abc import Iterator
from hashlib import sha256
from typing import Final

from trueloop.errors import Code, Place, TrueloopError

LOG_FILE: Final = "trueloop-witness.log"
_COMMENT: Final = re.compile(rb"\([^)]*\)?|;.*")
_NAMED: Final = re.compile(rb"<[^>]*>?")
_END: Final = re.compile(rb"(?<![A-Z])M0*(?:2|30)(?![\d.])")
_ALONE: Final = re.compile(rb"(?:N\d+)?M0*(?:2|30)")
_UNSURE: Final = re.compile(rb"(?<![A-Z])M(?:0*99(?!\d)|[\[#])")
_KEY: Final = re.compile(r"[\w.-]{1,80}")


def witnessed(text: bytes, key: str) -> bytes:
    """Returns the program with its witness, all its own lines as they are. `key` names the run.

    Raises CEL-WITNESS for a program that does not end in a block of its own: M2, M30 or a closing %.
    """
    assert _KEY.fullmatch(key), key
    lines = text.splitlines(keepends=True)
    newline = b"\r\n" if lines and lines[0].endswith(b"\r\n") else b"\n"
    ends, first = _ends(lines)
    if not ends:
        raise _refused("1 end of the program is missing", "end it with M2 or M30 in a block of its own", len(lines))
    head, tail = (newline.join([*block, b""]) for block in log_lines(key))
    whole = [b""] * len(lines)
    for k, line in enumerate(lines):
        whole[k] = (tail if k in ends else b"") + line
    return b"".join([*whole[:first], head, *whole[first:]])


def log_lines(key: str) -> tuple[list[bytes], list[bytes]]:
    """Returns the lines to insert at the beginning of the program, and before each of its ends."""
    mark, name = f"#<_trueloop_{sha256(key.encode()).hexdigest()[:16]}>", f"o<trueloop-{key}>"
    head = [
        *(f"{name} if [[#<_task> EQ 1] AND EXISTS[{mark}]]", f"(ABORT,run {key} was begun before: it runs once)"),
        *(f"{name} endif", f"{mark} = 1", f"(LOGAPPEND,{LOG_FILE})", f"(LOG,{key} started)"),
    ]
    tail = ["M66 P0 L0", f"(LOGAPPEND,{LOG_FILE})", f"(LOG,{key} ended)"]
    return [line.encode() for line in head], [line.encode() for line in tail]


def _ends(lines: list[bytes]) -> tuple[set[int], int]:
    """Where it ends, and before which line it begins."""
    found: set[int] = set()
    first, opened, open_since_end = 0, False, False
    for k, code in _codes(lines):
        if code == b"%":
            if not opened and not open_since_end and not found:
                opened, first = True, k + 1
                continue
            return (found | {k} if open_since_end else found), first
        if _END.search(code):
            if not _ALONE.fullmatch(code):
                raise _refused(f"block {code.decode(errors='replace')!r} ends it and does more", _APART, k + 1)
            found.add(k)
            open_since_end = False
        else:
            if _UNSURE.search(code):
                raise _refused(f"block {code.decode(errors='replace')!r} may end or repeat it", _APART, k + 1)
            open_since_end = True
    return found, first


_APART: Final = "write M2 or M30 into a block of its own, without a slash, and no M99 or computed M"


def _codes(lines: list[bytes]) -> Iterator[tuple[int, bytes]]:
    """Number and text of every line with code on it: without comments, names and blanks, in capitals."""
    for k, line in enumerate(lines):
        code = b"".join(_NAMED.sub(b"", _COMMENT.sub(b"", line)).split()).upper()
        if code:
            yield k, code


def _refused(why: str, hint: str, line: int) -> TrueloopError:
    return Code.CEL_WITNESS.refusal(f"the program cannot witness its run: {why}", hint=hint, place=Place(line=line))
