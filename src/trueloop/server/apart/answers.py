"""Messages between the service and a process that reads files: JSON documents, a line each."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Final

from trueloop.described import filled_from
from trueloop.domain.codec import Codec
from trueloop.errors import Code, Place, TrueloopError
from trueloop.jobs.factory.imports import CODEC as READ
from trueloop.jobs.factory.uploads import HandedFile


@dataclass(frozen=True)
class Question:
    """How a file is to be read, by the name of the way, in what time and with how much more memory than at first."""

    reading: str
    handed: HandedFile
    seconds: float
    memory_bytes: int


@dataclass(frozen=True)
class Refusal:
    """A `TrueloopError`."""

    code: Code
    message: str
    hint: str
    place: Place
    override: str | None
    values: Mapping[str, Any]

    @classmethod
    def of(cls, error: TrueloopError) -> "Refusal":
        """Makes a refusal from an error."""
        return filled_from(cls, error)

    def error(self) -> TrueloopError:
        """Makes the error from the refusal."""
        given = {"hint": self.hint, "place": self.place, "override": self.override, "values": self.values}
        return self.code.refusal(self.message, **given)  # type: ignore[arg-type]


@dataclass(frozen=True)
class Answer:
    """The result of reading, or why it failed: refused, a fault of ours (its error and where), or the memory did not
    suffice.

    `memory_bytes`: how much more memory the process has now than at its start.
    """

    value: Any = None
    refusal: Refusal | None = None
    fault: str = ""
    exhausted: bool = False
    memory_bytes: int = field(default=0, kw_only=True)


CODEC: Final[Codec] = READ.with_more(Question, Answer, Refusal, Code, Place)
