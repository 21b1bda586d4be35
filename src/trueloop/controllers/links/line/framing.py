"""A program between `%` and `%`, by which controls know its beginning and its end."""

from collections.abc import Iterator

from trueloop.controllers.links.line.codes import wrong


def framed(content: bytes) -> bytes:
    """A program between `%` and `%`, with line feeds."""
    lines = list(_lines(content))
    return b"\n".join([b"%", *lines, b"%", b""])


def require_no_end_within(text: bytes) -> None:
    """Raises LNK-CODE for a `%` of a framed text that is neither the first nor the last: it would end there."""
    for k, line in enumerate(text.split(b"\n")[1:-2], 1):
        if b"%" in line:
            raise wrong("'%' within a program ends it for the control", k, line.index(b"%") + 1)


def _lines(content: bytes) -> Iterator[bytes]:
    """Its lines without the `%` around them."""
    lines = content.replace(b"\r\n", b"\n").replace(b"\r", b"\n").strip(b"\n").split(b"\n")
    first = 1 if lines[0].strip() == b"%" else 0
    last = len(lines) - 1 if len(lines) > first and lines[-1].strip() == b"%" else len(lines)
    yield from lines[first:last]
