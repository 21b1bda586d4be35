"""Options that commands of several groups take, and the checks of their numbers."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import typer

from trueloop.domain.option import Language, LengthUnit

Db = Annotated[
    str | None,
    typer.Option("--db", metavar="FILE|URL", help="The store.  [default: trueloop.db in this folder]"),
]

Control = Literal["fanuc", "haas", "siemens", "heidenhain", "linuxcnc", "ge2000t", "okuma"]
"""As `trueloop.turned.program.wear_words` has them; a test compares."""

UnitOption = Annotated[
    Literal["mm", "inch"] | None,
    typer.Option("--unit", help="Unit of a table that does not say its own.  [default: what the table says]"),
]

Seed = Annotated[int, typer.Option("--seed", min=0, help="Seed of the random errors: the same gives the same part.")]

ModelOption = Annotated[Path, typer.Option("--model", "-m", metavar="MODEL.json", help="The machine's model.")]


@dataclass(frozen=True, kw_only=True)
class Page:
    """How the page is shown."""

    language: Annotated[Language, typer.Option("--language", help="Of the page.")] = "en"
    unit: Annotated[LengthUnit, typer.Option("--unit", help="Of the page.")] = "mm"


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
