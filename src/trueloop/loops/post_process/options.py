"""The user's options of series and proposals."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Annotated, Final

from trueloop.domain.option import Option
from trueloop.domain.proposal import ProposalClass


@dataclass(frozen=True)
class SeriesOptions:
    """Lengths in mm, of sizes: a diameter's change is twice the radial one. `automatic`: what needs no decision."""

    largest_mm: Annotated[
        float, Option("series.max_um", "A proposal that changes a size by more is not accepted.", above=0)
    ] = 0.150
    least_mm: Annotated[float, Option("series.min_um", "A smaller change of a size is not proposed.", least=0)] = 0.0005
    age_hours: Annotated[
        float, Option("series.max_age_hours", "A proposal made longer ago is not accepted.", above=0)
    ] = 168.0
    take_nominal: Annotated[
        bool, Option("series.take_nominal", "Use parts whose values are exactly nominal, as if they were filled in.")
    ] = False
    automatic: frozenset[ProposalClass] = field(default_factory=frozenset)


LEAST_PARTS: Final = 3
"""With fewer parts a level is not yet one."""

NAMES: Final = {"offset": ProposalClass.TOOL_OFFSET, "memory": ProposalClass.MEMORY, "weight": ProposalClass.WEIGHT}
"""Classes as commands name them."""


def classes_named(names: Iterable[str]) -> frozenset[ProposalClass]:
    """Returns the classes of these names."""
    return frozenset(NAMES[name] for name in names)
