"""Makes docs/http-api.md, every address and shape of the service, by its OpenAPI."""

from itertools import groupby
from typing import Any, Final

from scripts.web_shapes import openapi

HEAD: Final = """# The HTTP interface

Every address of `trueloop serve`, below `/api/v1`, with what it takes and gives. [service.md](service.md#for-programs)
says how to sign in, what `Idempotency-Key`, `ETag` and `If-Match` do, and how lists are paged. Refusals are
`application/problem+json` with a `code` of [errors.md](errors.md). `/api/v1/openapi.json` (signed in) is the same for
programs. Names end with their units; x is a radius; times are ISO 8601 with a zone.

"""
Node = dict[str, Any]


def page() -> str:
    """Returns the page: a section a kind of thing, a table an address, and all shapes."""
    document = openapi()
    parts = [HEAD]
    by_kind = sorted(document["paths"].items(), key=lambda item: _kind(item[0]))
    for kind, paths in groupby(by_kind, key=lambda item: _kind(item[0])):
        parts.append(f"## Addresses: {kind}\n\n| address | takes | gives | |\n|---|---|---|---|\n")
        parts += [_row(path, method, asked) for path, node in paths for method, asked in node.items()]
        parts.append("\n")
    parts.append("## Shapes\n\n")
    parts += [_shape(name, node) for name, node in document["components"]["schemas"].items() if name not in FRAME]
    return "".join(parts).rstrip() + "\n"


FRAME: Final = {"HTTPValidationError", "ValidationError"}
"""Shapes of the framework, which the service never answers with."""


def _kind(path: str) -> str:
    return path.removeprefix("/api/v1").split("/")[1] or "all"


def _row(path: str, method: str, asked: Node) -> str:
    named = [f"`{one['name']}`" for one in asked.get("parameters", ()) if one["in"] == "query"]
    body = _body(asked.get("requestBody", {}))
    takes = ", ".join([*([body] if body else []), *named])
    answers = {code: one for code, one in asked["responses"].items() if code.startswith("2")}
    gives = ", ".join(f"{code} {_body(one)}".strip() for code, one in answers.items())
    meaning = " ".join((asked.get("description") or asked["summary"]).split())
    address = path.removeprefix("/api/v1")
    return f"| `{method.upper()} {address}` | {takes} | {gives} | {_cell(meaning)} |\n"


def _body(holder: Node) -> str:
    kinds = holder.get("content", {})
    schema = kinds.get("application/json", {}).get("schema")
    return _type(schema) if schema else ", ".join(f"`{kind}`" for kind in kinds)


def _type(schema: Node) -> str:
    """A shape's name as a link, a list of them, or what JSON calls it."""
    if "$ref" in schema:
        name = schema["$ref"].rpartition("/")[2]
        return f"[{name}](#{name.lower()})"
    if "anyOf" in schema:
        return " or ".join(_type(one) for one in schema["anyOf"])
    if "enum" in schema or "const" in schema:
        return ", ".join(f'`"{one}"`' for one in schema.get("enum", [schema.get("const")]))
    if schema.get("type") == "array":
        return f"list of {_type(schema.get('items', {}))}"
    if isinstance(more := schema.get("additionalProperties"), dict):
        return f"names with {_type(more)}"
    kind = schema.get("type", "anything")
    return str({"object": "names with anything", "string": schema.get("format", "string")}.get(kind, kind))


def _shape(name: str, node: Node) -> str:
    meaning = _cell(" ".join((node.get("description") or "").split()))
    if "enum" in node:
        return f"### {name}\n\n{meaning}\n\nOne of {_type(node)}.\n\n".replace("\n\n\n\n", "\n\n")
    needed = set(node.get("required", ()))
    rows = "".join(
        f"| `{key}` | {_type(one)} | {'' if key in needed else _default(one)} | {_cell(one.get('description', ''))} |\n"
        for key, one in node.get("properties", {}).items()
    )
    table = f"| key | | left out | meaning |\n|---|---|---|---|\n{rows}\n" if rows else ""
    return f"### {name}\n\n{meaning}\n\n{table}".replace("\n\n\n\n", "\n\n")


def _default(schema: Node) -> str:
    value = schema.get("default")
    return "none" if value is None else f"`{value!r}`" if not isinstance(value, str) else f'`"{value}"`'


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")
