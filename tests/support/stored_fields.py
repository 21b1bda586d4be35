"""The fields of all types that a store may hold, as a file has them: what is stored has to stay readable.

`python -m tests.support.stored_fields` writes the file anew: after a migration of stored documents, where a field was
renamed or taken away; without one where fields with defaults came in.
"""

from dataclasses import MISSING, fields, is_dataclass
from pathlib import Path
from typing import Any

from trueloop.jobs.store.codec import store_codec

FILE = Path(__file__).with_name("stored_fields.txt")


def fields_of(kind: Any) -> dict[str, bool]:
    """The names of a type's fields, or of an enumeration's values, each with whether a document has to have it."""
    if not is_dataclass(kind):
        return {str(one.value): False for one in kind}
    return {one.name: one.default is MISSING and one.default_factory is MISSING for one in fields(kind)}


def kept() -> dict[str, set[str]]:
    """The types and fields of the file."""
    lines = FILE.read_text(encoding="utf-8").splitlines()
    return {name: set(rest.split(", ")) for name, rest in (line.split(": ") for line in lines)}


def page() -> str:
    """The file as it is for today's types, a line each."""
    types = sorted(store_codec().types.items())
    return "".join(f"{name}: {', '.join(fields_of(kind))}\n" for name, kind in types if fields_of(kind))


if __name__ == "__main__":
    FILE.write_text(page(), encoding="utf-8")
