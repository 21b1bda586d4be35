"""A JSON schema held against a document, by the words that pydantic writes: an oracle that knows no pydantic."""

from collections.abc import Iterator
from typing import Any

KINDS: dict[str, Any] = {
    "object": dict, "array": list, "string": str, "integer": int, "number": (int, float), "null": type(None),
    "boolean": bool,
}  # fmt: skip
KNOWN = {
    "$ref", "$defs", "$schema", "type", "properties", "required", "additionalProperties", "items", "anyOf", "enum",
    "const", "title", "description", "default",
}  # fmt: skip


def mistakes(value: Any, schema: dict[str, Any], defs: dict[str, Any], place: str = "$") -> Iterator[str]:
    """What is wrong in a document, by its place."""
    assert set(schema) <= KNOWN, f"{place}: the schema says {set(schema) - KNOWN}, which this oracle does not know"
    if "$ref" in schema:
        yield from mistakes(value, defs[schema["$ref"].rsplit("/", 1)[1]], defs, place)
        return
    if "anyOf" in schema and all(any(True for _ in mistakes(value, one, defs, place)) for one in schema["anyOf"]):
        yield f"{place}: none of several forms"
    kind = schema.get("type")
    if kind and (not isinstance(value, KINDS[kind]) or (isinstance(value, bool) and kind != "boolean")):
        yield f"{place}: {value!r} is no {kind}"
        return
    if value not in schema.get("enum", [value]) or value != schema.get("const", value):
        yield f"{place}: {value!r} is not among the values"
    if isinstance(value, dict):
        yield from _of_object(value, schema, defs, place)
    if isinstance(value, list) and "items" in schema:
        for k, one in enumerate(value):
            yield from mistakes(one, schema["items"], defs, f"{place}[{k}]")


def _of_object(value: dict[str, Any], schema: dict[str, Any], defs: dict[str, Any], place: str) -> Iterator[str]:
    known, more = schema.get("properties", {}), schema.get("additionalProperties", True)
    for key in schema.get("required", []):
        if key not in value:
            yield f"{place}.{key} is missing"
    for key, one in value.items():
        if key in known:
            yield from mistakes(one, known[key], defs, f"{place}.{key}")
        elif more is False:
            yield f"{place}.{key} is not in the schema"
        elif isinstance(more, dict):
            yield from mistakes(one, more, defs, f"{place}.{key}")
