"""The text of an inspection file, whatever its encoding, and numbers with a point or a comma."""

import codecs
import math
import re
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Final

from trueloop.errors import Code, Place
from trueloop.formats.input_file import read_text, readable
from trueloop.formats.toml_tables import SYNTAX_HINT

NAMES_HINT = 'a table [features] with lines such as "DIAMETER 7" = "journal"'


def feature_names(mapping: Path | None) -> Mapping[str, str]:
    """Reads the feature names of a mapping of any kind of file; none without a mapping or table. Raises MSR-MAPPING."""
    if mapping is None:
        return {}
    try:
        content = tomllib.loads(read_text(mapping, Code.MSR_MAPPING, hint=NAMES_HINT))
    except (ValueError, RecursionError) as error:
        why = f"not a TOML file: {error}"
        raise Code.MSR_MAPPING.refusal(why, hint=SYNTAX_HINT, place=Place(str(mapping))) from error
    names = content.get("features", {})
    if not isinstance(names, dict) or not all(isinstance(one, str) for one in names.values()):
        raise Code.MSR_MAPPING.refusal(
            "'features' is not a table of names in quotes", hint=NAMES_HINT, place=Place(str(mapping))
        )
    return names


MARKS: Final = (
    (codecs.BOM_UTF8, "utf-8-sig"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
OTHERS: Final = ["cp1252", "cp1250", "gb18030", "cp932"]
"""Encodings of such files where they are not UTF-8."""
NUMBER: Final = re.compile(r"[+-]?(?:\d+(?:[.,]\d*)?|[.,]\d+)(?:[eE][+-]?\d+)?")
PAIR: Final = re.compile(rb"[\x80-\xff]{2}")
UNUSED: Final = re.compile(rb"[\x81\x8d\x8f\x90\x9d]")
"""Single letters outside ASCII among others, `°` or `Ø`, are western: Chinese and Japanese has them in pairs."""
PLAIN: Final = frozenset("0123456789.+- \t\r\n")
"""Signs of numbers that can be read in one way alone."""
MOST: Final = 1e15
"""No length, angle or temperature is as large in any unit; its square is still a number."""
HINT: Final = "docs/measurements.md lists the formats that are read; other text: save it as CSV in UTF-8"


def read_decoded(path: Path) -> tuple[str, str]:
    """Returns a file's text and its assumed encoding. Raises MSR-FILE where it is not there or no text."""
    with readable(path, Code.MSR_FILE, hint=HINT):
        content = path.read_bytes()
    return decoded(content, path)


def decoded(content: bytes, path: Path) -> tuple[str, str]:
    """Returns text and encoding of bytes: without a mark UTF-8, or else the likeliest of `OTHERS`."""
    marked = next((name for mark, name in MARKS if content.startswith(mark)), None)
    for encoding in (marked,) if marked else ("utf-8", _likeliest(content)):
        try:
            return content.decode(encoding or "utf-8"), encoding or "utf-8"
        except UnicodeDecodeError:
            continue
    raise Code.MSR_FILE.refusal(
        f"{path.name!r} is not text in UTF-8, UTF-16 or {', '.join(OTHERS)}: it begins {content[:4].hex(' ')}",
        hint=HINT,
        place=Place(str(path)),
    )


def _likeliest(content: bytes) -> str | None:
    if b"\0" in content[:4096]:
        return None
    try:
        content.decode("utf-8")
    except UnicodeDecodeError:
        if not PAIR.search(content) and not UNUSED.search(content):
            return "cp1252"
        from charset_normalizer import from_bytes

        best = from_bytes(content[:200_000], cp_isolation=OTHERS).best()
        return best.encoding if best is not None and not _only_diameter_signs(content) else "cp1252"
    return None


def beginning(head: bytes) -> str:
    """Returns a file's first bytes as text, for recognising it: bytes that are not letters of it are replaced."""
    marked = next((name for mark, name in MARKS if head.startswith(mark)), "latin-1")
    return head.decode(marked, errors="replace")


def _only_diameter_signs(content: bytes) -> bool:
    """Returns whether western and central European text of it differ only in Ø and ø, which are Ř and ř in the
    latter.
    """
    western, central = (content[:200_000].decode(name, errors="replace") for name in ("cp1252", "cp1250"))
    return {one for one, other in zip(western, central, strict=True) if one != other} <= {"Ø", "ø"}


def number_in(text: str, path: Path, line: int, column: int | None = None) -> float:
    """Reads a number with a decimal point or comma; the two may differ from number to number in a file.

    Raises MSR-NUMBER for anything that is not a number, for `1,234.5`, whose comma may group digits, and beyond `MOST`.
    """
    value = float(text.strip().replace(",", ".")) if NUMBER.fullmatch(text.strip()) else None
    if value is None or abs(value) > MOST:
        raise Code.MSR_NUMBER.refusal(
            f"{text!r} is no number with one decimal point or comma" + ("" if value is None else f" up to {MOST:g}"),
            hint="write it without signs that group digits",
            place=Place(str(path), line, column),
            values={"text": text},
        )
    return value


def numbers_in(text: str, path: Path, line: int) -> list[float]:
    """Reads the numbers of a long text, separated by blanks, as `number_in` does: millions at once if all are plain."""
    words = text.split()
    if PLAIN.issuperset(text):
        try:
            values = list(map(float, words))
        except ValueError:
            values = [math.inf]
        if max(map(abs, values), default=0.0) <= MOST:
            return values
    return [number_in(word, path, line) for word in words]
