"""Dates and times as files write them: ISO 8601, or with day, month and year in an order that all of a file's tell."""

import re
from collections.abc import Sequence
from datetime import datetime
from typing import Final, Literal, TypeAlias

from trueloop.errors import Code, Place, TrueloopError

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
HINT: Final = 'say it in the mapping: dates = "day first" or "month first" (trueloop measure map FILE writes one)'


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
        return (_iso(text) or _year_first(text) or _local(text, order)).astimezone()
    except (ValueError, OverflowError, OSError) as error:
        raise _refusal(text, "it is no date with a time that is known here", place) from error


def _iso(text: str) -> datetime | None:
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


def _local(text: str, order: Order | None) -> datetime:
    found = LOCAL.fullmatch(text)
    if found is None or order is None:
        raise ValueError(text)
    day, month = int(found[1]), int(found[3])
    if order == "month first":
        day, month = month, day
    year = int(found[4])
    year += 0 if year > 99 else 2000 if year < PIVOT else 1900
    hour, half = int(found[5] or 0), (found[8] or "").lower()[:1]
    if half:
        hour = hour % 12 + (12 if half == "p" else 0)
    return datetime(year, month, day, hour, int(found[6] or 0), int(found[7] or 0))


def _refusal(text: str, why: str, place: Place) -> TrueloopError:
    return Code.MSR_TIME.refusal(
        f"{text!r} is no time that can be read: {why}", hint=HINT, place=place, values={"text": text}
    )
