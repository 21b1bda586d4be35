"""Options that belong together, as one value: a command takes a dataclass, typer sees an option for each of its fields.

    @dataclass(frozen=True, kw_only=True)
    class Reading:
        unit: Annotated[str | None, typer.Option("--unit")] = None

    @guarded
    def path(file: ProgramFile, reading: Reading) -> None: ...

A field may be such a dataclass itself. Help lists options in the order of parameters and fields.
"""

import functools
import inspect
from collections.abc import Callable, Iterator
from dataclasses import MISSING, fields, is_dataclass
from typing import Any, get_type_hints


def with_groups(command: Callable[..., Any]) -> Callable[..., Any]:
    """The command as a function of single options."""
    hints = get_type_hints(command, include_extras=True)
    groups = {name: hint for name, hint in hints.items() if is_dataclass(hint)}

    @functools.wraps(command)
    def run(*args: object, **given: object) -> object:
        values = {name: _value(group, given) for name, group in groups.items()}
        return command(*args, **given, **values)

    parameters: list[inspect.Parameter] = []
    for parameter in inspect.signature(command).parameters.values():
        group = groups.get(parameter.name)
        single = _parameters(group) if group else [parameter.replace(annotation=hints[parameter.name])]
        parameters += [one.replace(kind=inspect.Parameter.KEYWORD_ONLY) for one in single]
    run.__signature__ = inspect.Signature(parameters)  # type: ignore[attr-defined]
    run.__annotations__ = {one.name: one.annotation for one in parameters}
    return run


def _parameters(group: Any) -> Iterator[inspect.Parameter]:
    hints = get_type_hints(group, include_extras=True)
    for field in fields(group):
        if is_dataclass(hint := hints[field.name]):
            yield from _parameters(hint)
            continue
        default = inspect.Parameter.empty if field.default is MISSING else field.default
        yield inspect.Parameter(field.name, inspect.Parameter.KEYWORD_ONLY, default=default, annotation=hint)


def _value(group: Any, given: dict[str, object]) -> object:
    """The dataclass of its fields' values, which are taken out of those given."""
    hints = get_type_hints(group)
    return group(
        **{name: _value(hint, given) if is_dataclass(hint) else given.pop(name) for name, hint in hints.items()}
    )
