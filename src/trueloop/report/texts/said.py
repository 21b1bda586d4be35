"""A shape in the reader's language: every sentence of the calculation in it, said anew."""

from typing import Any, TypeVar

from trueloop.report.shape import Shape
from trueloop.report.texts.texts import Texts
from trueloop.wording import Wording

S = TypeVar("S", bound=Shape)


def said(shape: S, say: Texts) -> S:
    """Returns the shape with every sentence translated by `say`; numbers and names stay."""
    return type(shape).model_validate(_said(shape.model_dump(), say))


def _said(value: Any, say: Texts) -> Any:
    if isinstance(value, Wording):
        return say.note(value)
    if isinstance(value, dict):
        return {name: _said(one, say) for name, one in value.items()}
    if isinstance(value, list | tuple):
        return [_said(one, say) for one in value]
    return value
