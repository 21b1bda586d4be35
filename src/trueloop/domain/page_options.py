"""How a page speaks to its reader."""

from dataclasses import dataclass
from typing import Annotated, Literal, TypeAlias

from trueloop.domain.option import Option

Language: TypeAlias = Literal["en", "de"]
LengthUnit: TypeAlias = Literal["mm", "inch"]


@dataclass(frozen=True)
class PageOptions:
    """Language of the page, and the unit of its lengths; None: that of the program."""

    language: Annotated[
        Language, Option("report.language", '`"en"` or `"de"`: the language of the page, with its decimal sign.')
    ] = "en"
    unit: Annotated[
        LengthUnit | None,
        Option(
            "report.unit",
            '`"mm"` (errors in µm) or `"inch"` (errors in µin): the unit of the page; left out, the program\'s.',
        ),
    ] = None
