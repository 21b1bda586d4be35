"""Types of arrays, arrays as the Rust core takes them, and values compared by what they hold."""

from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeAlias, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array: TypeAlias = NDArray[np.float64]
Flags: TypeAlias = NDArray[np.bool_]
Integers: TypeAlias = NDArray[np.integer[Any]]

T = TypeVar("T")


def for_kernel(values: ArrayLike) -> Array:
    """Values as the Rust core takes them: row by row and aligned, which what comes from another process may not be."""
    return np.require(values, np.float64, ("C_CONTIGUOUS", "ALIGNED"))


def by_content(kind: type[T]) -> type[T]:
    """Makes `==` of a frozen dataclass that holds arrays mean the same content; put it above `@dataclass`."""
    kind.__eq__ = same_content  # type: ignore[method-assign]
    return kind


def same_content(one: object, other: object) -> bool:
    """Returns whether two values hold the same, arrays element by element, NaN being NaN."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other, equal_nan=one.dtype.kind == "f")
    if isinstance(one, float) and isinstance(other, float):
        return one == other or (np.isnan(one) and np.isnan(other))
    if type(one) is not type(other):
        # a value compared by content would ask here again
        return not any(isinstance(value, np.ndarray) or is_dataclass(value) for value in (one, other)) and one == other
    inside, there = _inside(one), _inside(other)
    if inside is None or there is None:
        return bool(one == other)
    return inside.keys() == there.keys() and all(same_content(inside[key], there[key]) for key in inside)


def _inside(value: object) -> Mapping[Any, object] | None:
    """Returns the parts of a value: its compared fields, its elements; None for a value without parts."""
    if is_dataclass(value):
        return {field.name: getattr(value, field.name) for field in fields(value) if field.compare}
    if isinstance(value, tuple | list):
        return dict(enumerate(value))
    return value if isinstance(value, Mapping) else None
