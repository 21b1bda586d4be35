"""The text of an inspection file, whatever its encoding, its numbers with a point or a comma, and its dates and times.

Dates are ISO 8601, or have day, month and year in an order that all of a file's tell.
"""

import codecs
import math
import re
import tomllib
from collections.abc import Mapping, Sequence
from datetime import datetime
from pathlib import Path
from typing import Final, Literal, TypeAlias

from trueloop.errors import Code, Place, TrueloopError
from trueloop.formats.input_file import read_text, readable
from trueloop.formats.toml_tables import SYNTAX_HINT
from trueloop.wording import wording

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
    if not isinstance(names, dict) or not all(isinstance(name, str) for name in names.values()):
        raise Code.MSR_MAPPING.refusal(
            "'features' is not a table of names in quotes", hint=NAMES_HINT, place=Place(str(mapping))
        )
    return names


MARKS: Final = ((codecs.BOM_UTF8, "utf-8-sig"), (codecs.BOM_UTF16_LE, "utf-16"), (codecs.BOM_UTF16_BE, "utf-16"))
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
EMPTY: Final = frozenset(("n/a", "na", "n.a.", "n.m.", "n. m.", "k.a.", "k. a.", "nan", "null", "none"))
"""Cells that state nothing, in lower case, as do those of the signs below alone, and a workbook's errors (#REF!)."""
SIGNS: Final = "*-–—.?"
HINT: Final = "docs/inspection-formats.md lists the formats that are read; other text: save it as CSV in UTF-8"


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


def is_empty(cell: str) -> bool:
    """Returns whether a cell states nothing: it is empty, a dash, stars, or an error.

    >>> [is_empty(cell) for cell in ("", "***", "NaN", "#REF!", "0", "A-1")]
    [True, True, True, True, False, False]
    """
    return not cell.strip(SIGNS) or cell.lower() in EMPTY or (cell.startswith("#") and cell.rstrip("!?").isupper())


