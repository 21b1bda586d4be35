"""Values as plain JSON and back: frozen dataclasses of numbers, text, arrays, tuples, mappings, times and enumerations.

What JSON has is written as it is, and a tuple as an array. All else is an object whose `type` says what it is: a type
of the registry, or one of `array`, `list`, `dict`, `bytes`, `datetime`, `number` (which is not finite). Numbers come
back to the last bit. Nothing is imported or run by what a document says: types that are not registered are refused.
"""

import json
import math
import re
from collections.abc import Collection, Mapping
from dataclasses import MISSING, Field, dataclass, fields, is_dataclass
from datetime import datetime
from enum import Enum
from functools import cache, cached_property
from types import NoneType, UnionType
from typing import Any, Final, Literal, TypeAlias, TypeVar, Union, get_args, get_origin, get_type_hints

import numpy as np
from numpy.typing import NDArray

from trueloop.errors import Code, TrueloopError


def fits(value: object, hint: Any) -> bool:
    """Returns whether a value is of a type as annotations write it: unions, literals, and contents of containers.

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
    """Returns whether a container's elements are of the types of its annotation; of other generic types, always."""
    if isinstance(value, Mapping):
        return all(fits(key, inner[0]) and fits(one, inner[1]) for key, one in value.items())
    if isinstance(value, tuple) and inner[-1] is not Ellipsis and len(inner) > 1:
        return len(value) == len(inner) and all(map(fits, value, inner))
    return not isinstance(value, Collection) or all(fits(one, inner[0]) for one in value)


TAG: Final = "type"
ARRAYS: Final = re.compile(r"bool|u?int(8|16|32|64)|float(32|64)")
"""Types of the elements of arrays, by numpy's names."""
WHOLE: Final = "the document"
HINT: Final = "take the file as trueloop wrote it; one of a later version is read by that version"

_AS_IT_IS: Final = frozenset({str, int, float, bool, type(None)})
Plain: TypeAlias = Any
"""Values that `json` reads and writes: None, bool, int, float, str, list, dict with keys of str."""

T = TypeVar("T")


@dataclass(frozen=True, eq=False)
class Codec:
    """The registry: the types that a document may hold, by the name that stands for each in JSON."""

    types: Mapping[str, type]

    @classmethod
    def of(cls, *types: type, **renamed: type) -> "Codec":
        """Makes a codec of frozen dataclasses and enumerations, each under its own name or the one given."""
        return cls({}).with_more(*types, **renamed)

    def with_more(self, *types: type, **renamed: type) -> "Codec":
        """Returns a codec with further types."""
        added = (*types, *renamed.values())
        named = {**self.types, **{one.__name__: one for one in types}, **renamed}
        if len(named) != len(self.types) + len(added) or len(set(named.values())) != len(named):
            raise TypeError(f"a type or a name twice: {sorted(one.__name__ for one in added)}")
        if wrong := [one.__name__ for one in added if not _is_value(one)]:
            raise TypeError(f"no frozen dataclasses or enumerations: {wrong}")
        return Codec(named)

    def to_json(self, value: object) -> str:
        """Writes a value as a JSON document. Raises TypeError for anything that is not a value of this codec."""
        return json.dumps(self.plain(value), ensure_ascii=False, allow_nan=False) + "\n"

    def from_json(self, text: str | bytes, kind: type[T]) -> T:
        """Reads the value of a JSON document, of this type. Raises VAL-FORM for one that does not hold it."""
        try:
            return self.value(json.loads(text, parse_constant=_no_constant), kind)
        except (ValueError, RecursionError) as wrong:
            raise _refused(f"{wrong}", WHOLE) from wrong

    def plain(self, value: Any) -> Plain:
        """Converts a value to what `json` writes."""
        kind = type(value)
        if kind in _AS_IT_IS and (kind is not float or math.isfinite(value)):  # the most frequent first
            return value
        if isinstance(value, tuple) and not isinstance(value, Enum):
            return [self.plain(one) for one in value]
        if isinstance(value, Enum) or is_dataclass(value):
            return self._plain_of_registered(value)
        if isinstance(value, bool | int | str):
            return value
        if isinstance(value, float):
            return float(value) if math.isfinite(value) else {TAG: "number", "value": repr(float(value))}
        return self._plain_of_mapping(value) if isinstance(value, Mapping) else self._plain_of_other(value)

    def value(self, plain: Plain, kind: type[T]) -> T:
        """Converts what `json` has read to a value of this type. Raises VAL-FORM for what does not hold it."""
        found = self._value(plain, WHOLE)
        if not isinstance(found, kind):
            raise _refused(f"a {type(found).__name__} instead of a {kind.__name__}", WHOLE)
        return found

    @cached_property
    def _names(self) -> dict[type, str]:
        return {kind: name for name, kind in self.types.items()}

    def _plain_of_registered(self, value: Any) -> Plain:
        name = self._names.get(type(value))
        if name is None:
            raise TypeError(f"{type(value)} is not registered")
        if isinstance(value, Enum):
            return {TAG: name, "value": self.plain(value.value)}
        return {TAG: name} | {field.name: self.plain(getattr(value, field.name)) for field in _fields(value)}

    def _plain_of_mapping(self, value: Mapping[Any, object]) -> Plain:
        """An object as it is; with keys that JSON or the tag cannot have, a list of pairs."""
        if all(isinstance(key, str) and not isinstance(key, Enum) and key != TAG for key in value):
            return {key: self.plain(one) for key, one in value.items()}
        return {TAG: "dict", "items": [[self.plain(key), self.plain(one)] for key, one in value.items()]}

    def _plain_of_other(self, value: object) -> Plain:
        if isinstance(value, list):
            return {TAG: "list", "items": [self.plain(one) for one in value]}
        if isinstance(value, np.ndarray) and ARRAYS.fullmatch(value.dtype.name):
            elements = value.ravel().tolist()
            if value.dtype.kind == "f" and not np.all(np.isfinite(value)):
                elements = [self.plain(element) for element in elements]
            return {TAG: "array", "of": value.dtype.name, "shape": list(value.shape), "values": elements}
        if isinstance(value, np.bool_ | np.integer):
            return value.item()
        if isinstance(value, bytes):
            return {TAG: "bytes", "latin1": value.decode("latin-1")}
        if isinstance(value, datetime):
            return {TAG: "datetime", "value": value.isoformat()}
        raise TypeError(f"{type(value)} is no value that can be stored")

    def _value(self, plain: Plain, where: str) -> Any:
        if isinstance(plain, list):
            return tuple(self._value(one, f"{where}[{k}]") for k, one in enumerate(plain))
        if not isinstance(plain, dict):
            return plain
        if TAG not in plain:
            return {key: self._value(one, f"{where}.{key}") for key, one in plain.items()}
        name, inner = plain[TAG], {key: one for key, one in plain.items() if key != TAG}
        registered = self.types.get(name) if isinstance(name, str) else None
        if registered is None:
            return self._other(name, inner, where)
        return self._registered(registered, inner, where)

    def _registered(self, kind: Any, inner: dict[str, Plain], where: str) -> Any:
        values = {
            key: one if type(one) in _AS_IT_IS else self._value(one, f"{where}.{key}") for key, one in inner.items()
        }
        if issubclass(kind, Enum):
            if set(values) != {"value"} or values["value"] not in _worths(kind):
                raise _refused(f"{values} is no {kind.__name__}", where)
            return kind(values["value"])
        hints = _hints(kind)
        if unknown := values.keys() - hints.keys():
            raise _refused(f"{kind.__name__} has no {sorted(unknown)}", where)
        if missing := _needed(kind) - values.keys():
            raise _refused(f"{kind.__name__} lacks {sorted(missing)}", where)
        for key, one in values.items():
            if type(one) is not hints[key] and not fits(one, hints[key]):
                raise _refused(f"{kind.__name__}.{key} cannot be {_shown(one)}", where)
        return kind(**values)

    def _other(self, name: object, inner: dict[str, Plain], where: str) -> Any:
        try:
            if name in ("list", "dict"):
                items = [self._value(one, f"{where}[{k}]") for k, one in enumerate(inner["items"])]
                return items if name == "list" else dict(items)
            if isinstance(name, str) and name in _OTHERS:
                return _OTHERS[name](inner)
        except (KeyError, TypeError, ValueError, OverflowError) as wrong:
            raise _refused(f"this {name} cannot be read, at {wrong}", where) from wrong
        raise _refused(f"the type {name!r} is not known", where)


