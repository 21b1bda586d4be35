"""What a user may choose, stated once: at the field of the frozen dataclass that the code computes with.

    correction_mm: Annotated[float, Option("compensation.max_correction_um", "A larger …", above=0)] = 0.150

Keys of job files, their defaults and bounds, options of commands, the JSON schema and the tables of the documentation
are read from there.
"""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, get_args, get_type_hints

from trueloop.units import UM_PER_MM


class Unit(NamedTuple):
    """A unit that the end of a key names: `inside` takes its numbers to mm, rad and shares, `outside` back."""

    name: str
    inside: Callable[[float], float] = float
    outside: Callable[[float], float] = float


def _um(name: str) -> Unit:
    return Unit(name, lambda given: given / UM_PER_MM, lambda value: value * UM_PER_MM)


UNITS: Final = {
    "_mm_per_min": Unit("mm/min"),
    "_um_per_mm": _um("µm/mm"),
    "_um": _um("µm"),
    "_mm": Unit("mm"),
    "_in": Unit("inch"),
    "_deg": Unit("°", math.radians, lambda angle: round(math.degrees(angle), 9)),
    "_percent": Unit("%", lambda given: given / 100, lambda share: share * 100),
    "_hours": Unit("h"),
}
"""By the end of a key, the longest first where one ends with another."""


def unit_of(key: str) -> Unit:
    """Returns the unit that a key ends with; one without a name where it names none."""
    return next((unit for end, unit in UNITS.items() if key.endswith(end)), Unit(""))


@dataclass(frozen=True)
class Option:
    """How a field is set: the table and key of a job file, whose end names the unit there, what it means, and the
    numbers accepted, in that unit: over `above` or from `least`, below `below` or up to `most`.
    """

    key: str
    meaning: str
    above: float | None = None
    least: float | None = None
    below: float | None = None
    most: float | None = None
    unit: str = ""
    """In words, of a key whose end names none."""


@dataclass(frozen=True)
class Choice:
    """An option with the type of its values and its default, in the unit of its key."""

    option: Option
    kind: Any
    default: Any


def choices_of(options: Any) -> dict[str, Choice]:
    """Returns by field the options of a dataclass: of its type, or of an instance that holds other defaults.

    The default of an option that has to be given is `...`.
    """
    found = {}
    kind = options if isinstance(options, type) else type(options)
    for name, hint in get_type_hints(kind, include_extras=True).items():
        taken, *notes = get_args(hint) or (hint,)
        for option in notes:
            if isinstance(option, Option):
                found[name] = Choice(option, taken, outside(option.key, getattr(options, name, ...)))
    return found


def inside(key: str, given: Any) -> Any:
    """Converts a value as given under a key to the one that the code computes with."""
    return unit_of(key).inside(given) if isinstance(given, float) else given


def outside(key: str, value: Any) -> Any:
    """Converts a value that the code computes with to the one given under a key."""
    return unit_of(key).outside(value) if isinstance(value, float) else value
