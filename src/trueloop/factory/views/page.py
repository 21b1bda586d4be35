"""One page of a list, and where the next begins."""

from dataclasses import dataclass
from typing import Generic, TypeVar

T = TypeVar("T")


@dataclass(frozen=True)
class Page(Generic[T]):
    """`next` is the cursor of the next page; None: this was the last."""

    items: tuple[T, ...]
    next: str | None = None
