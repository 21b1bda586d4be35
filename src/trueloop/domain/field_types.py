"""Whether a value that was read is of the type that a field is declared with."""

from collections.abc import Collection, Mapping
from types import NoneType, UnionType
from typing import Any, Literal, TypeVar, Union, get_args, get_origin

import numpy as np


def fits(value: object, hint: Any) -> bool:
    """Whether a value is of a type as annotations write it: unions, literals, and what containers hold, included.

    A whole number is a float too, a bool is neither. The elements of an array are not looked at.
    """
    if type(value) is hint or hint in (Any, object) or isinstance(hint, TypeVar):
        return True
    origin, inner = get_origin(hint) or hint, get_args(hint)
    if origin in (Union, UnionType):
        return any(fits(value, one) for one in inner)
    if origin is Literal:
        return value in inner
    if origin in (float, int):
        return isinstance(value, origin | int) and not isinstance(value, bool)
    if not isinstance(value, NoneType if hint is None else origin):
        return False
    return not inner or isinstance(value, np.ndarray) or _holds(value, inner)


def _holds(value: object, inner: tuple[Any, ...]) -> bool:
    """Whether the elements of a container are of the types in its annotation; of another generic type, always."""
    if isinstance(value, Mapping):
        return all(fits(key, inner[0]) and fits(one, inner[1]) for key, one in value.items())
    if isinstance(value, tuple) and inner[-1] is not Ellipsis and len(inner) > 1:
        return len(value) == len(inner) and all(map(fits, value, inner))
    return not isinstance(value, Collection) or all(fits(one, inner[0]) for one in value)