def number_in(text: str, path: Path, line: int, column: int | None = None) -> float:
    """Reads a number with a decimal point or comma; the two may differ from number to number in a file.

    Raises MSR-NUMBER for anything that is not a number, for `1,234.5`, whose comma may group digits, and beyond `MOST`.
    """
    value = float(text.strip().replace(",", ".")) if NUMBER.fullmatch(text.strip()) else None
    if value is None or abs(value) > MOST:
        raise Code.MSR_NUMBER.refusal(
            wording("{text!r} is not a number with one decimal point or comma", text=text)
            if value is None
            else wording("{text!r} is larger than {most:g}", text=text, most=MOST),
            hint=wording("write it without signs that group digits"),
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


Order: TypeAlias = Literal["day first", "month first"]
LOCAL: Final = re.compile(
    r"(\d{1,2})([./-])(\d{1,2})\2(\d{4}|\d{2})"
    r"(?:[ T,;/]+(\d{1,2})[:.](\d{2})(?:[:.](\d{2})(?:[.,]\d+)?)?\s*([AaPp]\.?[Mm]\.?)?)?"
)
YEAR_FIRST: Final = re.compile(
    r"(\d{4})([./-]?)(\d{2})\2(\d{2})(?:[ T,;]+(\d{1,2}):?(\d{2})(?::?(\d{2})(?:[.,]\d+)?)?)?"
)
PIVOT: Final = 70
"""A year of two digits below it is 20xx."""
MONTHS: Final = (
    *(("jan",), ("feb",), ("mar", "mär", "mae"), ("apr",), ("may", "mai"), ("jun",), ("jul",), ("aug",), ("sep",)),
    *(("oct", "okt"), ("nov",), ("dec", "dez")),
)
"""First letters of the months' names, English and German."""
_TIME: Final = r"(?:,?\s+(?P<hour>\d{1,2}):(?P<min>\d{2})(?::(?P<s>\d{2}))?\s*(?P<half>[AaPp]\.?[Mm]?\.?)?)?"
MONTH_FIRST: Final = re.compile(rf"(?P<month>[A-Za-zäÄ]{{3,9}})\.?\s+(?P<day>\d{{1,2}}),?\s+(?P<year>\d{{4}}){_TIME}")
DAY_FIRST: Final = re.compile(
    rf"(?P<day>\d{{1,2}})\.?[\s-]+(?P<month>[A-Za-zäÄ]{{3,9}})\.?[\s-]+(?P<year>\d{{4}}){_TIME}"
)
DATES_HINT: Final = 'say it in the mapping: dates = "day first" or "month first" (trueloop measure map FILE writes one)'


def order_of(texts: Sequence[str], place: Place) -> Order | None:
    """Returns the order of day and month that all local dates of a file have in common; None where none is local.

    A date with dots has the day first. Raises MSR-TIME where the order does not follow, or dates contradict each other.
    """
    found = [match for text in set(texts) if (match := LOCAL.fullmatch(text))]
    if not found:
        return None
    first = any(int(one[1]) > 12 for one in found)
    second = any(int(one[3]) > 12 for one in found)
    dotted = all(one[2] == "." for one in found)
    if first and second:
        raise _refusal(found[0][0], "other dates of the file have the month where it has the day", place)
    if second:
        return "month first"
    if first or dotted or all(one[1] == one[3] for one in found):
        return "day first"
    raise _refusal(found[0][0], "it may be day/month or month/day, and no date of the file tells which", place)


def moment(text: str, order: Order | None, place: Place) -> datetime | None:
    """Reads a date with or without a time, in this computer's zone where it names none; None for an empty text.

    Raises MSR-TIME for anything that is not a date.
    """
    if not text:
        return None
    try:
        return (iso_time(text) or _year_first(text) or _named_month(text) or _local(text, order)).astimezone()
    except (ValueError, OverflowError, OSError) as error:
        raise _refusal(text, "date and time are not in a known form", place) from error


def iso_time(text: str) -> datetime | None:
    """Returns a time as ISO 8601 writes it; None for anything else."""
    try:
        return datetime.fromisoformat(text)
    except ValueError:
        return None


def _year_first(text: str) -> datetime | None:
    found = YEAR_FIRST.fullmatch(text)
    if found is None:
        return None
    year, month, day, hour, minute, second = (int(found[k] or 0) for k in (1, 3, 4, 5, 6, 7))
    return datetime(year, month, day, hour, minute, second)


def _named_month(text: str) -> datetime | None:
    """`Mar 14, 2026 10:22:00`, `14. März 2026 10:22`, `14-MAR-2026`."""
    found = MONTH_FIRST.fullmatch(text) or DAY_FIRST.fullmatch(text)
    month = found and next((k for k, names in enumerate(MONTHS, 1) if found["month"][:3].casefold() in names), None)
    if not found or not month:
        return None
    return datetime(
        int(found["year"]), month, int(found["day"]), *_clock(found["hour"], *found.group("min", "s", "half"))
    )


def _clock(hour: str | None, minute: str | None, second: str | None, half: str | None) -> tuple[int, int, int]:
    of_day = int(hour or 0)
    if letter := (half or "").lower()[:1]:
        of_day = of_day % 12 + (12 if letter == "p" else 0)
    return of_day, int(minute or 0), int(second or 0)


def _local(text: str, order: Order | None) -> datetime:
    found = LOCAL.fullmatch(text)
    if found is None or order is None:
        raise ValueError(text)
    day, month = int(found[1]), int(found[3])
    if order == "month first":
        day, month = month, day
    year = int(found[4])
    year += 0 if year > 99 else 2000 if year < PIVOT else 1900
    return datetime(year, month, day, *_clock(found[5], found[6], found[7], found[8]))


def _refusal(text: str, why: str, place: Place) -> TrueloopError:
    return Code.MSR_TIME.refusal(
        f"{text!r} cannot be read as a time: {why}", hint=DATES_HINT, place=place, values={"text": text}
    )
