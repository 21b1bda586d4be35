"""A value in the store."""

from dataclasses import dataclass
from datetime import datetime
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Kept(Generic[T]):
    """A value in the store: its row, when it was kept, and whether this call kept it. `superseded_by`: another row.

    `supersedes` is the row in whose stead it stands, `by` who kept it and `why` it supersedes that row. Rows are
    numbered in the order in which they were kept, whatever the clock said; `clock_back`: when this one was kept, the
    clock stood before the time of the row before.
    """

    row: int
    value: T
    kept_at: datetime
    new: bool = False
    superseded_by: int | None = None
    supersedes: int | None = None
    by: str = ""
    why: str = ""
    clock_back: bool = False
