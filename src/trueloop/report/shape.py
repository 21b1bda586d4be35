"""Shapes of a page's parts as JSON. Their fields and the texts below them make the JSON schema."""

import math
from enum import Enum
from typing import Any, Self

from pydantic import ConfigDict

from trueloop.described import Described
from trueloop.units import UM_PER_MM


class Shape(Described):
    """A table of named values. Numbers that are not known are null."""

    model_config = ConfigDict(
        frozen=True, extra="forbid", allow_inf_nan=False, ser_json_inf_nan="null", defer_build=True
    )

    @classmethod
    def from_values(cls, *values: object, **others: object) -> Self:
        """Fills each field that `others` do not state from the first value with an attribute of its name.

        `x_um` without one is `x_mm` in µm, to four decimals. Members of enumerations become their values, numbers that
        are not finite None. Raises AttributeError where no value has the attribute.
        """
        return cls(**{name: _field(values, name) for name in cls.model_fields.keys() - others.keys()}, **others)


def um(value_mm: float) -> float:
    """Micrometres to four decimals, without a negative zero."""
    return round(value_mm * UM_PER_MM, 4) + 0.0


def known_um(value_mm: float | None) -> float | None:
    """Returns µm of a value in mm; None where it is not known."""
    return None if value_mm is None or not math.isfinite(value_mm) else um(value_mm)


def known(value: float) -> float | None:
    """Returns the value; None for NaN."""
    return None if math.isnan(value) else value


def _field(values: tuple[object, ...], name: str) -> Any:
    owner = next((value for value in values if hasattr(value, name)), None)
    if owner is None and name.endswith("_um"):
        in_mm = f"{name.removesuffix('_um')}_mm"
        return known_um(getattr(next((value for value in values if hasattr(value, in_mm)), None), in_mm))
    found = getattr(owner, name)
    if isinstance(found, Enum):
        return found.value
    return None if isinstance(found, float) and not math.isfinite(found) else found
