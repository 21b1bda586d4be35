"""Names of work offsets and the numbers by which the tool path knows them."""

import re

_NAME = re.compile(r"G\s*(?:(5[4-9])(?:\.([123]))?|(5\d\d))\s*", re.IGNORECASE)
_EXTENDED = re.compile(r"G\s*(?:54\.1|154)\s*P\s*(\d{1,3})\s*", re.IGNORECASE)
_FIRST, _LAST, _EXTENDED_FROM, _SETTABLE = 54, 59, 100, 4


def offset_number(name: str) -> int | None:
    """Returns 1 to 6 for G54 to G59, 7 to 9 for G59.1 to G59.3, 5 to 99 for G505 to G599, 101 … for G54.1 P1
    (G154 P1) …; None for anything that is not a name of a work offset.
    """
    if found := _EXTENDED.fullmatch(name):
        number = int(found[1])
        return _EXTENDED_FROM + number if number else None
    found = _NAME.fullmatch(name)
    if found is None or (found[2] and int(found[1]) != _LAST):
        return None
    if found[3]:
        return int(found[3]) - 500 or None
    return int(found[1]) - _FIRST + 1 + int(found[2] or 0)


def offset_name(number: int, dialect: str) -> str:
    """Returns the name of a work offset by its number, as that control calls it: of Heidenhain a preset."""
    if dialect == "heidenhain":
        return f"preset {number}"
    if number > _EXTENDED_FROM:
        return f"{'G154' if dialect.startswith('haas') else 'G54.1'} P{number - _EXTENDED_FROM}"
    if dialect == "siemens" and number > _SETTABLE:
        return f"G{500 + number}"
    last = _LAST - _FIRST + 1
    return f"G{_FIRST - 1 + number}" if number <= last else f"G{_LAST}.{number - last}"
