"""Options that several commands of `trueloop series` take."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Annotated, Final

import typer

from trueloop.domain.page_options import Language, LengthUnit

if TYPE_CHECKING:
    from trueloop.factory.book import Book
    from trueloop.loops.post_process.options import SeriesOptions
    from trueloop.storage.store import Store

LARGEST_UM: Final = 150.0
LEAST_UM: Final = 0.5
AGE_H: Final = 168.0
"""As `SeriesOptions` has them; a test compares."""


@dataclass(frozen=True, kw_only=True)
class Which:
    """Of which series."""

    part_type: Annotated[
        str | None, typer.Option("--type", "-t", help="The part type.  [default: the only one in the store]")
    ] = None
    characteristic: Annotated[
        list[str] | None,
        typer.Option("--characteristic", "-c", help="Of this characteristic alone; several times.  [default: all]"),
    ] = None
    take_nominal: Annotated[
        bool, typer.Option("--take-nominal", help="Use parts whose values are exactly nominal, as if filled in.")
    ] = False

    def book(self, store: "Store", options: "SeriesOptions") -> "Book":
        """The series asked for. Raises SER-UNKNOWN."""
        from trueloop.factory.book import only_type, read_book

        return read_book(store, self.part_type or only_type(store), options).named(self.characteristic or ())


@dataclass(frozen=True, kw_only=True)
class Page:
    """How the page is shown."""

    language: Annotated[Language, typer.Option("--language", help="Of the page.")] = "en"
    unit: Annotated[LengthUnit, typer.Option("--unit", help="Of the page.")] = "mm"
