"""Shapes of a page's parts as JSON. Their fields and the texts below them make the JSON schema."""

import math
from collections.abc import Iterable
from dataclasses import fields, is_dataclass
from enum import Enum
from importlib import import_module
from typing import Any, Self

from pydantic import BaseModel, ConfigDict

from trueloop.described import Described
from trueloop.errors import Code
from trueloop.extras import install_command
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


def to_frame(rows: Iterable[object]) -> Any:
    """Returns a table of rows, results or values with named fields, as a DataFrame of pandas, of polars without it.

    A field of fields becomes columns `field.name`; units are in the columns' names, as in the fields'. Raises
    OUT-FRAME where neither is installed.

    >>> store = trueloop.make_store("shop.db")
    >>> added = trueloop.add_inspections(store, [trueloop.example("series/first-three.csv")])
    >>> journal = trueloop.follow_series(store).characteristics[0]
    >>> trueloop.to_frame(journal.parts)[["serial", "after_um"]].values.tolist()
    [['101', 26.0], ['102', 29.0], ['103', 27.0]]
    """
    for library in ("pandas", "polars"):
        try:
            frame = import_module(library).DataFrame
        except ImportError:
            continue
        return frame([_columns(row) for row in rows])
    raise Code.OUT_FRAME.refusal(
        "a DataFrame needs a library, and neither 'pandas' nor 'polars' can be loaded", hint=install_command("notebook")
    )


def _columns(row: object, of: str = "") -> dict[str, object]:
    """Returns the named values of a row; those of a value within it with its name before theirs."""
    if isinstance(row, BaseModel):
        named: dict[str, object] = {name: getattr(row, name) for name in type(row).model_fields}
    elif is_dataclass(row) and not isinstance(row, type):
        named = {field.name: getattr(row, field.name) for field in fields(row)}
    else:
        named = dict(row) if isinstance(row, dict) else {"value": row}
    columns = dict[str, object]()
    for name, value in named.items():
        nested = isinstance(value, BaseModel) or (is_dataclass(value) and not isinstance(value, type))
        columns |= _columns(value, f"{of}{name}.") if nested else {f"{of}{name}": value}
    return columns
