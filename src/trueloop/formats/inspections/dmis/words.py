"""A DMIS statement taken apart: its label, its major word and what is said of it."""

import re
from dataclasses import dataclass
from typing import Final

PARTS: Final = re.compile(
    r"(?:([A-Za-z]{1,3})\s*\((.*?)\)\s*=\s*)?([A-Za-z][A-Za-z0-9_]*|)\s*(?:[/=]\s*(.*)|('.*))?", re.S
)


@dataclass(frozen=True, slots=True)
class Words:
    """`FA(D1)=FEAT/CIRCLE,…`: `kind` FA, `label` D1, `word` FEAT, `fields` CIRCLE and so on, blanks taken off.

    `kind` and `label` are empty where a statement has none; `kind` and `word` are in capitals.
    """

    kind: str
    label: str
    word: str
    fields: tuple[str, ...]
    line: int


def words_of(text: str, line: int) -> Words | None:
    """Returns the parts of a statement's text; None where it is built otherwise."""
    head, slash, rest = text.partition("/")
    name, equals, word = head.rpartition("=")
    if slash and word.isalpha() and (not equals or (name.endswith(")") and name.count("(") == 1)):  # nearly all are
        kind, _, label = name[:-1].partition("(")
        if kind.isalpha() or not equals:
            return Words(kind.upper(), label.strip(), word.upper(), fields_of(rest), line)
    found = PARTS.fullmatch(text)
    if found is None:
        return None
    kind, label, word, rest, quoted = found.groups()
    if not word and not kind:
        return None
    fields = fields_of(rest if rest is not None else quoted or "")
    return Words((kind or "").upper(), (label or "").strip(), word.upper(), fields, line)


def fields_of(text: str) -> tuple[str, ...]:
    """Returns the fields between commas, outside of quoted texts."""
    if not text:
        return ()
    if "'" not in text:
        fields = text.split(",")
        return tuple([field.strip() for field in fields] if " " in text or "\t" in text else fields)
    return tuple(_quoted_fields(text))


def _quoted_fields(text: str) -> list[str]:
    fields, begin, quoted = [], 0, False
    for place, letter in enumerate(text):
        if letter == "'":
            quoted = not quoted
        elif letter == "," and not quoted:
            fields.append(text[begin:place].strip())
            begin = place + 1
    return [*fields, text[begin:].strip()]


def unquoted(field: str) -> str:
    """Returns a quoted text without its quotes; others as they are."""
    if len(field) > 1 and field[0] == field[-1] == "'":
        return field[1:-1].replace("''", "'").strip()
    return field


def label_in(field: str) -> tuple[str, str] | None:
    """Returns `FA(D1)` as ("FA", "D1"); None for anything that is not a label."""
    kind, opened, label = field.partition("(")
    if not opened or not label.endswith(")") or not kind.strip().isalpha():
        return None
    return kind.strip().upper(), label[:-1].strip()


def key_of(label: str) -> str:
    """Returns a label as it is compared: DMIS has no small letters, and a cut line may have lost a blank."""
    return label.upper() if label.isalnum() else "".join(label.split()).upper()
