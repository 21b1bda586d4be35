"""What is said in mm and µm beside the same in inches and microinches, judged by the definition of the inch alone."""

import re
from decimal import Decimal
from typing import Final

MM_PER_INCH: Final = Decimal("25.4")
PER_UNIT: Final = {"mm": MM_PER_INCH, "µm": MM_PER_INCH / 1000}
"""What one of the other unit is in this one."""
OTHER: Final = {"mm": "in", "µm": "µin"}
_TOKEN: Final = re.compile(r"(?<![\w.])[+−-]?\d+(?:[.,]\d+)*(?!\w)|µin\b|µm\b|\bmm\b|(?<=\d )in\b|^in$")
_RANGE: Final = re.compile(r"\s*(?:±|…|to|bis)\s*")
_NAMED: Final = re.compile(r"_(uin|um|mm|in) ([+-]?[\d.]+)")
"""A value under a name with its unit."""
_GROUPED: Final = {"en": re.compile(r",(?=\d{3})"), "de": re.compile(r"(?<=[1-9])\.(?=\d{3}\b)|(?<=\d\d)\.(?=\d{3}\b)")}


def unit_of(head: str) -> str:
    """The unit that the head of a column ends with; empty: none."""
    found = re.search(r"(?:^| )(µin|µm|mm|in)$", head.strip())
    return found[1] if found else ""


def disagreement(metric: str, inch: str, head: str = "", language: str = "en") -> str:
    """Why two texts do not say the same, empty where they do. `head`: the unit that stands at the head of the first.

    A number with a unit of length is converted, one that is none is the same in both; units follow the choice.
    """
    here, there = _said(metric, head), _said(inch, OTHER.get(head, ""))
    if len(here) != len(there):
        return f"{metric!r} and {inch!r} do not have as many numbers"
    for (number, unit), (other, its) in zip(here, there, strict=True):
        if unit not in PER_UNIT:
            if (number, unit) != (other, its):
                return f"{number} {unit} is {other} {its} in {inch!r}"
        elif its != OTHER[unit]:
            return f"{number} {unit} has the unit {its!r} in {inch!r}"
        elif not _same(_number(number, language), _number(other, language), PER_UNIT[unit]):
            return f"{number} {unit} is not {other} {its}: {metric!r}, {inch!r}"
    return ""


def _said(text: str, head: str) -> list[tuple[str, str]]:
    """Numbers with their units: the one that follows, in a range that of its end, else that of the head."""
    text = _NAMED.sub(lambda one: f" {one[2]} {one[1].replace('u', 'µ')}", text)
    said: list[tuple[str, str]] = []
    unit, after = head, len(text)
    following = ""
    for one in reversed(list(_TOKEN.finditer(text))):
        between = text[one.end() : after]
        if one[0][-1].isdigit():
            if following and not following[-1].isdigit() and between.strip() == "":
                unit = following
            elif not following or not _RANGE.fullmatch(between):
                unit = head
            said.append((one[0], unit))
        after, following = one.start(), one[0]
    return said[::-1]


def _number(text: str, language: str) -> Decimal:
    plain = _GROUPED[language].sub("", text)
    return Decimal(plain.replace("−", "-").replace(",", "."))


def _same(metric: Decimal, inch: Decimal, per_unit: Decimal) -> bool:
    """Within half a step of the last decimal of either."""
    half, other = (Decimal(1).scaleb(int(one.as_tuple().exponent)) / 2 for one in (metric, inch))
    return abs(metric - inch * per_unit) <= half + other * per_unit
