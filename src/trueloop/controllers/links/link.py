"""The operations of every link to a control, and the program names that it takes."""

import re
from dataclasses import dataclass
from datetime import datetime
from typing import Final, Protocol

from trueloop.errors import Code, TrueloopError
from trueloop.wording import did_you_mean

PART: Final = ".part"
"""Ends the name of a program that is being sent; `checked_name` refuses it."""
NAME: Final = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.,+-]{0,99}")
LARGEST: Final = 64_000_000
"""Bytes of a program; a control holds far less."""


@dataclass(frozen=True)
class ListedProgram:
    """A program at a control: its name there, its bytes, when it was changed; None: the control does not say."""

    name: str
    size_bytes: int | None = None
    changed_at: datetime | None = None


@dataclass(frozen=True)
class Busy:
    """Programs that a control executes, or has read and would cut so; names with their folders or without."""

    runs: tuple[str, ...] = ()
    loaded: tuple[str, ...] = ()


class Link(Protocol):
    """A control's programs. Names are checked (`checked_name`) before they reach it.

    Every method raises LNK-REACH where the control is not reached, refuses, or the line breaks; `read` LNK-NAME for a
    program that is not there.
    """

    @property
    def where(self) -> str:
        """Returns the control's address for people, without a password."""

    @property
    def note(self) -> str:
        """Returns what a user of this link has to know; empty: nothing."""

    def listed(self) -> list[ListedProgram]:
        """Lists the programs at the control, by name."""

    def read(self, name: str) -> bytes:
        """Reads a program, byte for byte."""

    def write_aside(self, name: str, content: bytes) -> str:
        """Sends a program under another name, which is returned: nothing is replaced yet."""

    def put_in_place(self, aside: str, name: str) -> None:
        """Gives what was sent aside its own name, in place of what has that name."""

    def remove_aside(self, aside: str) -> None:
        """Takes what was sent aside away again."""

    def busy(self) -> Busy | None:
        """Returns what runs and what is loaded; None: this link cannot know."""


def checked_name(name: str) -> str:
    """Returns the name. Raises LNK-NAME for one that could leave the control's folder, or stands for a transfer."""
    if NAME.fullmatch(name) and not name.endswith(PART) and ".." not in name:
        return name
    raise Code.LNK_NAME.refusal(
        f"{name!r} is not a valid program name",
        hint=f"up to 100 letters, digits and _ . , + -, beginning with a letter, a digit or _, not ending with {PART}",
        values={"name": name},
    )


def no_such_program(name: str, where: str, there: list[str]) -> TrueloopError:
    """Makes the error LNK-NAME, with the nearest name."""
    hint = did_you_mean(name, there) or f"{len(there)} programs are there: `trueloop link list`"
    return Code.LNK_NAME.refusal(f"no program {name!r} is stored at {where}", hint=hint, values={"name": name})


def not_reached(where: str, error: Exception | str) -> TrueloopError:
    """Returns the error LNK-REACH."""
    said = error if isinstance(error, str) else f"{type(error).__name__}: {error}"
    return Code.LNK_REACH.refusal(
        f"{where}: {said}",
        hint="see that the control is on and its address right; `trueloop link compare` shows which program it holds",
        values={"where": where},
    )
