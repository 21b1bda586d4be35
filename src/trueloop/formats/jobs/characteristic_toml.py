"""Characteristics as tables of a job: what a drawing or a solid asks for, to be kept or taken out by hand."""

from collections.abc import Iterator, Sequence
from typing import Final

from trueloop.domain.characteristic import Characteristic
from trueloop.formats.jobs.profile_of_job import quoted

ROUNDED: Final = 9
"""Decimals of a size: conversions of inches end there."""


def characteristics_toml(asked: Sequence[Characteristic]) -> str:
    """A `[[part.characteristic]]` for each, lengths in mm; they follow a `[part]` table in mm. "" for none."""
    return "".join("\n" + "\n".join(_table(one)) + "\n" for one in asked)


def _table(one: Characteristic) -> Iterator[str]:
    yield "[[part.characteristic]]"
    yield f"name = {quoted(one.name)}"
    yield f"quantity = {quoted(one.quantity)}"
    yield f"feature = {quoted(one.feature)}"
    if one.other:
        yield f"other = {quoted(one.other)}"
    if one.nominal:
        yield f"nominal = {round(one.nominal, ROUNDED)!r}"
    if one.tolerance:
        yield f"tolerance = {quoted(one.tolerance)}"
        return
    for key, limit in (("lower_limit", one.lower_limit), ("upper_limit", one.upper_limit)):
        if limit is not None:
            yield f"{key} = {round(limit, ROUNDED)!r}"
