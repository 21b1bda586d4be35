"""One envelope for the corrections of all products: what they share, about a payload that is the product's own."""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import StrEnum
from typing import Generic, TypeVar

from trueloop.arrays import by_content

Payload = TypeVar("Payload")


class Product(StrEnum):
    """What a correction is a correction of."""

    TURNED = "turned"  # the contour of a turned part, by its touches
    SURFACE = "surface"  # a free-form surface, by measured parts
    MACHINE = "machine"  # a program, by a machine model or another field of displacements
    POINTS = "points"  # a drilling program, by errors in the plane


@by_content
@dataclass(frozen=True)
class Correction(Generic[Payload]):
    """A correction as it is stored, sent and judged later.

    `id`: sixteen hex digits from inputs and options (`record.record_id`), which the corrected program carries as its
    mark. `inputs_sha256` and `source_sha256` know the files it was made from and the program that it corrects ("" where
    it corrects none) by their content. `limits` are those it was held against, by name with the unit in the name;
    `decision` says in words what carries the correction and why.
    """

    id: str
    product: Product
    inputs_sha256: Mapping[str, str]
    source_sha256: str
    limits: Mapping[str, float]
    decision: tuple[str, ...]
    payload: Payload
