"""Tables of a TOML file whose keys set options of the code: types, defaults, bounds and meanings are the options'."""

from collections.abc import Callable
from operator import attrgetter
from types import UnionType
from typing import Annotated, Any, TypeVar, get_args, get_origin

from pydantic import Field, create_model

from trueloop.domain.option import Choice, Option, choices_of, inside
from trueloop.formats.toml_tables import MOST, MOST_COUNTED, In, T, Table

D = TypeVar("D")


def with_options(table: str, *options: object) -> Callable[[type[T]], type[T]]:
    """Puts keys in front of those of a table's model: every option of these dataclasses that belongs to that table.

    A dataclass is given as its type, or as an instance where its defaults are others here.
    """
    choices = [choice for one in options for choice in choices_of(one).values()]
    keys: dict[str, Any] = {
        choice.option.key.removeprefix(f"{table}."): _field(choice)
        for choice in choices
        if choice.option.key.startswith(f"{table}.")
    }

    def model_with_keys(model: type[T]) -> type[T]:
        before = create_model(model.__name__, __base__=Table, **keys)
        bases: Any = (model, before)
        whole: type[T] = create_model(
            model.__name__, __base__=bases, __module__=model.__module__, __doc__=model.__doc__
        )
        return whole

    return model_with_keys


def options_from(kind: type[D], file: Table, **others: object) -> D:
    """Returns the dataclass of a file's options, in mm, radians and shares; `others` are set by no key alone."""
    keys = {name: choice.option.key for name, choice in choices_of(kind).items()}
    return kind(**{name: inside(key, attrgetter(key)(file)) for name, key in keys.items()}, **others)


def _field(choice: Choice) -> tuple[Any, Any]:
    described = Field(choice.default, description=choice.option.meaning)
    return Annotated[_checked(choice.kind, choice.option), In(choice.option.unit)], described


def _checked(kind: Any, option: Option) -> Any:
    """The type with the option's bounds at its numbers."""
    if kind is float:
        least = -MOST if option.least is None and option.above is None else option.least
        most = MOST if option.most is None and option.below is None else option.most
        bounds = Field(gt=option.above, ge=least, lt=option.below, le=most, allow_inf_nan=False, strict=True)
        return Annotated[float, bounds]
    if kind is int:
        return Annotated[int, Field(ge=option.least, le=option.most or MOST_COUNTED, strict=True)]
    if isinstance(kind, UnionType):
        first, *rest = (_checked(one, option) for one in get_args(kind))
        return first | rest[0]
    if get_origin(kind) is tuple:
        return tuple[tuple(_checked(one, option) for one in get_args(kind))]  # type: ignore[misc]
    return kind
