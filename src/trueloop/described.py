"""Models of files and answers whose fields are explained by the text below them; records made of others."""

import ast
import inspect
from dataclasses import fields
from functools import cache
from itertools import pairwise
from textwrap import dedent
from typing import TYPE_CHECKING, TypeVar

from pydantic import BaseModel, GetJsonSchemaHandler
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import CoreSchema

if TYPE_CHECKING:
    from _typeshed import DataclassInstance

D = TypeVar("D", bound="DataclassInstance")


class Described(BaseModel):
    """A model whose JSON schema describes each field by the text below it.

    The texts are read from the source when a schema is made: pydantic reads them when the class is, in each start of a
    command.
    """

    @classmethod
    def __get_pydantic_json_schema__(cls, core_schema: CoreSchema, handler: GetJsonSchemaHandler) -> JsonSchemaValue:
        """Returns pydantic's schema with the meanings as descriptions."""
        schema = handler(core_schema)
        properties = handler.resolve_ref_schema(schema).get("properties", {})
        for name, meaning in meanings(cls).items():
            properties[name].setdefault("description", meaning)
        return schema


@cache
def meanings(model: type[BaseModel]) -> dict[str, str]:
    """Returns the meaning of each field that has one: the description it was made with, or the text below it."""
    texts: dict[str, str] = {}
    for kind in reversed(model.__mro__):
        if issubclass(kind, Described) and kind is not Described:
            texts |= _texts_below(kind)
    described = {name: field.description for name, field in model.model_fields.items()}
    every = {name: described[name] or texts.get(name) for name in described}
    return {name: text for name, text in every.items() if text}


def _texts_below(kind: type) -> dict[str, str]:
    """Returns the texts below the annotated names of a class; none of a class that a function made."""
    try:
        source = inspect.getsource(kind)
    except OSError:
        return {}
    body = ast.parse(dedent(source)).body[0]
    found: dict[str, str] = {}
    for above, below in pairwise(body.body if isinstance(body, ast.ClassDef) else []):
        match above, below:
            case ast.AnnAssign(target=ast.Name(id=name)), ast.Expr(value=ast.Constant(value=str(text))):
                found[name] = inspect.cleandoc(text)
    return found


def filled_from(kind: type[D], source: object, /, **others: object) -> D:
    """Makes a record of a kind: its fields have the values of like-named attributes of the source, but for `others`."""
    names = (field.name for field in fields(kind) if field.name not in others and hasattr(source, field.name))
    return kind(**{name: getattr(source, name) for name in names}, **others)
