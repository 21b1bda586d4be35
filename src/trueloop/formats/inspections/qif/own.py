"""What a reading has and QIF has no element for: written as attributes of an item, and taken back from them."""

from collections.abc import Mapping
from typing import Final

from trueloop.domain.characteristic import Quantity
from trueloop.domain.inspection import Reading
from trueloop.formats.inspections.qif.elements import Element
from trueloop.formats.inspections.shared.text import NUMBER

KEPT: Final = "trueloop."
"""How the names of these attributes begin."""
KINDS: Final = {
    Quantity.DIAMETER: "Diameter",
    Quantity.RADIUS: "Radius",
    Quantity.LENGTH: "Length",
    Quantity.ANGLE: "Angle",
}


def written_kind(reading: Reading) -> str:
    """The kind of characteristic a reading is written as; that of others is stated in words by its definition."""
    if reading.quantity is Quantity.POSITION and reading.axis:
        return "LinearCoordinate"
    return KINDS.get(reading.quantity, "UserDefinedLinear")


def kept_of(reading: Reading) -> dict[str, str]:
    """Names of features, place and axis by what they are called."""
    axis = reading.axis if written_kind(reading) != "LinearCoordinate" else ""
    place = " ".join(map(repr, reading.place_mm))
    kept = {"feature": reading.feature, "other": reading.other, "axis": axis, "place": place}
    return {name: value for name, value in kept.items() if value}


def kept_in(item: Element) -> Mapping[str, str]:
    """Returns the attributes kept in an item that was read."""
    every = (one.attributes for one in item.every("AttributeStr"))
    return {
        one["name"].removeprefix(KEPT): one.get("value", "") for one in every if one.get("name", "").startswith(KEPT)
    }


def place_in(text: str) -> tuple[float, ...]:
    """A place as it is kept; empty for none."""
    words = text.split()
    return tuple(map(float, words)) if all(NUMBER.fullmatch(word) and "," not in word for word in words) else ()
