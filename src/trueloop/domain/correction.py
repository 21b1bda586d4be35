"""One envelope for the corrections of all products: record and limits, about a payload that is the product's own."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Generic, Literal, TypeVar

from trueloop.arrays import by_content
from trueloop.domain.record import Record

Payload = TypeVar("Payload")


@by_content
@dataclass(frozen=True)
class Correction(Generic[Payload]):
    """A correction as it is stored, sent and judged later.

    `record` says of every product alike what was corrected, from what, and why; `limits` are those it was held against,
    by name with the unit in the name; `payload` is what the product's loop gave.
    """

    record: Record
    limits: Mapping[str, float]
    payload: Payload
    schema: Literal[1] = field(default=1, kw_only=True)

    @property
    def identity(self) -> tuple[str, ...]:
        """Returns the identity of its record."""
        return self.record.identity

    @property
    def source_sha256(self) -> str:
        """Returns the hash of the program that it corrects; "" where it corrects none."""
        return "" if self.record.program is None else self.record.program.sha256
