"""Options that commands of several groups take, and the checks of their numbers."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from trueloop.domain.option import Language, LengthUnit


def option(words: str, *names: str, **more: Any) -> Any:
    """Declares an option: what `--help` prints of it, its names, and more as `typer.Option` takes it."""
    return typer.Option(*names, help=words, **more)


def argument(words: str, **more: Any) -> Any:
    """Declares an argument: what `--help` prints of it, and more as `typer.Argument` takes it."""
    return typer.Argument(help=words, **more)


Db = Annotated[str | None, option("The store.  [default: trueloop.db in this folder]", "--db", metavar="FILE|URL")]

Control = Literal["fanuc", "haas", "siemens", "heidenhain", "linuxcnc", "ge2000t", "okuma"]
"""As `trueloop.turned.program.wear_numbers` has them; a test compares."""

UnitOption = Annotated[
    Literal["mm", "inch"] | None,
    option("Unit of a table that does not state its own.  [default: as the table states]", "--unit"),
]

Seed = Annotated[int, option("Seed of the random errors: the same gives the same part.", "--seed", min=0)]

ModelOption = Annotated[Path, option("The machine's model.", "--model", "-m", metavar="MODEL.json")]


@dataclass(frozen=True, kw_only=True)
class Page:
    """How the page is shown."""

    language: Annotated[Language, option("Of the page.")] = "en"
    unit: Annotated[LengthUnit, option("Of the page.")] = "mm"


def positive(value: float | None) -> float | None:
    """A finite number above 0, as an option's callback."""
    if value is not None and not 0 < value < math.inf:
        raise typer.BadParameter(f"{value} is not a finite number above 0")
    return value


def not_negative(value: float | None) -> float | None:
    """A finite number not below 0, as an option's callback."""
    if value is not None and not 0 <= value < math.inf:
        raise typer.BadParameter(f"{value} is not a finite number from 0 up")
    return value