def _is_value(kind: Any) -> bool:
    if issubclass(kind, Enum):
        return True
    parameters: Any = getattr(kind, "__dataclass_params__", None)
    return parameters is not None and parameters.frozen and all(f.init and f.name != TAG for f in _fields(kind))


def _array(inner: dict[str, Plain]) -> NDArray[Any]:
    if not ARRAYS.fullmatch(inner["of"]):
        raise ValueError(f"an array of {inner['of']!r}")
    kind = np.dtype(inner["of"])
    values = inner["values"]
    of_json = {float, int, bool} if kind.kind == "f" else {bool} if kind.kind == "b" else {int}
    if kind.kind == "f" and dict in map(type, values):
        values = [_number(value) if isinstance(value, dict) else value for value in values]
    if not of_json.issuperset(map(type, values)):
        raise ValueError(f"an element that is no {inner['of']}")
    array = np.array(values, dtype=kind).reshape([int(n) for n in inner["shape"]])
    array.setflags(write=False)  # a decoded value may be given to several readers
    return array


def _bytes(inner: dict[str, Plain]) -> bytes:
    return str(inner["latin1"]).encode("latin-1")


def _datetime(inner: dict[str, Plain]) -> datetime:
    return datetime.fromisoformat(inner["value"])


def _number(inner: dict[str, Plain]) -> float:
    return float(inner["value"])


_OTHERS: Final = {"array": _array, "bytes": _bytes, "datetime": _datetime, "number": _number}


def _fields(value: Any) -> tuple[Field[Any], ...]:
    return fields(value)


@cache
def _needed(kind: Any) -> frozenset[str]:
    return frozenset(field.name for field in _fields(kind) if field.default is field.default_factory is MISSING)


@cache
def _worths(kind: Any) -> tuple[object, ...]:
    return tuple(one.value for one in kind)


@cache
def _hints(kind: Any) -> dict[str, Any]:
    hints = get_type_hints(kind)
    return {field.name: hints[field.name] for field in _fields(kind)}


def _no_constant(name: str) -> float:
    raise ValueError(f"{name} is no number of JSON")


def _shown(value: object) -> str:
    text = repr(value)
    return text if len(text) <= 60 else f"{text[:60]}…"


def _refused(what: str, where: str) -> TrueloopError:
    return Code.VAL_FORM.refusal(f"{where}: {what}", hint=HINT)
