"""What may be wrong: an axis error or the nominal size, everywhere alike or following a temperature, time or travel.

[4773 Table 1] has an error follow the temperature of its own element; its other correlations "that should be tracked"
are here another element's temperature or any other signal, the order of the parts (time), the way of travel (lost
motion) and the nominal size of the part, which a part or a gauge away from 20 °C errs in proportion to.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final

from trueloop.diagnosis.terms.residuals import Residuals
from trueloop.machine.model.chain import Chain
from trueloop.machine.model.names import ErrorName

ORDER: Final = "order of the parts"
TRAVEL: Final = "way of travel"

STEADY: Final = 0.3
"""Share of the prior that an error is the same at all temperatures."""
MIXED: Final = 0.5
"""Share of an error that follows something that it has a steady part too."""
DEGREES: Final = (0.4, 0.4, 0.2)
"""Shares of what an error of motion is over travel: the same everywhere, a line, a parabola."""
LINE: Final = 1
OTHER: Final = 0.1
"""How probable other correlations are together, beside that with the temperature of the error's own element."""


@dataclass(frozen=True)
class NominalSize:
    """An error in proportion to the nominal coordinate of the part along a direction 0, 1, 2: no error of an axis."""

    number: int

    def __str__(self) -> str:
        return f"nominal {'XYZ'[self.number]}"


Wrong = ErrorName | NominalSize


@dataclass(frozen=True)
class Suspect:
    """`error` is wrong: at all temperatures alike if `steady`, and by what `follows` a signal if that is named.

    Both are polynomials of that `degree` in the axis' position, what follows a line at most.
    """

    error: Wrong
    follows: str = ""
    steady: bool = False
    degree: int = 0

    def __str__(self) -> str:
        return f"{self.error} with {self.follows}" if self.follows else f"{self.error}"

    @property
    def parts(self) -> tuple["Suspect", ...]:
        """What it is made of: one that is steady, one that follows."""
        alone = (Suspect(self.error, "", True, self.degree),) if self.steady else ()
        return (*alone, Suspect(self.error, self.follows, False, min(self.degree, LINE))) if self.follows else alone


def suspects(chain: Chain, seen: Residuals) -> Iterator[tuple[Suspect, float]]:
    """All of them with their share of the prior; each error has 1, the nominal size along each direction less."""
    for name in chain.errors():
        linear = name.axis in chain.order
        if linear != name.place:
            yield from _of(name, seen.element.get(name.axis, ""), seen, linear)
    for number in range(3):
        yield Suspect(NominalSize(number), "", True), OTHER / 2
        yield Suspect(NominalSize(number), ORDER), OTHER / 2


def _of(name: ErrorName, own: str, seen: Residuals, linear: bool) -> Iterator[tuple[Suspect, float]]:
    """Of one axis error; a place has no travel."""
    shapes = tuple(enumerate(DEGREES)) if linear else ((0, 1.0),)
    others = [*sorted(set(seen.state.signals) - {own, ORDER}), ORDER, *([TRAVEL] if linear else [])]
    for degree, shape in shapes:
        yield Suspect(name, "", True, degree), STEADY * shape
    for signal in [*([own] if own else []), *others]:
        share = (1 - STEADY) * (1 - OTHER if signal == own else OTHER / len(others))
        for degree, shape in shapes:
            yield Suspect(name, signal, True, degree), share * shape * MIXED
            if degree <= LINE:
                yield Suspect(name, signal, False, degree), share * shape * (1 - MIXED)
