"""What several commands of `trueloop diagnose` take."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from trueloop.domain.page_options import Language, LengthUnit

if TYPE_CHECKING:
    from trueloop.jobs.diagnose.asked import Asked

Accept = Annotated[
    list[str] | None,
    typer.Option(
        "--accept", metavar="CODE", help="Go on although it is refused with this code, as DIA-UNSTABLE; several times."
    ),
]
Output = Annotated[Path | None, typer.Option("--output", "-o", help="Folder for page and JSON.  [default: none]")]
Element = Annotated[
    list[str] | None,
    typer.Option(
        "--element",
        metavar="AXIS=SIGNAL",
        help="The temperature of what carries an axis; several times.  [default: what the model's terms take]",
    ),
]
Types = Annotated[
    list[str] | None, typer.Option("--type", "-t", help="Of this part type alone; several times.  [default: all]")
]


@dataclass(frozen=True, kw_only=True)
class Of:
    """Of which parts, and what is known of them besides."""

    part_type: Annotated[
        str | None, typer.Option("--type", "-t", help="The part type.  [default: the only one in the store]")
    ] = None
    job: Annotated[
        Path | None,
        typer.Option("--job", "-j", help="The job with the part's profile.  [default: features by their names]"),
    ] = None
    model: Annotated[
        Path | None,
        typer.Option(
            "--model",
            "-m",
            metavar="MODEL.json",
            help="The machine's model, for what its probe reported.  [default: none]",
        ),
    ] = None

    def asked(self, accept: list[str] | None) -> "Asked":
        """As jobs take it."""
        from trueloop.jobs.diagnose.asked import Asked

        return Asked(self.part_type, self.job, self.model, tuple(accept or ()))


@dataclass(frozen=True, kw_only=True)
class Page:
    """How the page is shown."""

    language: Annotated[Language, typer.Option("--language", help="Of the page.")] = "en"
    unit: Annotated[LengthUnit, typer.Option("--unit", help="Of the page.")] = "mm"


def elements_of(given: list[str] | None) -> dict[str, str]:
    """`["X=T2"]` as {"X": "T2"}."""
    found = {}
    for text in given or ():
        axis, equals, signal = (part.strip() for part in text.partition("="))
        if not (axis and equals and signal):
            raise typer.BadParameter(f"{text!r} is no AXIS=SIGNAL", param_hint="--element")
        found[axis] = signal
    return found
