"""Programs by their O number: their names, and the number that a text gives itself."""

import re
from typing import Final

from trueloop.controllers.links.line.framing import framed, require_no_end_within
from trueloop.errors import Code, TrueloopError

NAME: Final = re.compile(r"O(\d{4})")
HEAD: Final = re.compile(rb"\A%\s*O(\d{4})(?!\d)")


def named(number: int) -> str:
    """`O0012`."""
    return f"O{number:04d}"


def number_of(name: str) -> int:
    """The number of a program's name. Raises LNK-NAME for another name than `O0012`."""
    found = NAME.fullmatch(name)
    if found is None or int(found[1]) == 0:
        raise _wrong(f"{name!r} is no program's name at a control that counts programs", name)
    return int(found[1])


def checked_text(content: bytes, name: str) -> bytes:
    """The program framed. Raises LNK-NAME where it calls itself otherwise, LNK-CODE for a `%` within it."""
    text = framed(content)
    require_no_end_within(text)
    found = HEAD.match(text)
    if found is None or int(found[1]) != number_of(name):
        own = "begins with no O number of four digits" if found is None else f"calls itself {named(int(found[1]))}"
        raise _wrong(f"the program {own}, and is to be {name}: the control goes by the program", name)
    return text


def renumbered(text: bytes, number: int) -> bytes:
    """A framed program with another number. One that has none stays as it is."""
    return HEAD.sub(lambda found: found[0][:-4] + f"{number:04d}".encode(), text)


def _wrong(message: str, name: str) -> TrueloopError:
    hint = "name it by its O number, with four digits: `--name O0012`"
    return TrueloopError(Code.LNK_NAME, message, hint=hint, values={"name": name})
